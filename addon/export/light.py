# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps: Blender's numbers, unit axes and a place; docs/units.md says what they mean as light.

What newer versions add is folded into the strength: colour temperature, exposure, the factor of an
Emission node, and lamps that are not normalised by their size.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .. import compat
from .nodes import find_input, source_of
from .values import Values

POINT, SPOT, SUN, RECTANGLE, ELLIPSE = range(5)
NO_SHADOW, NO_MIS, FACING_DISK = 1, 2, 4
NARROWEST_SPREAD = 1e-3  # radians: 0 stands for a parallel beam in Blender, and for no limit in a scene
UNLIMITED, BOUNCES_SHIFT = 1024, 8  # Blender's highest limit of bounces; LIGHT_BOUNCES of kernels/scene_records.h


@dataclass
class Lamp:
    """One light of the scene; fields as in isophote/scene.py."""

    name: str
    kind: int
    to_world: np.ndarray  # f8 [3, 4], relative to the origin
    strength: np.ndarray  # f8 [3]
    size: tuple[float, float]
    spot: tuple[float, float]
    spread: float
    flags: int
    visibility: int


def export_light(ob, matrix: np.ndarray, origin: np.ndarray, visibility: int, notes) -> Lamp | None:
    """A lamp object at `matrix` (f8 [4, 4], world) as a Lamp; None where it gives no light."""
    light = ob.data
    values = Values("light", ob.name, notes)
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    kind, size, spot = SHAPES[light.type](light, lengths)
    cycles = getattr(light, "cycles", None)
    if light.type == "AREA" and getattr(cycles, "is_portal", False):
        values.note("portals are not supported: left out")
        return None
    strength = np.array(light.color[:3], dtype=np.float64) * compat.light_energy(light)
    strength *= compat.light_factor(light) * node_factor(light, values)
    if not getattr(light, "normalize", True):
        strength *= size_factor(kind, size)
    to_world = np.zeros((3, 4))
    to_world[:, :3] = matrix[:3, :3] if kind == SPOT else matrix[:3, :3] / np.where(lengths > 0.0, lengths, 1.0)
    to_world[:, 3] = matrix[:3, 3] - origin
    flags = 0 if compat.casts_shadow(light) else NO_SHADOW
    flags |= 0 if getattr(cycles, "use_multiple_importance_sampling", True) else NO_MIS
    flags |= FACING_DISK if kind in (POINT, SPOT) and compat.soft_falloff(light) else 0
    bounces = getattr(cycles, "max_bounces", UNLIMITED)
    flags |= 0 if bounces >= UNLIMITED else bounces + 1 << BOUNCES_SHIFT
    if not np.any(strength):
        return None
    spread = max(light.spread, NARROWEST_SPREAD) if light.type == "AREA" else 0.0
    return Lamp(ob.name, kind, to_world, strength, size, spot, spread, flags, visibility)


def point_shape(light, lengths):
    return POINT, (light.shadow_soft_size, 0.0), (0.0, 0.0)


def spot_shape(light, lengths):
    _, size, _ = point_shape(light, lengths)
    return SPOT, size, (light.spot_size, light.spot_blend)


def sun_shape(light, lengths):
    return SUN, (light.angle, 0.0), (0.0, 0.0)


def area_shape(light, lengths):
    square = light.shape in ("SQUARE", "DISK")
    size = (light.size * lengths[0], (light.size if square else light.size_y) * lengths[1])
    return (ELLIPSE if light.shape in ("DISK", "ELLIPSE") else RECTANGLE), size, (0.0, 0.0)


SHAPES = {"POINT": point_shape, "SPOT": spot_shape, "SUN": sun_shape, "AREA": area_shape}


def size_factor(kind: int, size) -> float:
    """What turns the strength of a lamp that is not normalised into that of one that is."""
    if kind in (POINT, SPOT):
        return 4.0 * math.pi * size[0] ** 2 if size[0] > 0.0 else 1.0
    if kind == SUN:
        return math.pi * math.sin(0.5 * size[0]) ** 2 if size[0] > 0.0 else 1.0
    area = size[0] * size[1] * (math.pi / 4.0 if kind == ELLIPSE else 1.0)
    return area if area > 0.0 else 1.0


def node_factor(light, values: Values) -> np.ndarray:
    """Colour times strength of the Emission node that feeds a lamp's output, f8 [3]; 1 without nodes."""
    if not compat.uses_nodes(light):
        return np.ones(3)
    output = light.node_tree.get_output_node("CYCLES")
    source = source_of(find_input(output, "Surface")) if output else None
    if source is None or source.node is None:
        values.note("its nodes have no shader at the output: gives no light")
        return np.zeros(3)
    if source.node.bl_idname != "ShaderNodeEmission":
        values.note(f"{source.node.name} ({source.node.bl_idname}): not supported in a lamp, taken as 1")
        return np.ones(3)
    color = values.color(source.node, source.stack, "Color").astype(np.float64)
    return color * values.number(source.node, source.stack, "Strength")


def join_lights(lamps: list[Lamp]) -> dict[str, np.ndarray]:
    """The scene's light arrays."""
    if not lamps:
        return {}
    return {
        "light_kind": np.array([lamp.kind for lamp in lamps], np.int32),
        "light_to_world": np.stack([lamp.to_world for lamp in lamps]),
        "light_strength": np.stack([lamp.strength for lamp in lamps]),
        "light_size": np.array([lamp.size for lamp in lamps], np.float64),
        "light_spot": np.array([lamp.spot for lamp in lamps], np.float64),
        "light_spread": np.array([lamp.spread for lamp in lamps], np.float64),
        "light_flags": np.array([lamp.flags for lamp in lamps], np.uint32),
        "light_visibility": np.array([lamp.visibility for lamp in lamps], np.uint32),
    }
