"""The kernels' test of boxes errs on the side of looking: every box that a ray meets is entered, few others are."""

import ctypes

import numpy as np
import pytest

from isophote.trees import BOX_MARGIN
from tests.kernel_lib import compiled

COUNT = 100_000


@pytest.fixture(scope="module")
def enter():
    probe = compiled('#include "box_probe.cpp"').probe_boxes

    def call(origin, direction, lo, hi, t_max):
        margin = np.float32(BOX_MARGIN) * np.maximum(np.abs(lo), np.abs(hi)).max(1, keepdims=True)
        lo, hi = lo - margin, hi + margin  # as the builder does, for the roundings of triangle_hit
        rays, boxes = (np.ascontiguousarray(np.hstack(pair), np.float32) for pair in ((origin, direction), (lo, hi)))
        t_max, found = np.broadcast_to(np.float32(t_max), len(rays)).copy(), np.empty(len(rays), np.int32)
        probe(len(rays), *(a.ctypes.data_as(ctypes.c_void_p) for a in (rays, boxes, t_max, found)))
        return found != 0

    return call


def meets(origin, direction, lo, hi, t_max):
    """In float64, of what float32 holds: whether the ray is in the box somewhere in [0, t_max]."""
    o, d, lo, hi = (np.float32(a).astype(float) for a in (origin, direction, lo, hi))
    with np.errstate(divide="ignore", invalid="ignore"):
        near, far = np.sort(np.stack([(lo - o) / d, (hi - o) / d]), axis=0)
    along = d == 0
    inside = (lo <= o) & (o <= hi)
    near = np.where(along, np.where(inside, -np.inf, np.inf), near)
    far = np.where(along, np.where(inside, np.inf, -np.inf), far)
    return np.maximum(near.max(1), 0) <= np.minimum(far.min(1), t_max)


def rays_and_boxes(rng, size, apart):
    """Boxes of about a size around points, and rays from elsewhere that pass through them or by their edges."""
    middle = rng.uniform(-1, 1, (COUNT, 3)) * apart
    half = rng.uniform(0, 1, (COUNT, 3)) * size
    half[rng.random((COUNT, 3)) < 0.1] = 0  # flat boxes, lines and points
    lo, hi = np.float32(middle - half), np.float32(middle + half)
    origin = np.float32(rng.uniform(-1, 1, (COUNT, 3)) * apart)
    corner = np.where(rng.random((COUNT, 3)) < 0.5, lo, hi)
    through = np.where(rng.random((COUNT, 1)) < 0.5, corner, rng.uniform(lo, np.maximum(hi, lo)))
    direction = through - origin
    along = rng.random((COUNT, 3)) < 0.1  # axes along which it does not move: in the planes of faces, too
    along[along.all(1)] = False
    origin, direction = np.where(along, np.float32(through), origin), np.where(along, 0, direction)
    length = np.linalg.norm(direction, axis=1, keepdims=True)
    direction = np.where(length > 0, direction / np.maximum(length, 1e-300), (0, 0, 1))
    return origin, np.float32(direction), lo, hi


@pytest.mark.parametrize("scale", [-40, 0, 40])
@pytest.mark.parametrize("size, apart", [(1, 1), (1e-3, 1), (1e-6, 1), (1, 1e-3)])
def test_no_box_that_is_met_is_left_out(enter, size, apart, scale):
    rng = np.random.default_rng([abs(scale), int(1 / size), int(1 / apart)])
    origin, direction, lo, hi = rays_and_boxes(rng, size * 2.0**scale, apart * 2.0**scale)
    wanted = meets(origin, direction, lo, hi, np.inf)
    assert wanted.mean() > 0.2, "a fair share of the rays has to meet its box"
    missed = wanted & ~enter(origin, direction, lo, hi, 3e38)
    assert not missed.any(), (origin[missed][0], direction[missed][0], lo[missed][0], hi[missed][0])


def test_boxes_are_not_entered_needlessly(enter):
    """Of rays that go anywhere, those that enter a box without meeting it are few."""
    rng = np.random.default_rng(3)
    origin, direction, lo, hi = rays_and_boxes(rng, 0.1, 1)
    direction = np.float32(direction + rng.normal(0, 0.05, direction.shape))
    wrong = enter(origin, direction, lo, hi, 3e38) & ~meets(origin, direction, lo, hi, np.inf)
    assert wrong.mean() < 1e-4


def test_boxes_behind_the_hit_are_skipped(enter):
    one = np.ones((1, 3), np.float32)
    behind = [enter(one * 0, one / 3**0.5, one * 2, one * 3, t)[0] for t in (2 * 3**0.5 * 0.999, 2 * 3**0.5)]
    assert behind == [False, True]
