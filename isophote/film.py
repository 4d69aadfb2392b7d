"""The film: sums of samples, and the one operation that progressive passes, devices, machines and resuming share.

Sample i belongs to replicate i & 1. Planes, rows from the bottom: 0-3 RGBA of replicate 0, 4-7 RGBA
of replicate 1, 8 how many samples were no numbers and count as 0; with AOVs also 9 depth, 10-12 normal,
13-15 albedo, 16-18 position. Depth and position come from sample 0 alone, as in Cycles: a mean of depths across an
edge is no depth. Where light is clamped four more: luminance cut off from direct and from indirect light of
replicate 0, and of replicate 1.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

import numpy as np

from isophote.files import replacing
from isophote.schedule import BLOCK, Region

FORMAT = 2
INVALID = 8  # the plane's number
COMBINED_PLANES = 9
AOV_PLANES = 19
CUT_PLANES = 4
CLAMPED = (COMBINED_PLANES + CUT_PLANES, AOV_PLANES + CUT_PLANES)
LIMITS = ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "transparent_bounces")


class FilmError(ValueError):
    """Films that do not fit together, or a film's file that cannot be used; the message says which."""


def two_sum(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(s, e) with s = fl(a + b) and s + e = a + b exactly (Knuth, TAOCP 2, 4.2.2, theorem B); e is 0 where s is
    not finite."""
    s = a + b
    rest = s - a
    return s, np.where(np.isfinite(s), (a - (s - rest)) + (b - rest), 0.0)


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
        if self.lo is None and error.any():
            self.lo = np.zeros_like(self.hi)
        if self.lo is not None:
            self.lo[rows] = error


class Film:
    """Sums of the samples [first, end) of a region's pixels.

    `open` is the float32 array (planes, h, w) into which a device adds the samples of the block under
    way, in order; `add_samples` says how many came and closes the block when it is full. `limits` counts the
    paths that each of LIMITS, the bounce limits, has ended, uint64.
    """

    def __init__(self, region: Region, planes: int, first: int = 0):
        x0, y0, x1, y1 = region
        if not (0 <= x0 < x1 and 0 <= y0 < y1):
            raise FilmError(f"region {tuple(region)} holds no pixels")
        if planes - CUT_PLANES * (planes in CLAMPED) not in (COMBINED_PLANES, AOV_PLANES):
            raise FilmError(f"a film has {COMBINED_PLANES} or {AOV_PLANES} planes, {CUT_PLANES} more where light is "
                            f"clamped, not {planes}")
        if first < 0 or first % BLOCK:
            raise FilmError(f"a film begins at a block's border, a multiple of {BLOCK}, not at sample {first}")
        self.region = (int(x0), int(y0), int(x1), int(y1))
        self.first = self.end = first
        self.open = np.zeros((planes, y1 - y0, x1 - x0), np.float32)
        self.totals = [Total() for _ in range(planes)]
        self.limits = np.zeros(len(LIMITS), np.uint64)

    @property
    def planes(self) -> int:
        return self.open.shape[0]

    @property
    def has_aovs(self) -> bool:
        return self.planes >= AOV_PLANES

    @property
    def is_clamped(self) -> bool:
        """Whether it has planes of what clamping cut off."""
        return self.planes in CLAMPED

    def cut(self, indirect: bool, replicate: int) -> np.ndarray:
        """Sum of the luminance that clamping cut off from one replicate's direct or indirect light, as `sum`."""
        if not self.is_clamped:
            return np.zeros(self.shape)
        return self.sum(self.planes - CUT_PLANES + 2 * replicate + indirect)

    @property
    def shape(self) -> tuple[int, int]:
        """(height, width) of the region in pixels."""
        return self.open.shape[1:]

    @property
    def samples(self) -> int:
        """Samples a pixel, both replicates together."""
        return self.end - self.first

    @property
    def replicate_samples(self) -> tuple[int, int]:
        """Samples a pixel of replicates 0 and 1; they differ by one where the count is odd."""
        even = (self.end + 1) // 2 - (self.first + 1) // 2
        return even, self.samples - even

    @property
    def open_samples(self) -> int:
        """Samples in the open block; blocks begin at multiples of BLOCK."""
        return self.end % BLOCK

    def add_samples(self, count: int, limits: np.ndarray | int = 0) -> None:
        """Note that `count` samples were added to `open`, of which the bounce limits ended `limits` paths (a device's).

        Raises FilmError where they do not fit its block.
        """
        if count < 0 or self.open_samples + count > BLOCK:
            raise FilmError(f"{count} samples after sample {self.end} cross the border of a block of {BLOCK}")
        self.end += count
        self.limits += np.asarray(limits, np.uint64)
        if count and self.open_samples == 0:
            self.close_block()

    def close_block(self) -> None:
        """Add the full open block to the totals and clear it. Raises FilmError while it is not full."""
        if self.open_samples:
            raise FilmError(f"the block holds {self.open_samples} of {BLOCK} samples and stays open")
        for plane, total in zip(self.open, self.totals, strict=True):
            if plane.any():
                total.add(plane)
        self.open.fill(0.0)

    def sum(self, plane: int) -> np.ndarray:
        """Sum of a plane over all samples, float64 (h, w): the same bits however the samples were split."""
        total = self.totals[plane].copy()
        if self.open_samples and self.open[plane].any():
            total.add(self.open[plane])
        return np.zeros(self.shape) if total.hi is None else total.hi + 0.0  # + 0.0: one sign of zero

    def save(self, path: str | Path, scene_hash: str, settings: dict) -> None:
        """Write a checkpoint (.npz): all sums, and the scene and settings that they belong to.

        `settings` is Settings.fingerprint(). The file appears whole or not at all. Raises OSError.
        """
        head = {"format": FORMAT, "region": self.region, "planes": self.planes, "first": self.first, "end": self.end,
                "limits": self.limits.tolist(), "scene": scene_hash, "settings": settings}
        arrays = {"isophote_film": np.array(json.dumps(head)), "open": self.open}
        for plane, total in enumerate(self.totals):
            for half in ("hi", "lo"):
                if getattr(total, half) is not None:
                    arrays[f"{half}{plane}"] = getattr(total, half)
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
            film = Film(tuple(head["region"]), head["planes"], head["first"])
            film.end = head["end"]
            film.limits[:] = head["limits"]
            film.open = loaded(path, data, "open", np.float32, film.open.shape)
            for plane, total in enumerate(film.totals):
                for half in ("hi", "lo"):
                    if f"{half}{plane}" in data:
                        setattr(total, half, loaded(path, data, f"{half}{plane}", np.float64, film.shape))
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


def loaded(path, data, name: str, dtype, shape: tuple) -> np.ndarray:
    array = data[name]
    if array.dtype != dtype or array.shape != shape:
        raise FilmError(f"{path}: {name} is {array.dtype} {array.shape}, wanted {np.dtype(dtype)} {shape}")
    return array


def merge(films: Iterable[Film]) -> Film:
    """One film of all samples, in any order of the films; they stay as they are.

    Their sample ranges must follow each other without overlap or gap, and only the last may end
    inside a block. The picture has the bits of a render in one go. Raises FilmError saying what does
    not fit.
    """
    parts = sorted(films, key=lambda film: (film.first, film.end))
    if not parts:
        raise FilmError("no films to merge")
    head = parts[0]
    for film in parts[1:]:
        if film.region != head.region or film.planes != head.planes:
            raise FilmError(f"films of region {head.region} with {head.planes} planes and of region {film.region} "
                            f"with {film.planes} planes do not merge")
    for film, follower in pairwise(parts):
        ranges = f"samples [{film.first}, {film.end}) and [{follower.first}, {follower.end})"
        if follower.first < film.end:
            raise FilmError(f"films overlap: {ranges}")
        if follower.first > film.end:
            raise FilmError(f"films leave a gap: {ranges}")
    merged = Film(head.region, head.planes, head.first)
    merged.end = parts[-1].end
    merged.open[:] = parts[-1].open
    merged.limits[:] = sum(film.limits for film in parts)
    for plane, total in enumerate(merged.totals):
        for film in parts:
            if film.totals[plane].hi is not None:
                total.add(film.totals[plane].hi, film.totals[plane].lo)
    return merged
