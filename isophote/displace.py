"""Vertices moved by the displacement of their materials, once a scene is exported.

A displacement is a program that emits it, a vector of the world: what nodes compute is asked of the kernels, as that of
textured lights is. As in Cycles (src/scene/mesh_displace.cpp) a vertex is asked for once, at its corner of the first
triangle whose material moves it, and meshes that several objects share are moved as the first of them sees them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from isophote.emission import emitted
from isophote.flatten import matrix_ranks
from isophote.geometry import baked_buffers, mesh_uses, own_trees
from isophote.material_program import Displacement, MaterialProgram, join_materials
from isophote.prepare import program_buffers
from isophote.scene import Scene, make_scene

NOTHING = MaterialProgram([], [], 0)
AT_ONCE = 1 << 14  # triangles that are worked at together: what caches hold
OF_INSTANCES = "instance_"  # how the names of arrays begin that have a row for each instance


@dataclass
class Moving:
    """What moves of a mesh: its number, that of the instance it is seen as, the slice of its vertices and its
    triangles, vertex indices [T, 3] within the mesh; which vertices move, and of the triangles and corners where they
    are asked for numbers and unit normals; which triangles get new normals, bool [T]."""

    mesh: int
    instance: int
    span: slice
    triangles: np.ndarray
    vertices: np.ndarray
    primitives: np.ndarray
    corners: np.ndarray
    normals: np.ndarray
    turning: np.ndarray


def displaced(scene: Scene, displacements: dict[int, Displacement], flat_normals: dict[int, np.ndarray]) -> Scene:
    """The scene with the vertices of its meshes moved and their normals made anew.

    `displacements` by number of the material; `flat_normals` are unit normals of the vertices, f4 [V, 3], of meshes
    without normals of their own, by number of the mesh: flat meshes move along these, too, and stay flat. Vertices
    whose displacement is no number stay, and a note names the mesh.
    """
    moving = moving_parts(scene, displacements)
    if not moving:
        return scene
    shown = as_shown(scene, displacements, flat_normals, [part.instance for part in moving])
    own = own_trees(shown)
    buffers = program_buffers(shown, baked_buffers(shown, own, mesh_uses(shown, own)))
    vertices, normals, notes = scene.vertices.copy(), scene.normals.copy(), []
    for number, part in enumerate(moving):
        own = vertices[part.span]
        to_world = scene.instance_to_world[part.instance, :, :3]
        offsets = offsets_of(buffers, number, part, to_world, scene.mesh_triangles[part.mesh])
        fine = np.isfinite(offsets).all(axis=1)
        if not fine.all():
            notes.append({"kind": "mesh", "name": scene.name_of("meshes", part.mesh),
                          "what": f"the displacement of {np.sum(~fine)} vertices is no number: left where they are"})
        own[part.vertices[fine]] += offsets[fine]
        first = scene.mesh_normals[part.mesh]
        if first >= 0 and part.turning.any():
            turn_normals(normals[first:first + len(own)], own, part.triangles[part.turning])
    return replace(scene, arrays=scene.arrays | {"vertices": vertices, "normals": normals}, notes=scene.notes + notes)


def moving_parts(scene: Scene, displacements: dict[int, Displacement]) -> list[Moving]:
    """Of all meshes that an instance shows with a material that moves them."""
    count = len(scene.material_first) - 1
    moves, turns = np.zeros(count, bool), np.zeros(count, bool)
    moves[list(displacements)] = True
    turns[[number for number, each in displacements.items() if each.turns_normals]] = True
    there = np.flatnonzero(matrix_ranks(scene.instance_to_world) == 3)  # flatten.py and validate.py see to the others
    meshes, first_instance = np.unique(scene.instance_mesh[there], return_index=True)
    made = []
    for mesh, instance in zip(meshes.tolist(), there[first_instance].tolist(), strict=True):
        begin, end = scene.mesh_triangles[mesh:mesh + 2].tolist()
        slots = scene.triangle_slots[begin:end] if len(scene.triangle_slots) else np.zeros(end - begin, np.uint16)
        material = scene.slot_materials[scene.instance_slots[instance] + slots.astype(np.int64)]
        if not moves[material].any():
            continue
        span = slice(*scene.mesh_vertices[mesh:mesh + 2].tolist())
        triangles = scene.triangles[begin:end].astype(np.int64) - span.start
        of_faces = face_normals(scene.vertices[span], triangles)
        asked = np.flatnonzero(moves[material] & of_faces.any(axis=1))  # others have no side to be asked from
        places = np.full(span.stop - span.start, -1)
        corners = triangles[asked].ravel()
        places[corners[::-1]] = np.arange(len(corners))[::-1]  # the first of each stays
        vertices = np.flatnonzero(places >= 0)
        primitives, corner = asked[places[vertices] // 3], places[vertices] % 3
        made.append(Moving(mesh, instance, span, triangles, vertices, primitives, corner, of_faces[primitives],
                           turns[material]))
    return made


def as_shown(scene: Scene, displacements: dict[int, Displacement], flat_normals: dict[int, np.ndarray],
             instances: list[int]) -> Scene:
    """The scene with these instances only, all of them smooth, of materials that emit their displacement."""
    arrays = scene.arrays | {name: array[instances] for name, array in scene.arrays.items()
                             if name.startswith(OF_INSTANCES) and len(array)}
    programs = [displacements[number].program if number in displacements else NOTHING
                for number in range(len(scene.material_first) - 1)]
    arrays = {name: array for name, array in arrays.items()
              if not name.startswith(("instruction_", "step_", "aov_")) and not name.endswith("_volume")}
    flat = [mesh for mesh in arrays["instance_mesh"].tolist() if scene.mesh_normals[mesh] < 0]
    first, added = scene.mesh_normals.copy(), [scene.normals]
    for mesh in flat:
        first[mesh] = sum(map(len, added))
        added.append(flat_normals[mesh])
    return make_scene(**arrays | join_materials(programs) | {"normals": np.concatenate(added), "mesh_normals": first})


def offsets_of(buffers: dict[str, np.ndarray], instance: int, part: Moving, to_world: np.ndarray,
               first_triangle: int) -> np.ndarray:
    """How far the vertices of a part move in the object's space, f8 [n, 3], as seen from in front of the triangles."""
    to_object = np.linalg.inv(to_world)
    ahead = unit(turned(part.normals, to_object.T))
    swapped = np.linalg.det(to_world) < 0  # kernels have mirrored triangles the other way around
    weights = np.array([[0, 0], [0, 1], [1, 0]] if swapped else [[0, 0], [1, 0], [0, 1]], np.float32)
    ids = np.stack([np.full(len(part.primitives), instance), part.primitives + int(first_triangle)], axis=1)
    made = emitted(buffers, ids.astype(np.uint32), weights[part.corners], -ahead)
    with np.errstate(invalid="ignore"):
        return turned(made.astype(np.float64), to_object)


def turn_normals(normals: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> None:
    """Gives the vertices of triangles the mean of the triangles' normals, each of the same weight, as Cycles does."""
    of_faces, corners = face_normals(vertices, triangles), triangles.ravel()
    total = np.stack([np.bincount(corners, np.repeat(of_faces[:, k], 3), len(vertices)) for k in range(3)], axis=1)
    there = total.any(axis=1)
    normals[there] = unit(total[there])


def face_normals(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Unit, f8 [T, 3]; 0 of triangles without an area."""
    made = np.empty((len(triangles), 3))
    for first in range(0, len(triangles), AT_ONCE):
        block = slice(first, first + AT_ONCE)
        a, b, c = vertices[triangles[block].T].astype(np.float64)
        made[block] = unit(np.cross(b - a, c - a))
    return made


def unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors of length 1, [n, 3]; 0 stays 0."""
    x, y, z = vectors.T
    length = np.sqrt(x * x + y * y + z * z)[:, None]
    return vectors / np.where(length > 0.0, length, 1.0)


def turned(vectors: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Vectors [n, 3] times a matrix [3, 3], in an order of adding that no library chooses."""
    return sum(vectors[:, k, None] * matrix[:, k] for k in range(3))
