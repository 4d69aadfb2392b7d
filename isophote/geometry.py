"""Meshes of a scene as kernels read them, and the trees over them.

Vertices of meshes with one user are moved to world space, so that only true instances cost a change of space; tracing
and shading see the same float32 positions. OpenCL devices trace BVH2s (trees.py) as they are, with a record for each
triangle of their leaves; the CPU has a wide tree. Each kind is made when it is first asked for.

What was made for another frame is used again: all of it where nothing that it depends on has changed, else trees
with new boxes. Hits do not depend on the tree, so no bit of a picture does.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from isophote import _native, motion, strands
from isophote.flatten import matrix_ranks
from isophote.records import make_records, numbers, records
from isophote.scene import Scene
from isophote.trees import NOTHING, THREADS, WORLD, Before, Content, Tree, make_tree, make_wide_tree

# What meshes, trees and records are made of; the scene's other arrays may change and they stay.
OF_MESHES = ("vertices", "triangles", "mesh_vertices", "mesh_triangles", "mesh_keys", "key_vertices", "mesh_radii",
             "radii")
OF_TREES = (*OF_MESHES, "instance_mesh", "instance_to_world", "instance_visibility", "sphere_center", "sphere_radius",
            "sphere_visibility", "instance_keys", "key_to_world", "vectors")
INPUTS = (*OF_TREES, "triangle_slots", "normals", "mesh_normals", "instance_slots", "sphere_material", "key_normals")
# How a mesh comes into the space of its tree, as native/triangles.h has it (struct MeshUse).
MESH_USE = np.dtype([("instance", "<u4"), ("visibility", "<u4"), ("mirrored", "<u4"), ("unused", "<u4"),
                     ("to_world", "<f8", 12), ("to_object", "<f8", 9)])


@dataclass
class Joined:
    """All BVH2s of a scene as one: records of nodes, primitives and ends of leaves, instances with their trees' roots,
    and the world's root."""

    nodes: np.ndarray
    order: np.ndarray
    last: np.ndarray
    instances: np.ndarray
    root: int


@dataclass
class Geometry:
    """Buffers by name (kernels/scene_buffers.h, without those that only tracing reads), what trees are over, and
    fingerprints of what all was made of.

    `trees` are the BVH2s that there are, by number; who needs others makes them. Roots in the buffer `instances` only
    say who has a tree of its own: Joined has the numbers.
    """

    buffers: dict[str, np.ndarray]
    meshes: _native.Meshes
    instance_mesh: np.ndarray
    contents: list[Content]
    inputs: dict[str, tuple]
    before: Before = NOTHING
    trees: dict[int, Tree] = field(default_factory=dict)

    def changes(self, scene: Scene) -> set[str]:
        """Those of INPUTS that a scene does not have in common with it, to the last bit."""
        return self.differing(fingerprints(scene))

    def differing(self, inputs: dict[str, tuple]) -> set[str]:
        return {name for name in INPUTS if self.inputs[name] != inputs[name]}

    @property
    def bytes(self) -> dict[str, int]:
        """Of memory, by name: what shading reads, the BVH2s, the CPU's tree."""
        trees = [*self.trees.values(), *self.before.trees.values()]
        wide = [tree for tree in (vars(self).get("wide_tree"), self.before.wide_tree) if tree]
        return {"meshes": sum(array.nbytes for array in self.buffers.values()),
                "bvh2": sum(tree.nodes.nbytes + tree.order.nbytes + tree.last.nbytes for tree in trees),
                "wide_tree": sum(sum(tree.bytes.values()) for tree in wide)}

    def tree(self, number: int) -> Tree:
        """The BVH2 over a content."""
        if number not in self.trees:
            self.trees[number] = make_tree(self.meshes, self.contents[number], self.before)
        return self.trees[number]

    def bvh2(self) -> list[Tree]:
        return [self.tree(number) for number in range(len(self.contents))]

    @cached_property
    def wide_tree(self):
        """The CPU's own tree over the same things."""
        number_of = {content.mesh: number for number, content in enumerate(self.contents)}
        tree_of = np.array([number_of.get(mesh, numbers()["NONE"]) for mesh in self.instance_mesh.tolist()], np.uint32)
        return make_wide_tree(self.meshes, self.contents, tree_of, self.before, self.tree)

    def settle(self, keep_bvh2: bool) -> None:
        """Let go of what has been of use: trees of the frame before, and the BVH2s where no device traces them."""
        self.before = NOTHING
        if not keep_bvh2:
            self.trees = {}

    def drop_wide_tree(self) -> None:
        """Leave the CPU's tree to those who have taken it."""
        vars(self).pop("wide_tree", None)

    def as_before(self, same_meshes: bool) -> Before:
        """What it has for the next frame."""
        trees = {tree.content.mesh: tree for tree in self.trees.values()}
        contents = {content.mesh: content for content in self.contents}
        return Before(trees, contents, vars(self).get("wide_tree"), same_meshes)

    def joined(self) -> Joined:
        """The BVH2s one after the other."""
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
        """Bytes of nodes and triangles, by buffer, as Joined and `leaf_records` have them."""
        trees = self.bvh2()
        return {"nodes": sum(tree.nodes.nbytes for tree in trees),
                "triangles": sum(len(tree.order) for tree in trees) * records()["Triangle"].itemsize}

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
    own = own_trees(scene)
    uses = mesh_uses(scene, own)
    same_trees = changes.isdisjoint(OF_TREES)
    buffers = baked_buffers(scene, own, uses, kept.buffers["vertices"] if same_trees else None)
    if same_trees:
        made = Geometry(buffers, kept.meshes, scene.instance_mesh, kept.contents, inputs, trees=kept.trees)
        if "wide_tree" in vars(kept):
            made.wide_tree = kept.wide_tree
        return made
    meshes = _native.Meshes(buffers["vertices"], scene.triangles, scene.mesh_triangles, uses.view(np.uint8))
    used = mesh_users(scene) > 0
    contents = [mesh_content(scene, mesh) for mesh in np.flatnonzero(own & used).tolist()]
    contents.append(world_content(scene, contents, np.flatnonzero(~own & used), buffers["spheres"],
                                  buffers["instances"]))
    before = kept.as_before(changes.isdisjoint(OF_MESHES)) if kept else NOTHING
    made = Geometry(buffers, meshes, scene.instance_mesh, contents, inputs, before)
    if not before.wide_tree:
        made.bvh2()
    return made


# ------------------------------------------------------------------ meshes


def mesh_users(scene: Scene) -> np.ndarray:
    """How many instances each mesh has."""
    return np.bincount(scene.instance_mesh, minlength=len(scene.mesh_normals))


def own_trees(scene: Scene) -> np.ndarray:
    """Mask (M) of meshes that have a tree of their own: those with several users, what moves or deforms, strands."""
    own = (mesh_users(scene) > 1) | motion.deforming(scene) | strands.stranded(scene)
    own[scene.instance_mesh[motion.moving(scene)]] = True
    return own


def baked_buffers(scene: Scene, own: np.ndarray, uses: np.ndarray, vertices: np.ndarray | None = None) -> dict:
    """Buffers by name (kernels/scene_buffers.h) of all that does not need trees; `vertices` where they are known."""
    made = {"vertices": baked_vertices(scene, uses) if vertices is None else vertices, "indices": scene.triangles,
            "normals": baked_normals(scene, uses), "radii": strands.marked_radii(scene), "slots": scene.triangle_slots,
            "spheres": make_spheres(scene), "instances": make_instances(scene, own)}
    return made | motion.motion_buffers(scene)


def mesh_uses(scene: Scene, own: np.ndarray) -> np.ndarray:
    """A MESH_USE for each mesh; those without a tree of their own come to world space."""
    made = np.zeros(len(own), MESH_USE)
    made["instance"], made["visibility"] = numbers()["NONE"], numbers()["RAY_ALL"]
    instances = np.flatnonzero(~own[scene.instance_mesh])
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


# ------------------------------------------------------------------ what trees are over


def mesh_boxes(scene: Scene) -> np.ndarray:
    """Lowest and highest corner of each mesh's triangles in object space, float32 (M, 2, 3); 0 where it has none."""
    boxes = np.empty((len(scene.mesh_normals), 2, 3), np.float32)
    _native.find_mesh_boxes(scene.vertices, scene.triangles, scene.mesh_triangles, THREADS, boxes)
    return boxes


def content_of(scene: Scene, mesh: int, members, lo=(), hi=(), reference=()) -> Content:
    members = np.asarray(members, np.uint32)
    return Content(mesh, members, scene.mesh_triangles[members], scene.mesh_triangles[members + 1],
                   *(np.asarray(bound, np.float32).reshape(-1, 3) for bound in (lo, hi)),
                   np.asarray(reference, np.uint32))


def mesh_content(scene: Scene, mesh: int) -> Content:
    """Of the tree of one mesh."""
    if strands.stranded(scene)[mesh]:
        return content_of(scene, mesh, [], *strands.segment_boxes(scene, mesh), references(scene, mesh))
    if motion.deforming(scene)[mesh]:
        return content_of(scene, mesh, [], *motion.shape_boxes(scene, mesh), references(scene, mesh))
    return content_of(scene, mesh, [mesh])


def references(scene: Scene, mesh: int) -> np.ndarray:
    """What a tree has of triangles, or segments, that are in leaves one by one (REF_SINGLE of scene_records.h)."""
    return np.arange(scene.mesh_triangles[mesh], scene.mesh_triangles[mesh + 1]) | numbers()["REF_SPHERE"] << 30


def world_content(scene: Scene, contents: list[Content], members: np.ndarray, spheres: np.ndarray,
                  instances: np.ndarray) -> Content:
    """The triangles of meshes in world space, spheres, and the instances of the other meshes, of which there are the
    contents."""
    n = numbers()
    placed = np.flatnonzero(instances["root"] != n["NONE"])
    of_meshes = mesh_boxes(scene)
    for content in contents:
        if len(content.reference):
            of_meshes[content.mesh] = content.lo.min(axis=0), content.hi.max(axis=0)
    boxes = of_meshes[scene.instance_mesh[placed]].astype(np.float64)
    lo, hi = instance_boxes(instances[placed], boxes)
    moving = np.flatnonzero(motion.moving(scene)[placed])
    lo[moving], hi[moving] = motion.swept_boxes(scene, placed[moving], boxes[moving])
    center, radius = spheres["center"], spheres["radius"][:, None]
    reference = [np.arange(len(spheres)) | n["REF_SPHERE"] << 30, placed | n["REF_INSTANCE"] << 30]
    return content_of(scene, WORLD, members, np.concatenate([center - radius, lo]),
                      np.concatenate([center + radius, hi]), np.concatenate(reference))


# ------------------------------------------------------------------ spheres and instances


def make_spheres(scene: Scene) -> np.ndarray:
    """Sphere records."""
    return make_records("Sphere", len(scene.sphere_radius), center=scene.sphere_center, radius=scene.sphere_radius,
                        material=scene.sphere_material, visibility=scene.sphere_visibility)


def make_instances(scene: Scene, own: np.ndarray) -> np.ndarray:
    """Instance records; the roots of those whose mesh has a tree of its own are filled in by Geometry.joined."""
    n, mesh = numbers(), scene.instance_mesh
    matrices, shared = scene.instance_to_world, own[mesh]
    inverse, flat = np.zeros_like(matrices), motion.moving(scene) & (matrix_ranks(matrices) < 3)
    inverse[~flat, :, :3] = np.linalg.inv(matrices[~flat, :, :3])  # who moves may be flat for a moment
    inverse[:, :, 3] = -np.einsum("nij,nj->ni", inverse[:, :, :3], matrices[:, :, 3])
    normals = scene.mesh_normals[mesh].astype(np.int64)
    radii = scene.mesh_radii[mesh].astype(np.int64)
    flags = (is_mirrored(matrices) & ~shared) * n["INSTANCE_MIRRORED"] | (normals >= 0) * n["INSTANCE_SMOOTH"]
    flags |= (radii > 0) * n["INSTANCE_STRANDS"]
    first = np.where(radii > 0, radii - 1, np.where(normals >= 0, normals, scene.mesh_vertices[mesh]))
    first -= scene.mesh_vertices[mesh]
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
