# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes into Blender's render result."""

from __future__ import annotations

import numpy as np

from isophote.passes import channels_of, check_passes, named_pass
from isophote.settings import MOST_LEVELS

from .compat import frame_border, pass_name, set_pass
from .export.aovs import aovs_of, is_taken
from .export.camera import resolution_of
from .export.light_groups import LightGroups

KINDS = ("diffuse", "glossy", "transmission")  # of closures, in light passes
# Passes that Blender switches on and off itself, by our name; the others are this add-on's.
BUILTIN = {
    "depth": "use_pass_z",
    "normal": "use_pass_normal",
    "position": "use_pass_position",
    **{f"{kind}_{of}": f"use_pass_{kind}_{of}" for kind in KINDS for of in ("direct", "indirect", "color")},
    "uv": "use_pass_uv",
    "vector": "use_pass_vector",
    "mist": "use_pass_mist",
    "object_index": "use_pass_object_index",
    "material_index": "use_pass_material_index",
    "emission": "use_pass_emit",
    "environment": "use_pass_environment",
    "ambient_occlusion": "use_pass_ambient_occlusion",
    **{f"crypto_{kind}": f"use_pass_cryptomatte_{kind}" for kind in ("object", "material", "asset")},
}
OWN = ("albedo", "sample_count", "invalid", "error")
DENOISING = ("denoising_normal", "denoising_albedo", "denoising_depth")  # by Cycles' switch, where its add-on is on
# Switches of Blender and Cycles whose passes there are not.
MISSING = {"use_pass_shadow": "Shadow", "use_pass_subsurface_direct": "Subsurface Direct",
           "use_pass_subsurface_indirect": "Subsurface Indirect", "use_pass_subsurface_color": "Subsurface Color"}
TYPES = {"rgba": "COLOR", "X": "VALUE", "Z": "VALUE", "XYZ": "VECTOR", "XYZW": "VECTOR", "UVA": "VECTOR",
         "RGB": "COLOR", "RGBA": "COLOR"}
NAMED_CHANNELS = {"color": "RGBA", "value": "X", "light": "RGB"}  # by what isophote.planes has before the name
FAILED_COLOUR = (1.0, 0.0, 1.0, 1.0)
FAILED_SQUARE = 16  # pixels


def wanted_passes(view_layer) -> tuple[str, ...]:
    """Names, as in isophote.passes, of what a view layer asks for."""
    builtin = [name for name, flag in BUILTIN.items() if getattr(view_layer, flag)]
    own = [name for name in OWN if getattr(view_layer.isophote, name)]
    cycles = getattr(view_layer, "cycles", None)
    catcher = ("shadow_catcher",) if getattr(cycles, "use_pass_shadow_catcher", False) else ()
    denoising = DENOISING if getattr(cycles, "denoising_store_passes", False) else ()
    return check_passes(("combined", *builtin, *own, *denoising, *catcher))


def matte_levels(view_layer) -> int:
    """Ids of a pixel that Cryptomatte's passes show."""
    return min(view_layer.pass_cryptomatte_depth, MOST_LEVELS)


def missing_passes(scene, view_layer) -> list[dict]:
    """A note for each pass that a view layer asks for and that there is not."""
    missing = [name for flag, name in MISSING.items() if getattr(view_layer, flag, False)]
    taken = [aov.name for aov in view_layer.aovs if aov.is_valid and is_taken(aov.name)]
    reasons = dict.fromkeys(missing, "is not supported: left out")
    reasons |= dict.fromkeys(taken, "an AOV with the name of a pass: left out")
    if view_layer.use_pass_vector and scene.render.use_motion_blur:
        reasons["Vector"] = "is black with motion blur"
    return [{"kind": "pass", "name": name, "what": what} for name, what in reasons.items()]


def register_passes(engine, scene, view_layer) -> None:
    """Tell Blender (its compositor, its files) which passes a view layer will have."""
    for name, channels in channels_of(wanted_passes(view_layer), matte_levels(view_layer)).items():
        engine.register_pass(scene, view_layer, pass_name(name), len(channels), channels, TYPES[channels])
    lights = [f"light:{name}" for name in LightGroups(view_layer).names]
    for name in (*aovs_of(view_layer), *lights):
        channels = NAMED_CHANNELS[name.partition(":")[0]]
        engine.register_pass(scene, view_layer, named_pass(name), len(channels), channels, TYPES[channels])


class OpenResult:
    """A view layer's render result, open from the first chunk to the last: one begin, many updates, one end.

    `passes` are names as in isophote.passes, `named` as in isophote.planes, `levels` those of Cryptomatte; Blender
    gives an open result the passes that were added before.
    """

    def __init__(self, engine, width: int, height: int, layer: str, view: str = "",
                 passes: tuple[str, ...] = (), named=(), levels: int = 0):
        self.engine = engine
        for name, channels in channels_of((name for name in passes if name != "combined"), levels).items():
            engine.add_pass(pass_name(name), len(channels), channels, layer=layer)
        for name in named:
            channels = NAMED_CHANNELS[name.partition(":")[0]]
            engine.add_pass(named_pass(name), len(channels), channels, layer=layer)
        self.result = engine.begin_result(0, 0, width, height, layer=layer, view=view)

    def show(self, planes: dict[str, np.ndarray]) -> None:
        """Copy planes, "Pass" -> float32 (h, w, c), into the result and let Blender draw it."""
        passes = self.result.layers[0].passes
        for name, values in planes.items():
            set_pass(passes[pass_name(name)], values)
        self.engine.update_result(self.result)

    def __enter__(self) -> OpenResult:
        return self

    def __exit__(self, kind, *_) -> None:
        self.engine.end_result(self.result, cancel=kind is not None)


def view_names(engine) -> list[str]:
    """Of the views that a render has: one without a name, but for stereoscopy."""
    return [view.name for view in engine.get_result().views]


def stamp(engine, fields: dict[str, str]) -> None:
    """Add metadata that Blender stores in the picture's file; the open result would not pass it on."""
    result = engine.get_result()
    for name, value in fields.items():
        result.stamp_data_add_field(name, value)


def mark_failed(engine, scene, layer: str) -> None:
    """Fill a view layer, in all its views, with a chequer that nobody takes for a picture: Blender saves a file even
    after an error."""
    x0, y0, x1, y1 = frame_border(scene.render, resolution_of(scene.render))
    rows, columns = np.indices((y1 - y0, x1 - x0)) // FAILED_SQUARE
    chequer = np.zeros((y1 - y0, x1 - x0, 4), np.float32)
    chequer[(rows + columns) % 2 == 0] = FAILED_COLOUR
    chequer[..., 3] = 1.0
    for view in view_names(engine):
        with OpenResult(engine, x1 - x0, y1 - y0, layer, view) as result:
            result.show({"Combined": chequer})
