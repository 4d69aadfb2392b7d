# SPDX-License-Identifier: GPL-3.0-or-later
"""Tangents of triangles along texture coordinates: Mikkelsen 2008, "Simulation of Wrinkled Surfaces Revisited".

Corners of one place, normal and coordinate whose triangles lie the same way round in the texture share one tangent.
That these triangles must also touch along edges is left out: it matters where two sheets meet in a point.
"""

from __future__ import annotations

import numpy as np


def corner_tangents(places: np.ndarray, uvs: np.ndarray, normals: np.ndarray | None) -> np.ndarray:
    """Unit tangents of triangles' corners and the signs of their bitangents, f4 [T, 3, 4]; 0 where coordinates have no
    area. Takes places f4 [T, 3, 3], coordinates f4 [T, 3, 2] and unit normals f4 [T, 3, 3], None where all is flat."""
    places, uvs = places.astype(np.float64), uvs.astype(np.float64)
    e1, e2 = places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]
    s, t = uvs[:, 1] - uvs[:, 0], uvs[:, 2] - uvs[:, 0]
    area = s[:, 0] * t[:, 1] - s[:, 1] * t[:, 0]
    sign = np.where(area > 0.0, 1.0, -1.0)
    along = unit(e1 * t[:, 1:] - e2 * s[:, 1:]) * (sign * (area != 0.0))[:, None]
    if normals is None:
        normals = np.repeat(unit(np.cross(e1, e2))[:, None], 3, axis=1)
    normals = normals.astype(np.float64)
    before = within(np.roll(places, 1, axis=1) - places, normals)
    after = within(np.roll(places, -1, axis=1) - places, normals)
    angles = np.arccos(np.clip((before * after).sum(axis=2), -1.0, 1.0))
    weighted = within(np.repeat(along[:, None], 3, axis=1), normals) * angles[:, :, None]
    parts = [places, normals, uvs, np.broadcast_to(sign[:, None, None], uvs[:, :, :1].shape)]
    group = equal_rows(np.concatenate(parts, axis=2).reshape(-1, 9).astype(np.float32))
    sums = np.stack([np.bincount(group, weighted[:, :, k].ravel()) for k in range(3)], axis=1)
    made = np.empty((len(places), 3, 4), np.float32)
    made[:, :, :3] = unit(sums)[group].reshape(-1, 3, 3)
    made[:, :, 3] = sign[:, None]
    return made


def equal_rows(rows: np.ndarray) -> np.ndarray:
    """The number of each row's value, the same for equal rows."""
    rows = np.ascontiguousarray(rows + np.float32(0.0))  # one zero only
    whole = rows.view(np.dtype((np.void, rows.dtype.itemsize * rows.shape[1]))).ravel()
    return np.unique(whole, return_inverse=True)[1].reshape(-1)


def unit(vectors: np.ndarray) -> np.ndarray:
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(lengths > 0.0, lengths, 1.0)


def within(vectors: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """The part at right angles to normals, made unit."""
    return unit(vectors - (vectors * normals).sum(axis=-1, keepdims=True) * normals)
