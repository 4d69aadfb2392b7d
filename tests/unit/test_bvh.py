"""The tree builder: valid trees over anything, the same ones for any number of threads."""

import numpy as np
import pytest

from isophote import _native
from isophote.geometry import MESH_USE
from isophote.records import numbers, records
from isophote.trees import ITEM_COST
from tests.scenes import ball
from tests.scenes import box as scene_box

N = numbers()
DEPTH = 46  # what the stacks of kernels/bvh.h rest on
MAX_LEAF = 4


NONE = np.zeros((0, 3), np.float32)


def meshes_of(corners):
    """One mesh of triangles (n, 3, 3)."""
    corners = np.ascontiguousarray(corners, np.float32)
    triangles = np.arange(3 * len(corners), dtype=np.uint32).reshape(-1, 3)
    return _native.Meshes(corners.reshape(-1, 3), triangles, np.array([0, len(corners)], np.uint32),
                          np.zeros(1, MESH_USE).view(np.uint8))


def build_triangles(corners, threads=1, margin=2.0**-20):
    return build_all(corners, NONE, NONE, np.zeros(0, np.uint32), margin, MAX_LEAF, threads)


def build_all(corners, lo, hi, reference, margin, max_leaf, threads):
    nodes, order, last, root, depth = _native.make_tree(
        meshes_of(corners), np.zeros(1, np.uint32), lo, hi, reference, margin, ITEM_COST, max_leaf, threads)
    return nodes.view(records()["Bvh2Node"]), order, last, root, depth


def build(lo, hi, reference=None, max_leaf=MAX_LEAF, threads=1):
    lo, hi = (np.ascontiguousarray(a, np.float32).reshape(-1, 3) for a in (lo, hi))
    if reference is None:
        reference = np.full(len(lo), N["REF_TRIANGLES"] << 30, np.uint32)
    return build_all(np.zeros((0, 3, 3)), lo, hi, reference, 0.0, max_leaf, threads)


def boxes(rng, count, size=0.1):
    center = rng.uniform(-1, 1, (count, 3))
    half = rng.uniform(0, size, (count, 3))
    return center - half, center + half


def box_of(node, child):
    """Low and high corner of a child's box, float32 as kernels reach them."""
    center, half = (np.array([node[f"{name}_{axis}"][child] for axis in "xyz"]) for name in ("center", "half"))
    return center - half, center + half


def check(lo, hi, made, reference=None):
    """Walks the tree: every item once, in all the boxes on the way to it, leaves that end, depth as told."""
    nodes, order, last, root, depth = made
    lo, hi = (np.asarray(a, np.float32).reshape(-1, 3) for a in (lo, hi))
    assert sorted(order.tolist()) == list(range(len(lo)))
    if not len(lo):
        assert root == N["NONE"] and not len(nodes)
        return
    kinds = np.full(len(lo), N["REF_TRIANGLES"]) if reference is None else reference >> 30
    position = np.flatnonzero(kinds[order] == N["REF_TRIANGLES"])
    seen, deepest, leaf_sizes = [], 0, []
    stack = [(int(root), np.full(3, -np.inf), np.full(3, np.inf), 1)]
    visited = set()
    while stack:
        ref, low, high, level = stack.pop()
        deepest = max(deepest, level)
        kind, index = ref >> 30, ref & 0x3FFFFFFF
        if kind == N["REF_NODE"]:
            assert ref not in visited
            visited.add(ref)
            node = nodes[index]
            for child in (0, 1):
                child_low, child_high = box_of(node, child)
                stack.append((int(node["child"][child]), np.maximum(low, child_low), np.minimum(high, child_high),
                              level + 1))
            continue
        if kind != N["REF_TRIANGLES"]:
            items = np.flatnonzero(reference == ref)
            assert len(items) == 1
        else:  # a run of triangles that ends at the one marked last
            run = position[index:]
            items = order[run[:np.argmax(last[run]) + 1]]
            assert last[run].any()
        leaf_sizes.append(len(items))
        seen.extend(items.tolist())
        assert (lo[items] >= low).all() and (hi[items] <= high).all()
    assert sorted(seen) == list(range(len(lo)))
    assert len(visited) == len(nodes)
    assert deepest <= depth + 1 and depth <= DEPTH
    return leaf_sizes


@pytest.mark.parametrize("count", [0, 1, 2, 4, 5, 100, 3000])
def test_trees_are_valid(count):
    lo, hi = boxes(np.random.default_rng(count), count)
    check(lo, hi, build(lo, hi))


def test_leaves_hold_few_items():
    lo, hi = boxes(np.random.default_rng(5), 3000)
    assert max(check(lo, hi, build(lo, hi))) <= MAX_LEAF
    assert max(check(lo, hi, build(lo, hi, max_leaf=1))) == 1


def test_kinds_do_not_mix_in_leaves():
    """Triangles, spheres and instances under one root."""
    rng = np.random.default_rng(6)
    lo, hi = boxes(rng, 600)
    kind = rng.integers(1, 4, 600).astype(np.uint32)
    reference = kind << 30 | np.where(kind == N["REF_TRIANGLES"], 0, np.arange(600)).astype(np.uint32)
    check(lo, hi, build(lo, hi, reference), reference)


@pytest.mark.parametrize("count", [100, 20000, 200000])
def test_threads_make_no_difference(count):
    lo, hi = boxes(np.random.default_rng(7), count, 0.02)
    one = build(lo, hi, threads=1)
    for threads in (2, 7):
        other = build(lo, hi, threads=threads)
        assert all(np.array_equal(a, b) for a, b in zip(one[:3], other[:3], strict=True)) and one[3:] == other[3:]


def same_point(count):
    return np.zeros((count, 3)), np.zeros((count, 3))


def same_center(count):
    half = np.random.default_rng(8).uniform(0, 1, (count, 3))
    return -half, half


def on_a_line(count):
    """Sizes that fall by powers of two: greedy splits would peel off one at a time."""
    x = 2.0 ** -np.linspace(0, 120, count)
    lo = np.stack([x, np.zeros(count), np.zeros(count)], axis=1)
    return lo, lo * 1.01


def flat(count):
    lo, hi = boxes(np.random.default_rng(9), count)
    lo[:, 2] = hi[:, 2] = 0.25
    return lo, hi


def far_apart(count):
    """Half in one point, half at the ends of what float32 holds."""
    lo = np.zeros((count, 3))
    lo[::2] = np.random.default_rng(10).choice([-1, 1], (len(lo[::2]), 3)) * 1e37
    return lo, lo


def clusters(count):
    """Ever denser clusters within clusters."""
    rng = np.random.default_rng(11)
    center = rng.normal(size=(count, 3)) * 10.0 ** -rng.integers(0, 30, (count, 1))
    return center, center


@pytest.mark.parametrize("shape", [same_point, same_center, on_a_line, flat, far_apart, clusters])
@pytest.mark.parametrize("count", [2, 9, 5000])
def test_degenerate_input(shape, count):
    lo, hi = shape(count)
    check(lo, hi, build(lo, hi, threads=2))


def test_huge_counts_in_one_point_stay_shallow():
    lo, hi = same_point(300000)
    nodes, order, last, root, depth = build(lo, hi, threads=2)
    assert sorted(order.tolist()) == list(range(300000)) and depth <= DEPTH


def test_good_trees_are_better_than_bad_ones():
    """The surface area heuristic: far fewer box areas than a tree over a shuffled order would have."""
    lo, hi = boxes(np.random.default_rng(12), 4000, 0.02)
    nodes = build(lo, hi)[0]
    size = [2 * nodes[f"half_{axis}"] for axis in "xyz"]
    area = 2 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0])
    whole = 2 * 3 * 2.0 ** 2
    assert area.sum() / whole < 40, "expected visits of a random line"


# ------------------------------------------------------------------ triangles in pieces


def slanted(rng, count):
    """Long thin triangles in all directions."""
    start, along = rng.uniform(-1, 1, (count, 3)), rng.normal(size=(count, 3))
    return np.stack([start, start + along, start + rng.normal(0, 0.005, (count, 3))], axis=1).astype(np.float32)


def leaves(made):
    """(positions, low, high) of each leaf."""
    nodes, order, last, root, _ = made
    ends = np.flatnonzero(last)
    stack = [(int(root), np.full(3, -np.inf), np.full(3, np.inf))]
    while stack:
        ref, low, high = stack.pop()
        if ref >> 30 == N["REF_NODE"]:
            for child in (0, 1):
                stack.append((int(nodes[ref]["child"][child]), *box_of(nodes[ref], child)))
        else:
            first = ref & 0x3FFFFFFF
            yield order[first:ends[np.searchsorted(ends, first)] + 1], low, high


def test_slanted_triangles_are_cut_and_covered():
    """Each point of a triangle lies in a leaf that holds the triangle, and most boxes have become small."""
    rng = np.random.default_rng(20)
    corners = slanted(rng, 4000)
    made = build_triangles(corners)
    assert 1.2 * len(corners) < len(made[1]) < 3 * len(corners)
    assert set(made[1].tolist()) == set(range(len(corners)))
    points = np.einsum("pk,nki->npi", rng.dirichlet((0.3, 0.3, 0.3), 50), corners.astype(float))
    covered = np.zeros(points.shape[:2], bool)
    for positions, low, high in leaves(made):
        inside = (points[positions] >= low) & (points[positions] <= high)
        np.logical_or.at(covered, positions, inside.all(2))
    assert covered.all()
    for threads in (2, 7):
        other = build_triangles(corners, threads)
        assert all(np.array_equal(a, b) for a, b in zip(made[:3], other[:3], strict=True)) and made[3:] == other[3:]


def test_even_triangles_stay_whole():
    """A sphere in a box, whose walls are far larger but lie along the axes."""
    meshes = [ball(rings=40), scene_box(half=3.0)]
    corners = np.concatenate([vertices[triangles] for vertices, triangles in meshes])
    assert sorted(build_triangles(corners)[1].tolist()) == list(range(len(corners)))


@pytest.mark.parametrize("count", [0, 1, 2, 5000])
@pytest.mark.parametrize("scale", [0.0, 1e-40, 1.0, 1e37])
def test_triangles_of_any_size(count, scale):
    """Points, denormal numbers, and where areas overflow."""
    corners = slanted(np.random.default_rng(21), count) * np.float32(scale)
    made = build_triangles(corners, threads=2)
    assert set(made[1].tolist()) == set(range(count)) and made[4] <= DEPTH
    lo, hi = corners.min(1), corners.max(1)
    if len(made[1]) == count and count:
        for positions, low, high in leaves(made):
            assert (lo[positions] >= low).all() and (hi[positions] <= high).all()
