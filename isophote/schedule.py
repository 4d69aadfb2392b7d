"""How the samples of a render are cut into items of work. Pure functions: the same cut on every machine.

Samples are added in float32 within a block of BLOCK samples and in float64 beyond it, so every cut
that keeps to the borders of blocks, or goes through a block in order, gives the same bits.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

BLOCK = 64  # samples a pixel summed in float32 (design, section 6)
FIRST_DECISION = 16  # samples before which no render stops for its error
ITEM_SECONDS = 0.35  # an item aims at 0.2 to 0.5 s: cancelling is quick, overhead is small
FIRST_BLOCKS, MOST_BLOCKS = 1 << 8, 1 << 20  # of an item that lists pixels: at unknown speed; 100 MB of sums at most

Region = tuple[int, int, int, int]  # x0, y0, x1, y1 in pixels from the lower left; x1 and y1 lie outside


@dataclass(frozen=True)
class WorkItem:
    """Samples [first_sample, first_sample + samples) of every pixel of a region; never crosses a block's border.

    With `pixels`, int32 (n, 3), these are no region's pixels but n others in one row, region (0, 0, n, 1): x and y in
    the frame, and the sample, at a block's border, from which `first_sample` counts. A pixel may be there several
    times, for several blocks.
    """

    region: Region
    first_sample: int
    samples: int
    pixels: np.ndarray | None = None

    def __post_init__(self):
        x0, y0, x1, y1 = self.region
        if not (0 <= x0 < x1 and 0 <= y0 < y1):
            raise ValueError(f"region {self.region} holds no pixels")
        if self.first_sample < 0 or self.samples < 1:
            raise ValueError(f"samples [{self.first_sample}, {self.end_sample}) are no range")
        if self.first_sample // BLOCK != (self.end_sample - 1) // BLOCK:
            raise ValueError(f"samples [{self.first_sample}, {self.end_sample}) cross a block of {BLOCK}")

    @property
    def end_sample(self) -> int:
        return self.first_sample + self.samples


def next_samples(first: int, now: int, end: int, step: int) -> int:
    """Size of the item that follows sample `now` of a run over [first, end): 1, 1, 2, 4, 8, ... up to `step`.

    Doubling what is there keeps early pictures quick to come and every later item aligned. Returns 0
    at the end. Raises ValueError for a range or step that cannot be.
    """
    if not 0 <= first <= now <= end or step < 1:
        raise ValueError(f"no item after sample {now} of [{first}, {end}) in steps of {step}")
    in_block = BLOCK - now % BLOCK
    return min(max(1, now - first), step, in_block, end - now)


def next_decision(samples: int) -> int:
    """The first number of samples above `samples` at which a render may stop for its error: 16, 20, 24, 28, 32, 40, ...

    That is 4 to 7 times the powers of two from 4 on: fixed numbers, so that where a render stops depends on its
    film alone, and close enough that it does not take much longer than it must.
    """
    if samples < FIRST_DECISION:
        return FIRST_DECISION
    part = 1 << (samples.bit_length() - 3)
    return (samples // part + 1) * part


def is_decision(samples: int) -> bool:
    """Whether a render may stop for its error at this number of samples."""
    return samples > 0 and next_decision(samples - 1) == samples


def sample_items(first: int, end: int, step: int, region: Region = (0, 0, 1, 1)) -> Iterator[WorkItem]:
    """The items of samples [first, end) in order, progressive and never crossing the border of a block."""
    now = first
    while count := next_samples(first, now, end, step):
        yield WorkItem(region, now, count)
        now += count


def choose_step(seconds_per_sample: float, target: float = ITEM_SECONDS) -> int:
    """The power of two in [1, BLOCK] nearest below what fits `target` seconds at the measured speed.

    A power of two keeps items aligned with blocks; 1 where the speed is not known (0 or less).
    """
    if not seconds_per_sample > 0:
        return 1
    fitting = min(target / seconds_per_sample, BLOCK)
    return 1 << max(0, int(fitting).bit_length() - 1)


def choose_blocks(seconds_per_block: float, target: float = ITEM_SECONDS) -> int:
    """How many blocks of single pixels fit `target` seconds at the measured speed, from 1 to MOST_BLOCKS."""
    if not seconds_per_block > 0:
        return FIRST_BLOCKS
    return max(1, int(min(target / seconds_per_block, MOST_BLOCKS)))


def split(samples: int, parts: int, first: int = 0) -> list[tuple[int, int]]:
    """Ranges (first, end) for `parts` workers that tile [first, first + samples), cut at the borders of blocks only.

    Sizes differ by at most one block. Where there are fewer blocks than parts, fewer ranges come
    back, none of them empty. Raises ValueError where `first` lies inside a block.
    """
    if samples < 1 or parts < 1:
        raise ValueError(f"cannot split {samples} samples into {parts} parts")
    if first % BLOCK:
        raise ValueError(f"a range of samples begins at a block's border, a multiple of {BLOCK}, not at {first}")
    blocks = -(-samples // BLOCK)
    parts = min(parts, blocks)
    borders = [first + min(samples, BLOCK * (blocks * part // parts)) for part in range(parts + 1)]
    return list(pairwise(borders))
