# SPDX-License-Identifier: GPL-3.0-or-later
"""The space of a lamp, as its nodes see it: constants of the lamp's own program, which kernels know nothing of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from isophote.values import call1, divide

from .values import call3, dot, outputs, source, triple

POINT, SPOT, SUN, RECTANGLE, ELLIPSE = range(5)


@dataclass(frozen=True)
class LampSpace:
    """`matrix`: f8 [4, 4], Blender's world; `size` as the scene has it; `cone`: full angle of a spot.

    `known(kind, name)` are the parts of what is known of the lamp's object (instance_values.py).
    """

    kind: int
    matrix: np.ndarray
    size: tuple[float, float]
    cone: float
    known: Callable[[str, str], tuple]

    @property
    def inverse(self) -> np.ndarray:
        return np.linalg.pinv(self.matrix[:3, :3])

    def place(self) -> np.ndarray:
        """The point of the lamp in Blender's world; of a sun the direction in which it shines, as in Cycles."""
        return source("object_point" if self.kind == SUN else "position")

    def from_center(self) -> np.ndarray:
        return self.place() - self.matrix[:3, 3]  # in this order differences of large numbers are small ones

    def point(self) -> np.ndarray:
        """The point in the lamp's own space."""
        return turned(self.inverse, self.from_center())

    def moved(self, kind: str, v, to_world: bool) -> np.ndarray:
        """A POINT, VECTOR or NORMAL between the world and the lamp's space."""
        matrix = self.matrix[:3, :3] if to_world else self.inverse
        if kind == "NORMAL":
            across = (self.inverse if to_world else self.matrix[:3, :3]).T
            return call3("normalize", *turned(across, v))
        if kind == "VECTOR":
            return turned(matrix, v)
        return turned(matrix, v) + self.matrix[:3, 3] if to_world else turned(matrix, v - self.matrix[:3, 3])

    def parametric(self) -> np.ndarray:
        """Geometry's Parametric and UV coordinates: 0 to 1 over an area lamp, the cone of a spot and the disk of a sun,
        around a point longitude and latitude (Cycles' kernel/light)."""
        if self.kind == POINT:
            normal = turned(self.inverse, source("shading_normal"))
            return triple(*outputs("sphere_place", *(normal * 0.5 + 0.5)), 0.0)
        if self.kind == SPOT:
            x, y, z = turned(self.inverse, source("incoming"))
            scale = divide(-0.5 / np.tan(0.5 * self.cone), z)
            return triple(x * scale + 0.5, y * scale + 0.5, 0.0)
        if self.kind == SUN:
            toward = -1.0 * source("incoming")
            off = toward + self.matrix[:3, 2] / np.linalg.norm(self.matrix[:3, 2])
            quarter = np.sin(0.25 * self.size[0])
            scale = divide(0.5 / quarter if quarter > 0.0 else 0.0, call1("length", *off))
            x, y, _ = turned(self.inverse, toward)
            return triple(x * scale + 0.5, y * scale + 0.5, 0.0)
        axes = self.matrix[:3, :2] / np.maximum(np.linalg.norm(self.matrix[:3, :2], axis=0), 1e-30)
        x, y = (dot(axes[:, k], self.from_center()) * (1.0 / max(self.size[k], 1e-30)) + 0.5 for k in range(2))
        return triple(x, y, 0.0)


def turned(matrix: np.ndarray, v) -> np.ndarray:
    """A matrix, f8 [3, 3], times a vector."""
    return triple(*(dot(row, v) for row in matrix))
