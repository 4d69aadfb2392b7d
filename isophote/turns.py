"""Which pixels get the next blocks, where pixels have different numbers of samples (isophote/adaptive.py).

Each pixel that lacks samples gets one block a turn, so that a render that is ended early has them all over the picture,
and within a turn neighbours follow each other, whose paths go much the same way. An item of work takes as many blocks
as suit its device, of one turn or of several, and may thus have a pixel several times.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

SQUARE = 8  # pixels a side, of the squares in which pixels are ordered


@dataclass(frozen=True)
class Turn:
    """The pixels of a turn: `pixels` (n), indices into the picture, lack `lacks` (n) blocks each, of which this turn
    gives them one. The first `given` of them have theirs."""

    pixels: np.ndarray
    lacks: np.ndarray
    given: int = 0

    def give(self, blocks: int) -> tuple[list[Turn], Turn]:
        """The next `blocks` blocks, or all that are lacking, in parts none of which has a pixel twice; and the turn
        that follows them."""
        parts, turn = [], self
        while blocks > 0 and len(turn.pixels):
            now = slice(turn.given, turn.given + blocks)
            parts.append(Turn(turn.pixels[now], turn.lacks[now]))
            blocks -= len(parts[-1].pixels)
            turn = turn.after(len(parts[-1].pixels))
        return parts, turn

    def after(self, blocks: int) -> Turn:
        """This turn with `blocks` more given; the next one where that ends it."""
        if self.given + blocks < len(self.pixels):
            return Turn(self.pixels, self.lacks, self.given + blocks)
        again = self.lacks > 1
        return Turn(self.pixels[again], self.lacks[again] - 1)


def first_turn(lacks: np.ndarray) -> Turn:
    """The first turn of a picture whose pixels lack so many blocks, integers (h, w)."""
    order = by_squares(*lacks.shape)
    lacks = lacks.ravel()[order]
    return Turn(order[lacks > 0], lacks[lacks > 0])


@lru_cache(maxsize=2)
def by_squares(height: int, width: int) -> np.ndarray:
    """Indices into (height, width) pixels, ordered by squares."""
    rows, columns = np.divmod(np.arange(height * width), width)
    return np.lexsort((columns, rows, columns // SQUARE, rows // SQUARE))
