"""Sums of blocks, exact in two float64 a value, so that films merge in any order (isophote/film.py)."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from isophote.turns import Turn

THREADS = ThreadPoolExecutor(os.cpu_count() or 1, "isophote-totals")


def two_sum(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(s, e) with s = fl(a + b) and s + e = a + b exactly (Knuth, TAOCP 2, 4.2.2, theorem B); e is 0 where s is
    not finite."""
    s = a + b
    rest = s - a
    error = s - rest
    np.subtract(a, error, out=error)
    error += np.subtract(b, rest, out=rest)
    return s, np.where(np.isfinite(s), error, 0.0) if any_of(error) else error


def any_of(values: np.ndarray) -> bool:
    """Whether a value is not 0. For floats `values.any()` takes five times as long."""
    return bool((values != 0.0).any())


class Total:
    """A plane's sum over blocks as two float64 a value, (hi, lo) of shape (h, w); hi is the sum's nearest float64.

    Sums of float32 are exact in it while they span fewer than some 60 powers of two (Dekker 1971), so
    their order does not matter. Nothing is allocated before it is needed: `hi` is None for a plane of
    zeros, `lo` while every sum was exact in float64, which is the usual case.
    """

    CHUNK = 1 << 15  # values worked on at once, so that temporaries stay in the cache

    __slots__ = ("hi", "lo")

    def __init__(self, hi: np.ndarray | None = None, lo: np.ndarray | None = None):
        self.hi, self.lo = hi, lo

    def copy(self) -> Total:
        return Total(*(None if half is None else half.copy() for half in (self.hi, self.lo)))

    def add(self, hi: np.ndarray, lo: np.ndarray | None = None) -> None:
        """Add a plane of values (float32 or float64), or another total's two halves."""
        if self.hi is None:
            self.hi, self.lo = hi.astype(np.float64), None if lo is None else lo.copy()
            return
        step = max(1, self.CHUNK // hi.shape[1])
        with np.errstate(invalid="ignore"):  # inf - inf, where a device delivered them
            for row in range(0, hi.shape[0], step):
                self.add_rows(slice(row, row + step), hi, lo)

    def add_rows(self, rows: slice, hi: np.ndarray, lo: np.ndarray | None) -> None:
        total, error = two_sum(self.hi[rows], hi[rows].astype(np.float64, copy=False))
        for rest in (self.lo, lo):
            if rest is not None:
                total, error = two_sum(total, error + rest[rows])
        self.hi[rows] = total
        if self.lo is None and any_of(error):
            self.lo = np.zeros_like(self.hi)
        if self.lo is not None:
            self.lo[rows] = error

    def add_listed(self, values: np.ndarray, pixels: np.ndarray) -> None:
        """Add values (n), float32, to `pixels`, indices into the flat plane that has `hi` already, none of them twice.

        Of the native module, which works on several planes at once; numpy keeps Python's lock here.
        """
        from isophote import _native

        lo = np.zeros(0) if self.lo is None else self.lo.reshape(-1)
        added = _native.add_listed(self.hi.reshape(-1), lo, values, pixels)
        if added < len(pixels):
            self.lo = np.zeros_like(self.hi)
            self.add_listed(values[added:], pixels[added:])


def add_parts(totals: list[Total], parts: list[Turn], sums: np.ndarray) -> None:
    """Add the sums (planes, n) of the blocks of `parts`, one behind the other, to the planes' totals."""
    borders = np.cumsum([len(part.pixels) for part in parts])[:-1]

    def add(total: Total, plane: np.ndarray) -> None:
        for part, values in zip(parts, np.split(plane, borders), strict=True):
            if any_of(values):
                total.add_listed(values, part.pixels)

    list(THREADS.map(add, totals, sums))
