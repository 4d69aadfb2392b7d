# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that move and meshes that deform while the shutter is open, from Blender's scene at several times.

As Cycles has it (intern/cycles/blender/object.cpp, geometry.cpp): each object has 2^n + 1 keys, instances are told
apart by what made them and Blender's persistent numbers, and lamps stay. Other than there a mesh whose vertices move
counts as deforming, whatever moves them.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from isophote.scene import Scene

from .. import compat
from .instances import is_sphere, matrices_of
from .mesh import evaluated_mesh
from .notes import Notes

MOVED = 1e-6  # relative change of a matrix from which on an object counts as moving
OTHER_VERTICES = "its mesh has other vertices while the shutter is open: it stays"
STILL_STRANDS = "strands are not looked at while the shutter is open: they follow their object"
SAME_DISPLACEMENT = "its mesh deforms while the shutter is open, its displacement is that of the middle of that time"


def identities(depsgraph, numbers: list[int]) -> list[tuple]:
    """What tells instances, by their numbers in depsgraph.object_instances, from others at any time. A number may be
    there twice, as that of an object that is held out."""
    wanted = set(numbers)
    found = {k: identity(instance) for k, instance in enumerate(depsgraph.object_instances) if k in wanted}
    return [found[number] for number in numbers]


def identity(instance) -> tuple:
    own = instance.object.original.as_pointer()
    if not instance.is_instance:
        return own, 0, ()
    return own, instance.parent.original.as_pointer(), tuple(instance.persistent_id)


def walk(depsgraph):
    """(number, identity, instance) of everything that is shown."""
    for number, instance in enumerate(depsgraph.object_instances):
        if instance.show_self or instance.show_particles:
            yield number, identity(instance), instance


def motion_steps(ob, parent) -> int:
    """n of an object's 2^n + 1 keys, 0 where it is to stay; what made an instance has a say, too."""
    steps = 1
    for each in {ob, parent} - {None}:
        settings = getattr(each, "cycles", None)
        if not getattr(settings, "use_motion_blur", True):
            return 0
        steps = max(steps, getattr(settings, "motion_steps", 1))
    return steps


def deforms(ob, parent) -> bool:
    return all(getattr(getattr(each, "cycles", None), "use_deform_motion", True) for each in (ob, parent) if each)


def parts_of(steps: int) -> list[float]:
    """Times of an object's keys, from 0 to 1 over the shutter's time."""
    return [k / 2 ** steps for k in range(2 ** steps + 1)]


@dataclass
class Shape:
    """A mesh at one time, its vertices and corners in Blender's order. `normals` of the corners, None where it is
    flat."""

    vertices: np.ndarray
    corners: int
    normals: np.ndarray | None = None

    def hashed(self) -> tuple[tuple[int, int], int]:
        """Numbers of vertices and corners, and what differs where the vertices are elsewhere."""
        return (len(self.vertices), self.corners), hash(self.vertices.tobytes())


@dataclass
class Moving:
    """Follows the instances of an exported scene through time: `prepare` at the middle of the shutter's time, `look` at
    each other one, `finish` at the middle again. With `all_move` everything has three keys, whatever its settings."""

    scene: Scene
    notes: Notes
    all_move: bool = False
    steps: list[int] = field(default_factory=list)  # of each instance
    places: dict[float, np.ndarray] = field(default_factory=dict)  # f8 [I, 4, 4] by time, NaN where one is missing
    spheres: dict[tuple, np.ndarray] = field(default_factory=dict)  # matrices in the middle
    users: dict[tuple, int] = field(default_factory=dict)  # the mesh of one instance of each that may deform
    middle: dict[int, tuple] = field(default_factory=dict)  # of these meshes, Shape.hashed
    shapes: dict[int, dict[float, Shape | None]] = field(default_factory=dict)  # by mesh and time, where they differ
    mesh_steps: dict[int, int] = field(default_factory=dict)

    def __post_init__(self):
        self.row_of: dict[tuple, int] = {}  # first row of each identity
        self.first_rows = [self.row_of.setdefault(key, row) for row, key in enumerate(self.scene.identities)]

    def prepare(self, depsgraph) -> None:
        self.steps = [0] * len(self.first_rows)
        for _, key, instance in walk(depsgraph):
            ob, parent = instance.object, instance.parent if instance.is_instance else None
            row, steps = self.row_of.get(key), 1 if self.all_move else motion_steps(ob, parent)
            if steps and instance.show_self and is_sphere(ob):
                self.spheres[key] = np.array(instance.matrix_world)
            if row is None:
                continue
            self.steps[row] = steps
            mesh = int(self.scene.instance_mesh[row])
            is_mesh = not self.scene.mesh_radii[mesh]
            if is_mesh and steps and mesh not in self.mesh_steps and (self.all_move or deforms(ob, parent)):
                self.users[key], self.mesh_steps[mesh] = mesh, steps
                self.middle[mesh] = read_shape(ob).hashed()

        for row in np.flatnonzero(self.scene.mesh_radii[self.scene.instance_mesh]):
            if self.steps[self.first_rows[row]]:
                self.notes.add("object", self.scene.name_of("instances", row), STILL_STRANDS)

    def times(self) -> set[float]:
        return {part for steps in set(self.steps) if steps for part in parts_of(steps)}

    def look(self, depsgraph, time: float) -> None:
        places = self.places[time] = np.full((len(self.first_rows), 4, 4), np.nan)
        matrices = matrices_of(depsgraph.object_instances)
        for number, key, instance in walk(depsgraph):
            row = self.row_of.get(key)
            if row is not None:
                places[row] = matrices[number]
            if key in self.users:
                self.compare(self.users[key], instance.object, time)
            if key in self.spheres and not np.array_equal(self.spheres[key], instance.matrix_world):
                self.notes.add("object", instance.object.name, "a sphere that moves is not supported: it stays")

    def compare(self, mesh: int, ob, time: float) -> None:
        found, before = read_shape(ob), self.middle[mesh]
        if found is None or found.hashed()[0] != before[0]:
            self.notes.add("object", ob.name, OTHER_VERTICES)
            self.shapes.setdefault(mesh, {})[time] = None
        elif found.hashed() != before:
            smooth = self.scene.mesh_normals[mesh] >= 0
            self.shapes.setdefault(mesh, {})[time] = read_shape(ob, smooth=True) if smooth else found

    def finish(self, depsgraph) -> dict[str, np.ndarray]:
        """The scene's arrays of motion."""
        return self.key_arrays() | self.shape_arrays(depsgraph)

    def key_arrays(self) -> dict[str, np.ndarray]:
        own, first = self.scene.instance_to_world, np.array(self.first_rows, int)
        steps, counts, made = np.array(self.steps, int)[first], np.zeros(len(own), np.uint32), {}
        for each in set(self.steps) - {0}:
            rows = np.flatnonzero(steps == each)
            keys = np.stack([self.places_at(first[rows], time) for time in parts_of(each)], axis=1)
            change = np.abs(keys - own[rows, None]).max(axis=(1, 2, 3))
            moved = ~(change <= MOVED * np.abs(own[rows]).max(axis=(1, 2)))
            counts[rows[moved]] = keys.shape[1]
            made |= zip(rows[moved].tolist(), keys[moved], strict=True)
        if not made:
            return {}
        return {"instance_keys": counts, "key_to_world": np.concatenate([made[row] for row in sorted(made)])}

    def places_at(self, rows: np.ndarray, time: float) -> np.ndarray:
        """f8 [n, 3, 4]; those of the middle where there is no such instance at that time."""
        own = self.scene.instance_to_world[rows]
        if time == 0.5:
            return own
        found = self.places[time][rows]
        found[:, :3, 3] -= self.scene.origin
        return np.where(np.isnan(found[:, 3, 3])[:, None, None], own, found[:, :3])

    def shape_arrays(self, depsgraph) -> dict[str, np.ndarray]:
        deforming = {mesh: shapes for mesh, shapes in self.shapes.items() if all(shapes.values())}
        found, displacements = {}, {}
        for _, key, instance in walk(depsgraph) if deforming else ():
            mesh = self.users.get(key)
            if mesh in deforming:
                found[mesh] = corners_of_vertices(self.scene, mesh, instance.object)
                if found[mesh] is None:
                    self.notes.add("object", instance.object.name, OTHER_VERTICES)
                    continue
                own = slice(self.scene.mesh_vertices[mesh], self.scene.mesh_vertices[mesh + 1])
                displacements[mesh] = self.scene.vertices[own] - read_shape(instance.object).vertices[found[mesh][0]]
                if displacements[mesh].any():
                    self.notes.add("object", instance.object.name, SAME_DISPLACEMENT)
        counts, vertices, normals = np.zeros(len(self.scene.mesh_normals), np.uint32), [], []
        for mesh, corners in sorted(found.items()):
            if corners is None:
                continue
            own = slice(self.scene.mesh_vertices[mesh], self.scene.mesh_vertices[mesh + 1])
            first = int(self.scene.mesh_normals[mesh])
            times = parts_of(self.mesh_steps[mesh])
            counts[mesh] = len(times)
            for time in times:
                shape = deforming[mesh].get(time)
                moved = displacements[mesh]
                vertices.append(shape.vertices[corners[0]] + moved if shape else self.scene.vertices[own])
                if first >= 0:
                    stays = self.scene.normals[first:first + own.stop - own.start]
                    turns = shape and shape.normals is not None and not moved.any()
                    normals.append(shape.normals[corners[1]] if turns else stays)
        if not vertices:
            return {}
        made = {"mesh_keys": counts, "key_vertices": np.concatenate(vertices)}
        return made | ({"key_normals": np.concatenate(normals)} if normals else {})


def read_shape(ob, smooth: bool = False) -> Shape | None:
    """Without normals unless it is smooth; None where an object has no mesh now."""
    mesh, is_copy = evaluated_mesh(ob)
    if mesh is None:
        return None
    try:
        vertices = np.array(compat.vertex_positions(mesh)).reshape(-1, 3)
        if not smooth:
            return Shape(vertices, len(mesh.loops))
        mesh.calc_loop_triangles()
        corners = compat.triangle_corners(mesh, len(mesh.loop_triangles)).reshape(-1, 3)
        return Shape(vertices, len(mesh.loops), compat.corner_normals(mesh, compat.corner_vertices(mesh), corners))
    finally:
        if is_copy:
            ob.to_mesh_clear()


def corners_of_vertices(scene: Scene, mesh: int, ob) -> tuple[np.ndarray, np.ndarray] | None:
    """Blender's vertex and one of its corners for each vertex of an exported mesh, from the object as it was exported;
    None where that is no longer so. Vertices of no triangle are Blender's own."""
    found, is_copy = evaluated_mesh(ob)
    try:
        found.calc_loop_triangles()
        corners = compat.triangle_corners(found, len(found.loop_triangles))
        first, end = (int(each) for each in scene.mesh_triangles[mesh:mesh + 2])
        used = (scene.triangles[first:end] - scene.mesh_vertices[mesh]).reshape(-1)
        if len(corners) != len(used):
            return None
        of_vertex = np.zeros(int(scene.mesh_vertices[mesh + 1] - scene.mesh_vertices[mesh]), np.int64)
        of_vertex[used] = corners
        vertices = np.arange(len(of_vertex))
        vertices[used] = compat.corner_vertices(found)[corners]
        return vertices, of_vertex
    finally:
        if is_copy:
            ob.to_mesh_clear()
