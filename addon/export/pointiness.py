# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a mesh points out or in at its vertices, as Cycles counts it (blender/mesh.cpp, attr_create_pointiness)."""

from __future__ import annotations

import numpy as np

from .tangents import equal_rows, unit


def pointiness_of(places: np.ndarray, normals: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """f4 [V], half where it is flat, more where it points out: of vertices' places and unit normals f4 [V, 3] and of
    edges i4 [E, 2].

    The angle between the normal and the mean of the directions to a vertex's neighbours, averaged with those of the
    neighbours. Vertices in one place are one.
    """
    group = equal_rows(places.astype(np.float32))
    count = int(group.max(initial=-1)) + 1
    first = np.zeros(count, np.int64)
    first[group[::-1]] = np.arange(len(places))[::-1]
    place = places[first].astype(np.float64)
    normal = unit(sums_of(group, normals.astype(np.float64), count))
    pairs = np.unique(np.sort(group[edges], axis=1), axis=0)
    a, b = pairs[pairs[:, 0] != pairs[:, 1]].T
    along, ends = unit(place[b] - place[a]), np.concatenate([a, b])
    neighbours = np.bincount(ends, minlength=count)
    mean = sums_of(ends, np.concatenate([along, -along]), count) / np.maximum(neighbours, 1)[:, None]
    angles = np.arccos(np.clip((normal * mean).sum(axis=1), -1.0, 1.0)) / np.pi
    angles[neighbours == 0] = 0.0
    blurred = angles + np.bincount(ends, angles[np.concatenate([b, a])], count)
    return (blurred / (neighbours + 1))[group].astype(np.float32)


def sums_of(group: np.ndarray, vectors: np.ndarray, count: int) -> np.ndarray:
    return np.stack([np.bincount(group, vectors[:, k], count) for k in range(3)], axis=1)
