"""Adaptive sampling: which pixels get the next samples of a render that is to reach a wanted error.

A render stops when SHARE of its pixels are within the error E (confidence.py). A pixel whose samples have the
relative standard deviation r is within it after n samples with the probability erf(sqrt(x / 2)), x = n / k,
where k = (r / E)^2. The sum of these over the pixels grows most a sample where its derivative
exp(-x / 2) / sqrt(2 pi x) / k is largest, so for a price p of a sample each pixel wants the x at which

    exp(-x / 2) / sqrt(2 pi x) = p k,

and the price is the one at which SHARE of all are within E. Noisy pixels get more samples, but pixels that are
hopeless at that price, of which the rest may consist, get few. Another E only scales all of it, so what is wanted is
spent in parts: each decision goes half the way, on a logarithmic scale and within GROWTH, and its samples go where most
is wanted of what is lacking.

No bias. Were a pixel's number of samples decided by the pixel itself, one that missed a bright hit would look calm,
get few samples and stay too dark. So rows decide for each other: even rows' numbers follow from odd rows' sums, and
odd rows' from even ones'; samples of different pixels are independent. Through several decisions a row's early samples
do have a say in its later numbers, since they set how many samples its neighbours' noise was estimated from;
bench/error_target.py measures that no bias is to be seen.

Noise is pooled over cells of CELL pixels of the deciding rows and their neighbours. Unsure tiles (confidence.py) are
never hopeless: what may be missing there would go on being missed.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from isophote.confidence import SHARE, near, relative_errors, tiles_of
from isophote.film import Film
from isophote.schedule import BLOCK
from isophote.statistics import Luminance, luminance_of, spread_over_tiles

PILOT = BLOCK  # samples of every pixel, before the first decision
GROWTH = (1.125, 1.5)  # least and most, of the samples from one decision to the next
CELL = (2, 4)  # rows of one half and columns, whose pixels get the same number: 4 x 4 pixels of the picture
STEP = 1.0 / 64.0  # of x, in the table of its derivative
LEAST = 1e-6  # of the largest wanted number, for pixels without noise: they come last, but they come

X = STEP * np.arange(1, 1025)
SLOPE = np.array([math.exp(-x / 2.0) / math.sqrt(2.0 * math.pi * x) for x in X])  # falls
WITHIN = np.array([math.erf(math.sqrt(x / 2.0)) for x in X])


def next_limits(film: Film, target: float, most: int) -> np.ndarray:
    """Where each pixel of a film is to end next, int64 (h, w), for `allow`; `most` is the last end that there may be.

    Between blocks only. The result is the same as before only where all pixels have reached `most`.
    """
    ends = np.broadcast_to(film.now(), film.shape)
    limits, seen = np.empty(film.shape, np.int64), luminance_of(film)
    most = most // BLOCK * BLOCK
    for half in (0, 1):
        takes, gives = slice(half, None, 2), slice(1 - half, None, 2)
        there = ends[takes]
        if not there.size:
            continue
        wanted = np.ones(there.shape)
        if ends[gives].size:
            counts = np.broadcast_to(film.counts, film.shape)[gives]
            own = replace(seen, mean=seen.mean[gives], variance=seen.variance[gives],
                          origin=(seen.origin[0], seen.origin[1] // 2))
            wanted = on_cells(wanted_samples(own, counts, target), there.shape)
        limits[takes] = spend(wanted, there - film.first, most - film.first) + film.first
    return limits


def wanted_samples(seen: Luminance, counts: np.ndarray, target: float) -> np.ndarray:
    """How many samples the cells of a picture want, at least LEAST of the most, by cell. `counts` (h, w) it has."""
    tiles = tiles_of(seen)
    errors = relative_errors(seen, tiles)
    if errors is None:
        return np.ones(cells(counts).shape)
    unsure = spread_over_tiles(tiles.unsure, seen.mean.shape, seen.origin)
    squares = errors * errors
    squares[~np.isfinite(squares)] = 0.0
    k = near(cells(squares * counts), np.add) / (9.0 * target * target)
    k = np.maximum(k, LEAST * k.max()) if k.any() else np.ones(k.shape)
    x = X[at_price(price_of(k), k)]
    wanted = k * np.where(cells(unsure) > 0.0, np.maximum(x, 1.0), x)
    return np.maximum(wanted, LEAST * wanted.max())


def cells(values: np.ndarray) -> np.ndarray:
    """Means over CELL."""
    rows, columns = (np.arange(0, size, side) for size, side in zip(values.shape, CELL, strict=True))

    def sums(of):
        return np.add.reduceat(np.add.reduceat(of, rows, axis=0), columns, axis=1)

    return sums(values.astype(np.float64)) / sums(np.ones(values.shape))


def on_cells(values: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Each pixel of (h, w) gets its cell's value; the last row once more where there is one pixel more."""
    spread = np.repeat(np.repeat(values, CELL[0], axis=0), CELL[1], axis=1)[:shape[0], :shape[1]]
    return np.pad(spread, ((0, shape[0] - len(spread)), (0, 0)), mode="edge")


def at_price(price: float, k: np.ndarray) -> np.ndarray:
    """The index into X of the x that is wanted for each k."""
    return np.maximum(len(X) - 1 - np.searchsorted(SLOPE[::-1], price * k), 0)


def price_of(k: np.ndarray) -> float:
    """The highest price, among powers of 2^(1/16) about, at which SHARE are within the error."""
    low, high = 0, 1 << 12  # exponents; 2^-128 to 2^128 over the largest k
    unit = 1.0 / float(k.max())
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if WITHIN[at_price(unit * power(middle), k)].mean() >= SHARE else (low, middle)
    return unit * power(low)


def power(step: int) -> float:
    """2^((step - 2048) / 16), by a line within each power of two: exact arithmetic, the same everywhere."""
    return math.ldexp(1.0 + (step % 16) / 16.0, step // 16 - 128)


def spend(wanted: np.ndarray, counts: np.ndarray, most: int) -> np.ndarray:
    """Samples of each pixel (h, w) until the next decision: in whole blocks, in proportion to what is wanted.

    `counts` are there, multiples of BLOCK; no pixel gets more than `most`.
    """
    total = int(counts.sum())
    growth = min(max(math.sqrt(float(wanted.sum()) / total), GROWTH[0]), GROWTH[1])
    budget = min(max(int(total * growth), total + BLOCK), max(total, most * counts.size))
    unit = 1.0 / float(wanted.max())
    low, high = 0, 1 << 12
    while high - low > 1:  # what `low` gives is too little
        middle = (low + high) // 2
        enough = int(spent(unit * power(middle), wanted, counts, most).sum()) >= budget
        low, high = (low, middle) if enough else (middle, high)
    return spent(unit * power(high), wanted, counts, most)


def spent(scale: float, wanted: np.ndarray, counts: np.ndarray, most: int) -> np.ndarray:
    blocks = np.ceil(np.minimum(scale * wanted, most) / BLOCK).astype(np.int64)
    return np.maximum(counts, np.minimum(BLOCK * blocks, most))
