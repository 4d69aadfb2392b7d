"""Independent replicates of a render, and the statistics of two engines that rendered the same scene.

A replicate is a render with a seed of its own. K of them show the error of their mean whatever the
sampler does inside (Sobol, blue noise), so both engines are measured by the same rule.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
from scipy import stats

from bench.cycles_process import laid_over
from isophote.compare import limit, mean_flip, z_test
from isophote.device import open_device
from isophote.film import Film
from isophote.passes import PASSES, film_planes
from isophote.prepare import prepare
from isophote.scene import Scene
from isophote.schedule import sample_items
from isophote.settings import Settings
from isophote.statistics import pool, sums_over_tiles
from isophote.validate import clean

TILE = 8  # pixels a side, of the tiles tested
CLOSE = 0.005  # relative: how near the channel means of two engines should be
SIGNIFICANCE = 0.01
ROUNDING = 1e-5  # relative: what is left of a constant after some thousand sums in float32
MANY = 1e6  # degrees of freedom of what has no variance


@contextlib.contextmanager
def uploaded(scene: Scene, settings: Settings) -> Iterator:
    """An open device that holds the scene: prepared once for all replicates."""
    device = open_device(settings.device, settings)
    try:
        device.upload(prepare(clean(scene)[0]))
        yield device
    finally:
        device.close()


def render_film(device, scene: Scene, settings: Settings) -> Film:
    """The whole frame by a device that holds the scene."""
    region = (0, 0, *(int(n) for n in scene.resolution))
    film = Film(region, film_planes(settings))
    for item in sample_items(0, settings.samples, settings.samples, region):
        film.add_samples(device.render(item, settings, film.open, lambda: False))
    return film


def render_replicates(scene: Scene, settings: Settings, seeds: Iterable[int], over=None) -> np.ndarray:
    """Linear RGB by seed, float32 (K, h, w, 3), rows from the bottom, settings.samples each; `over` as in laid_over."""
    with uploaded(scene, settings) as device:
        films = (render_film(device, scene, replace(settings, seed=seed)) for seed in seeds)
        return np.stack([laid_over(PASSES["combined"].make(film), over) for film in films])


def tile_means(images: np.ndarray, tile: int = TILE) -> np.ndarray:
    """Means over tiles x tiles pixels of (K, h, w, c); tiles at the right and the top may be smaller."""
    count = sums_over_tiles(np.ones(images.shape[1:3]), tile=tile)
    return np.stack([np.stack([sums_over_tiles(image[..., c].astype(np.float64), tile=tile) / count
                               for c in range(image.shape[2])], axis=-1) for image in images])


def mean_and_variance(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Over the first axis, K replicates: their mean, and the variance of that mean (ddof 1)."""
    values = np.asarray(values, np.float64)
    return values.mean(axis=0), values.var(axis=0, ddof=1) / len(values)


def welch_dof(var_a, var_b, count_a: int, count_b: int) -> np.ndarray:
    """Degrees of freedom of a difference whose two variances are estimates (Welch 1947)."""
    below = var_a ** 2 / (count_a - 1) + var_b ** 2 / (count_b - 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(below > 0.0, (var_a + var_b) ** 2 / below, MANY)


def pooled(variance: np.ndarray, tile: int = TILE) -> np.ndarray:
    """Each value's mean over its tile, (h, w, c) to (h, w, c)."""
    return np.stack([pool(variance[..., c], tile=tile) for c in range(variance.shape[2])], axis=-1)


def test_equal(a: np.ndarray, b: np.ndarray, pool_pixels: bool = False) -> dict:
    """isophote.compare.z_test of two sets of replicates (K, h, w, c), every value by itself.

    The standard errors are those values' own, from their K replicates; t is turned into z with Welch's
    degrees of freedom. `pool_pixels`: at least the mean over tiles, for pixels: few samples that can only
    be this or that (lamp seen or not) may fall the same way in all replicates, with no spread at all.
    Sums in float32 are trusted to ROUNDING. `sees` is the smallest relative difference of a single
    value that would be rejected, for the value of median noise (0 where all is black).
    """
    (mean_a, var_a), (mean_b, var_b) = mean_and_variance(a), mean_and_variance(b)
    dof = welch_dof(var_a, var_b, len(a), len(b))
    sigmas = []
    for mean, variance in ((mean_a, var_a), (mean_b, var_b)):
        floor = pooled(variance) if pool_pixels else 0.0
        sigmas.append(np.sqrt(np.maximum(variance, floor) + (ROUNDING * mean) ** 2))
    result = z_test(mean_a, mean_b, *sigmas, dof=dof, significance=SIGNIFICANCE).as_dict()
    lit = mean_b > 0.0
    sigma = np.hypot(*sigmas)[lit] / mean_b[lit]
    return result | {"sees": float(limit(SIGNIFICANCE, mean_a.size) * np.median(sigma)) if lit.any() else 0.0}


test_equal.__test__ = False  # for pytest: not a test, whatever its name says


def mean_ratios(a: np.ndarray, b: np.ndarray) -> list[dict]:
    """By channel: ratio of the whole pictures' means a / b, and half its 95 % interval (first order, Welch).

    `verdict`: "within" or "beyond" CLOSE where the interval says so, else "undecided". A channel
    that is black in both has ratio 1.
    """
    rows = []
    for x, y in zip(np.moveaxis(a.mean(axis=(1, 2), dtype=np.float64), -1, 0),
                    np.moveaxis(b.mean(axis=(1, 2), dtype=np.float64), -1, 0), strict=True):
        (mean_x, var_x), (mean_y, var_y) = mean_and_variance(x), mean_and_variance(y)
        if mean_x == mean_y == 0.0:
            rows.append({"ratio": 1.0, "half_interval": 0.0, "verdict": "within"})
            continue
        ratio = mean_x / mean_y
        variances = var_x / mean_x ** 2, var_y / mean_y ** 2
        t = stats.t.ppf(0.975, welch_dof(*variances, len(x), len(y)))
        half = float(ratio * t * np.sqrt(sum(variances)))
        off = abs(ratio - 1.0)
        verdict = "within" if off + half <= CLOSE else "beyond" if off - half > CLOSE else "undecided"
        rows.append({"ratio": float(ratio), "half_interval": half, "verdict": verdict})
    return rows


def noise(a: np.ndarray, b: np.ndarray) -> dict:
    """Variance of a's pixels over that of b's, at the samples that they have: of all, and the median pixel's. 1 where
    neither has any."""
    var_a, var_b = (mean_and_variance(x)[1].mean(axis=-1) for x in (a, b))
    both = (var_a > 0.0) & (var_b > 0.0)
    if not both.any():
        return {"mean": 1.0, "median": 1.0}
    return {"mean": float(var_a.mean() / var_b.mean()), "median": float(np.median(var_a[both] / var_b[both]))}


def flips(a: np.ndarray, b: np.ndarray) -> dict:
    """FLIP of a against b, and as a measure of the noise of b against itself; halves of the replicates each."""
    half = len(b) // 2
    reference = b[:half].mean(axis=0)
    return {"flip": mean_flip(reference, a[:half].mean(axis=0))[0],
            "flip_itself": mean_flip(reference, b[half:2 * half].mean(axis=0))[0]}


def compare_replicates(a: np.ndarray, b: np.ndarray) -> dict:
    """Everything that is said about two sets of replicates (K, h, w, 3); `agrees` is the verdict.

    They agree where no channel's mean is beyond CLOSE, and the tests of pixels and of tiles pass.
    """
    means = mean_ratios(a, b)
    pixels, tiles = test_equal(a, b, pool_pixels=True), test_equal(tile_means(a), tile_means(b))
    agrees = pixels["passed"] and tiles["passed"] and all(row["verdict"] != "beyond" for row in means)
    return {"means": means, "pixels": pixels, "tiles": tiles, "noise": noise(a, b), **flips(a, b), "agrees": agrees}
