"""THE table of passes: what each is called, what it needs and how it comes from a film."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from isophote.film import AOV_PLANES, COMBINED_PLANES, CUT_PLANES, INVALID, Film, FilmError
from isophote.settings import Settings
from isophote.statistics import pixel_error


def combined(film: Film) -> np.ndarray:
    """Mean of all samples, both replicates; alpha is premultiplied."""
    return np.stack([mean_of(film, film.sum(c) + film.sum(4 + c)) for c in range(4)], axis=-1)


def mean_of(film: Film, sums: np.ndarray) -> np.ndarray:
    return (sums / np.maximum(film.counts, 1)).astype(np.float32)


def mean_planes(first: int, count: int) -> Callable[[Film], np.ndarray]:
    return lambda film: np.stack([mean_of(film, film.sum(first + c)) for c in range(count)], axis=-1)


def first_sample_planes(first: int, count: int) -> Callable[[Film], np.ndarray]:
    """Planes to which sample 0 alone contributes. Raises FilmError for a part of a render without it."""

    def planes(film: Film) -> np.ndarray:
        if np.any(film.first):
            raise FilmError(f"depth and position come from sample 0; this film begins at sample {np.max(film.first)}")
        return np.stack([film.sum(first + c).astype(np.float32) for c in range(count)], axis=-1)

    return planes


def invalid(film: Film) -> np.ndarray:
    """How many of the pixel's samples were NaN, infinite or too large for float32, and count as 0."""
    return film.sum(INVALID).astype(np.float32)[..., None]


def sample_count(film: Film) -> np.ndarray:
    return np.broadcast_to(film.counts, film.shape)[..., None].astype(np.float32)


@dataclass(frozen=True)
class Pass:
    """A pass: name in settings, name in Blender and in files, channel ids, whether the film must hold AOVs.

    `make` gives float32 (h, w, len(channels)), rows from the bottom.
    """

    name: str
    blender_name: str
    channels: str
    needs_aovs: bool
    make: Callable[[Film], np.ndarray]


PASSES: dict[str, Pass] = {
    entry.name: entry
    for entry in (
        Pass("combined", "Combined", "RGBA", False, combined),
        Pass("depth", "Depth", "Z", True, first_sample_planes(9, 1)),
        Pass("normal", "Normal", "XYZ", True, mean_planes(10, 3)),
        Pass("albedo", "Albedo", "RGB", True, mean_planes(13, 3)),
        Pass("position", "Position", "XYZ", True, first_sample_planes(16, 3)),
        Pass("sample_count", "Sample Count", "X", False, sample_count),
        Pass("invalid", "Invalid", "X", False, invalid),
        Pass("error", "Error", "RGB", False, pixel_error),  # one standard deviation of the pixel's mean
    )
}


def check_passes(names: Iterable[str]) -> tuple[str, ...]:
    """The names in the table's order, each once. Raises ValueError naming one that is unknown, and those that exist."""
    names = list(names)
    for name in names:
        if name not in PASSES:
            raise ValueError(f"no pass {name!r}; there are {', '.join(PASSES)}")
    return tuple(name for name in PASSES if name in names)


def planes_for(names: Iterable[str], clamps: bool = False) -> int:
    """Planes that a film needs for these passes, and where light is clamped."""
    planes = AOV_PLANES if any(PASSES[name].needs_aovs for name in names) else COMBINED_PLANES
    return planes + CUT_PLANES * clamps


def film_planes(settings: Settings) -> int:
    """Planes of a film of these settings."""
    return planes_for(settings.passes, settings.clamps)


def make_passes(film: Film, names: Iterable[str]) -> dict[str, np.ndarray]:
    """Blender's name -> float32 (h, w, c) for each pass asked for. Raises FilmError where the film lacks its planes."""
    made = {}
    for name in check_passes(names):
        entry = PASSES[name]
        if entry.needs_aovs and not film.has_aovs:
            raise FilmError(f"pass {name}: the film was made without AOVs")
        made[entry.blender_name] = entry.make(film)
    return made
