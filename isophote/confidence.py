"""What a film can claim of its error and where it cannot: intervals of tiles, rare light, the error of most pixels.

A standard error says little where light comes in rare, bright hits (caustics, a tiny light behind glass):
a tile that has had none looks perfect. Two replicates a and b show such hits: a pixel that had one has a - b
as large as the light itself, so sqrt(v) (statistics.py) is what the hit added to the picture. From that:

Hits. A pixel whose noise is sqrt(v) and which is brighter by d than the darkest next to it has had about
h = d^2 / v hits, taken between 1 and MOST_HITS: 1 for one hit, many at a noisy edge. The variance of a tile comes from
(sum v)^2 / sum (v^2 / h) hits; below FEW the tile is unsure.

Unseen light. The light of the hits in tiles with few of them, spread evenly over the squares of 4, 8, 16 ... tiles
and the whole frame around a tile, is what the tile may have missed. Where that is more than its own
standard error, it is unsure, the more so where it is black. A tile that has light and no noise (a background) has
missed none, but it is unsure where it borders on noise: a sliver of an edge may lie in it.

Intervals. The variance comes from r = (sum v)^2 / sum v^2 pixels, 21 of 64 where all are alike (the kurtosis of
normal noise is 3), so it has 3 r degrees of freedom, which Student's t takes. Hits are rare above the mean, so
intervals miss above rather than below: the upper half is longer by what Hall (1992, On the removal of skewness by
transformation, section 2) finds for a studentized mean, gamma (2 z^2 + 1) / 6 standard errors, with the
skewness gamma = sum (v^1.5 / h^0.5) / (sum v)^1.5 of independent hits.

bench/coverage.py measures how often all this holds.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from isophote.film import Film
from isophote.statistics import (
    TILE,
    Z95,
    ImageError,
    Luminance,
    image_error,
    luminance_of,
    pixels_of_tiles,
    spread_over_tiles,
    sums_over_tiles,
)

FEW = 6.0  # hits from which a tile's variance must come
MOST_HITS = 16.0  # of one pixel
SQUARE = 4  # tiles a side, of the smallest square in which rare light is looked for
SKEW = (2.0 * Z95 * Z95 + 1.0) / 6.0
SHARE = 0.95  # of the pixels, for which an error is said
FLOOR = 0.1  # of the picture's mean luminance: darker pixels are measured by this


@dataclass(frozen=True)
class Tiles:
    """Tiles of a film, each array of the shape of sums_over_tiles.

    `mean` is the tile's mean luminance, `sigma` its standard error with `freedom` degrees, `skew` that error's
    skewness, `unseen` the luminance that the tile may have missed, `unsure` whether 95 % confidence cannot be claimed.
    """

    mean: np.ndarray
    sigma: np.ndarray
    freedom: np.ndarray
    skew: np.ndarray
    unseen: np.ndarray
    unsure: np.ndarray

    def interval(self) -> tuple[np.ndarray, np.ndarray]:
        """The ends (low, high) of the 95 % confidence intervals of the tiles' means."""
        t = student95(self.freedom)
        return self.mean - t * self.sigma, self.mean + (t + SKEW * self.skew) * self.sigma


def student95(freedom: np.ndarray) -> np.ndarray:
    """The two-sided 95 % quantile of Student's t, to 1 % from 3 degrees of freedom on (Abramowitz, Stegun 26.7.5)."""
    z = Z95
    terms = ((z ** 3 + z) / 4, (5 * z ** 5 + 16 * z ** 3 + 3 * z) / 96,
             (3 * z ** 7 + 19 * z ** 5 + 17 * z ** 3 - 15 * z) / 384)
    return z + sum(term / freedom ** power for power, term in enumerate(terms, 1))


def tiles_of(seen: Luminance) -> Tiles:
    """The tiles of a picture's luminance."""
    origin, variance = seen.origin, seen.variance
    counts = pixels_of_tiles(variance.shape, origin)
    mean = sums_over_tiles(seen.mean, origin) / counts
    total = sums_over_tiles(variance, origin)
    noisy = total > 0.0
    safe = np.where(noisy, total, 1.0)
    root, square = np.sqrt(variance), variance * variance
    hits = hits_of(seen)
    few = noisy & (total * total < FEW * sums_over_tiles(square / hits, origin))
    # Where a tile has few hits, the pixels that vary more than it does on average are those that had them.
    rare = root * (variance > spread_over_tiles(np.where(few, total / counts, np.inf), variance.shape, origin))
    unseen = spread_evenly(sums_over_tiles(rare, origin), counts, (origin[0] // TILE, origin[1] // TILE))
    quiet = ~noisy & (mean > 0.0)
    unseen[quiet] = 0.0
    sigma = np.sqrt(total) / counts
    freedom = 3.0 * safe * safe / np.where(noisy, sums_over_tiles(square, origin), 1.0)
    skew = sums_over_tiles(variance * root / np.sqrt(hits), origin) / safe ** 1.5
    return Tiles(mean, sigma, freedom, skew, unseen, few | (unseen > sigma) | quiet & near(noisy, np.logical_or))


def hits_of(seen: Luminance) -> np.ndarray:
    """About how many hits made each pixel's noise, (h, w), from 1 to MOST_HITS."""
    above, hits = seen.mean - near(seen.mean, np.minimum), np.ones(seen.mean.shape)
    with np.errstate(over="ignore", invalid="ignore"):
        np.divide(np.multiply(above, above, out=above), seen.variance, out=hits, where=seen.variance > 0.0)
    return np.clip(hits, 1.0, MOST_HITS, out=hits)


def near(values: np.ndarray, combine: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> np.ndarray:
    """The 3 x 3 pixels around each of (h, w), combined (np.add, np.minimum); the border is repeated."""
    padded = np.pad(values, 1, mode="edge")
    rows = combine(padded[:-2], padded[1:-1])
    combine(rows, padded[2:], out=rows)
    made = combine(rows[:, :-2], rows[:, 1:-1])
    return combine(made, rows[:, 2:], out=made)


def spread_evenly(light: np.ndarray, counts: np.ndarray, origin: tuple[int, int]) -> np.ndarray:
    """The largest mean a pixel of `light` over squares of tiles around each tile, up to the whole frame.

    `light` is summed over tiles of `counts` pixels; `origin` is the x, y of the first tile.
    """
    most, side = np.zeros(light.shape), SQUARE
    while True:
        mean = sums_over_tiles(light, origin, side) / sums_over_tiles(counts, origin, side)
        most = np.maximum(most, spread_over_tiles(mean, light.shape, origin, side))
        if side >= max(origin[0] + light.shape[1], origin[1] + light.shape[0]):
            return most
        side *= 2


def relative_errors(seen: Luminance, tiles: Tiles) -> np.ndarray | None:
    """Each pixel's error relative to its luminance, (h, w); None for a black picture.

    The error is sqrt(v), half the difference of the replicates: one draw from the law of the pixel's own error
    where noise is as often above as below; at least the light that the tile may have missed. The luminance is the
    lower one of the pixel and of its surroundings (one hit must not vouch for itself), at least FLOOR.
    """
    floor = FLOOR * seen.mean.mean()
    if not floor > 0.0:
        return None
    light, error = near(seen.mean, np.add), np.sqrt(seen.variance)
    light /= 9.0
    np.maximum(np.minimum(seen.mean, light, out=light), floor, out=light)
    np.maximum(error, spread_over_tiles(tiles.unseen, error.shape, seen.origin), out=error)
    return np.divide(error, light, out=error)


def error_of_most(errors: np.ndarray) -> ImageError:
    """The SHARE quantile of the pixels' errors, with its 95 % interval from order statistics (binomial)."""
    spread = Z95 * math.sqrt(SHARE * (1.0 - SHARE) / errors.size)
    at = [min(errors.size - 1, max(0, math.ceil(share * errors.size) - 1))
          for share in (SHARE, SHARE - spread, SHARE + spread)]
    ordered = np.partition(errors, at, axis=None)
    return ImageError(*(float(ordered[index]) for index in at))


def samples_for(target: float, looks: list[tuple[int, float]]) -> float | None:
    """The number of samples at which an error is expected, from looks at (samples, error); None without any.

    The error falls on as it fell since half as many samples, between samples^-1/4 and samples^-1.
    """
    looks = [(samples, error) for samples, error in looks if error > 0.0]
    if not looks:
        return None
    samples, error = looks[-1]
    before, larger = min(looks, key=lambda look: abs(look[0] - samples / 2))
    power = math.log(larger / error) / math.log(samples / before) if before < samples else 0.5
    return samples * (error / target) ** (1.0 / min(1.0, max(0.25, power)))


@dataclass(frozen=True)
class Claim:
    """What is said of a picture. None is "not known".

    `mean`: statistics.image_error, the root of the mean variance relative to the mean luminance. `most`: 95 % of
    the pixels are within this relative error. `unsure`: the share of the picture's pixels, in tiles that had
    too few bright hits for 95 % confidence.
    """

    mean: ImageError | None
    most: ImageError | None
    unsure: float | None


def claim_of(film: Film, seen: Luminance | None = None) -> Claim:
    """What a film can claim of its picture; all None with one sample a pixel. `seen` is luminance_of(film), where the
    caller has it."""
    seen = seen or luminance_of(film)
    if seen is None:
        return Claim(None, None, None)
    tiles = tiles_of(seen)
    errors = relative_errors(seen, tiles)
    unsure = spread_over_tiles(tiles.unsure, film.shape, seen.origin)
    return Claim(image_error(film, seen), None if errors is None else error_of_most(errors), float(unsure.mean()))
