"""Triangles, spheres and instances of a scene as records, in the order of the trees built over them.

What was made for another frame is used again: all of it where nothing that it depends on has changed, else the
trees whose counts are the same, with new boxes. Hits do not depend on the tree, so no bit of a picture does.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from isophote import _native
from isophote.records import make_records, numbers, records
from isophote.scene import Scene

BOX_MARGIN = 2.0**-20  # relative to the largest coordinate of a box: 16 roundings of float32
MAX_LEAF = 4  # items; larger leaves only where the surface area heuristic cannot tell them apart
REFIT_COST = 1.1  # of a tree with new boxes, by the surface area heuristic, over the cost when it was built
# What trees and records are made of; the scene's other arrays may change and they stay.
OF_MESHES = ("vertices", "triangles", "triangle_slots", "normals", "mesh_triangles", "mesh_normals")
INPUTS = (*OF_MESHES, "instance_mesh", "instance_to_world", "instance_slots", "instance_visibility", "sphere_center",
          "sphere_radius", "sphere_material", "sphere_visibility")
WORLD = -1
OF_WIDE_TREE = ("nodes", "triangles", "instances")
# A run of a mesh's triangles as native/triangles.h has it (struct Part).
PART = np.dtype([("first", "<u4"), ("count", "<u4"), ("instance", "<u4"), ("visibility", "<u4"), ("normals", "<i4"),
                 ("mirrored", "<u4"), ("to_world", "<f8", 12), ("to_object", "<f8", 9)])
THREADS = os.cpu_count() or 1


@dataclass
class Items:
    """Boxes float32 (n, 3) and references, ascending, of the instances below a tree."""

    lo: np.ndarray
    hi: np.ndarray
    reference: np.ndarray


NO_ITEMS = Items(*(np.zeros((0, 3), np.float32),) * 2, np.zeros(0, np.uint32))


@dataclass
class Tree:
    """A tree and what its leaves refer to, in their order. References count from 0 (join_trees).

    `order` and `last` are those of _native.make_tree: triangles come first, then spheres, then items. A triangle
    that is in several leaves is in them several times.
    """

    nodes: np.ndarray
    order: np.ndarray
    last: np.ndarray
    root: int
    items: Items
    triangles: np.ndarray = None
    normal_index: np.ndarray = None
    normals: np.ndarray = None
    spheres: np.ndarray = None
    mesh: int = WORLD  # in whose space it is
    corner_count: int = 0  # triangles that it is over
    built_cost: float = 0.0  # by the surface area heuristic, 0 until it is asked for


@dataclass
class Geometry:
    """Buffers by name (kernels/scene_buffers.h), the reference of the world's root, and what they were made of."""

    buffers: dict[str, np.ndarray]
    root: int
    trees: list[Tree]
    inputs: dict[str, np.ndarray] = field(default_factory=dict)

    def changes(self, scene: Scene) -> set[str]:
        """Those of INPUTS that a scene does not have in common with it, to the last bit."""
        return {name for name in INPUTS if not is_same(self.inputs[name], scene.arrays[name])}

    @property
    def bytes(self) -> int:
        """Of memory, about: the CPU's tree holds corners and boxes once more."""
        arrays = [*self.buffers.values(), *self.inputs.values(), self.buffers["triangles"], self.buffers["nodes"]]
        return sum(array.nbytes for array in arrays + [tree.order for tree in self.trees])

    @cached_property
    def wide_tree(self):
        """The CPU's own tree over the same things."""
        made = (self.buffers[name].view(np.uint8).reshape(-1) for name in OF_WIDE_TREE)
        return _native.make_wide_tree(*made, self.root, THREADS)


def is_same(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether two arrays of one type have the same bytes."""
    if a is b or a.shape != b.shape:
        return a is b
    return _native.same_bytes(a.reshape(-1).view(np.uint8), b.reshape(-1).view(np.uint8), THREADS)


def make_geometry(scene: Scene, kept: Geometry | None = None) -> Geometry:
    """Buffers (nodes, triangles, normal_index, corner_normals, spheres, instances) and the world's root.

    Meshes with one user are moved to world space (in float64, then rounded), so that only true
    instances cost a change of space. `kept` is what was made for another scene, often the frame before.
    """
    changes = kept.changes(scene) if kept else set(INPUTS)
    if not changes:
        return kept
    n = numbers()
    users = np.bincount(scene.instance_mesh, minlength=len(scene.mesh_normals))
    shared = users > 1
    old = {tree.mesh: tree for tree in kept.trees} if kept else {}
    trees = [old[mesh] if mesh in old and changes.isdisjoint(OF_MESHES) else object_tree(scene, mesh, old.get(mesh))
             for mesh in np.flatnonzero(shared).tolist()]

    instances = make_instances(scene)
    is_shared = shared[scene.instance_mesh] if len(shared) else np.zeros(0, bool)
    of_shared = np.flatnonzero(is_shared)
    boxes = mesh_boxes(scene)[scene.instance_mesh[of_shared]].astype(np.float64)
    items = Items(*instance_boxes(instances[of_shared], boxes),
                  of_shared.astype(np.uint32) | np.uint32(n["REF_INSTANCE"] << 30))
    trees.append(make_tree(scene, world_parts(scene, np.flatnonzero(~is_shared)), make_spheres(scene), items,
                           old.get(WORLD)))
    buffers, roots = join_trees(trees)
    root_of = np.full(len(shared), n["NONE"], np.uint32)
    root_of[shared] = roots[:-1]
    instances["root"] = root_of[scene.instance_mesh]
    made = Geometry(buffers | {"instances": instances}, roots[-1], trees, {name: scene.arrays[name] for name in INPUTS})
    return with_wide_tree_of(kept, made) if kept else made


def with_wide_tree_of(kept: Geometry, made: Geometry) -> Geometry:
    """Takes the CPU's own tree over too, where all that it is made of is the same: other normals do not count."""
    same = made.root == kept.root and all(is_same(kept.buffers[name], made.buffers[name]) for name in OF_WIDE_TREE)
    if same and "wide_tree" in vars(kept):
        made.wide_tree = kept.wide_tree
    return made


# ------------------------------------------------------------------ triangles


def object_part(scene: Scene, mesh: int) -> np.ndarray:
    """The triangles of a mesh in object space, as one PART."""
    return make_parts(scene, np.array([mesh]), np.full(1, numbers()["NONE"], np.uint32))


def world_parts(scene: Scene, instances: np.ndarray) -> np.ndarray:
    """The triangles of instances (their numbers) in world space, a PART each."""
    made = make_parts(scene, scene.instance_mesh[instances], instances)
    matrices = scene.instance_to_world[instances]
    made["visibility"] = scene.instance_visibility[instances]
    made["mirrored"] = np.linalg.det(matrices[:, :, :3]) < 0
    made["to_world"] = matrices.reshape(-1, 12)
    made["to_object"] = np.linalg.inv(matrices[:, :, :3]).reshape(-1, 9)
    return made


def make_parts(scene: Scene, meshes: np.ndarray, instances: np.ndarray) -> np.ndarray:
    made = np.zeros(len(meshes), PART)
    made["first"] = scene.mesh_triangles[meshes]
    made["count"] = scene.mesh_triangles[meshes + 1] - made["first"]
    made["normals"] = scene.mesh_normals[meshes]
    made["instance"] = instances
    return made


def mesh_boxes(scene: Scene) -> np.ndarray:
    """Lowest and highest corner of each mesh's triangles in object space, float32 (M, 2, 3); 0 where it has none."""
    boxes = np.empty((len(scene.mesh_normals), 2, 3), np.float32)
    _native.find_mesh_boxes(scene.vertices, scene.triangles, scene.mesh_triangles, THREADS, boxes)
    return boxes


# ------------------------------------------------------------------ trees


def make_tree(scene: Scene, parts: np.ndarray, spheres: np.ndarray, items: Items, kept: Tree | None) -> Tree:
    """A tree over the triangles of PARTs, spheres (records) and items: the kept one with new boxes if that serves."""
    corners = np.empty((int(parts["count"].sum()), 3, 3), np.float32)
    _native.bake_corners(scene.vertices, scene.triangles, parts.view(np.uint8), THREADS, corners)
    refitted = refit(scene, parts, corners, spheres, items, kept) if kept else None
    return refitted or placed(build(corners, spheres, items), scene, parts, corners, spheres)


def object_tree(scene: Scene, mesh: int, kept: Tree | None) -> Tree:
    """The tree of a mesh with several users, in its own space."""
    made = make_tree(scene, object_part(scene, mesh), make_records("Sphere", 0), NO_ITEMS, kept)
    made.mesh = mesh
    return made


def build(corners: np.ndarray, spheres: np.ndarray, items: Items) -> Tree:
    """A new tree, without the records of its leaves."""
    n = numbers()
    centers, radii = spheres["center"], spheres["radius"][:, None]
    # Boxes are wider by the roundings of triangle_hit, which go with the largest coordinate: else a ray in the
    # plane of a flat box, or one that meets coincident triangles, would find a hit in one tree and not in another.
    reference = np.concatenate([np.full(len(spheres), n["REF_SPHERES"] << 30, np.uint32), items.reference])
    nodes, order, last, root, _ = _native.make_tree(
        corners, np.concatenate([centers - radii, items.lo]), np.concatenate([centers + radii, items.hi]), reference,
        BOX_MARGIN, 0, 0, 0, MAX_LEAF, THREADS)
    return Tree(nodes, order, last, root, items)


def placed(tree: Tree, scene: Scene, parts: np.ndarray, corners: np.ndarray, spheres: np.ndarray) -> Tree:
    """The tree with the records of its leaves, in their order."""
    count, balls = len(corners), len(spheres)
    order, last = tree.order, tree.last
    if count < len(order):
        chosen = order < count
        order, last = order[chosen], last[chosen]
    tree.corner_count = count
    tree.triangles, tree.normal_index = np.empty(len(order), records()["Triangle"]), np.empty(len(order), np.uint32)
    smooth = parts["count"][parts["normals"] >= 0].sum()
    if count < len(order):
        smooth = np.repeat(parts["normals"] >= 0, parts["count"])[order].sum()
    tree.normals = np.empty(int(smooth), records()["CornerNormals"])
    _native.place_triangles(scene.triangle_slots, scene.normals, parts.view(np.uint8), corners, order, last, THREADS,
                            tree.triangles.view(np.uint8), tree.normal_index, tree.normals.view(np.uint8))
    is_ball = (tree.order >= count) & (tree.order < count + balls) if balls else slice(0)
    tree.spheres = spheres[tree.order[is_ball] - count]
    tree.spheres["flags"] |= tree.last[is_ball].astype(np.uint32) * np.uint32(numbers()["LAST_IN_LEAF"])
    return tree


def refit(scene: Scene, parts: np.ndarray, corners: np.ndarray, spheres: np.ndarray, items: Items,
          kept: Tree) -> Tree | None:
    """The kept tree around what its leaves hold now; None where counts differ, where triangles are in several leaves
    (in pieces no longer theirs), or where its cost has grown too much."""
    if not len(kept.triangles) == kept.corner_count == len(corners) or len(kept.spheres) != len(spheres) \
            or not is_same(kept.items.reference, items.reference):
        return None
    made = placed(Tree(kept.nodes.copy(), kept.order, kept.last, kept.root, items), scene, parts, corners, spheres)
    before, after = _native.refit_tree(
        made.nodes, made.root, made.triangles.view(np.uint8), made.spheres.view(np.uint8), items.reference, items.lo,
        items.hi, BOX_MARGIN, THREADS)
    made.built_cost = kept.built_cost or before
    return made if after <= REFIT_COST * made.built_cost else None


def join_trees(trees: list[Tree]) -> tuple[dict[str, np.ndarray], list[int]]:
    """The trees' records one after the other as buffers, and the references of their roots there."""
    n = numbers()
    ends = {name: np.cumsum([0] + [len(getattr(tree, name)) for tree in trees])
            for name in ("triangles", "normals", "spheres")}
    first_node = np.cumsum([0] + [len(tree.nodes) // records()["Bvh2Node"].itemsize for tree in trees])
    nodes, index, roots = [], [], []
    for tree, *base in zip(trees, first_node, ends["triangles"], ends["spheres"], strict=False):
        base = np.array([*base, 0], np.uint32)  # by kind of reference: instances have one number everywhere
        made = tree.nodes.view(records()["Bvh2Node"])
        if base.any():
            made = made.copy()
            made["child"] += base[made["child"] >> 30]
        nodes.append(made)
        root = tree.root
        roots.append(root if root == n["NONE"] else root + int(base[root >> 30]))
    for tree, base in zip(trees, ends["normals"], strict=False):
        moved = tree.normal_index
        index.append(np.where(moved == n["NONE"], moved, moved + np.uint32(base)) if base else moved)
    return {"nodes": joined(nodes), "triangles": joined([tree.triangles for tree in trees]),
            "normal_index": joined(index), "corner_normals": joined([tree.normals for tree in trees]),
            "spheres": joined([tree.spheres for tree in trees])}, roots


def joined(arrays: list[np.ndarray]) -> np.ndarray:
    """One array of several; the array itself where only one holds anything."""
    filled = [array for array in arrays if len(array)] or arrays[:1]
    return filled[0] if len(filled) == 1 else np.concatenate(filled)


# ------------------------------------------------------------------ spheres and instances


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
