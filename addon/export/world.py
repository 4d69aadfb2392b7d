# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: one radiance in all directions, or a material whose emission is the radiance of a direction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isophote.material_program import MaterialProgram, make_material
from isophote.values import ProgramTooLarge, varies

from .. import compat
from .closures import Closure, arrange
from .lookups import Lookups
from .material import TOO_LARGE, emitted_radiance
from .nodes import find_input, live_link
from .values import Values

RAYS = (("camera", 1), ("diffuse", 2), ("glossy", 4), ("transmission", 8))  # RAY_ bits of kernels/scene_records.h


@dataclass
class World:
    """`radiance` W/(m^2 sr), f8 [3], or `program` where it differs by direction; kinds of rays that do not see it."""

    radiance: np.ndarray
    program: MaterialProgram | None = None
    hidden: int = 0


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
    if live_link(output.inputs["Volume"]):
        values.note("volumes are not supported: left out")
    radiance = emitted_radiance(values, find_input(output, "Surface"))
    if not varies(radiance):
        return World(np.maximum(radiance.astype(np.float64), 0.0), None, hidden)
    try:
        program = make_material(arrange([Closure("emission", radiance)]))
    except ProgramTooLarge as error:
        values.note(f"its node graph is too large ({error}): rendered magenta")
        return World(np.array(TOO_LARGE), None, hidden)
    return World(np.zeros(3), program, hidden)
