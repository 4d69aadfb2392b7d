"""A prepared scene's trees in other forms: leaves of another size, parent links, wide nodes, no tree at all.

Each function takes a Prepared that has all its buffers (Prepared.traced) and returns another whose buffers `nodes`,
`world` and `instances` (and the marks of `triangles`) hold the new form; everything else is shared. References keep
their meaning (kernels/scene_records.h), so one form's leaves are the other's. Trees are walked level by level, so that
numpy does the work.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path

import numpy as np

from bench.study.variant import Variant
from isophote import _native
from isophote.geometry import Geometry, Joined, plain
from isophote.prepare import Prepared
from isophote.records import fields_of, numbers, records
from isophote.trees import THREADS

HUGE = np.float32(3e38)  # a box that every ray enters
MARGIN = 2.0**-12  # of a step
WIDE_NODES = Path(__file__).parents[2] / "kernels" / "study" / "wide_nodes.h"
AXES = ("x", "y", "z")


def adapt(prepared: Prepared, variant: Variant) -> Prepared:
    """The scene in the form that a variant's traversal reads. Raises ValueError where its stack is too small."""
    prepared = replace(prepared, buffers=prepared.traced())
    if variant.leaf:
        prepared = with_leaves(prepared, variant.leaf)
    if variant.traversal in ("list", "list_local"):
        return as_list(prepared)
    if variant.traversal == "stackless":
        return with_parents(prepared)
    width = {"wide4": 4, "quantised4": 4, "quantised8": 8}.get(variant.traversal, 2)
    if width > 2:
        prepared = as_wide(prepared, width, variant.traversal != "wide4")
    if variant.traversal != "shipping":
        # A level leaves its other children on the stack, those of eight as one entry with their mask.
        depths = [tree_depth(prepared, root) for root in roots(prepared)]
        needed = (3 if width == 4 else 1) * (depths[-1] + max(depths[:-1], default=0)) + 2
        if needed > variant.stack:
            raise ValueError(f"{variant.traversal}: the tree needs a stack of {needed}, here is one of {variant.stack}")
    return prepared


# ------------------------------------------------------------------ references and roots


def kind_of(ref: np.ndarray) -> np.ndarray:
    return ref >> 30


def is_node(ref: np.ndarray) -> np.ndarray:
    return kind_of(ref) == numbers()["REF_NODE"]


def index_of(ref):
    return ref & 0x3FFFFFFF


def roots(prepared: Prepared) -> list[int]:
    """Roots of the instanced meshes' trees, each once, then the world's."""
    none = numbers()["NONE"]
    shared = np.unique(prepared.buffers["instances"]["root"])
    return [int(root) for root in shared if root != none] + [int(prepared.buffers["world"]["root"][0])]


def with_roots(prepared: Prepared, new: dict[int, int], **buffers) -> Prepared:
    """A copy with other buffers and each root replaced by its new reference."""
    made = dict(prepared.buffers)
    for name in ("instances", "world"):
        made[name] = made[name].copy()
        made[name]["root"] = [new.get(int(root), int(root)) for root in made[name]["root"]]
    made |= buffers
    triangles, last = made["triangles"], np.uint32(numbers()["LAST_IN_LEAF"])
    joined = Joined(made["nodes"], np.ascontiguousarray(triangles["primitive"]),
                    (triangles["flags"] & last != 0).astype(np.uint8), made["instances"], int(made["world"]["root"][0]))
    old = prepared.geometry
    geometry = OtherTrees(made, old.meshes, old.instance_mesh, [], {}, given=joined)
    return replace(prepared, buffers=made, geometry=geometry)


@dataclass
class OtherTrees(Geometry):
    """A geometry with these trees: the CPU's is made of them."""

    given: Joined = None

    def joined(self) -> Joined:
        return self.given

    @cached_property
    def wide_tree(self):
        n, given = numbers(), self.given
        own = given.instances["root"]
        shared = np.unique(own[own != n["NONE"]])
        tree_of = np.where(own == n["NONE"], n["NONE"], np.searchsorted(shared, own)).astype(np.uint32)
        sources = [(plain(given.nodes), given.order, given.last, int(root)) for root in [*shared, given.root]]
        return _native.make_wide_tree(self.meshes, sources, tree_of, THREADS)


def levels(nodes: np.ndarray, root: int):
    """Numbers of the nodes of each level of a tree, from its root down."""
    level = np.array([root], np.uint32)
    level = level[is_node(level)]
    while len(level):
        yield level
        children = nodes["child"][level].ravel()
        level = children[is_node(children)]


def tree_depth(prepared: Prepared, root: int) -> int:
    """Levels of inner nodes below a root."""
    nodes = prepared.buffers["nodes"]
    if root == numbers()["NONE"]:
        return 0
    return sum(1 for _ in levels(nodes, root))


# ------------------------------------------------------------------ leaves


def run_lengths(triangles: np.ndarray) -> np.ndarray:
    """For each triangle, how many follow to the end of its leaf, itself included."""
    last = np.flatnonzero(triangles["flags"] & np.uint32(numbers()["LAST_IN_LEAF"]))
    at = np.arange(len(triangles))
    return last[np.searchsorted(last, at)] - at + 1 if len(last) else at


def with_leaves(prepared: Prepared, size: int) -> Prepared:
    """Subtrees of at most `size` triangles become one leaf each; larger leaves stay. For size 1 the scene must have
    been built with such leaves (scenes.ready_with_leaves)."""
    n = numbers()
    nodes, triangles = prepared.buffers["nodes"].copy(), prepared.buffers["triangles"].copy()
    lengths = run_lengths(triangles)
    count = np.zeros(len(nodes), np.int64)  # triangles below each node; more than can be where it holds other things
    first = np.zeros(len(nodes), np.int64)
    new_roots, joined_first, joined_count = {}, [], []
    for root in roots(prepared):
        for level in reversed(list(levels(nodes, root))):
            ref = nodes["child"][level]
            inner, leaf = is_node(ref), kind_of(ref) == n["REF_TRIANGLES"]
            below = np.full(ref.shape, len(triangles) + 1, np.int64)
            start = np.zeros(ref.shape, np.int64)
            below[inner], start[inner] = count[ref[inner]], first[ref[inner]]
            below[leaf], start[leaf] = lengths[index_of(ref[leaf])], index_of(ref[leaf])
            count[level], first[level] = below.sum(1), start.min(1)
            joined = inner & (below <= size)
            ref[joined] = start[joined] | np.int64(n["REF_TRIANGLES"] << 30)
            nodes["child"][level] = ref
            joined_first.append(start[joined])
            joined_count.append(below[joined])
        if is_node(np.uint32(root)) and count[root] <= size:
            new_roots[root] = int(first[root]) | n["REF_TRIANGLES"] << 30
            joined_first.append([first[root]])
            joined_count.append([count[root]])
    # A leaf's triangles lie side by side: of those within it only the last stays marked.
    start, length = (np.concatenate([np.zeros(0, np.int64), *parts]) for parts in (joined_first, joined_count))
    border = np.zeros(len(triangles) + 1, np.int64)
    np.add.at(border, start, 1)
    np.add.at(border, start + length - 1, -1)
    triangles["flags"][np.cumsum(border)[:-1] > 0] &= np.uint32(~n["LAST_IN_LEAF"] & 0xFFFFFFFF)
    return with_roots(prepared, new_roots, nodes=nodes, triangles=triangles)


def leaves_below(prepared: Prepared, root: int) -> np.ndarray:
    """References of all leaves of a tree, in the order of kind and number."""
    nodes = prepared.buffers["nodes"]
    found = [np.array([root], np.uint32)]
    found += [nodes["child"][level].ravel() for level in levels(nodes, root)]
    refs = np.concatenate(found)
    return np.sort(refs[~is_node(refs) & (refs != numbers()["NONE"])])


def as_list(prepared: Prepared) -> Prepared:
    """No tree: chains of a run of triangles and other things (kernels/study/list.h). Also serves the CPU's wide
    tree, as a tree without boxes."""
    n = numbers()
    triangles = prepared.buffers["triangles"].copy()
    new_roots, chain = {}, []
    for root in roots(prepared):
        leaves = leaves_below(prepared, root)
        links = []
        runs = index_of(leaves[kind_of(leaves) == n["REF_TRIANGLES"]]).astype(np.int64)
        if len(runs):
            is_last = (triangles["flags"] & np.uint32(n["LAST_IN_LEAF"])) != 0
            end = runs[-1] + int(np.argmax(is_last[runs[-1]:]))
            triangles["flags"][runs[0]:end] &= np.uint32(~n["LAST_IN_LEAF"] & 0xFFFFFFFF)
            links.append(int(runs[0]) | n["REF_TRIANGLES"] << 30)
        links += [int(ref) for ref in leaves[kind_of(leaves) != n["REF_TRIANGLES"]]]
        if links:
            new_roots[root] = links[-1] if len(links) == 1 else len(chain)
        chain += [(ref, len(chain) + k + 1 if k + 2 < len(links) else links[-1]) for k, ref in enumerate(links[:-1])]
    nodes = np.zeros(max(len(chain), 1), records()["Bvh2Node"])
    for axis in AXES:
        nodes[f"half_{axis}"] = HUGE
    if chain:
        nodes["child"] = chain
    return with_roots(prepared, new_roots, nodes=nodes, triangles=triangles)


# ------------------------------------------------------------------ parents


def with_parents(prepared: Prepared) -> Prepared:
    """Parent links and the order of children in each node's unused words; leaves that are roots get a node above."""
    n = numbers()
    nodes = prepared.buffers["nodes"].copy()
    leaves = [root for root in roots(prepared) if root != n["NONE"] and not is_node(np.uint32(root))]
    new_roots = {root: len(nodes) + k for k, root in enumerate(leaves)}
    above = np.zeros(len(leaves), nodes.dtype)
    for k, root in enumerate(leaves):
        above["child"][k] = root, n["NONE"]
        for axis in AXES:
            above[f"half_{axis}"][k] = HUGE
    nodes = np.concatenate([nodes, above])
    apart = np.stack([nodes[f"center_{axis}"][:, 1] - nodes[f"center_{axis}"][:, 0] for axis in AXES], 1)
    axis = np.abs(apart).argmax(1)
    upper_first = np.take_along_axis(apart, axis[:, None], 1)[:, 0] < 0
    nodes["unused"][:, 1] = axis | upper_first << 2
    nodes["unused"][:, 0] = n["NONE"]
    parent, child = np.nonzero(is_node(nodes["child"]))
    nodes["unused"][nodes["child"][parent, child], 0] = parent << 1 | child
    return with_roots(prepared, new_roots, nodes=nodes)


# ------------------------------------------------------------------ wide nodes


@cache
def wide_records() -> dict[str, np.dtype]:
    """The records of kernels/study/wide_nodes.h."""
    text = re.sub(r"/\*.*?\*/", " ", WIDE_NODES.read_text(), flags=re.S)
    return {name: np.dtype([f for line in body.split(";") for f in fields_of(line, records())])
            for body, name in re.findall(r"typedef struct \{(.*?)\} (\w+);", text, re.S)}


def as_wide(prepared: Prepared, width: int, quantised: bool) -> Prepared:
    """The BVH2s collapsed to `width` children: the child with the largest surface is opened until all places are taken
    (Wald, Benthin and Boulos 2008, section 4.2)."""
    nodes = prepared.buffers["nodes"]
    center, half = (np.stack([nodes[f"{name}_{axis}"] for axis in AXES], 2) for name in ("center", "half"))
    boxes = np.stack([center - half, center + half], 2)  # (node, child, lo hi, axis)
    made, new_roots, placed = [], {}, 0
    for root in roots(prepared):
        if not is_node(np.uint32(root)):
            continue
        new_roots[root] = placed
        level = np.array([root], np.uint32)
        while len(level):
            ref, box = open_children(nodes["child"], boxes, level, width)
            if width == 8:
                ref, box = place_by_octant(ref, box)
            inner = (ref != numbers()["NONE"]) & is_node(ref)
            level = ref[inner]
            ref = ref.copy()
            ref[inner] = placed + len(ref) + np.arange(len(level), dtype=np.uint32)
            made.append((quantise if quantised else plain_nodes)(ref, box))
            placed += len(ref)
    kind = (f"QuantisedNode{width}" if quantised else f"PlainNode{width}")
    packed = np.concatenate(made) if made else np.zeros(1, wide_records()[kind])
    return with_roots(prepared, new_roots, nodes=packed)


def open_children(child: np.ndarray, boxes: np.ndarray, level: np.ndarray, width: int):
    """References (n, width), NONE where empty, and boxes float32 (n, width, lo hi, axis) of a level's wide nodes."""
    count, none = len(level), np.uint32(numbers()["NONE"])
    ref = np.full((count, width), none, np.uint32)
    box = np.zeros((count, width, 2, 3), np.float32)
    ref[:, :2], box[:, :2] = child[level], boxes[level]
    for place in range(2, width):
        size = np.maximum(box[:, :, 1] - box[:, :, 0], 0).astype(np.float64)
        area = size[..., 0] * size[..., 1] + size[..., 1] * size[..., 2] + size[..., 2] * size[..., 0]
        area[~is_node(ref) | (ref == none)] = -1
        widest = area.argmax(1)
        row = np.flatnonzero(area[np.arange(count), widest] >= 0)
        opened = ref[row, widest[row]]
        ref[row, widest[row]], box[row, widest[row]] = child[opened, 0], boxes[opened, 0]
        ref[row, place], box[row, place] = child[opened, 1], boxes[opened, 1]
    return ref, box


def place_by_octant(ref: np.ndarray, box: np.ndarray):
    """Children moved to the place whose number's bits say on which side of the node they lie, the clearest case first
    (Ylitie et al. 2017, section 3.3, who solve the assignment by an auction; this is greedy)."""
    count, none = len(ref), np.uint32(numbers()["NONE"])
    there = ref != none
    center = box.astype(np.float64).mean(2)
    lo = np.where(there[..., None], box[:, :, 0], np.inf).min(1)
    hi = np.where(there[..., None], box[:, :, 1], -np.inf).max(1)
    sides = np.array([[1 if slot >> axis & 1 else -1 for axis in range(3)] for slot in range(8)])
    gain = np.einsum("nca,sa->ncs", center - ((lo + hi) / 2)[:, None], sides)
    gain[~there] = -np.inf
    new_ref, new_box = np.full_like(ref, none), np.zeros_like(box)
    row = np.arange(count)
    for _ in range(8):
        best = gain.reshape(count, -1).argmax(1)
        from_, to = best // 8, best % 8
        some = np.flatnonzero(gain[row, from_, to] > -np.inf)
        new_ref[some, to[some]], new_box[some, to[some]] = ref[some, from_[some]], box[some, from_[some]]
        gain[some, from_[some], :] = -np.inf
        gain[some, :, to[some]] = -np.inf
    return new_ref, new_box


def plain_nodes(ref: np.ndarray, box: np.ndarray) -> np.ndarray:
    made = np.zeros(len(ref), wide_records()[f"PlainNode{ref.shape[1]}"])
    made["child"] = ref
    for axis, name in enumerate(AXES):
        made[f"lo_{name}"], made[f"hi_{name}"] = box[:, :, 0, axis], box[:, :, 1, axis]
    return made


def quantise(ref: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Boxes as 8-bit steps from the node's corner, with MARGIN steps to spare for the kernels' rounding (wide.h)."""
    count, width = ref.shape
    made = np.zeros(count, wide_records()[f"QuantisedNode{width}"])
    made["child"] = ref
    there = ref != numbers()["NONE"]
    if width == 8:
        made["exponents"] = np.bitwise_or.reduce(there << np.arange(24, 32, dtype=np.uint32), axis=1)
    shifts = np.uint32(8) * (np.arange(width, dtype=np.uint32) % 4)
    for axis, name in enumerate(AXES):
        lo = np.where(there, box[:, :, 0, axis], np.inf).astype(np.float64)
        hi = np.where(there, box[:, :, 1, axis], -np.inf).astype(np.float64)
        low, high = lo.min(1), hi.max(1)
        exponent = np.ceil(np.log2(np.maximum(high - low, 1e-36) / 250)).astype(int)
        # A step is no less than what float32 tells apart at the corner, whose rounding is then a step at most.
        exponent = np.clip(np.maximum(exponent, np.frexp(np.maximum(abs(low), abs(high)))[1] - 24), -126, 127)
        step = np.exp2(exponent)
        corner = (low - MARGIN * step).astype(np.float32)
        corner = np.where(corner > low - MARGIN * step, np.nextafter(corner, np.float32(-np.inf)), corner)
        made["corner"][:, axis] = corner
        made["exponents"] |= (exponent + 127).astype(np.uint32) << np.uint32(8 * axis)
        steps_low = np.floor((lo - corner[:, None]) / step[:, None] - MARGIN)
        steps_high = np.ceil((hi - corner[:, None]) / step[:, None] + MARGIN)
        assert (steps_low[there] >= 0).all() and (steps_high[there] <= 255).all()
        for bound, steps in (("lo", steps_low), ("hi", steps_high)):
            words = (np.where(there, steps, 0).astype(np.uint32) << shifts).reshape(count, -1, 4)
            word = np.bitwise_or.reduce(words, axis=2)
            made[f"{bound}_{name}"] = word if width > 4 else word[:, 0]
    return made
