# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: one radiance in all directions. Textures are replaced by their average, which is noted."""

from __future__ import annotations

import numpy as np

from .. import compat
from .nodes import find_input, live_link, source_of
from .values import Values

PIXELS_MAX = 1 << 25  # of an environment picture that is averaged


def world_radiance(scene, notes) -> np.ndarray:
    """W/(m^2 sr), f8 [3]; black without a world, as in Cycles."""
    world = scene.world
    if world is None:
        return np.zeros(3)
    values = Values("world", world.name, notes)
    hidden = [name for name in ("camera", "diffuse", "glossy", "transmission")
              if not getattr(getattr(world, "cycles_visibility", None), name, True)]
    if hidden:
        values.note(f"ray visibility ({', '.join(hidden)}) is not supported: visible to all rays")
    if not compat.uses_nodes(world):
        return np.array(world.color[:3], dtype=np.float64)
    output = world.node_tree.get_output_node("CYCLES")
    if output is None:
        return np.zeros(3)
    if live_link(output.inputs["Volume"]):
        values.note("volumes are not supported: left out")
    return np.maximum(radiance_of(values, find_input(output, "Surface"), ()), 0.0)


def radiance_of(values: Values, socket, stack) -> np.ndarray:
    source = source_of(socket, stack)
    node, stack = source.node, source.stack
    if node is None:
        return np.zeros(3)
    if node.bl_idname == "ShaderNodeMixShader":
        t = min(max(values.number(node, stack, "Fac"), 0.0), 1.0)
        return radiance_of(values, node.inputs[1], stack) * (1.0 - t) + radiance_of(values, node.inputs[2], stack) * t
    if node.bl_idname == "ShaderNodeAddShader":
        return radiance_of(values, node.inputs[0], stack) + radiance_of(values, node.inputs[1], stack)
    if node.bl_idname not in ("ShaderNodeBackground", "ShaderNodeEmission"):
        values.note(f"{node.name} ({node.bl_idname}): not supported in a world, left out")
        return np.zeros(3)
    return background_color(values, node, stack) * values.number(node, stack, "Strength")


def background_color(values: Values, node, stack) -> np.ndarray:
    """The colour of a Background; an environment picture counts with its average."""
    source = source_of(find_input(node, "Color"), stack)
    if source.node is not None and source.node.bl_idname == "ShaderNodeTexEnvironment":
        average = picture_average(source.node.image)
        if average is not None:
            values.note(f"{source.node.name} ({source.node.bl_idname}): not supported, the picture's average is used")
            return average
    return values.color(node, stack, "Color").astype(np.float64)


def picture_average(image) -> np.ndarray | None:
    """Average of an equirectangular picture over the sphere, linear RGB f8 [3]; None where it cannot be read."""
    if image is None or not image.has_data and not image.size[0]:
        return None
    width, height = image.size
    if width == 0 or height == 0 or width * height > PIXELS_MAX or image.channels < 3:
        return None
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    rows = pixels.reshape(height, width, image.channels)[:, :, :3].mean(axis=1, dtype=np.float64)
    weights = np.sin((np.arange(height) + 0.5) * np.pi / height)
    average = (rows * weights[:, None]).sum(axis=0) / weights.sum()
    if not image.is_float and image.colorspace_settings.name.lower().startswith("srgb"):
        average = np.where(average <= 0.04045, average / 12.92, ((average + 0.055) / 1.055) ** 2.4)
    return average if np.all(np.isfinite(average)) else None
