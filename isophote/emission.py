"""What materials emit where it differs from point to point: asked of the kernels, for choosing lights."""

from __future__ import annotations

import os

import numpy as np

from isophote import _native
from isophote.records import numbers, scene_buffers

THREADS = os.cpu_count() or 1
POINTS, FEWEST_POINTS, MOST_POINTS = 1 << 20, 4, 64  # of all triangles together, and of one


def radiance_from(buffers: dict[str, np.ndarray], directions: np.ndarray) -> np.ndarray:
    """Radiance of the world, f4 [N, 3], seen along unit vectors, f4 [N, 3]."""
    ids = np.full((len(directions), 2), numbers()["NONE"], np.uint32)
    return evaluate(buffers, ids, np.zeros((len(directions), 2), np.float32), directions)


def mean_radiance(buffers: dict[str, np.ndarray], instance: np.ndarray, primitive: np.ndarray,
                  normal: np.ndarray) -> np.ndarray:
    """Mean over points of triangles, half of them seen from each side, f8 [N, 3]; numbers that are none count as 0.

    `normal` is unit, f8 [N, 3].
    """
    count = int(np.clip(POINTS // max(len(instance), 1), FEWEST_POINTS, MOST_POINTS))
    total = np.zeros((len(instance), 3))
    ids = np.stack([instance, primitive], axis=1).astype(np.uint32)
    for k, place in enumerate(points_of_triangle(count)):
        side = -normal if k % 2 else normal
        total += evaluate(buffers, ids, np.broadcast_to(place, (len(ids), 2)), side)
    return total / count


def points_of_triangle(count: int) -> np.ndarray:
    """Weights of the second and third corner of points spread evenly, f4 [count, 2]: an additive recurrence (Roberts
    2018, "The Unreasonable Effectiveness of Quasirandom Sequences"), folded at the diagonal."""
    golden = 1.32471795724474602596
    u = (0.5 + np.arange(1, count + 1)[:, None] / np.array([golden, golden ** 2])) % 1.0
    return np.where(u.sum(axis=1, keepdims=True) > 1.0, 1.0 - u, u).astype(np.float32)


def evaluate(buffers: dict[str, np.ndarray], ids: np.ndarray, places: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """As native/emission.h has it; not finite or negative parts are 0."""
    nothing = np.zeros(0, np.uint8)
    arrays = [buffers[name].reshape(-1).view(np.uint8) if name in buffers else nothing for name in scene_buffers()]
    made = np.empty((len(ids), 3), np.float32)
    _native.evaluate_emission(arrays, ids, np.ascontiguousarray(places, np.float32),
                              np.ascontiguousarray(directions, np.float32), THREADS, made)
    return np.where(np.isfinite(made), np.maximum(made, 0.0), 0.0)
