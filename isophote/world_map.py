"""The map by which directions of the world are drawn (kernels/world.h): its cells, and how bright it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isophote.emission import radiance_from
from isophote.records import numbers
from isophote.scene import Scene
from isophote.statistics import LUMINANCE
from isophote.values import operations
from isophote.world_sun import WorldSun

COMPUTED = 1024  # columns for a world that is no picture
FOR_SUNS = 2048  # and for one that has several suns, or one whose place is not known
FEWEST = 64
WIDTHS, FINER = (512, 2048), (2, 1, 0)  # how often cells are halved where so many columns, or more, were asked for
AT_ONCE = 1 << 20  # directions that are asked for together
EVEN = 1e-3  # worlds whose luminance differs by less, in parts of its mean, are left to closures
SUN_CHANCES = 0.25, 0.8  # least and most of a sun that is drawn apart: where it is mirrored, and where it is in shadow


@dataclass
class WorldMap:
    """`cumulated`: chances of rows, then of the columns of each row, from 0 to 1, f4; the mean radiance, f8 [3].

    `sun_width`: 1 less the cosine of half the angle of the disc that is drawn with `sun_chance` instead of the map; its
    part of the map is as bright as what lies around it. 0 where there is none.
    """

    cumulated: np.ndarray
    width: int
    height: int
    mean: np.ndarray
    sun_width: float = 0.0
    sun_chance: float = 0.0


def make_world_map(scene: Scene, buffers: dict[str, np.ndarray]) -> WorldMap | None:
    """Of a scene's world; None where it has none to compute, or one that is dark or the same in all directions."""
    if not len(scene.world_material):
        return None
    sun = WorldSun.of(scene.world_sun[0]) if len(scene.world_sun) else None
    width = columns_asked_for(scene)
    radiance, solid = cell_radiance(buffers, width, width // 2, sun), row_angles(width // 2)[:, None]
    mean = np.einsum("hwc,hk->c", radiance, solid) / (width * solid.sum())
    bright = radiance @ LUMINANCE.astype(np.float32)
    of_sun = sun.brings(buffers) if sun else np.zeros(3)
    if bright.max() - bright.min() <= EVEN * ((mean + of_sun) @ LUMINANCE) and not of_sun.any():
        return None
    if not bright.any():
        bright = np.ones_like(bright)  # all comes from the disc
    for _ in range(FINER[np.searchsorted(WIDTHS, width)]):
        bright = refined(bright)
    height, width = bright.shape
    cumulated = cumulate(smoothed(bright) * row_angles(height)[:, None])
    if not of_sun.any():
        return WorldMap(cumulated, width, height, mean)
    chance = np.clip(of_sun @ LUMINANCE / ((mean + of_sun) @ LUMINANCE), *SUN_CHANCES)
    return WorldMap(cumulated, width, height, mean + of_sun, sun.width, chance)


def columns_asked_for(scene: Scene) -> int:
    """Those of the largest picture that the world reads, within limits; not few where it has a sun that is not drawn
    apart."""
    material = int(scene.world_material[0])
    steps = slice(*scene.material_steps[material:material + 2])
    has_sun = (scene.step_op[steps] == operations()["sun_disc"].number).any() and not len(scene.world_sun)
    least = FOR_SUNS if has_sun else FEWEST
    reads = scene.step_op[steps] == operations()["image"].number
    if not reads.any():
        return max(least, COMPUTED)
    widest = int(scene.images[scene.step_data[steps][reads], 1].max())
    return min(max(widest & ~1, least), numbers()["MOST_MAP_CELLS"])


def cell_radiance(buffers: dict[str, np.ndarray], width: int, height: int, sun: WorldSun | None) -> np.ndarray:
    """At the middle of each cell, or around the sun, f4 [height, width, 3]; rows from the south pole up."""
    theta = np.pi * (1.0 - (np.arange(height) + 0.5) / height)
    phi = 2.0 * np.pi * (0.5 - (np.arange(width) + 0.5) / width)
    made, rows = np.empty((height, width, 3), np.float32), max(1, AT_ONCE // width)
    for first in range(0, height, rows):
        t = theta[first:first + rows, None]
        d = np.stack(np.broadcast_arrays(np.sin(t) * np.cos(phi), np.sin(t) * np.sin(phi), np.cos(t)), axis=-1)
        d = sun.pushed_out(d) if sun else d
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
