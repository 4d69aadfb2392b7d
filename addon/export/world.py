# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: one radiance in all directions, or a material whose emission is the radiance of a direction."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from isophote.material_program import MaterialProgram, make_material
from isophote.values import ProgramTooLarge, rewritten, varies

from .. import compat
from .closures import Closure, arrange
from .lookups import Lookups
from .material import TOO_LARGE, emitted_radiance
from .nodes import find_input
from .values import Sun, Values
from .volume import volume_program

FAR_AWAY = 3e38
RAYS = (("camera", 1), ("diffuse", 2), ("glossy", 4), ("transmission", 8))  # RAY_ bits of kernels/scene_records.h

FALLOFFS = {"QUADRATIC": 2.0, "LINEAR": 1.0, "INVERSE_QUADRATIC": 0.5}


@dataclass
class World:
    """`radiance` W/(m^2 sr), f8 [3], or `program` where it differs by direction; kinds of rays that do not see it; its
    `sun`, as Scene.world_sun has it; the `volume` that fills it."""

    radiance: np.ndarray
    program: MaterialProgram | None = None
    hidden: int = 0
    sun: np.ndarray = field(default_factory=lambda: np.zeros((0, 4)))
    volume: MaterialProgram | None = None


def export_world(scene, notes, lookups: Lookups) -> World:
    """Black without a world, as in Cycles."""
    world = scene.world
    if world is None:
        return World(np.zeros(3))
    visibility = getattr(world, "cycles_visibility", None)
    hidden = sum(bit for name, bit in RAYS if not getattr(visibility, name, True))
    if not compat.uses_nodes(world):
        return World(np.array(world.color[:3], dtype=np.float64), None, hidden)
    values = Values("world", world.name, notes, lookups)
    output = world.node_tree.get_output_node("CYCLES")
    if output is None:
        return World(np.zeros(3))
    made = emitting_world(values, output, hidden)
    made.volume = volume_program(world, world.node_tree, "world", notes, lookups)
    return made


def emitting_world(values: Values, output, hidden: int) -> World:
    """What the surface of an output emits."""
    radiance = emitted_radiance(values, find_input(output, "Surface"))
    if not varies(radiance):
        return World(np.maximum(radiance.astype(np.float64), 0.0), None, hidden)
    try:
        program = make_material(arrange([Closure("emission", radiance)]))
    except ProgramTooLarge as error:
        values.note(f"its node graph is too large ({error}): rendered magenta")
        return World(np.array(TOO_LARGE), None, hidden)
    return World(np.zeros(3), program, hidden, sun_of(values.suns))


def mist_of(world) -> tuple[float, float, float]:
    """Start, depth and exponent of the falloff of a world's mist."""
    if world is None:
        return 0.0, 0.0, 1.0
    settings = world.mist_settings
    return settings.start, settings.depth, FALLOFFS[settings.falloff]


def occlusion_distance_of(world) -> float:
    """Within which surfaces occlude in the Ambient Occlusion pass, metres."""
    return FAR_AWAY if world is None else world.light_settings.distance


def sun_of(suns: list[Sun]) -> np.ndarray:
    """Direction in the world and half the angle of the one sun that there is, f8 [1, 4]; empty where there are several,
    or where directions reach the sky otherwise than turned."""
    found = {tuple(sun.direction.tolist()) + (sun.half,): sun for sun in suns}
    if len(found) != 1:
        return np.zeros((0, 4))
    (sun,) = found.values()
    turn = matrix_of(sun.seen)
    if turn is None or not np.allclose(turn @ turn.T, np.eye(3), atol=1e-5):
        return np.zeros((0, 4))
    return np.array([[*(turn.T @ sun.direction), sun.half]])


def matrix_of(vector: np.ndarray) -> np.ndarray | None:
    """Of the linear function that an array of expressions is of the direction in which one looks, f8 [3, 3]; None where
    it is none."""
    columns = [values_at(vector, axis) for axis in np.eye(3)]
    probe = np.array([0.36, -0.48, 0.8])
    tried = values_at(vector, probe)
    if tried is None or any(column is None for column in columns):
        return None
    matrix = np.stack(columns, axis=1)
    return matrix if np.allclose(matrix @ probe, tried, atol=1e-5) else None


def values_at(vector: np.ndarray, direction: np.ndarray) -> np.ndarray | None:
    """What expressions are in a direction; None where they read something else as well."""
    def place(call, inputs):
        return tuple(direction.tolist()) if call.name == "object_point" else None
    found = [rewritten(part, place) for part in vector]
    return None if varies(found) else np.array(found, np.float64)
