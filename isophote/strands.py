"""Strands of a scene (hair, fur, grass) and the boxes around their segments; kernels/strand.h traces them."""

from __future__ import annotations

import numpy as np

from isophote.materials import OPERATIONS
from isophote.motion import deforming, shape_range
from isophote.scene import Scene, slots_of

MARGIN = 2.0**-20  # of what segment_hit computes, relative to the largest coordinate of a box
FARTHEST = 1e9  # coordinates whose fourth powers float32 holds


def stranded(scene: Scene) -> np.ndarray:
    """Mask (M) of meshes that are strands."""
    return scene.mesh_radii > 0


def segments(scene: Scene, mesh: int) -> np.ndarray:
    """First and last vertex of each segment, counted from the mesh's first, int64 [n, 2]."""
    rows = scene.triangles[scene.mesh_triangles[mesh]:scene.mesh_triangles[mesh + 1], :2]
    return rows.astype(np.int64) - int(scene.mesh_vertices[mesh])


def radii_of(scene: Scene, mesh: int) -> np.ndarray:
    """Radius of each vertex, f4 [n]."""
    first, count = int(scene.mesh_radii[mesh]) - 1, int(scene.mesh_vertices[mesh + 1] - scene.mesh_vertices[mesh])
    return scene.radii[first:first + count]


def places_of(scene: Scene, mesh: int) -> np.ndarray:
    """Of the vertices at each time that there is, f4 [times, n, 3]."""
    if deforming(scene)[mesh]:
        return shape_range(scene, mesh)
    return scene.vertices[None, scene.mesh_vertices[mesh]:scene.mesh_vertices[mesh + 1]]


def marked_radii(scene: Scene) -> np.ndarray:
    """All radii, those at the ends of strands with the sign changed, which zeros have, too."""
    made = scene.radii.copy()
    for mesh in np.flatnonzero(stranded(scene)):
        ends, own = segments(scene, mesh), radii_of(scene, mesh)
        counts = np.zeros((2, len(own)), bool)
        counts[[[0], [1]], ends.T] = True
        first = int(scene.mesh_radii[mesh]) - 1
        made[first:first + len(own)] = np.copysign(own, np.where(counts.all(axis=0), 1.0, -1.0))
    return made


def strand_errors(scene: Scene) -> list[tuple[str, int, str]]:
    """(group, number, what) of what kernels must not meet; all indices but those of radii are known to be good."""
    first, counts = scene.mesh_radii.astype(np.int64) - 1, np.diff(scene.mesh_vertices.astype(np.int64))
    outside = (first < -1) | (first >= 0) & (first + counts > len(scene.radii))
    errors = [("meshes", mesh, "its radii lie outside the array") for mesh in np.flatnonzero(outside)]
    if errors:
        return errors
    uses = np.zeros(len(scene.radii) + 1, np.int64)
    for mesh in np.flatnonzero(stranded(scene)):
        uses[first[mesh]:first[mesh] + counts[mesh]] += 1
        rows = scene.triangles[scene.mesh_triangles[mesh]:scene.mesh_triangles[mesh + 1]].astype(np.int64)
        if (rows != rows[:, :1] + (0, 1, 0)).any():
            errors.append(("meshes", mesh, "a triangle of its strands is no segment"))
        if scene.mesh_normals[mesh] >= 0 or (uses > 1).any():
            errors.append(("meshes", mesh, "strands with normals, or with radii that others have, too"))
    wanders = np.isin(scene.instruction_op, [OPERATIONS["subsurface"][0]])
    owner = np.searchsorted(scene.material_first, np.flatnonzero(wanders), side="right") - 1
    filled = np.union1d(owner, np.flatnonzero(scene.material_volume))
    for instance in np.flatnonzero(stranded(scene)[scene.instance_mesh]):
        slots = np.unique(slots_of(scene, int(scene.instance_mesh[instance])))
        if np.isin(scene.slot_materials[int(scene.instance_slots[instance]) + slots], filled).any():
            errors.append(("instances", instance, "strands have no inside for a volume or for subsurface scattering"))
    return errors


def segment_boxes(scene: Scene, mesh: int) -> tuple[np.ndarray, np.ndarray]:
    """Boxes f4 [n, 3] of a mesh's segments, which hold them at every time."""
    ends, radii, places = segments(scene, mesh), radii_of(scene, mesh)[:, None], places_of(scene, mesh)
    low = np.minimum(*((places - radii)[:, each] for each in ends.T)).min(axis=0)
    high = np.maximum(*((places + radii)[:, each] for each in ends.T)).max(axis=0)
    margin = MARGIN * np.maximum(np.abs(low), np.abs(high)).max(axis=1, keepdims=True)
    return low - margin, high + margin


def bad_segments(scene: Scene, mesh: int) -> np.ndarray:
    """Mask [n]: an end that is not finite at some time, or so far away that squares overflow; a radius that is not
    finite or below 0, or none at either end. Lengths may be 0."""
    radii, ends = radii_of(scene, mesh), segments(scene, mesh)
    with np.errstate(invalid="ignore"):
        fine = (np.abs(places_of(scene, mesh)) < FARTHEST).all(axis=(0, 2)) & (radii >= 0.0) & (radii < FARTHEST)
        return ~(fine[ends].all(axis=1) & (radii[ends].max(axis=1) > 0.0))
