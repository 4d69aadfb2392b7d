# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps: Blender's numbers, unit axes and a place; docs/units.md says what they mean as light.

What newer versions add is folded into the strength: colour temperature, exposure, the factor of an
Emission node, and lamps that are not normalised by their size.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from isophote.material_program import MaterialProgram, make_material
from isophote.records import numbers
from isophote.values import ProgramTooLarge, varies

from .. import compat
from .closures import Closure, arrange
from .lamp_space import ELLIPSE, POINT, RECTANGLE, SPOT, SUN, LampSpace
from .lookups import Lookups
from .material import TOO_LARGE, emitted_radiance
from .nodes import find_input, source_of
from .values import Values

NO_SHADOW, NO_MIS, FACING_DISK = 1, 2, 4
NARROWEST_SPREAD = 1e-3  # radians: 0 stands for a parallel beam in Blender, and for no limit in a scene
UNLIMITED = 255  # bounces that no path has


@dataclass
class Lamp:
    """One light of the scene; fields as in isophote/scene.py. `program`: what its nodes emit, where that varies."""

    name: str
    kind: int
    to_world: np.ndarray  # f8 [3, 4], relative to the origin
    strength: np.ndarray  # f8 [3]
    size: tuple[float, float]
    spot: tuple[float, float]
    spread: float
    flags: int
    visibility: int
    program: MaterialProgram | None
    link: int = 0  # its number in LightLinking


def export_light(ob, matrix: np.ndarray, origin: np.ndarray, visibility: int, notes, lookups: Lookups,
                 known) -> Lamp | None:
    """A lamp object at `matrix` (f8 [4, 4], world) as a Lamp; None where it gives no light. `known` as in LampSpace."""
    light = ob.data
    values = Values("light", ob.name, notes, lookups)
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    kind, size, spot = SHAPES[light.type](light, lengths)
    cycles = getattr(light, "cycles", None)
    if light.type == "AREA" and getattr(cycles, "is_portal", False):
        values.note("portals do not guide the light of the world: noisier, not another picture")
        return None
    strength = np.array(light.color[:3], dtype=np.float64) * compat.light_energy(light)
    values.lamp = LampSpace(kind, matrix, size, spot[0], known)
    factor, program = node_factor(light, values)
    strength *= compat.light_factor(light) * factor
    if not getattr(light, "normalize", True):
        strength *= size_factor(kind, size)
    to_world = np.zeros((3, 4))
    to_world[:, :3] = matrix[:3, :3] if kind == SPOT else matrix[:3, :3] / np.where(lengths > 0.0, lengths, 1.0)
    to_world[:, 3] = matrix[:3, 3] - origin
    flags = 0 if compat.casts_shadow(light) else NO_SHADOW
    flags |= 0 if getattr(cycles, "use_multiple_importance_sampling", True) else NO_MIS
    flags |= FACING_DISK if kind in (POINT, SPOT) and compat.soft_falloff(light) else 0
    bounces = getattr(cycles, "max_bounces", UNLIMITED)
    flags |= 0 if bounces >= UNLIMITED else bounces + 1 << numbers()["LIGHT_BOUNCES_SHIFT"]
    if not np.any(strength):
        return None
    spread = max(light.spread, NARROWEST_SPREAD) if light.type == "AREA" else 0.0
    return Lamp(ob.name, kind, to_world, strength, size, spot, spread, flags, visibility, program)


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


def node_factor(light, values: Values) -> tuple[np.ndarray, MaterialProgram | None]:
    """What a lamp's nodes emit, f8 [3], 1 without nodes; or 1 and a program, where that varies."""
    if not compat.uses_nodes(light):
        return np.ones(3), None
    output = light.node_tree.get_output_node("CYCLES")
    surface = find_input(output, "Surface") if output else None
    if surface is None or source_of(surface).node is None:
        values.note("its nodes have no shader at the output: gives no light")
        return np.zeros(3), None
    radiance = emitted_radiance(values, surface)
    if not varies(radiance):
        return radiance.astype(np.float64), None
    try:
        return np.ones(3), make_material(arrange([Closure("emission", radiance)]))
    except ProgramTooLarge as error:
        values.note(f"its node graph is too large ({error}): shines magenta")
        return np.array(TOO_LARGE), None


def join_lights(lamps: list[Lamp], add_program) -> dict[str, np.ndarray]:
    """The scene's light arrays; `add_program(program, name)` gives a material's number."""
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
        "light_material": np.array([lamp.program and add_program(lamp.program, lamp.name) + 1 or 0 for lamp in lamps],
                                   np.uint32),
    }
