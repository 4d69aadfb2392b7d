# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's properties as the engine's Settings."""

from __future__ import annotations

from isophote.settings import Settings

from .result import matte_levels, wanted_passes

PREVIEW_SAMPLES = 32  # of the small pictures of materials and lights
# Properties of scene.isophote that bear the names of settings.
SAME = (
    "samples",
    "time_limit",
    "adaptive",
    "seed",
    "precision",
    "wait_for_kernels",
    "max_bounces",
    "diffuse_bounces",
    "glossy_bounces",
    "transmission_bounces",
    "volume_bounces",
    "transparent_bounces",
    "clamp_direct",
    "clamp_indirect",
    "filter_width",
)

# Cycles' name of a setting -> ours, where one means the other.
FROM_CYCLES = {
    "samples": "samples",
    "time_limit": "time_limit",
    "seed": "seed",
    "max_bounces": "max_bounces",
    "diffuse_bounces": "diffuse_bounces",
    "glossy_bounces": "glossy_bounces",
    "transmission_bounces": "transmission_bounces",
    "volume_bounces": "volume_bounces",
    "transparent_max_bounces": "transparent_bounces",
    "sample_clamp_direct": "clamp_direct",
    "sample_clamp_indirect": "clamp_indirect",
    "filter_width": "filter_width",
}


def own_values(own) -> dict:
    """The settings in scene.isophote, by name of Settings."""
    return {**{name: getattr(own, name) for name in SAME}, "error_target": own.error_percent / 100.0}


def file_settings(scene) -> dict:
    """What a file asks for, by name of Settings: its Isophote settings where some were made, else those of Cycles."""
    own, cycles = scene.isophote, getattr(scene, "cycles", None)
    if any(own.is_property_set(name) for name in (*SAME, "error_percent")) or cycles is None:
        values = own_values(own)
    else:
        values = {ours: getattr(cycles, theirs) for theirs, ours in FROM_CYCLES.items()}
    layer = next((layer for layer in scene.view_layers if layer.use), scene.view_layers[0])  # the one that is exported
    return {**values, "film_transparent": scene.render.film_transparent, "matte_levels": matte_levels(layer)}


def make_settings(scene, view_layer, region: tuple[int, int, int, int], preview: bool = False) -> Settings:
    """The settings of one view layer's render. Raises ValueError for values that do not fit."""
    own = scene.isophote
    values = own_values(own)
    if view_layer.samples > 0:  # Blender's override by layer
        values["samples"] = view_layer.samples
    if preview:
        values |= {"samples": min(values["samples"], PREVIEW_SAMPLES), "error_target": 0.0}
    return Settings(
        **values,
        device="openmp" if preview else device_of(own),
        threads=scene.render.threads,  # of the scene, of the machine, or of the option -t: Blender knows
        film_transparent=scene.render.film_transparent,
        passes=("combined",) if preview else wanted_passes(view_layer),
        matte_levels=matte_levels(view_layer),
        region=region,
    )


def device_of(own) -> str:
    """openmp, opencl (the first that is usable) or opencl:N."""
    if own.device == "opencl" and own.opencl_device >= 0:
        return f"opencl:{own.opencl_device}"
    return own.device
