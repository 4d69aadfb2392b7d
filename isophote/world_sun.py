"""A disc of the world that is drawn apart from its map, because the map's cells may be larger (kernels/world.h)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isophote.emission import radiance_from

POINTS = 4096  # directions that are asked for in it
GOLDEN = (3.0 - 5.0 ** 0.5) / 2.0
MARGIN = 1.001  # how much wider it is drawn: at its edge rounding must not leave it to the map


@dataclass
class WorldSun:
    """Unit direction of its middle, f8 [3], half its angle in radians, and 1 less the cosine of that."""

    middle: np.ndarray
    half: float
    width: float

    @classmethod
    def of(cls, sun: np.ndarray) -> WorldSun:
        """As Scene.world_sun has it, a little wider."""
        half = min(MARGIN * float(sun[3]), np.pi / 2)
        return cls(sun[:3], half, 2.0 * np.sin(0.5 * half) ** 2)

    def axes(self) -> tuple[np.ndarray, np.ndarray]:
        x = np.cross(self.middle, np.eye(3)[np.argmin(np.abs(self.middle))])
        x /= np.linalg.norm(x)
        return x, np.cross(self.middle, x)

    def brings(self, buffers: dict[str, np.ndarray]) -> np.ndarray:
        """What it adds to the mean radiance of the world, beyond that of its edge, f8 [3]."""
        k, (x, y) = np.arange(POINTS)[:, None], self.axes()
        below, around = self.width * (k + 0.5) / POINTS, 2.0 * np.pi * GOLDEN * k  # evenly, on a spiral (Vogel 1979)
        spread = np.sqrt(below * (2.0 - below)) * (x * np.cos(around) + y * np.sin(around))
        inside = radiance_from(buffers, (self.middle * (1.0 - below) + spread).astype(np.float32))
        edge = radiance_from(buffers, self.pushed_out(np.broadcast_to(self.middle, (1, 3))).astype(np.float32))
        return np.maximum(inside.mean(axis=0, dtype=np.float64) - edge[0], 0.0) * (self.width / 2.0)

    def pushed_out(self, d: np.ndarray) -> np.ndarray:
        """Unit directions, f8 [..., 3]; those that lie in it moved to just outside of its edge."""
        along = d @ self.middle
        off = d - along[..., None] * self.middle
        length = np.linalg.norm(off, axis=-1, keepdims=True)
        off = np.where(length > 1e-9, off / np.maximum(length, 1e-9), self.axes()[0])
        edge = MARGIN * self.half
        inside = (along > 0.0) & (np.arctan2(length[..., 0], along) < edge)
        return np.where(inside[..., None], self.middle * np.cos(edge) + off * np.sin(edge), d)
