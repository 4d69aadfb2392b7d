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
get few samples and stay too dark. So the two colours of a chessboard decide for each other: white pixels' numbers
follow from black ones' sums and the other way round; samples of different pixels are independent. Through several
decisions a pixel's early samples still have a say in its later numbers, since they set from how many samples its
neighbours' noise is estimated, and few samples of a skewed law mostly look calm. So noise is pooled over many pixels,
CELL of the deciding colour with the cells around, 72 in all: with the three next ones pictures became 0.6 % too dark,
with 15 of them 0.05 %, with 45 nothing was to be seen. bench/adaptive.py measures it.

Unsure tiles (confidence.py) are never hopeless: what may be missing there would go on being missed.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from isophote.confidence import SHARE, near, relative_errors, tiles_of
from isophote.film import Film
from isophote.schedule import BLOCK
from isophote.statistics import Luminance, luminance_of, spread_over_tiles
from isophote.totals import THREADS

PILOT = BLOCK  # samples of every pixel, before the first decision
GROWTH = (1.125, 2.0)  # least and most, of the samples from one decision to the next
CELL = (4, 2)  # pixels of one colour that get the same number: of 4 x 4 of the picture
STEP = 1.0 / 64.0  # of x, in the table of its derivative
LEAST = 1e-6  # of the largest wanted number, for pixels without noise: they come last, but they come

X = STEP * np.arange(1, 1025)
SLOPE = np.array([math.exp(-x / 2.0) / math.sqrt(2.0 * math.pi * x) for x in X])  # falls
WITHIN = np.array([math.erf(math.sqrt(x / 2.0)) for x in X])


def next_limits(film: Film, target: float, most: int, seen: Luminance | None = None) -> np.ndarray:
    """Where each pixel of a film is to end next, int64 (h, w), for `allow`; `most` is the last end that there may be.

    Between blocks only. The result is the same as before only where all pixels have reached `most`. `seen` is
    luminance_of(film), where the caller has it.
    """
    seen, most = seen or luminance_of(film), most // BLOCK * BLOCK - np.min(film.first)
    return next_counts(seen, np.broadcast_to(film.counts, film.shape), target, most) + film.first


def next_counts(seen: Luminance, counts: np.ndarray, target: float, most: int) -> np.ndarray:
    """How many samples each pixel of a picture that has `counts` (h, w) is to have next, at most `most`."""
    counts = np.array(counts, np.int64)
    next_ones = counts.copy()
    fields = colours(counts.shape)

    def decide(takes: np.ndarray, gives: np.ndarray) -> np.ndarray:
        mean, variance, there = (of.reshape(-1)[gives] for of in (seen.mean, seen.variance, counts))
        wanted = wanted_samples(Luminance(mean, variance, (seen.origin[0] // 2, seen.origin[1])), there, target)
        return spend(wanted, counts.reshape(-1)[takes], most)

    # A fast device waits for this: the colours are decided side by side.
    for takes, decided in zip(fields, THREADS.map(decide, fields, fields[::-1]), strict=True):
        next_ones.reshape(-1)[takes] = decided
    return next_ones


@lru_cache(maxsize=2)
def colours(shape: tuple[int, int]) -> list[np.ndarray]:
    """Indices into the flat (h, w) of the two colours of a chessboard, each packed to (h, half of w, rounded up).

    Where a row has one pixel less of a colour, its last one is there twice. A column of pixels is packed like a row.
    One pixel is its own neighbour.
    """
    if shape[1] == 1:
        return colours(shape[::-1]) if shape[0] > 1 else 2 * [np.zeros((1, 1), np.int64)]
    rows, columns = np.arange(shape[0])[:, None], 2 * np.arange((shape[1] + 1) // 2)
    shifted = [columns + (rows + colour) % 2 for colour in (0, 1)]
    return [rows * shape[1] + np.where(at < shape[1], at, at - 2) for at in shifted]


def wanted_samples(seen: Luminance, counts: np.ndarray, target: float) -> np.ndarray:
    """How many samples the cells of a picture want, at least LEAST of the most, by cell. `counts` (h, w) it has."""
    tiles = tiles_of(seen)
    errors = relative_errors(seen, tiles)
    if errors is None:
        return np.ones(over_cells(counts, np.add).shape)
    unsure = spread_over_tiles(tiles.unsure, seen.mean.shape, seen.origin)
    squares = errors * errors
    np.copyto(squares, 0.0, where=~np.isfinite(squares))
    squares *= counts
    k = near(cells(squares), np.add) / (9.0 * target * target)
    k = np.maximum(k, LEAST * k.max()) if k.any() else np.ones(k.shape)
    x = X[at_price(price_of(k), k)]
    wanted = k * np.where(over_cells(unsure, np.logical_or), np.maximum(x, 1.0), x)
    return np.maximum(wanted, LEAST * wanted.max())


def cells(values: np.ndarray) -> np.ndarray:
    """Means over CELL."""
    return over_cells(values, np.add) / over_cells(np.ones(values.shape), np.add)


def over_cells(values: np.ndarray, combine: np.ufunc) -> np.ndarray:
    """The pixels of each CELL combined (np.add, np.logical_or)."""
    rows, columns = (np.arange(0, size, side) for size, side in zip(values.shape, CELL, strict=True))
    return combine.reduceat(combine.reduceat(values, rows, axis=0), columns, axis=1)


def on_cells(values: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Each pixel of (h, w) gets its cell's value."""
    return np.repeat(np.repeat(values, CELL[0], axis=0), CELL[1], axis=1)[:shape[0], :shape[1]]


def at_price(price: float, k: np.ndarray) -> np.ndarray:
    """The index into X of the x that is wanted for each k."""
    return np.maximum(len(X) - 1 - np.searchsorted(SLOPE[::-1], price * k), 0)


def price_of(k: np.ndarray) -> float:
    """The highest price, among powers of 2^(1/16) about, at which SHARE are within the error."""
    low, high = 0, 1 << 12  # exponents; 2^-128 to 2^128 over the largest k
    unit = 1.0 / float(k.max())
    order, within = np.argsort(k, axis=None), np.empty(k.shape)
    ordered = k.reshape(-1)[order]
    while high - low > 1:
        middle = (low + high) // 2
        within.reshape(-1)[order] = within_at_price(unit * power(middle), ordered)
        low, high = (middle, high) if within.mean() >= SHARE else (low, middle)
    return unit * power(low)


def within_at_price(price: float, ordered: np.ndarray) -> np.ndarray:
    """WITHIN[at_price(price, k)] for ascending k (n), in a tenth of the time: the table is looked up in them."""
    borders = np.searchsorted(price * ordered, SLOPE[::-1], side="right")
    shares = np.append(WITHIN[::-1], WITHIN[0])
    return np.repeat(shares, np.diff(borders, prepend=0, append=len(ordered)))


def power(step: int) -> float:
    """2^((step - 2048) / 16), by a line within each power of two: exact arithmetic, the same everywhere."""
    return math.ldexp(1.0 + (step % 16) / 16.0, step // 16 - 128)


def spend(wanted: np.ndarray, counts: np.ndarray, most: int) -> np.ndarray:
    """Samples of each pixel (h, w) until the next decision: in whole blocks, in proportion to what its cell wants.

    `counts` (h, w) are there; they and `most`, which no pixel exceeds, are multiples of BLOCK.
    """
    total = int(counts.sum())
    growth = min(max(math.sqrt(float(on_cells(wanted, counts.shape).sum()) / total), GROWTH[0]), GROWTH[1])
    budget = min(max(int(total * growth), total + BLOCK), max(total, most * counts.size))
    unit, blocks = 1.0 / float(wanted.max()), (counts // BLOCK).astype(np.int32)
    low, high = 0, 1 << 12
    while high - low > 1:  # what `low` gives is too little
        middle = (low + high) // 2
        enough = BLOCK * int(spent(unit * power(middle), wanted, blocks, most).sum(dtype=np.int64)) >= budget
        low, high = (low, middle) if enough else (middle, high)
    return BLOCK * spent(unit * power(high), wanted, blocks, most).astype(np.int64)


def spent(scale: float, wanted: np.ndarray, blocks: np.ndarray, most: int) -> np.ndarray:
    """How many blocks each pixel has then, int32 (h, w)."""
    cells_have = np.minimum(np.ceil(np.minimum(scale * wanted, most) / BLOCK), most // BLOCK).astype(np.int32)
    return np.maximum(blocks, on_cells(cells_have, blocks.shape))
