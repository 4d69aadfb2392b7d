"""Triangles, spheres and instances of a scene as records, in the order of the trees built over them."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np

from isophote import _native
from isophote.records import make_records, numbers, records
from isophote.scene import Scene

BOX_MARGIN = 2.0**-20  # relative to the largest coordinate of a box: 16 roundings of float32
MAX_LEAF = 4  # items; larger leaves only where the surface area heuristic cannot tell them apart


@dataclass
class Soup:
    """Triangles of one space: corners float32 (n, 3, 3), and n values each of what their records say."""

    corners: np.ndarray
    primitive: np.ndarray
    instance: np.ndarray
    slot: np.ndarray  # material slot | visibility << 16
    normals: np.ndarray  # float32 (n, 3, 3); rows of NaN where the triangle is flat


@dataclass
class Items:
    """Boxes float32 (n, 3) and references of what a tree is built over besides triangles."""

    lo: np.ndarray
    hi: np.ndarray
    reference: np.ndarray


class TreeList:
    """Trees laid out one after the other in the scene's buffers."""

    def __init__(self, threads: int):
        self.threads = threads
        self.nodes, self.triangles, self.normals, self.spheres = [], [], [], []
        self.counts = {"node": 0, "triangle": 0, "sphere": 0}
        self.depth = 0

    def add(self, soup: Soup, spheres: np.ndarray, items: Items) -> int:
        """Build a tree over triangles, spheres (records) and further items. Returns the reference to its root."""
        n = numbers()
        count, balls = len(soup.corners), len(spheres)
        centers, radii = spheres["center"], spheres["radius"][:, None]
        # Boxes are wider by the roundings of triangle_hit, which go with the largest coordinate: else a ray in the
        # plane of a flat box, or one that meets coincident triangles, would find a hit in one tree and not in another.
        reference = np.concatenate([np.full(balls, n["REF_SPHERES"] << 30, np.uint32), items.reference])
        nodes, order, last, root, depth = _native.make_tree(
            soup.corners, np.concatenate([centers - radii, items.lo]), np.concatenate([centers + radii, items.hi]),
            reference, BOX_MARGIN, *(self.counts[kind] for kind in ("node", "triangle", "sphere")), MAX_LEAF,
            self.threads)
        last = last.astype(np.uint32) * np.uint32(n["LAST_IN_LEAF"])

        ids = order[order < count]
        self.triangles.append(make_records(
            "Triangle", len(ids), v0=soup.corners[ids, 0], v1=soup.corners[ids, 1], v2=soup.corners[ids, 2],
            primitive=soup.primitive[ids], instance=soup.instance[ids],
            slot=soup.slot[ids] | last[order < count]))
        self.normals.append(soup.normals[ids])
        is_ball = (order >= count) & (order < count + balls)
        placed = spheres[order[is_ball] - count]
        placed["flags"] |= last[is_ball]
        self.spheres.append(placed)
        self.nodes.append(nodes.view(records()["Bvh2Node"]))
        for kind, made in (("node", self.nodes), ("triangle", self.triangles), ("sphere", self.spheres)):
            self.counts[kind] += len(made[-1])
        self.depth = max(self.depth, depth)
        return root


def make_geometry(scene: Scene) -> tuple[dict[str, np.ndarray], int]:
    """Buffers (nodes, triangles, normal_index, corner_normals, spheres, instances) and the world's root.

    Meshes with one user are moved to world space (in float64, then rounded), so that only true
    instances cost a change of space.
    """
    n = numbers()
    users = np.bincount(scene.instance_mesh, minlength=len(scene.mesh_normals))
    shared = users > 1
    trees = TreeList(os.cpu_count() or 1)
    no_items = Items(*(np.zeros((0, 3), np.float32),) * 2, np.zeros(0, np.uint32))
    no_spheres = make_records("Sphere", 0)

    instances = make_instances(scene)
    boxes = np.zeros((len(shared), 2, 3))
    for mesh in np.flatnonzero(shared):
        soup = mesh_soup(scene, mesh)
        root = trees.add(soup, no_spheres, no_items)
        instances["root"][scene.instance_mesh == mesh] = root
        boxes[mesh] = soup.corners.min((0, 1)), soup.corners.max((0, 1))

    of_shared = np.flatnonzero(shared[scene.instance_mesh]) if len(shared) else np.zeros(0, int)
    lo, hi = instance_boxes(instances[of_shared], boxes[scene.instance_mesh[of_shared]])
    items = Items(lo, hi, of_shared.astype(np.uint32) | np.uint32(n["REF_INSTANCE"] << 30))
    alone = np.flatnonzero(~shared[scene.instance_mesh]) if len(shared) else []
    world = join_soups([bake(scene, i) for i in alone])
    root = trees.add(world, make_spheres(scene), items)

    normals = np.concatenate(trees.normals)
    smooth = ~np.isnan(normals[:, 0, 0])
    index = np.full(len(normals), n["NONE"], np.uint32)
    index[smooth] = np.arange(smooth.sum())
    normals = np.ascontiguousarray(normals[smooth]).reshape(-1, 9).view(records()["CornerNormals"]).ravel()
    return {"nodes": np.concatenate(trees.nodes), "triangles": np.concatenate(trees.triangles),
            "normal_index": index, "corner_normals": normals, "spheres": np.concatenate(trees.spheres),
            "instances": instances}, root


def mesh_soup(scene: Scene, mesh: int) -> Soup:
    """The triangles of a mesh in object space."""
    first, end = scene.mesh_triangles[mesh], scene.mesh_triangles[mesh + 1]
    count, at = end - first, scene.mesh_normals[mesh]
    normals = scene.normals[at:at + count] if at >= 0 else np.full((count, 3, 3), np.nan, np.float32)
    return Soup(scene.vertices[scene.triangles[first:end]], np.arange(first, end, dtype=np.uint32),
                np.full(count, numbers()["NONE"], np.uint32), scene.triangle_slots[first:end], normals)


def bake(scene: Scene, instance: int) -> Soup:
    """The triangles of an instance in world space, each float64 corner rounded once.

    Where the transform mirrors, two corners change places, so that a triangle's front stays its front.
    """
    soup = mesh_soup(scene, scene.instance_mesh[instance])
    matrix = scene.instance_to_world[instance]
    soup.corners = (soup.corners.astype(np.float64) @ matrix[:, :3].T + matrix[:, 3]).astype(np.float32)
    if scene.mesh_normals[scene.instance_mesh[instance]] >= 0:
        normals = soup.normals.astype(np.float64) @ np.linalg.inv(matrix[:, :3])
        length = np.linalg.norm(normals, axis=2, keepdims=True)
        soup.normals = (normals / np.where(length > 0, length, 1)).astype(np.float32)
    if np.linalg.det(matrix[:, :3]) < 0:
        soup.corners, soup.normals = soup.corners[:, [0, 2, 1]], soup.normals[:, [0, 2, 1]]
    soup.instance[:] = instance
    soup.slot = soup.slot | (scene.instance_visibility[instance] << np.uint32(16))
    return soup


def join_soups(soups: list[Soup]) -> Soup:
    """One soup of several."""
    empty = Soup(np.zeros((0, 3, 3), np.float32), *(np.zeros(0, np.uint32) for _ in range(3)),
                 np.zeros((0, 3, 3), np.float32))
    soups = soups or [empty]
    return Soup(*(np.concatenate([getattr(soup, name) for soup in soups])
                  for name in ("corners", "primitive", "instance", "slot", "normals")))


def make_spheres(scene: Scene) -> np.ndarray:
    """Sphere records; their numbers follow those of the triangles."""
    count = len(scene.sphere_radius)
    return make_records(
        "Sphere", count, center=scene.sphere_center, radius=scene.sphere_radius, material=scene.sphere_material,
        primitive=len(scene.triangles) + np.arange(count), flags=scene.sphere_visibility << np.uint32(16))


def make_instances(scene: Scene) -> np.ndarray:
    """Instance records; the roots of shared meshes are filled in when their trees are built."""
    matrices = scene.instance_to_world
    inverse = np.zeros_like(matrices)
    inverse[:, :, :3] = np.linalg.inv(matrices[:, :, :3])
    inverse[:, :, 3] = -np.einsum("nij,nj->ni", inverse[:, :, :3], matrices[:, :, 3])
    return make_records(
        "Instance", len(matrices), to_world=matrices.reshape(-1, 12), to_object=inverse.reshape(-1, 12),
        root=numbers()["NONE"], first_slot=scene.instance_slots, visibility=scene.instance_visibility)


def instance_boxes(instances: np.ndarray, boxes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """World boxes float32 (n, 3) of object boxes (n, 2, 3) under the records' float32 transforms.

    Widened by the roundings that a ray suffers on its way to object space and back.
    """
    corners = np.stack([np.where([c & 1, c & 2, c & 4], boxes[:, 1], boxes[:, 0]) for c in range(8)], axis=1)
    matrices = instances["to_world"].astype(np.float64).reshape(-1, 3, 4)
    world = np.einsum("nij,ncj->nci", matrices[:, :, :3], corners) + matrices[:, None, :, 3]
    lo, hi = world.min(1), world.max(1)
    reach = np.abs(matrices[:, :, :3]) @ np.abs(boxes).max(1)[:, :, None]
    margin = (np.maximum(np.abs(lo), np.abs(hi)) + reach[:, :, 0]).max(1, keepdims=True) * 2.0**-20
    return (lo - margin).astype(np.float32), (hi + margin).astype(np.float32)
