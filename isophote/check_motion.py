"""What may be wrong with what moves while the shutter is open: asked by validate.py."""

from __future__ import annotations

import os

import numpy as np

from isophote.motion import deforming, shape_range
from isophote.scene import Scene


def motion_errors(scene: Scene) -> list[tuple[str, int, str]]:
    """(group, number, what) of what does not fit: counts of keys against the arrays that hold them."""
    vertices, smooth = np.diff(scene.mesh_vertices.astype(np.int64)), scene.mesh_normals >= 0
    of_shapes = scene.mesh_keys.astype(np.int64) * vertices
    errors = [("instances", k, "it has one matrix alone to move by") for k in np.flatnonzero(scene.instance_keys == 1)]
    errors += [("meshes", k, "it has one shape alone to deform by") for k in np.flatnonzero(scene.mesh_keys == 1)]
    if scene.instance_keys.astype(np.int64).sum() != len(scene.key_to_world):
        errors.append(("instances", 0, "key_to_world has not the matrices that instance_keys counts"))
    if of_shapes.sum() != len(scene.key_vertices) or (of_shapes * smooth).sum() != len(scene.key_normals):
        errors.append(("meshes", 0, "key_vertices and key_normals have not the shapes that mesh_keys counts"))
    if not np.isfinite(scene.key_normals).all():
        errors.append(("meshes", 0, "key_normals is not finite"))
    counts = np.concatenate([scene.instance_keys, scene.mesh_keys])
    if scene.vectors and not np.isin(counts, (0, 3)).all():
        errors.append(("instances", 0, "the Vector pass wants keys of three frames"))
    return errors


def mark_bad_shapes(scene: Scene, bad: np.ndarray) -> None:
    """Of meshes that deform, marks in `bad` (T) triangles that are not finite at some time, and no others but those
    that have an area at no key."""
    from isophote import _native  # a scene with errors can be told without it

    for mesh in np.flatnonzero(deforming(scene)):
        own = slice(int(scene.mesh_triangles[mesh]), int(scene.mesh_triangles[mesh + 1]))
        triangles = scene.triangles[own] - scene.mesh_vertices[mesh]
        always, made = np.ones(len(triangles), bool), np.empty(len(triangles), np.uint8)
        shapes = shape_range(scene, mesh)
        for shape in shapes:
            _native.find_bad_triangles(np.ascontiguousarray(shape), triangles, os.cpu_count() or 1, made)
            always &= made.view(bool)
        bad[own] = always | ~np.isfinite(shapes).all(axis=(0, 2))[triangles].all(axis=1)
