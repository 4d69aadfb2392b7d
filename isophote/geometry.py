"""Meshes of a scene as kernels read them, and the trees over them.

Vertices of meshes with one user are moved to world space, so that only true instances cost a change of space; tracing
and shading see the same float32 positions. The trees are BVH2s: an OpenCL device traces them as they are, with a
record for each triangle of their leaves; for the CPU they are collapsed to the wide tree and are then only needed for
frames that follow.

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
MAX_LEAF = 4  # triangles; larger leaves only where the surface area heuristic cannot tell them apart
ITEM_COST = 1.0  # of testing a triangle, where a node of the BVH2 costs 1: lower means larger leaves, fewer nodes
REFIT_COST = 1.1  # of a tree with new boxes, by the surface area heuristic, over the cost when it was built
# What meshes, trees and records are made of; the scene's other arrays may change and they stay.
OF_MESHES = ("vertices", "triangles", "mesh_vertices", "mesh_triangles")
OF_TREES = (*OF_MESHES, "instance_mesh", "instance_to_world", "instance_visibility", "sphere_center", "sphere_radius",
            "sphere_visibility")
INPUTS = (*OF_TREES, "triangle_slots", "normals", "mesh_normals", "instance_slots", "sphere_material")
WORLD = -1
# How a mesh comes into the space of its tree, as native/triangles.h has it (struct MeshUse).
MESH_USE = np.dtype([("instance", "<u4"), ("visibility", "<u4"), ("mirrored", "<u4"), ("unused", "<u4"),
                     ("to_world", "<f8", 12), ("to_object", "<f8", 9)])
THREADS = os.cpu_count() or 1


@dataclass
class Content:
    """What a tree is over: all triangles of the meshes `members`, of which [first, end) are the numbers, and other
    things by boxes float32 (n, 3) and references, ascending. `mesh`: in whose space, or WORLD."""

    mesh: int
    members: np.ndarray
    first: np.ndarray
    end: np.ndarray
    lo: np.ndarray
    hi: np.ndarray
    reference: np.ndarray

    @property
    def triangle_count(self) -> int:
        return int((self.end - self.first).sum())


@dataclass
class Tree:
    """A BVH2. Its references to nodes and triangles count from 0 (Geometry.joined); `order` are the primitives of its
    leaves, one after the other, `last` says which end one. A triangle that is in several leaves is there several times.
    """

    content: Content
    nodes: np.ndarray
    order: np.ndarray
    last: np.ndarray
    root: int
    built_cost: float = 0.0  # by the surface area heuristic, 0 until it is asked for


@dataclass
class Joined:
    """All trees of a scene as one: records of nodes, primitives and ends of leaves, instances with their trees' roots,
    and the world's root."""

    nodes: np.ndarray
    order: np.ndarray
    last: np.ndarray
    instances: np.ndarray
    root: int


@dataclass
class Geometry:
    """Buffers by name (kernels/scene_buffers.h, without those that only tracing reads), what trees are over, the trees,
    and fingerprints of what all was made of.

    `trees` is None once they have been dropped; who needs them again builds them again. Roots in the buffer
    `instances` only say who has a tree of its own: Joined has the numbers.
    """

    buffers: dict[str, np.ndarray]
    meshes: _native.Meshes
    instance_mesh: np.ndarray
    contents: list[Content]
    trees: list[Tree] | None
    inputs: dict[str, tuple] = field(default_factory=dict)

    def changes(self, scene: Scene) -> set[str]:
        """Those of INPUTS that a scene does not have in common with it, to the last bit."""
        return self.differing(fingerprints(scene))

    def differing(self, inputs: dict[str, tuple]) -> set[str]:
        return {name for name in INPUTS if self.inputs[name] != inputs[name]}

    @property
    def bytes(self) -> dict[str, int]:
        """Of memory, by name: what shading reads, the BVH2s, the CPU's tree."""
        held = {"meshes": sum(array.nbytes for array in self.buffers.values()),
                "bvh2": sum(tree.nodes.nbytes + tree.order.nbytes + tree.last.nbytes for tree in self.trees or [])}
        return held | {"wide_tree": sum(self.wide_tree.bytes.values()) if "wide_tree" in vars(self) else 0}

    def bvh2(self) -> list[Tree]:
        """The trees, built again where they have been dropped."""
        if self.trees is None:
            self.trees = [build(self.meshes, content) for content in self.contents]
        return self.trees

    def drop_trees(self) -> None:
        """Give back what only OpenCL devices and frames that follow have use for."""
        self.trees = None

    def joined(self) -> Joined:
        """The trees one after the other."""
        n, trees = numbers(), self.bvh2()
        first_node = np.cumsum([0] + [len(tree.nodes) // records()["Bvh2Node"].itemsize for tree in trees])
        first_triangle = np.cumsum([0] + [len(tree.order) for tree in trees])
        nodes, roots = [], {}
        for tree, *base in zip(trees, first_node, first_triangle, strict=False):
            base = np.array([*base, 0, 0], np.uint32)  # by kind of reference: others have one number everywhere
            made = tree.nodes.view(records()["Bvh2Node"])
            if base.any():
                made = made.copy()
                made["child"] += base[made["child"] >> 30]
            nodes.append(made)
            root = tree.root
            roots[tree.content.mesh] = root if root == n["NONE"] else root + int(base[root >> 30])
        instances = self.buffers["instances"].copy()
        own = instances["root"] != n["NONE"]
        instances["root"][own] = [roots[mesh] for mesh in self.instance_mesh[own].tolist()]
        return Joined(together(nodes), together([tree.order for tree in trees]),
                      together([tree.last for tree in trees]), instances, roots[WORLD])

    def traced_sizes(self) -> dict[str, int]:
        """Bytes of `traced`, by buffer."""
        trees = self.bvh2()
        return {"nodes": sum(tree.nodes.nbytes for tree in trees),
                "triangles": sum(len(tree.order) for tree in trees) * records()["Triangle"].itemsize}

    @cached_property
    def wide_tree(self):
        """The CPU's own tree over the same things."""
        all_ = self.joined()
        return _native.make_wide_tree(self.meshes, plain(all_.nodes), all_.order, all_.last, plain(all_.instances),
                                      all_.root, THREADS)

    def leaf_records(self, joined: Joined) -> np.ndarray:
        """A Triangle record for each triangle of the leaves, in their order."""
        made = np.empty(len(joined.order), records()["Triangle"])
        _native.make_triangles(self.meshes, joined.order, joined.last, THREADS, plain(made))
        return made


def plain(array: np.ndarray) -> np.ndarray:
    """The bytes of an array."""
    return array.reshape(-1).view(np.uint8)


def together(arrays: list[np.ndarray]) -> np.ndarray:
    """One array of several; the array itself where only one holds anything."""
    filled = [array for array in arrays if len(array)] or arrays[:1]
    return filled[0] if len(filled) == 1 else np.concatenate(filled)


def fingerprints(scene: Scene) -> dict[str, tuple]:
    """Shape and 128 bits of each of INPUTS: arrays that differ have the same by a chance of about 2^-120."""
    arrays = {name: scene.arrays[name] for name in INPUTS}
    return {name: (array.shape, *_native.fingerprint(plain(array), THREADS)) for name, array in arrays.items()}


def make_geometry(scene: Scene, kept: Geometry | None = None) -> Geometry:
    """Meshes (buffers vertices, indices, normals, slots), spheres, instances, and the trees over them.

    `kept` is what was made for another scene, often the frame before.
    """
    inputs = fingerprints(scene)
    changes = kept.differing(inputs) if kept else set(INPUTS)
    if not changes:
        return kept
    users = np.bincount(scene.instance_mesh, minlength=len(scene.mesh_normals))
    uses = mesh_uses(scene, users)
    instances, spheres = make_instances(scene, users), make_spheres(scene)
    same_trees = changes.isdisjoint(OF_TREES)
    vertices = kept.buffers["vertices"] if same_trees else baked_vertices(scene, uses)
    buffers = {"vertices": vertices, "indices": scene.triangles, "normals": baked_normals(scene, uses),
               "slots": scene.triangle_slots, "spheres": spheres, "instances": instances}
    if same_trees:
        made = Geometry(buffers, kept.meshes, scene.instance_mesh, kept.contents, kept.trees, inputs)
        if "wide_tree" in vars(kept):
            made.wide_tree = kept.wide_tree
        return made
    meshes = _native.Meshes(vertices, scene.triangles, scene.mesh_triangles, uses.view(np.uint8))
    contents = [content_of(scene, mesh, [mesh]) for mesh in np.flatnonzero(users > 1).tolist()]
    contents.append(world_content(scene, users, spheres, instances))
    old = {tree.content.mesh: tree for tree in kept.trees or []} if kept else {}
    same_meshes = changes.isdisjoint(OF_MESHES)
    trees = [made_tree(meshes, content, old.get(content.mesh), same_meshes) for content in contents]
    return Geometry(buffers, meshes, scene.instance_mesh, contents, trees, inputs)


# ------------------------------------------------------------------ meshes


def mesh_uses(scene: Scene, users: np.ndarray) -> np.ndarray:
    """A MESH_USE for each mesh; those with one user come to world space."""
    made = np.zeros(len(users), MESH_USE)
    made["instance"], made["visibility"] = numbers()["NONE"], numbers()["RAY_ALL"]
    instances = np.flatnonzero(users[scene.instance_mesh] == 1)
    matrices, single = scene.instance_to_world[instances], scene.instance_mesh[instances]
    made["instance"][single] = instances
    made["visibility"][single] = scene.instance_visibility[instances]
    made["mirrored"][single] = is_mirrored(matrices)
    made["to_world"][single] = matrices.reshape(-1, 12)
    made["to_object"][single] = np.linalg.inv(matrices[:, :, :3]).reshape(-1, 9)
    return made


def is_mirrored(matrices: np.ndarray) -> np.ndarray:
    return np.linalg.det(matrices[:, :, :3]) < 0


def baked_vertices(scene: Scene, uses: np.ndarray) -> np.ndarray:
    """Vertices in the space of their tree, in float64 and rounded once; the scene's own where none moves."""
    if (uses["to_world"][uses["instance"] != numbers()["NONE"]] == np.eye(3, 4).ravel()).all():
        return scene.vertices
    made = np.empty_like(scene.vertices)
    _native.bake_vertices(scene.vertices, scene.mesh_vertices, uses.view(np.uint8), THREADS, made)
    return made


def baked_normals(scene: Scene, uses: np.ndarray) -> np.ndarray:
    """Normals in the space of the vertices; those of meshes with one user are made unit once more, in float64."""
    if not len(scene.normals) or (uses["instance"] == numbers()["NONE"]).all():
        return scene.normals
    made = np.empty_like(scene.normals)
    _native.bake_normals(scene.normals, scene.mesh_normals, scene.mesh_vertices, uses.view(np.uint8), THREADS, made)
    return made


def mesh_boxes(scene: Scene) -> np.ndarray:
    """Lowest and highest corner of each mesh's triangles in object space, float32 (M, 2, 3); 0 where it has none."""
    boxes = np.empty((len(scene.mesh_normals), 2, 3), np.float32)
    _native.find_mesh_boxes(scene.vertices, scene.triangles, scene.mesh_triangles, THREADS, boxes)
    return boxes


# ------------------------------------------------------------------ trees


def content_of(scene: Scene, mesh: int, members, lo=(), hi=(), reference=()) -> Content:
    members = np.asarray(members, np.uint32)
    return Content(mesh, members, scene.mesh_triangles[members], scene.mesh_triangles[members + 1],
                   *(np.asarray(bound, np.float32).reshape(-1, 3) for bound in (lo, hi)),
                   np.asarray(reference, np.uint32))


def world_content(scene: Scene, users: np.ndarray, spheres: np.ndarray, instances: np.ndarray) -> Content:
    """The triangles of meshes with one user, spheres, and the instances of the other meshes."""
    n = numbers()
    placed = np.flatnonzero(instances["root"] != n["NONE"])
    boxes = mesh_boxes(scene)[scene.instance_mesh[placed]].astype(np.float64)
    lo, hi = instance_boxes(instances[placed], boxes)
    center, radius = spheres["center"], spheres["radius"][:, None]
    reference = [np.arange(len(spheres)) | n["REF_SPHERE"] << 30, placed | n["REF_INSTANCE"] << 30]
    return content_of(scene, WORLD, np.flatnonzero(users == 1), np.concatenate([center - radius, lo]),
                      np.concatenate([center + radius, hi]), np.concatenate(reference))


def made_tree(meshes, content: Content, kept: Tree | None, same_meshes: bool) -> Tree:
    """The kept tree as it is where that still serves, or with new boxes, else a new one."""
    if kept and same_meshes and content.mesh != WORLD:
        return kept
    return (refit(meshes, content, kept) if kept else None) or build(meshes, content)


def build(meshes, content: Content) -> Tree:
    """A new tree."""
    # Boxes are wider by the roundings of triangle_hit, which go with the largest coordinate: else a ray in the
    # plane of a flat box, or one that meets coincident triangles, would find a hit in one tree and not in another.
    nodes, order, last, root, _ = _native.make_tree(
        meshes, content.members, content.lo, content.hi, content.reference, BOX_MARGIN, ITEM_COST, MAX_LEAF, THREADS)
    if len(content.reference):
        triangles = order < meshes.triangle_count
        order, last = order[triangles], last[triangles]
    return Tree(content, nodes, order, last, root)


def refit(meshes, content: Content, kept: Tree) -> Tree | None:
    """The kept tree around what its leaves hold now; None where triangles have other numbers or are in several leaves
    (in pieces no longer theirs), or where its cost has grown too much."""
    before = kept.content
    same = all(np.array_equal(getattr(before, name), getattr(content, name)) for name in ("first", "end", "reference"))
    if not same or len(kept.order) != content.triangle_count:
        return None
    nodes = kept.nodes.copy()
    old_cost, cost = _native.refit_tree(meshes, nodes, kept.root, kept.order, kept.last, content.lo, content.hi,
                                        content.reference, BOX_MARGIN, THREADS)
    made = Tree(content, nodes, kept.order, kept.last, kept.root, kept.built_cost or old_cost)
    return made if cost <= REFIT_COST * made.built_cost else None


# ------------------------------------------------------------------ spheres and instances


def make_spheres(scene: Scene) -> np.ndarray:
    """Sphere records."""
    return make_records("Sphere", len(scene.sphere_radius), center=scene.sphere_center, radius=scene.sphere_radius,
                        material=scene.sphere_material, visibility=scene.sphere_visibility)


def make_instances(scene: Scene, users: np.ndarray) -> np.ndarray:
    """Instance records; the roots of those whose mesh has a tree of its own are filled in by Geometry.joined."""
    n, mesh = numbers(), scene.instance_mesh
    matrices, shared = scene.instance_to_world, users[mesh] > 1
    inverse = np.zeros_like(matrices)
    inverse[:, :, :3] = np.linalg.inv(matrices[:, :, :3])
    inverse[:, :, 3] = -np.einsum("nij,nj->ni", inverse[:, :, :3], matrices[:, :, 3])
    normals = scene.mesh_normals[mesh].astype(np.int64)
    flags = (is_mirrored(matrices) & ~shared) * n["INSTANCE_MIRRORED"] | (normals >= 0) * n["INSTANCE_SMOOTH"]
    first = np.where(normals >= 0, normals - scene.mesh_vertices[mesh], 0)
    return make_records(
        "Instance", len(matrices), to_world=matrices.reshape(-1, 12), to_object=inverse.reshape(-1, 12),
        root=np.where(shared, 0, n["NONE"]), first_slot=scene.instance_slots,
        visibility=scene.instance_visibility | flags.astype(np.uint32), first_normal=(first % 2**32).astype(np.uint32))


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
