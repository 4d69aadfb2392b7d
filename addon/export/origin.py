# SPDX-License-Identifier: GPL-3.0-or-later
"""The place in Blender's world that all else of a scene is relative to."""

from __future__ import annotations

import numpy as np

CELL = 10  # binary orders from the nearest thing that the camera sees to the grid of origins


def make_origin(place: np.ndarray, nearest: float) -> np.ndarray:
    """The point of a coarse grid that is next to the camera's place, f8 [3]: what all else is relative to.

    Its cells are 2^CELL times as wide as the power of two below `nearest`, the distance of the nearest thing
    that the camera sees (or the width of what an orthographic one sees), metres. So a camera that moves keeps
    the bits of what it looks at as long as it stays in its cell, and rounding to float32 moves nothing within
    the cell by more than 2^-16 of `nearest` (docs/architecture.md). A camera's place within it is exact.
    """
    if not nearest > 0.0:
        return place.copy()
    cell = np.ldexp(1.0, np.frexp(nearest)[1] - 1 + CELL)
    return np.round(place / cell) * cell
