"""The map by which directions of the world are drawn (kernels/world.h): its cells, and how bright it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isophote.emission import radiance_from
from isophote.records import numbers
from isophote.scene import Scene
from isophote.values import operations

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
COMPUTED = 1024  # columns for a world that is no picture
FEWEST = 64
WIDTHS, FINER = (512, 2048), (2, 1, 0)  # how often cells are halved where so many columns, or more, were asked for
AT_ONCE = 1 << 20  # directions that are asked for together
EVEN = 1e-3  # worlds whose luminance differs by less, in parts of its mean, are left to closures


@dataclass
class WorldMap:
    """`cumulated`: chances of rows, then of the columns of each row, from 0 to 1, f4; the mean radiance, f8 [3]."""

    cumulated: np.ndarray
    width: int
    height: int
    mean: np.ndarray


def make_world_map(scene: Scene, buffers: dict[str, np.ndarray]) -> WorldMap | None:
    """Of a scene's world; None where it has none to compute, or one that is dark or the same in all directions."""
    if not len(scene.world_material):
        return None
    width = columns_asked_for(scene)
    radiance, solid = cell_radiance(buffers, width, width // 2), row_angles(width // 2)[:, None]
    mean = np.einsum("hwc,hk->c", radiance, solid) / (width * solid.sum())
    bright = radiance @ LUMINANCE.astype(np.float32)
    if bright.max() - bright.min() <= EVEN * (mean @ LUMINANCE):
        return None
    for _ in range(FINER[np.searchsorted(WIDTHS, width)]):
        bright = refined(bright)
    height, width = bright.shape
    return WorldMap(cumulate(smoothed(bright) * row_angles(height)[:, None]), width, height, mean)


def columns_asked_for(scene: Scene) -> int:
    """Those of the largest picture that the world reads, within limits."""
    material = int(scene.world_material[0])
    steps = slice(*scene.material_steps[material:material + 2])
    reads = scene.step_op[steps] == operations()["image"].number
    if not reads.any():
        return COMPUTED
    widest = int(scene.images[scene.step_data[steps][reads], 1].max())
    return min(max(widest & ~1, FEWEST), numbers()["MOST_MAP_CELLS"])


def cell_radiance(buffers: dict[str, np.ndarray], width: int, height: int) -> np.ndarray:
    """At the middle of each cell, f4 [height, width, 3]; rows from the south pole up."""
    theta = np.pi * (1.0 - (np.arange(height) + 0.5) / height)
    phi = 2.0 * np.pi * (0.5 - (np.arange(width) + 0.5) / width)
    made, rows = np.empty((height, width, 3), np.float32), max(1, AT_ONCE // width)
    for first in range(0, height, rows):
        t = theta[first:first + rows, None]
        d = np.stack(np.broadcast_arrays(np.sin(t) * np.cos(phi), np.sin(t) * np.sin(phi), np.cos(t)), axis=-1)
        made[first:first + rows] = radiance_from(buffers, d.reshape(-1, 3)).reshape(-1, width, 3)
    return made


def row_angles(height: int) -> np.ndarray:
    """Differences of the cosine over each row, f8 [height]: solid angles but for a factor."""
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    return edges[:-1] - edges[1:]


def refined(bright: np.ndarray) -> np.ndarray:
    """Four cells of each, linearly between their middles: as pictures are interpolated. With cells of the size of
    texels most of a small sun would lie in cells half of which is dark."""
    height, width = bright.shape
    rows = np.pad(bright, ((1, 1), (0, 0)), mode="edge")
    made = np.empty((2 * height, width), bright.dtype)
    made[0::2] = 0.75 * bright + 0.25 * rows[:-2]
    made[1::2] = 0.75 * bright + 0.25 * rows[2:]
    finer = np.empty((2 * height, 2 * width), bright.dtype)
    finer[:, 0::2] = 0.75 * made + 0.25 * np.roll(made, 1, axis=1)
    finer[:, 1::2] = 0.75 * made + 0.25 * np.roll(made, -1, axis=1)
    return finer


def smoothed(bright: np.ndarray) -> np.ndarray:
    """Means over the cells of what lies linearly between their middles: with the middles' own values the dark side of
    an edge would hardly be drawn, and be noise."""
    across = 0.75 * bright + 0.125 * (np.roll(bright, 1, axis=1) + np.roll(bright, -1, axis=1))
    padded = np.pad(across, ((1, 1), (0, 0)), mode="edge")
    return 0.75 * across + 0.125 * (padded[:-2] + padded[2:])


def cumulate(weights: np.ndarray) -> np.ndarray:
    """Chances of rows and columns from the weights of cells, f8 [height, width]."""
    rows = weights.sum(axis=1)
    columns = np.cumsum(np.where(rows[:, None] > 0.0, weights, 1.0), axis=1)
    return np.concatenate([starting_at_0(np.cumsum(rows)[None])[0], starting_at_0(columns).ravel()])


def starting_at_0(sums: np.ndarray) -> np.ndarray:
    """Sums along the last axis, f8, as chances up to and including each: f4, with 0 before them."""
    scaled = (sums / sums[:, -1:]).astype(np.float32)
    return np.concatenate([np.zeros((len(sums), 1), np.float32), scaled], axis=1)
