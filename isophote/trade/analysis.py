"""From runs to rows: how noisy each choice is, how wrong, and how long it takes, each with its interval.

Notation: x_k is the picture of a choice with seed k, t_k the truth's with the same seed and samples, r the long
reference (other seeds), all linear RGB. Values are relative to below = r^2 + FLOOR mean(r)^2, as in relMSE:

    noise^2 = mean over pixels of var_k(x_k) / below              no reference in it, so no bias either
    bias^2  = mean over pixels of (mean(d)^2 - var(d) / K) / below,   d_k = x_k - t_k
    error^2 = noise^2 + bias^2                                    the expected relMSE of one such picture

Seeds are shared, so most of the noise of d cancels (common random numbers); it needs no reference. What a choice
does to the light is the mean luminance of d. With few replicates intervals are Student's and the jackknife's; where
many choices are asked whether they are off, the level is corrected for that (intervals.corrected_level).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import chain

import numpy as np

from isophote.confidence import FLOOR as DARK
from isophote.confidence import SHARE, near
from isophote.statistics import LUMINANCE, sums_over_tiles
from isophote.trade.grid import Choice
from isophote.trade.intervals import LEVEL, Interval, corrected_level, interval_of, log_jackknife, student_quantile

FLOOR = 0.01  # of the mean's square, added to the denominator, as in bench/error_over_time.py
SMALL = 0.03  # relative: less of time or noise is not worth a word
EQUAL = 0.0005  # of the mean brightness: light within this counts as the same


@dataclass(frozen=True)
class Replicates:
    """All runs of a choice: `pictures` (K, S, h, w, 3), `counts` (S), `seconds` (K, S), `setup` seconds, by seed."""

    choice: Choice
    seeds: list[int]
    pictures: np.ndarray
    counts: np.ndarray
    seconds: np.ndarray
    setup: float
    info: dict


@dataclass(frozen=True)
class Reference:
    """The long reference: mean picture (h, w, 3), and the variance of that mean; `samples` a pixel in all."""

    picture: np.ndarray
    variance: np.ndarray
    samples: int

    @property
    def below(self) -> np.ndarray:
        return self.picture ** 2 + FLOOR * max(self.picture.mean(), 1e-30) ** 2

    @property
    def noise(self) -> float:
        """Its own error, relative."""
        return math.sqrt(float((self.variance / self.below).mean()))


@dataclass(frozen=True)
class Measured:
    """What is known of one choice. Intervals are of 95 %.

    By number of samples: `noise`, `error` (relative, root mean square) and `seconds` (median). At the most samples:
    `time` and `noise_ratio` over the user's settings at equal samples, `light` (relative change of the mean luminance
    from the user's settings), `light_bias` (from the truth); `time_found`, `noise_found`, `light_found`, `bias_found`:
    whether they are beyond chance for all choices together; `bias` and `tile_bias` (from the truth, rms over pixels and
    over tiles). From the user's settings, or for those from the truth: `shift` (rms over pixels), `worst_tile` (the
    largest change of the tiles where it is beyond chance, None where there is none), `tiles_off` (their share),
    `change` (picture of it, mean over the seeds, (h, w, 3)). `picture` is the first seed's; `same_bits` as the user's
    settings. `within`: 95 % of the pixels are within this of their brightness (the median seed), those of the user's
    settings within `base_within`.
    """

    choice: Choice
    seeds: int
    counts: list[float]
    seconds: list[float]
    setup: float
    noise: list[Interval]
    error: list[Interval]
    time: Interval
    time_found: bool
    noise_ratio: Interval
    noise_found: bool
    light: Interval
    light_found: bool
    light_bias: Interval
    bias_found: bool
    bias: float
    tile_bias: float
    shift: float
    worst_tile: float | None
    tiles_off: float
    same_bits: bool
    within: float
    base_within: float
    picture: np.ndarray
    change: np.ndarray
    info: dict

    @property
    def effort(self) -> Interval:
        """Time for the same noise, over the user's settings: samples are taken to lower the variance as 1 / n.

        Times and noises err independently, so the logarithms' intervals add as squares.
        """
        parts = [(math.log(i.value), math.log(max(i.high, 1e-30) / max(i.low, 1e-30)) / 2 if i.low > 0.0 else math.inf)
                 for i in (self.time, self.noise_ratio) if i.value > 0.0]
        if len(parts) < 2:
            return Interval(0.0, 0.0, math.inf)
        value, half = parts[0][0] + 2.0 * parts[1][0], min(math.hypot(parts[0][1], 2.0 * parts[1][1]), 700.0)
        return Interval(value, value - half, value + half).map(math.exp)


def make_reference(pieces: np.ndarray, samples: int) -> Reference:
    """From pieces (P, h, w, 3) of `samples` each; with one piece its variance is not known: NaN."""
    pieces = np.asarray(pieces, np.float64)
    count = len(pieces)
    variance = pieces.var(axis=0, ddof=1) / count if count > 1 else np.full(pieces.shape[1:], np.nan)
    return Reference(pieces.mean(axis=0), variance, samples * count)


def spread(pictures: np.ndarray, below: np.ndarray) -> tuple[float, np.ndarray]:
    """noise^2 of (K, h, w, 3), and the K values of it without one replicate each (K > 2, else NaN)."""
    count = len(pictures)
    mean = pictures.mean(axis=0, dtype=np.float64)
    away = np.stack([float((((picture - mean) ** 2) / below).mean()) for picture in pictures])
    whole = away.sum() / (count - 1)
    if count < 3:
        return whole, np.full(count, np.nan)
    # Without x_j the sum of squares about the mean falls by K / (K - 1) times its own distance.
    return whole, (away.sum() - away * count / (count - 1)) / (count - 2)


def offset(differences: np.ndarray, below: np.ndarray) -> tuple[float, np.ndarray]:
    """bias^2 of (K, ...) as in the head, without bias and so perhaps below 0, and the K values without one each."""
    count = len(differences)
    mean = differences.mean(axis=0, dtype=np.float64)
    variance = differences.var(axis=0, ddof=1, dtype=np.float64)
    whole = float(((mean ** 2 - variance / count) / below).mean())
    if count < 3:
        return whole, np.full(count, np.nan)
    parts = []
    for left_out in differences:
        mean_j = mean + (mean - left_out) / (count - 1)
        variance_j = ((count - 1) * variance - (left_out - mean) ** 2 * count / (count - 1)) / (count - 2)
        parts.append(float(((mean_j ** 2 - variance_j / (count - 1)) / below).mean()))
    return whole, np.array(parts)


def luminance(pictures: np.ndarray) -> np.ndarray:
    return np.asarray(pictures, np.float64) @ LUMINANCE


def shared(a: Replicates, b: Replicates) -> tuple[list[int], list[int]]:
    """Places of the seeds that both have."""
    seeds = [seed for seed in a.seeds if seed in b.seeds]
    return [a.seeds.index(seed) for seed in seeds], [b.seeds.index(seed) for seed in seeds]


def light_change(a: Replicates, b: Replicates, brightness: float, level: float) -> tuple[Interval, bool]:
    """How much brighter a is than b, relative to `brightness`: the 95 % interval, and whether it is beyond chance."""
    in_a, in_b = shared(a, b)
    means = (luminance(a.pictures[in_a, -1].mean(axis=(1, 2), dtype=np.float64))
             - luminance(b.pictures[in_b, -1].mean(axis=(1, 2), dtype=np.float64))) / brightness
    return interval_of(means), not interval_of(means, level).holds_zero


def time_ratio(a: Replicates, b: Replicates, level: float) -> tuple[Interval, bool]:
    """Seconds of a over those of b at the most samples, round by round: 95 % interval, and whether beyond chance."""
    in_a, in_b = shared(a, b)
    logs = np.log(a.seconds[in_a, -1] / b.seconds[in_b, -1])
    return interval_of(logs).map(lambda x: math.exp(min(x, 700.0))), not interval_of(logs, level).holds_zero


def ratio_of_noise(a: Replicates, b: Replicates, below: np.ndarray, level: float) -> tuple[Interval, bool]:
    """The same of their noise."""
    in_a, in_b = shared(a, b)
    mine, theirs = spread(a.pictures[in_a, -1], below), spread(b.pictures[in_b, -1], below)
    if not theirs[0] > 0.0:
        return Interval(1.0, 1.0, 1.0), False
    wide, usual = (log_jackknife(mine[0] / theirs[0], mine[1] / theirs[1], of) for of in (level, LEVEL))
    return usual.map(math.sqrt), not wide.low <= 1.0 <= wide.high


def differences(a: Replicates, b: Replicates) -> np.ndarray:
    """a - b at the most samples for each seed that both have, (K, h, w, 3)."""
    in_a, in_b = shared(a, b)
    return a.pictures[in_a, -1].astype(np.float64) - b.pictures[in_b, -1]


def within(own: Replicates, reference: Reference) -> float:
    """The relative error of the luminance that 95 % of the pixels keep, at the most samples; of the median seed."""
    true = luminance(reference.picture)
    off = np.abs(luminance(own.pictures[:, -1]) - true) / np.maximum(near(true, np.add) / 9.0, DARK * true.mean())
    return float(np.median([np.quantile(one, SHARE) for one in off]))


def in_tiles(change: np.ndarray, reference: Reference) -> np.ndarray:
    """Luminance of (K, h, w, 3) in tiles, (K, rows, columns), relative to the tile's own, dark ones lifted."""
    count = sums_over_tiles(np.ones(reference.picture.shape[:2]))
    own = luminance(reference.picture)
    below = np.maximum(sums_over_tiles(own) / count, DARK * own.mean())
    return np.stack([sums_over_tiles(luminance(one)) / count for one in change]) / np.where(below > 0.0, below, 1.0)


def tiles_beyond_chance(relative: np.ndarray) -> tuple[float | None, float]:
    """worst_tile and tiles_off of Measured. Each tile is tested at the level that holds for all tiles together."""
    count = len(relative)
    mean, error = relative.mean(axis=0), relative.std(axis=0, ddof=1) / math.sqrt(count)
    factor = student_quantile(corrected_level(relative[0].size), count - 1)
    off = (np.abs(mean) > factor * error) & (np.abs(mean) > EQUAL)
    worst = float(mean[off][np.abs(mean[off]).argmax()]) if off.any() else None
    return worst, float(off.mean())


def measure(base: Replicates, others: Iterable[Replicates], truth: Replicates, reference: Reference,
            tests: int) -> list[Measured]:
    """The user's settings, the others (which may be loaded one by one) and the truth, in this order.

    `tests` is how many choices are asked one question (whether time, noise or light differ), for which its level is
    corrected.
    """
    level = corrected_level(tests)
    return [measure_one(own, base, truth, reference, level) for own in chain([base], others, [truth])]


def measure_one(own: Replicates, base: Replicates, truth: Replicates, reference: Reference,
                level: float) -> Measured:
    below, brightness = reference.below, float(luminance(reference.picture).mean()) or 1e-30
    in_own, in_base = shared(own, base)
    other = truth if own is base else base
    change = differences(own, other)
    bias, bias_parts = (0.0, np.zeros(len(own.seeds))) if own is truth else offset(differences(own, truth), below)
    noise, error = [], []
    for s in range(len(own.counts)):
        whole, parts = spread(own.pictures[:, s], below)
        noise.append(log_jackknife(whole, parts).map(math.sqrt))
        both = (np.maximum(parts, 0.0) + np.maximum(bias_parts, 0.0)) if len(parts) == len(bias_parts) else parts
        error.append(log_jackknife(whole + max(0.0, bias), both).map(math.sqrt))
    time, time_found = time_ratio(own, base, level)
    noise_ratio, noise_found = ratio_of_noise(own, base, below, level)
    light, light_found = light_change(own, base, brightness, level)
    light_bias, bias_found = light_change(own, truth, brightness, level)
    tiles = in_tiles(differences(own, truth), reference)
    tile_bias = math.sqrt(max(0.0, offset(tiles, np.ones(tiles.shape[1:]))[0]))
    worst_tile, tiles_off = tiles_beyond_chance(in_tiles(change, reference))
    return Measured(
        own.choice, len(own.seeds), own.counts.tolist(), np.median(own.seconds, axis=0).tolist(), own.setup, noise,
        error, time, time_found, noise_ratio, noise_found, light, light_found, light_bias, bias_found,
        math.sqrt(max(0.0, bias)), tile_bias, math.sqrt(max(0.0, offset(change, below)[0])), worst_tile, tiles_off,
        bool(np.array_equal(own.pictures[in_own], base.pictures[in_base])), within(own, reference),
        within(base, reference), own.pictures[0, -1].copy(), change.mean(axis=0), own.info)
