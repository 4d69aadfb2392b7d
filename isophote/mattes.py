"""Mattes of a film: how much of each pixel is covered by which ids. Sums are whole numbers, so exact in any order.

A device's sums have a table of rows for each pixel and block (kernels/mattes.h); here blocks come together in sorted
lists, in which a pixel has as many ids as it needs.
"""

from __future__ import annotations

import numpy as np

from isophote.planes import Planes
from isophote.records import numbers

UNITS = numbers()["MATTE_UNITS"]  # a covered sample's


class Coverage:
    """Of one kind: `keys`, uint64, ascending, are pixel << 32 | the bits of an id, 0 for what no id was kept of;
    `units` how much it covers, int64, of UNITS a sample."""

    __slots__ = ("keys", "units")

    def __init__(self, keys: np.ndarray | None = None, units: np.ndarray | None = None):
        self.keys = np.zeros(0, np.uint64) if keys is None else keys
        self.units = np.zeros(0, np.int64) if units is None else units

    def add(self, keys: np.ndarray, units: np.ndarray) -> None:
        """Add units to keys in any order, some of which may be there several times."""
        at = np.searchsorted(self.keys, keys)
        known = np.zeros(len(keys), bool)
        inside = at < len(self.keys)
        known[inside] = self.keys[at[inside]] == keys[inside]
        np.add.at(self.units, at[known], units[known])
        if not known.all():
            new, which = np.unique(keys[~known], return_inverse=True)
            sums = np.zeros(len(new), np.int64)
            np.add.at(sums, which, units[~known])
            places = np.searchsorted(self.keys, new)
            self.keys, self.units = np.insert(self.keys, places, new), np.insert(self.units, places, sums)

    @property
    def lost(self) -> int:
        return int(self.units[self.keys.astype(np.uint32) == 0].sum())

    def ranked(self, pixels: int, ranks: int) -> tuple[np.ndarray, np.ndarray]:
        """(ids float32, units int64), each (pixels, ranks): those that cover most of a pixel, of equals the lower bits
        first; 0 where there are no more."""
        pixel, bits = self.keys >> np.uint64(32), self.keys.astype(np.uint32)
        order = np.lexsort((bits, -self.units, pixel))
        order = order[bits[order] != 0]
        pixel, bits, units = pixel[order].astype(np.int64), bits[order], self.units[order]
        rank = np.arange(len(pixel)) - np.searchsorted(pixel, pixel)
        first = rank < ranks
        made = np.zeros((pixels, ranks), np.uint32), np.zeros((pixels, ranks), np.int64)
        made[0][pixel[first], rank[first]], made[1][pixel[first], rank[first]] = bits[first], units[first]
        return made[0].view(np.float32), made[1]


class Mattes:
    """Coverage by kind, of a film of these planes."""

    def __init__(self, planes: Planes):
        self.rows = planes.matte_rows
        self.of = {kind: Coverage() for kind in planes.mattes}

    def copy(self) -> Mattes:
        made = Mattes.__new__(Mattes)
        made.rows = self.rows
        made.of = {kind: Coverage(each.keys, each.units.copy()) for kind, each in self.of.items()}
        return made

    def add_tables(self, tables: np.ndarray, pixels: np.ndarray) -> None:
        """Add a device's tables, float32 (numbers, n), of pixels (n), some of which may be there several times."""
        pixels = pixels.astype(np.uint64) << np.uint64(32)
        width = 1 + len(self.of)
        table = tables[1:].reshape(self.rows, width, -1)
        row, at = np.nonzero(table[:, 0])
        lost = np.flatnonzero(tables[0])
        units = np.concatenate([table[row, 0, at], tables[0, lost]]).astype(np.int64)
        for column, coverage in enumerate(self.of.values(), 1):
            ids = table[row, column, at].view(np.uint32)
            coverage.add(np.concatenate([pixels[at] | ids, pixels[lost]]), units)

    def add(self, other: Mattes) -> None:
        for kind, coverage in self.of.items():
            coverage.add(other.of[kind].keys, other.of[kind].units)

    @property
    def lost(self) -> int:
        """Units of which the ids were not kept, because more met in a pixel and a block than there are rows."""
        return max((coverage.lost for coverage in self.of.values()), default=0)
