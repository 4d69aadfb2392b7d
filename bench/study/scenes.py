"""What the study renders: scenes that are already exported, and rooms with any number of triangles."""

from __future__ import annotations

from contextlib import contextmanager

from isophote import geometry
from isophote.prepare import Prepared, prepare
from isophote.scene import Scene
from isophote.validate import clean


@contextmanager
def leaf_limit(triangles: int):
    """Trees that are built within have at most so many items in a leaf."""
    usual, geometry.MAX_LEAF = geometry.MAX_LEAF, triangles
    try:
        yield
    finally:
        geometry.MAX_LEAF = usual


def ready_with_leaves(scene: Scene, triangles: int) -> Prepared:
    """A prepared scene whose leaves hold at most so many triangles."""
    with leaf_limit(triangles):
        return prepare(clean(scene)[0])
