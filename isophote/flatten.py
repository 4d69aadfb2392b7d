"""Instances whose matrix has one zero scale: flat, but there. Kernels invert matrices, so each becomes its own mesh."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from isophote.records import numbers
from isophote.scene import Scene


def matrix_ranks(matrices: np.ndarray) -> np.ndarray:
    """Rank (n) of the linear part of matrices f8 (n, 3, 4): 3, 2 where it flattens, less where nothing is left; 0 where
    one is not finite."""
    with np.errstate(over="ignore"):  # float32 is what kernels get
        finite = np.isfinite(matrices.astype(np.float32)).all(axis=(1, 2))
    ranks = np.zeros(len(finite), int)
    if finite.any():
        ranks[finite] = np.linalg.matrix_rank(matrices[finite][:, :, :3])
    return ranks


def instance_ranks(scene: Scene) -> np.ndarray:
    """Ranks (I) of the instances' matrices: of one that moves the largest while the shutter is open, 0 if some is not
    finite."""
    ranks = matrix_ranks(scene.instance_to_world)
    moving = np.flatnonzero(scene.instance_keys)
    if len(moving):
        with np.errstate(over="ignore", invalid="ignore"):
            large = np.linalg.det(scene.key_to_world[:, :, :3]).astype(np.float32)  # kernels invert by minors
            finite = np.isfinite(large) & np.isfinite(scene.key_to_world.astype(np.float32)).all(axis=(1, 2))
        counts = scene.instance_keys[moving].astype(np.int64)
        first = np.cumsum(counts) - counts
        most = ranks[moving] if scene.vectors else np.maximum.reduceat(matrix_ranks(scene.key_to_world), first)
        ranks[moving] = np.where(np.logical_and.reduceat(finite, first), most, 0)
    return ranks


def flattened(scene: Scene, ranks: np.ndarray) -> Scene:
    """The scene with each instance of rank 2 replaced by a mesh of its own in world space, without smooth normals; it
    stays while the shutter is open."""
    flat = np.flatnonzero(ranks == 2)
    if not len(flat):
        return scene
    scene = without_motion(scene, ranks == 2)
    a = scene.arrays
    parts = {name: [a[name]] for name in ("vertices", "triangles", "triangle_slots", "mesh_vertices", "mesh_triangles",
                                              "mesh_normals", "mesh_keys", "mesh_radii")}
    a = a | {name: a[name].copy() for name in ("instance_mesh", "instance_to_world")}
    attributes, values = [a["mesh_attributes"]], [a["attribute_values"]]
    names = {group: list(those) for group, those in scene.names.items()}
    mesh, vertex, end = len(a["mesh_normals"]), len(a["vertices"]), len(a["triangles"])
    for instance in flat:
        first, last = a["mesh_triangles"][a["instance_mesh"][instance]:][:2]
        used, triangles = np.unique(a["triangles"][first:last], return_inverse=True)
        matrix = a["instance_to_world"][instance].copy()
        parts["vertices"].append((a["vertices"][used] @ matrix[:, :3].T + matrix[:, 3]).astype(np.float32))
        parts["triangles"].append((triangles.reshape(-1, 3) + vertex).astype(np.uint32))
        parts["triangle_slots"].append(a["triangle_slots"][first:last])
        parts["mesh_vertices"].append(np.array([vertex + len(used)], np.uint32))
        end += last - first
        parts["mesh_triangles"].append(np.array([end], np.uint32))
        parts["mesh_normals"].append(np.array([-1], np.int32))
        parts["mesh_keys"].append(np.zeros(1, np.uint32))
        parts["mesh_radii"].append(np.zeros(1, np.int32))  # flat strands have no area
        own, made = attributes_of(a, a["instance_mesh"][instance], used, sum(map(len, values)))
        attributes.append(own[None])
        values.append(made)
        if names.get("meshes"):
            names["meshes"].append(scene.name_of("instances", instance))
        a["instance_mesh"][instance], a["instance_to_world"][instance] = mesh, np.eye(3, 4)
        mesh, vertex = mesh + 1, vertex + len(used)
    parts |= {"mesh_attributes": attributes, "attribute_values": values}
    return replace(scene, arrays=a | {name: np.concatenate(part) for name, part in parts.items()}, names=names)


def without_motion(scene: Scene, stays: np.ndarray) -> Scene:
    """The scene without the motion of instances, mask (I)."""
    a = scene.arrays
    gone = np.repeat(stays, a["instance_keys"])
    return replace(scene, arrays=a | {"instance_keys": np.where(stays, 0, a["instance_keys"]).astype(np.uint32),
                                      "key_to_world": a["key_to_world"][~gone]})


def attributes_of(arrays: dict, mesh: int, used: np.ndarray, first: int) -> tuple[np.ndarray, np.ndarray]:
    """Attributes of a copy of a mesh of which only some vertices are `used`: its row of mesh_attributes, and the values
    by vertex, which will begin at `first` of attribute_values; all others are shared."""
    n = numbers()
    own, values = arrays["mesh_attributes"][mesh].copy(), [np.zeros(0, np.float32)]
    for each in own:
        if each[1] == n["DOMAIN_VERTEX"]:
            start, components = int(each[0]), int(each[2])
            rows = start + components * (used.astype(np.int64) - arrays["mesh_vertices"][mesh])
            values.append(arrays["attribute_values"][rows[:, None] + np.arange(components)].ravel())
            each[0] = first
            first += len(values[-1])
    return own, np.concatenate(values)
