# SPDX-License-Identifier: GPL-3.0-or-later
"""The meshes of one export, and when those of the export before are still the same.

Where Blender's dependency graph lives from frame to frame (Persistent Data), it tells what it has evaluated anew
since it was last rendered, and it owns the meshes that it shows: what it has not evaluated is as it was. Cycles goes
by the same list (blender/cycles, src/blender/sync.cpp, BlenderSync::sync_recalc).

All meshes are taken over or none, because joining their arrays costs as much as reading them.
"""

from __future__ import annotations

import bpy
import numpy as np

from .mesh import MeshArrays, export_attributes, export_mesh, join_meshes
from .strands import Refined, read_curves, read_hair, refine, strand_attributes

VERTEX_NORMALS = "normal", ""  # key of an attribute
WITHOUT_MESHES = {"CAMERA", "LIGHT", "LIGHT_PROBE", "SPEAKER"}


class OthersMet(Exception):
    """The dependency graph shows other meshes, or in another order, than in the export before."""


class Meshes:
    """Each mesh is read when it is first met; with `before`, they are those of that export, else OthersMet is raised.

    `names`, `needed` (the slots that a mesh uses), `flat`, `flat_normals` (of the vertices of flat meshes that are
    displaced) and `attributes` (those that were asked for, by key) go by the mesh's number.
    """

    def __init__(self, before: Meshes | None = None):
        self._expected = iter(before._number_of.items()) if before else None
        self.names: list[str] = before.names if before else []
        self.needed: list[int] = before.needed if before else []
        self.flat: list[bool] = before.flat if before else []
        self.flat_normals: dict[int, np.ndarray] = before.flat_normals if before else {}
        self.attributes: list[dict] = before.attributes if before else []
        self.lasting = True  # whether `updates` tells of all that they depend on, which of strands is not known
        self._number_of: dict[tuple, int | None] = {}  # by the evaluated data, in the order in which they are met
        self._read: list[MeshArrays] = []
        self._strands: dict[int, Refined] = {}
        self._arrays = before._arrays if before else None

    def number_of(self, ob, attributes=(), displaced=()) -> int | None:
        """Of the mesh of an evaluated object, None where it has no faces. `attributes`: keys of those that it must have
        (Lookups.attributes); `displaced`: what moves it, so that those that differ in it are meshes of their own."""
        data = ob.data
        if data is None:
            return None
        # The mesh of metaballs depends on more than their data.
        key = data.as_pointer(), ob.original.as_pointer() if ob.type == "META" else None, displaced
        if key not in self._number_of:
            self._number_of[key] = self.read(ob) if self._expected is None else self.taken_over(key)
        number = self._number_of[key]
        if number is not None:
            missing = [each for each in attributes if each not in self.attributes[number]]
            if missing:
                self.attributes[number] |= export_attributes(ob, missing)
            if displaced and self.flat[number] and number not in self.flat_normals:
                self.flat_normals[number] = export_attributes(ob, [VERTEX_NORMALS])[VERTEX_NORMALS].values
        return number

    def number_of_strands(self, ob, modifier, depsgraph, attributes=()) -> int | None:
        """Likewise of the hair that a particle modifier makes; without one, of a Curves object."""
        key = (ob.original if modifier else ob.data).as_pointer(), modifier and modifier.name, ()
        if self._expected is not None:
            raise OthersMet
        if key not in self._number_of:
            self.lasting = False
            strands = read_hair(ob, modifier, depsgraph) if modifier else read_curves(ob)
            refined = refine(strands) if strands else None
            self._number_of[key] = self.add(refined and refined.arrays)
            if refined:
                self._strands[self._number_of[key]] = refined
        number = self._number_of[key]
        if number is not None:
            missing = [each for each in attributes if each not in self.attributes[number]]
            self.attributes[number] |= strand_attributes(ob, modifier, self._strands[number], missing)
        return number

    def read(self, ob) -> int | None:
        self.lasting &= ob.type == "MESH" and not ob.data.is_editmode
        return self.add(export_mesh(ob))

    def add(self, arrays: MeshArrays | None) -> int | None:
        if arrays is None:
            return None
        self.names.append(arrays.name)
        self.needed.append(1 if arrays.slots is None else int(arrays.slots.max()) + 1)
        self.flat.append(arrays.normals is None)
        self.attributes.append({})
        self._read.append(arrays)
        return len(self.names) - 1

    def taken_over(self, key: tuple) -> int | None:
        expected, number = next(self._expected, (None, None))
        if expected != key:
            raise OthersMet
        return number

    def join(self) -> dict[str, np.ndarray]:
        """The scene's arrays of all of them, once everything has been met."""
        if self._expected is None:
            self._arrays, self._read, self._strands = join_meshes(self._read), [], {}
        elif next(self._expected, None):
            raise OthersMet
        return self._arrays


class Changes:
    """Follows the dependency graph of one engine, which must ask for each export: updates are told once."""

    def __init__(self):
        self._meshes: Meshes | None = None

    def unchanged_meshes(self, depsgraph) -> Meshes | None:
        """Those of the export before, if it ended well and none was evaluated since."""
        meshes, self._meshes = self._meshes, None
        return meshes if meshes and meshes.lasting and not any(map(may_change_meshes, depsgraph.updates)) else None

    def exported(self, meshes: Meshes) -> None:
        self._meshes = meshes


def may_change_meshes(update) -> bool:
    """Whether a DepsgraphUpdate speaks of a mesh, or of an object whose geometry was evaluated."""
    if isinstance(update.id, bpy.types.Object):
        return update.is_updated_geometry and update.id.type not in WITHOUT_MESHES
    return isinstance(update.id, bpy.types.Mesh)
