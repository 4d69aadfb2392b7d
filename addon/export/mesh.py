# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluated meshes as arrays: positions, triangles, slots and, where the mesh is smooth, normals of vertices.

Only foreach_get into numpy, and only the calls that a mesh needs: no slots are read where there is one
material, no normals where every face is flat.
"""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np

from .. import compat
from .attributes import Attribute, read_attribute


@dataclass
class MeshArrays:
    """One mesh, object space. `normals` is None for flat meshes, `slots` where all are 0. `radii` make it strands: its
    triangles are segments (isophote/scene.py, FIELDS)."""

    name: str
    vertices: np.ndarray  # f4 [V, 3]
    triangles: np.ndarray  # u4 [T, 3]
    slots: np.ndarray | None  # u2 [T]
    normals: np.ndarray | None  # f4 [V, 3]
    radii: np.ndarray | None = None  # f4 [V]


def export_mesh(ob) -> MeshArrays | None:
    """Triangulate what an evaluated object looks like; None where it has no faces.

    Works for meshes and metaballs: whatever has a mesh.
    """
    mesh, is_copy = evaluated_mesh(ob)
    if mesh is None:
        return None
    try:
        return read_mesh(mesh, ob.data.name if ob.data else ob.name)
    finally:
        if is_copy:
            ob.to_mesh_clear()


def export_attributes(ob, keys) -> dict[tuple, Attribute | None]:
    """The attributes of an evaluated object's mesh by key, None for those that it does not have."""
    mesh, is_copy = evaluated_mesh(ob)
    try:
        mesh.calc_loop_triangles()
        corners = compat.triangle_corners(mesh, len(mesh.loop_triangles)).reshape(-1, 3)
        split = compat.corner_normals(mesh, compat.corner_vertices(mesh), corners) is not None
        return {key: read_attribute(mesh, *key, split) for key in keys}
    finally:
        if is_copy:
            ob.to_mesh_clear()


def evaluated_mesh(ob) -> tuple:
    """(mesh, whether it is a copy that to_mesh_clear() drops) of an evaluated object, None where it has none.

    Blender 4.5 and newer subdivide here, when the mesh is first asked for, and earlier ones before they render.
    """
    if ob.type == "MESH" and not ob.data.is_editmode and not compat.reading_changes(ob.data):
        return ob.data, False  # Cycles reads this one, too: a copy costs time, and computed normals go with it
    try:
        return ob.to_mesh(), True
    except RuntimeError:  # an object type without a mesh
        return None, False


def read_mesh(mesh, name: str) -> MeshArrays | None:
    """Arrays of a bpy Mesh, None where it has no faces."""
    if len(mesh.polygons) == 0:
        return None
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    if count == 0:
        return None
    corners, corner_vertices = compat.triangle_corners(mesh, count).reshape(-1, 3), compat.corner_vertices(mesh)
    vertices = compat.vertex_positions(mesh).reshape(-1, 3)
    normals = compat.corner_normals(mesh, corner_vertices, corners)
    if normals is not None:
        vertices, corner_vertices, normals = split_vertices(vertices, corner_vertices, normals)
    return MeshArrays(name, vertices, np.take(corner_vertices, corners), compat.triangle_slots(mesh, count), normals)


def split_vertices(vertices: np.ndarray, corner_vertices: np.ndarray, corner_normals: np.ndarray):
    """(vertices, vertex of each corner, normal of each vertex): a vertex is there once for each of its normals."""
    from isophote import _native  # the add-on loads without it, to say what is wrong

    corner_vertices, added, normals = _native.split_vertices(
        corner_vertices, corner_normals, len(vertices), os.cpu_count() or 1)
    return (np.concatenate([vertices, vertices[added]]) if len(added) else vertices), corner_vertices, normals


def join_meshes(meshes: list[MeshArrays]) -> dict[str, np.ndarray]:
    """Concatenate meshes into the scene's arrays (isophote/scene.py, FIELDS)."""
    if not meshes:
        return {"mesh_vertices": np.zeros(1, np.uint32), "mesh_triangles": np.zeros(1, np.uint32)}
    first_vertex = np.cumsum([0] + [len(m.vertices) for m in meshes])
    smooth = [m.normals is not None for m in meshes]
    first_normal = np.cumsum([0] + [len(m.normals) if s else 0 for m, s in zip(meshes, smooth, strict=False)])
    arrays = {
        "vertices": joined([m.vertices for m in meshes]),
        "triangles": joined([m.triangles + np.uint32(v) if v else m.triangles
                             for m, v in zip(meshes, first_vertex, strict=False)]),
        "mesh_vertices": first_vertex.astype(np.uint32),
        "mesh_triangles": np.cumsum([0] + [len(m.triangles) for m in meshes]).astype(np.uint32),
        "mesh_normals": np.where(smooth, first_normal[:-1], -1).astype(np.int32),
    }
    radii = [m.radii for m in meshes if m.radii is not None]
    if radii:
        counts = np.array([0 if m.radii is None else len(m.radii) for m in meshes])
        arrays["mesh_radii"] = np.where(counts > 0, 1 + np.cumsum(counts) - counts, 0).astype(np.int32)
        arrays["radii"] = joined(radii)
    if any(smooth):
        arrays["normals"] = joined([m.normals for m in meshes if m.normals is not None])
    if any(m.slots is not None for m in meshes):
        arrays["triangle_slots"] = joined([np.zeros(len(m.triangles), np.uint16) if m.slots is None else m.slots
                                           for m in meshes])
    return arrays


def joined(arrays: list[np.ndarray]) -> np.ndarray:
    """One array of several, without a copy where there is one only."""
    return arrays[0] if len(arrays) == 1 else np.concatenate(arrays)
