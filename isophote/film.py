"""The film: sums of samples, and the one operation that progressive passes, devices, machines and resuming share.

Sample i belongs to replicate i & 1. isophote/planes.py says which planes there are. Some are of sample 0 alone, as in
Cycles: a mean of depths across an edge is no depth.

A pixel's samples are those from `first` on, without a gap. All pixels have as many, until `allow` says how far each
may go (isophote/adaptive.py decides that): from then on the pixels that lack samples get them in whole blocks, by turns
(isophote/turns.py).
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

import numpy as np

from isophote.files import replacing
from isophote.mattes import Coverage, Mattes
from isophote.planes import Planes, make_planes
from isophote.schedule import BLOCK, Region, WorkItem
from isophote.totals import Total, add_parts, any_of
from isophote.turns import Turn, first_turn

FORMAT = 5
COMBINED_PLANES = Planes()
LIMITS = ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "volume_bounces",
          "transparent_bounces")


class FilmError(ValueError):
    """Films that do not fit together, or a film's file that cannot be used; the message says which."""


class Film:
    """Sums of the samples [first, end) of a region's pixels; of [first, ends) where pixels have different numbers.

    `open` is the float32 array (planes, h, w) into which a device adds the samples of the block under
    way, in order; `add_samples` says how many came and closes the block when it is full. Where pixels have different
    numbers `ends` are those to which they have samples and `limits` those at which they are to end, int64 (h, w), at
    borders of blocks; `turn` knows whose blocks come next, which `add_blocks` takes whole. All three are None while
    pixels have the same samples, [first, end); afterwards `end` and `open` are of no more use. A film that goes on from
    one whose pixels differ has an integer (h, w) as `first`.

    `ended` counts the paths that each of LIMITS, the bounce limits, has ended, uint64. `mattes` has the closed blocks'
    tables, those behind the planes that are sums.
    """

    def __init__(self, region: Region, planes: Planes = COMBINED_PLANES, first: int | np.ndarray = 0):
        x0, y0, x1, y1 = region
        if not (0 <= x0 < x1 and 0 <= y0 < y1):
            raise FilmError(f"region {tuple(region)} holds no pixels")
        if np.any(np.less(first, 0)) or np.any(np.mod(first, BLOCK)):
            raise FilmError(f"a film begins at a block's border, a multiple of {BLOCK}, not at sample {first}")
        self.region = (int(x0), int(y0), int(x1), int(y1))
        self.shape = (self.region[3] - self.region[1], self.region[2] - self.region[0])  # height, width in pixels
        self.first, self.end = first, (first if np.ndim(first) == 0 else 0)
        self.ends: np.ndarray | None = None
        self.limits: np.ndarray | None = None
        self.turn: Turn | None = None
        self._paths = 0  # where pixels have different numbers
        self.planes = planes
        self.open = np.zeros((planes, *self.shape), np.float32)
        self.totals = [Total() for _ in range(planes.sums)]
        self.mattes = Mattes(planes)
        self.ended = np.zeros(len(LIMITS), np.uint64)
        if np.ndim(first):
            self.ends = np.array(first, np.int64)
            self.allow(self.ends)

    @property
    def pixels(self) -> int:
        return self.shape[0] * self.shape[1]

    def cut(self, indirect: bool, replicate: int) -> np.ndarray:
        """Sum of the luminance that clamping cut off from one replicate's direct or indirect light, as `sum`."""
        if not self.planes.clamps:
            return np.zeros(self.shape)
        return self.sum(self.planes.cut + 2 * replicate + indirect)

    @property
    def counts(self) -> int | np.ndarray:
        """Samples of a pixel, both replicates together; int64 (h, w) where pixels have different numbers."""
        return self.now() - self.first

    @property
    def paths(self) -> int:
        """Samples of all pixels together."""
        return self.pixels * (self.end - self.first) if self.ends is None else self._paths

    @property
    def samples(self) -> int:
        """Samples a pixel, the mean where pixels have different numbers."""
        return self.paths // self.pixels

    @property
    def most_samples(self) -> int:
        """Samples of the pixel that has most."""
        return int(np.max(self.counts))

    @property
    def replicate_samples(self) -> tuple[int, int] | tuple[np.ndarray, np.ndarray]:
        """Samples of a pixel of replicates 0 and 1, as `counts`; they differ by one where the count is odd."""
        if self.ends is not None:  # whole blocks
            half = self.counts // 2
            return half, half
        even = (self.end + 1) // 2 - (self.first + 1) // 2
        return even, self.end - self.first - even

    @property
    def open_samples(self) -> int:
        """Samples in the open block; blocks begin at multiples of BLOCK."""
        return self.end % BLOCK

    def now(self) -> int | np.ndarray:
        """The sample that follows those of a pixel."""
        return self.end if self.ends is None else self.ends

    def add_samples(self, count: int, ended: np.ndarray | int = 0) -> None:
        """Note that `count` samples were added to `open`, of which the bounce limits ended `ended` paths (a device's).

        Raises FilmError where they do not fit its block, and for a film whose pixels get blocks.
        """
        if self.ends is not None:
            raise FilmError("pixels with different numbers of samples get whole blocks (add_blocks)")
        if count < 0 or self.open_samples + count > BLOCK:
            raise FilmError(f"{count} samples after sample {self.end} cross the border of a block of {BLOCK}")
        self.end += count
        self.ended += np.asarray(ended, np.uint64)
        if count and self.open_samples == 0:
            self.close_block()

    def close_block(self) -> None:
        """Add the full open block to the totals and clear it. Raises FilmError while it is not full."""
        if self.open_samples:
            raise FilmError(f"the block holds {self.open_samples} of {BLOCK} samples and stays open")
        for plane, total in zip(self.open[:self.planes.sums], self.totals, strict=True):
            if any_of(plane):
                total.add(plane)
        add_tables(self.mattes, self.open[self.planes.sums:])
        self.open.fill(0.0)

    def allow(self, limits: np.ndarray) -> None:
        """Say where each pixel is to end, integers (h, w), at borders of blocks; less than there is changes nothing.

        Raises FilmError within a block and for other limits.
        """
        limits = np.asarray(limits, np.int64)
        if limits.shape != self.shape or (limits % BLOCK).any():
            raise FilmError(f"limits are multiples of {BLOCK}, one for each pixel of {self.shape}")
        if self.open_samples:
            raise FilmError(f"the block holds {self.open_samples} of {BLOCK} samples and must be full first")
        if self.ends is None:
            self.ends = np.full(self.shape, self.end, np.int64)
        self.open = np.zeros((self.planes, 0, 0), np.float32)
        self.limits, self._paths = np.maximum(limits, self.ends), int(self.counts.sum())
        for total in self.totals:
            if total.hi is None:
                total.hi = np.zeros(self.shape)
        self.turn = first_turn((self.limits - self.ends) // BLOCK)

    @property
    def settled(self) -> bool:
        """Whether every pixel has what `allow` said."""
        return self.turn is not None and not len(self.turn.pixels)

    def next_blocks(self, most: int) -> WorkItem:
        """The next blocks that pixels lack, at most `most`, to be added by `add_blocks`."""
        parts, _ = self.turn.give(most)
        pixels, lacks = (np.concatenate(of) for of in ([part.pixels for part in parts], [part.lacks for part in parts]))
        rows = pixels // self.shape[1]
        made = np.empty((len(pixels), 3), np.int32)
        made[:, 0], made[:, 1] = pixels - rows * self.shape[1] + self.region[0], rows + self.region[1]
        made[:, 2] = self.limits.reshape(-1)[pixels] - BLOCK * lacks
        return WorkItem((0, 0, len(pixels), 1), 0, BLOCK, made)

    def add_blocks(self, sums: np.ndarray, ended: np.ndarray | int = 0) -> None:
        """Add the sums, float32 (planes, 1, n), of the n blocks that `next_blocks` gave; `ended` as in add_samples.

        Raises FilmError for another number of planes and for more blocks than pixels lack.
        """
        parts, turn = self.turn.give(sums.shape[2])
        given = sum(len(part.pixels) for part in parts)
        if sums.shape != (int(self.planes), 1, given):
            raise FilmError(f"sums {sums.shape} are no blocks of {self.planes}, of which {given} are lacking")
        add_parts(self.totals, parts, sums[:self.planes.sums, 0])
        if self.planes.mattes:
            self.mattes.add_tables(sums[self.planes.sums:, 0], np.concatenate([part.pixels for part in parts]))
        for part in parts:
            self.ends.reshape(-1)[part.pixels] += BLOCK
        self.turn = turn
        self._paths += BLOCK * given
        self.ended += np.asarray(ended, np.uint64)

    def sum(self, plane: int) -> np.ndarray:
        """Sum of a plane over all samples, float64 (h, w): the same bits however the samples were split."""
        total = self.totals[plane]
        if self.open_samples and any_of(self.open[plane]):
            total = total.copy()
            total.add(self.open[plane])
        return np.zeros(self.shape) if total.hi is None else total.hi + 0.0  # + 0.0: one sign of zero

    def all_mattes(self) -> Mattes:
        """Of all samples; as `sum`."""
        if not self.open_samples or self.ends is not None:
            return self.mattes
        mattes = self.mattes.copy()
        add_tables(mattes, self.open[self.planes.sums:])
        return mattes

    def save(self, path: str | Path, scene_hash: str, settings: dict) -> None:
        """Write a checkpoint (.npz): all sums, and the scene and settings that they belong to.

        `settings` is Settings.fingerprint(). The file appears whole or not at all. Raises OSError.
        """
        head = {"format": FORMAT, "region": self.region, "planes": self.planes.groups,
                "clamps": self.planes.clamps, "named": self.planes.named, "mattes": self.planes.mattes,
                "levels": self.planes.levels, "first": self.first, "end": self.end,
                "ended": self.ended.tolist(), "scene": scene_hash, "settings": settings}
        arrays = {"isophote_film": np.array(json.dumps(head)), "open": self.open}
        if self.ends is not None:
            arrays |= {"ends": self.ends, "limits": self.limits}
        for plane, total in enumerate(self.totals):
            for half in ("hi", "lo"):
                if getattr(total, half) is not None:
                    arrays[f"{half}{plane}"] = getattr(total, half)
        for kind, coverage in self.mattes.of.items():
            arrays |= {f"keys_{kind}": coverage.keys, f"units_{kind}": coverage.units}
        with replacing(path) as temporary, open(temporary, "wb") as file:
            np.savez(file, **arrays)


def load_film(path: str | Path, scene_hash: str, settings: dict) -> Film:
    """Read a checkpoint; rendering on from it gives the bits of a render in one go.

    Raises FilmError naming the file where it is missing, damaged, no film, or of another scene or
    other settings (`settings` is Settings.fingerprint()).
    """
    try:
        with np.load(path, allow_pickle=False) as data:
            if "isophote_film" not in data:
                raise FilmError(f"{path}: a .npz file, but no Isophote film")
            head = json.loads(str(data["isophote_film"]))
            if head.get("format") != FORMAT:
                raise FilmError(f"{path}: film format {head.get('format')}, this version reads {FORMAT}")
            check_origin(path, head, scene_hash, settings)
            planes = make_planes(head["planes"], head["clamps"], head["named"], head["mattes"], head["levels"])
            film = Film(tuple(head["region"]), planes, head["first"])
            if "ends" in data:
                film.ends, limits = (loaded(path, data, name, np.int64, film.shape) for name in ("ends", "limits"))
                film.allow(limits)
            film.end = head["end"]
            film.ended[:] = head["ended"]
            film.open = loaded(path, data, "open", np.float32, film.open.shape)
            for plane, total in enumerate(film.totals):
                for half in ("hi", "lo"):
                    if f"{half}{plane}" in data:
                        setattr(total, half, loaded(path, data, f"{half}{plane}", np.float64, film.shape))
            for kind in film.mattes.of:
                keys = loaded(path, data, f"keys_{kind}", np.uint64)
                film.mattes.of[kind] = Coverage(keys, loaded(path, data, f"units_{kind}", np.int64, keys.shape))
            return film
    except FilmError:
        raise
    except FileNotFoundError:
        raise FilmError(f"{path}: no such file") from None
    except (OSError, ValueError, zipfile.BadZipFile, EOFError, KeyError, TypeError, AttributeError) as error:
        raise FilmError(f"{path}: not a readable film ({error})") from None


def check_origin(path, head: dict, scene_hash: str, settings: dict) -> None:
    """Raise FilmError naming what differs between a checkpoint's scene and settings and those wanted."""
    if head["scene"] != scene_hash:
        raise FilmError(f"{path}: a film of another scene ({head['scene'][:12]}, this one is {scene_hash[:12]})")
    wanted, found = json.loads(json.dumps(settings)), head["settings"]  # as JSON: tuples become lists
    differing = [f"{key} was {found.get(key)}, is {wanted.get(key)}"
                 for key in sorted(set(wanted) | set(found)) if wanted.get(key) != found.get(key)]
    if differing:
        raise FilmError(f"{path}: a film with other settings: {'; '.join(differing)}")


def loaded(path, data, name: str, dtype, shape: tuple | None = None) -> np.ndarray:
    """An array of the file; without a `shape` it is a list of any length."""
    array = data[name]
    if array.dtype != dtype or (array.shape != shape if shape else array.ndim != 1):
        raise FilmError(f"{path}: {name} is {array.dtype} {array.shape}, wanted {np.dtype(dtype)} {shape}")
    return array


def add_tables(mattes: Mattes, tables: np.ndarray) -> None:
    """Add tables (numbers, h, w), where there are mattes."""
    if len(tables):
        mattes.add_tables(tables.reshape(len(tables), -1), np.arange(tables[0].size))


def merge(films: Iterable[Film]) -> Film:
    """One film of all samples, in any order of the films; they stay as they are.

    Their sample ranges must follow each other without overlap or gap, and only the last may end
    inside a block. The picture has the bits of a render in one go. Raises FilmError saying what does
    not fit.
    """
    parts = sorted(films, key=lambda film: (np.mean(film.first), np.mean(film.now())))
    if not parts:
        raise FilmError("no films to merge")
    head = parts[0]
    for film in parts[1:]:
        if film.region != head.region or film.planes != head.planes:
            raise FilmError(f"films of region {head.region} with {head.planes} and of region {film.region} "
                            f"with {film.planes} do not merge")
    reached = head.now()
    for film, follower in pairwise(parts):
        adds = follower.now() > follower.first
        if np.any(adds & (follower.first < reached)):
            raise FilmError(f"films overlap: samples {range_of(film)} and {range_of(follower)}")
        if np.any(adds & (follower.first > reached)):
            raise FilmError(f"films leave a gap: samples {range_of(film)} and {range_of(follower)}")
        reached = np.where(adds, follower.now(), reached)
    uneven = any(film.ends is not None for film in parts)
    if uneven and any(film.open_samples for film in parts):
        raise FilmError("films whose pixels have different numbers of samples merge between blocks only")
    merged = Film(head.region, head.planes, head.first)
    merged.ended[:] = sum(film.ended for film in parts)
    for plane, total in enumerate(merged.totals):
        for film in parts:
            if film.totals[plane].hi is not None:
                total.add(film.totals[plane].hi, film.totals[plane].lo)
    for film in parts:
        merged.mattes.add(film.mattes)
    if uneven:
        merged.ends = np.array(reached)
        merged.allow(reached)
    else:
        merged.end = parts[-1].end
        merged.open[:] = parts[-1].open
    return merged


def range_of(film: Film) -> str:
    return f"[{np.min(film.first)}, {np.max(film.now())})"
