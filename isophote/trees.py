"""Trees over a scene's meshes, spheres and instances: BVH2s, and the CPU's wide tree that they are collapsed to.

A scene has a tree for each mesh with several users, in its own space, and one for the world. Those of another frame,
over as many of the same things, get new boxes instead of being built, unless their expected cost has grown too much.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from isophote import _native

BOX_MARGIN = 2.0**-20  # relative to the largest coordinate of a box: 16 roundings of float32
MAX_LEAF = 4  # triangles; larger leaves only where the surface area heuristic cannot tell them apart
ITEM_COST = 0.5  # of testing a triangle, where a node of the BVH2 costs 1: lower means larger leaves, fewer nodes
REFIT_COST = 1.1  # of a tree with new boxes, by the surface area heuristic, over the cost when it was built
WORLD = -1
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

    def holds_what(self, other: Content) -> bool:
        """Whether it is over the same triangles and things, wherever they are."""
        return all(np.array_equal(getattr(self, name), getattr(other, name)) for name in ("first", "end", "reference"))


@dataclass
class Tree:
    """A BVH2. Its references to nodes and triangles count from 0; `order` are the primitives of its leaves, one after
    the other, `last` says which end one. A triangle that is in several leaves is there several times."""

    content: Content
    nodes: np.ndarray
    order: np.ndarray
    last: np.ndarray
    root: int
    built_cost: float = 0.0  # by the surface area heuristic, 0 until it is asked for


@dataclass(frozen=True)
class Before:
    """Trees of another frame, by the mesh in whose space they are: what new ones may be made of.

    `same_meshes`: only instances, spheres or materials have changed.
    """

    trees: dict[int, Tree]
    contents: dict[int, Content]
    wide_tree: object  # None where there was none
    same_meshes: bool


NOTHING = Before({}, {}, None, False)


def make_tree(meshes, content: Content, before: Before) -> Tree:
    """The tree from before as it is where that still serves, or with new boxes, else a new one."""
    kept = before.trees.get(content.mesh)
    if kept and before.same_meshes and content.mesh != WORLD:
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
    if not content.holds_what(kept.content) or len(kept.order) != content.triangle_count:
        return None
    nodes = kept.nodes.copy()
    old_cost, cost = _native.refit_tree(meshes, nodes, kept.root, kept.order, kept.last, content.lo, content.hi,
                                        content.reference, BOX_MARGIN, THREADS)
    made = Tree(content, nodes, kept.order, kept.last, kept.root, kept.built_cost or old_cost)
    return made if cost <= REFIT_COST * made.built_cost else None


def make_wide_tree(meshes, contents: list[Content], tree_of: np.ndarray, before: Before, tree: Callable):
    """The CPU's tree. What was there before over the same things is copied and gets new boxes; `tree` gives the BVH2
    of a content by its number where there is nothing of use. `tree_of`: of each instance, the number or NONE."""
    old, numbers = before.wide_tree, {mesh: number for number, mesh in enumerate(before.contents)}
    kept = {k: numbers[content.mesh] for k, content in enumerate(contents)
            if old and can_keep(content, before, numbers)}
    while True:
        made = _native.make_wide_tree(meshes, [(old, kept[k]) if k in kept else source_of(tree(k))
                                               for k in range(len(contents))], tree_of, THREADS)
        moved = [k for k in kept if not before.same_meshes or contents[k].mesh == WORLD]
        worse = [k for k in moved if not fits(made, k, meshes, contents[k])]
        if not worse:
            return made
        for k in worse:
            del kept[k]


def source_of(tree: Tree) -> tuple:
    return tree.nodes, tree.order, tree.last, tree.root


def can_keep(content: Content, before: Before, numbers: dict[int, int]) -> bool:
    """Whether a part of the wide tree is over the same things, each once."""
    old = before.contents.get(content.mesh)
    return bool(old) and content.holds_what(old) and (
        before.wide_tree.triangles(numbers[content.mesh]) == content.triangle_count)


def fits(wide_tree, part: int, meshes, content: Content) -> bool:
    """Give a part the boxes of what it holds now; False where it has become too bad a tree by that."""
    built_cost, cost = _native.refit_wide_tree(meshes, wide_tree, part, content.lo, content.hi, content.reference,
                                               BOX_MARGIN, THREADS)
    return cost <= REFIT_COST * built_cost
