"""The statistical error of a film, from the spread of its two replicates (design, section 6).

The variance between the samples of a Sobol sequence says little about the error of their mean. Two
independently scrambled replicates do: with means a, b of n0 and n1 samples, n = n0 + n1, the picture
is m = (n0 a + n1 b) / n, and were each sample of variance s^2, then var(a - b) = s^2 n / (n0 n1) and
var(m) = s^2 / n. So

    v = (a - b)^2 n0 n1 / n^2        estimates the variance of m, without bias; (a - b)^2 / 4 for n0 = n1.

One v a pixel is a wild estimate (chi-squared with one degree of freedom), so standard errors are
pooled: the mean of v over tiles of 8 x 8 pixels. Replicates of unequal size (an odd count) are exact
for independent samples and nearly so for Sobol's. With one sample a pixel nothing is known: NaN or None.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from isophote.film import Film

TILE = 8
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # Rec. 709
Z95 = 1.959963984540054


def sums_over_tiles(values: np.ndarray, origin: tuple[int, int] = (0, 0), tile: int = TILE) -> np.ndarray:
    """Sums of (h, w) over tiles of the full frame's grid; `origin` is the x, y of the first pixel in the frame."""
    rows, columns = (borders_of_tiles(*of, tile)[:-1] for of in zip(values.shape, origin[::-1], strict=True))
    return np.add.reduceat(np.add.reduceat(values, rows, axis=0), columns, axis=1)


def borders_of_tiles(size: int, origin: int, tile: int) -> np.ndarray:
    """Where the tiles of a row of pixels begin, and where the last one ends."""
    return np.clip(np.arange(origin // tile * tile, origin + size + tile, tile) - origin, 0, size)


def pixels_of_tiles(shape: tuple[int, int], origin: tuple[int, int] = (0, 0), tile: int = TILE) -> np.ndarray:
    """How many pixels each tile of (h, w) has: sums_over_tiles of ones."""
    rows, columns = (np.diff(borders_of_tiles(*of, tile)) for of in zip(shape, origin[::-1], strict=True))
    return np.multiply.outer(rows, columns).astype(np.float64)


def spread_over_tiles(tiles: np.ndarray, shape: tuple[int, int], origin=(0, 0), tile: int = TILE) -> np.ndarray:
    """The inverse shape of sums_over_tiles: each pixel of (h, w) gets its tile's value."""
    rows, columns = (np.diff(borders_of_tiles(*of, tile)) for of in zip(shape, origin[::-1], strict=True))
    return np.repeat(np.repeat(tiles, columns, axis=1), rows, axis=0)


def pool(values: np.ndarray, origin: tuple[int, int] = (0, 0), tile: int = TILE) -> np.ndarray:
    """Each pixel's mean over its tile, (h, w) to (h, w)."""
    means = sums_over_tiles(values, origin, tile) / pixels_of_tiles(values.shape, origin, tile)
    return spread_over_tiles(means, values.shape, origin, tile)


def weighted_sums(film: Film, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sums of both replicates, float64 (h, w) each, of RGB weighted by `weights` (3)."""
    halves = np.zeros((2, *film.shape))
    for replicate in (0, 1):
        for channel, weight in enumerate(weights):
            if weight:
                part = film.sum(4 * replicate + channel)
                part *= weight
                halves[replicate] += part
    return halves[0], halves[1]


def variance_of_mean(sums: tuple[np.ndarray, np.ndarray], counts: tuple) -> np.ndarray:
    """v of this module's head, (h, w), not pooled, from the sums of both replicates and their sample counts (> 0, of
    all pixels or of each)."""
    difference = sums[0] / counts[0] - sums[1] / counts[1]
    alike = counts[0] is counts[1]  # whole blocks
    return difference * difference * (0.25 if alike else counts[0] * counts[1] / (counts[0] + counts[1]) ** 2)


@dataclass(frozen=True)
class Luminance:
    """A picture's luminance: means and v, float64 (h, w) each; `origin` is the x, y of the first pixel in the frame."""

    mean: np.ndarray
    variance: np.ndarray
    origin: tuple[int, int]


def luminance_of(film: Film) -> Luminance | None:
    """The luminance of a film's picture; None with one sample a pixel."""
    counts = film.replicate_samples
    if np.min(counts[1]) == 0:
        return None
    halves = weighted_sums(film, LUMINANCE)
    return Luminance((halves[0] + halves[1]) / film.counts, variance_of_mean(halves, counts), film.region[:2])


def pixel_error(film: Film) -> np.ndarray:
    """One standard deviation of the picture's RGB, float32 (h, w, 3), pooled over tiles; NaN with one sample."""
    error = np.full((*film.shape, 3), np.nan, np.float32)
    if np.min(film.replicate_samples) > 0:
        for channel in range(3):
            sums = weighted_sums(film, np.eye(3)[channel])
            error[..., channel] = np.sqrt(pool(variance_of_mean(sums, film.replicate_samples), film.region[:2]))
    return error


@dataclass(frozen=True)
class ImageError:
    """The relative error of a picture as one number, with the ends of its 95 % confidence interval."""

    value: float
    low: float
    high: float


def image_error(film: Film, seen: Luminance | None = None) -> ImageError | None:
    """Root of the mean variance of the pixels' luminance, relative to the picture's mean luminance:

        E = sqrt(mean over pixels of v) / mean over pixels of luminance

    0.01 says that pixels are off by about 1 % of the mean brightness. The interval comes from the scatter
    of v within tiles (so that tiles may differ, and heavy tails count), by the central limit theorem
    over the picture: se(mean v)^2 = sum over tiles of N_t var_t(v) / N^2. It is a little too wide where
    pixels of one tile differ in kind. None where nothing is known: one sample, or a black picture.
    `seen` is luminance_of(film), where the caller has it.
    """
    seen = seen or luminance_of(film)
    brightness = 0.0 if seen is None else float(seen.mean.mean())
    if not brightness > 0.0:
        return None
    variance, origin = seen.variance, seen.origin
    counts = pixels_of_tiles(film.shape, origin)
    sums = sums_over_tiles(variance, origin)
    squares = sums_over_tiles(variance * variance, origin)
    # A tile of one pixel has no scatter of its own: v^2 stands in, an overestimate.
    scatter = np.where(counts > 1, (squares - sums * sums / counts) * counts / np.maximum(counts - 1, 1), squares)
    spread = Z95 * math.sqrt(max(0.0, float(scatter.sum()))) / variance.size
    mean = float(variance.mean())
    value, low, high = (math.sqrt(max(0.0, x)) / brightness for x in (mean, mean - spread, mean + spread))
    return ImageError(value, low, high)


def mean_and_error(images: np.ndarray, tile: int = TILE) -> tuple[np.ndarray, np.ndarray]:
    """Mean (h, w, c) of K independent renders (K, h, w, c), and its standard error pooled over tiles.

    For engines that keep no replicates: render K times with different seeds. Degrees of freedom of a
    pixel's error: about (K - 1) * tile^2. Raises ValueError for K < 2.
    """
    images = np.asarray(images, np.float64)
    if images.ndim != 4 or len(images) < 2:
        raise ValueError(f"at least 2 renders (K, h, w, c) are needed, got an array of shape {images.shape}")
    variance = images.var(axis=0, ddof=1) / len(images)
    pooled = [pool(variance[..., channel], tile=tile) for channel in range(images.shape[3])]
    return images.mean(axis=0), np.sqrt(np.stack(pooled, axis=-1))
