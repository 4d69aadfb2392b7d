"""Measures what settings have taken from the picture, by pairs of renders that differ in one setting.

Both renders of a pair have the same seed, so that paths which never meet the setting are the same, and the
difference has little noise. Pairs with several seeds say how far to trust it: with K pairs of mean luminances a (as
set) and b (without the setting), the share removed is R = sum (b - a) / sum b, and its 95 % interval is that of the
mean of b - a - R b, divided by the mean of b (the ratio's first order), with Student's t of K - 1 degrees of freedom.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from isophote.confidence import FLOOR, student95
from isophote.device import Device, open_device
from isophote.film import LIMITS, Film
from isophote.ledger import CLAMPS, entry, ledger_of, nothing
from isophote.params import MOST_BOUNCES
from isophote.passes import film_planes
from isophote.scene import Scene, SceneError, resized
from isophote.schedule import BLOCK, sample_items
from isophote.settings import Settings
from isophote.statistics import LUMINANCE, sums_over_tiles, weighted_sums
from isophote.validate import check, clean

if TYPE_CHECKING:
    from isophote.prepare import Prepared

IMAGE_BOUND, TILE_BOUND = 0.0005, 0.005  # relative, within which a precision counts as equivalent to strict
FEWEST_PAIRS = 3
# What is measured unless something else is asked for: longer side in pixels (the share of light needs no resolution),
# samples a pixel, pairs.
SIDE, SAMPLES, PAIRS = 192, 64, 8


@dataclass(frozen=True)
class Effect:
    """What a setting took in K pairs of pictures: the share of the light, the ends of its 95 % interval, and the mean
    luminance of a pixel."""

    removed: float
    low: float
    high: float
    luminance: float


def effect_of(pairs: list[tuple[np.ndarray, np.ndarray]]) -> Effect:
    """The effect on the means of pictures (as set, without the setting). Raises ValueError for fewer than 3 pairs."""
    if len(pairs) < FEWEST_PAIRS:
        raise ValueError(f"{len(pairs)} pairs: at least {FEWEST_PAIRS} are needed for an interval")
    a, b = (np.array([pair[k].mean() for pair in pairs]) for k in (0, 1))
    if not b.sum() > 0.0:
        return Effect(0.0, 0.0, 0.0, 0.0)
    removed = float((b - a).sum() / b.sum())
    half = half_interval(b - a - removed * b) / float(b.mean())
    return Effect(removed, removed - half, removed + half, float((b - a).mean()))


def half_interval(values: np.ndarray) -> np.ndarray:
    """Half the 95 % interval of the mean over the first axis, K independent values."""
    count = len(values)
    return student95(np.float64(count - 1)) * values.std(axis=0, ddof=1) / math.sqrt(count)


def worst_tile(pairs: list[tuple[np.ndarray, np.ndarray]]) -> tuple[float, float]:
    """(the largest end of a tile's 95 % interval, the share of tiles within TILE_BOUND) of the relative difference.

    Tiles darker than FLOOR of the picture are measured by that.
    """
    count = sums_over_tiles(np.ones(pairs[0][0].shape))
    a, b = (np.stack([sums_over_tiles(pair[k]) / count for pair in pairs]) for k in (0, 1))
    mean = b.mean(axis=0)
    ends = (np.abs((b - a).mean(axis=0)) + half_interval(b - a)) / np.maximum(mean, FLOOR * mean.mean())
    return float(ends.max()), float((ends <= TILE_BOUND).mean())


def luminance_of_film(film: Film) -> np.ndarray:
    """Mean luminance, float64 (h, w)."""
    halves = weighted_sums(film, LUMINANCE)
    return (halves[0] + halves[1]) / film.samples


class Renderer:
    """Renders one scene again and again; a device for each precision and each use of clamps, opened when needed."""

    def __init__(self, prepared: Prepared, settings: Settings):
        width, height = prepared.resolution
        self.prepared, self.settings, self.region = prepared, settings, settings.region or (0, 0, width, height)
        self.devices: dict[tuple, Device] = {}

    def device(self, settings: Settings) -> Device:
        kind = settings.precision, settings.clamps
        if kind not in self.devices:
            device = open_device(settings.device, settings)
            self.devices[kind] = device
            device.upload(self.prepared)
        return self.devices[kind]

    def film(self, seed: int, **changes) -> Film:
        """The film of one seed, with some of the settings changed."""
        settings = replace(self.settings, seed=seed, passes=("combined",), **changes)
        film = Film(self.region, film_planes(settings))
        device = self.device(settings)
        for item in sample_items(0, settings.samples, BLOCK, self.region):
            film.add_samples(device.render(item, settings, film.open, lambda: False), device.ended)
        return film

    def close(self) -> None:
        for device in self.devices.values():
            device.close()


@contextmanager
def renderer(scene: Scene, settings: Settings) -> Iterator[Renderer]:
    """Raises DeviceError."""
    from isophote.prepare import prepare  # needs the native module

    made = Renderer(prepare(clean(scene)[0]), settings)
    try:
        yield made
    finally:
        made.close()


def small(scene: Scene) -> Scene:
    """The scene with a longer side of at most SIDE pixels."""
    width, height = (int(n) for n in scene.resolution)
    scale = min(1.0, SIDE / max(width, height))
    return resized(scene, (max(1, round(width * scale)), max(1, round(height * scale))))


def checked_ledger(scene: Scene, settings: Settings, pairs: int,
                   progress: Callable[[str], None] = lambda what: None) -> list[dict]:
    """measured_ledger of the whole frame of a scene that nobody has checked yet. Raises SceneError, too."""
    problems, _, dropped = check(scene)
    if errors := [str(problem) for problem in problems if problem.severity == "error"]:
        raise SceneError("; ".join(errors))
    return measured_ledger(scene, replace(settings, region=None), pairs, [*scene.notes, *dropped], progress)


def measured_ledger(scene: Scene, settings: Settings, pairs: int, notes: list[dict],
                    progress: Callable[[str], None] = lambda what: None) -> list[dict]:
    """The ledger of a scene with these settings, each entry measured by so many pairs of renders of settings.samples.

    `progress` is called with what comes next. Raises DeviceError, and ValueError for fewer than 3 pairs.
    """
    seeds = [settings.seed + k for k in range(pairs)]
    with renderer(scene, settings) as renders:
        progress("as set")
        films = [renders.film(seed) for seed in seeds]
        as_set = [luminance_of_film(film) for film in films]

        def without(**changes) -> list[tuple[np.ndarray, np.ndarray]]:
            progress(", ".join(f"{name} {value}" for name, value in changes.items()))
            return [(a, luminance_of_film(renders.film(seed, **changes)))
                    for a, seed in zip(as_set, seeds, strict=True)]

        whole = joined(films)
        entries = {made["switch"]: made for made in ledger_of(whole, settings, [])}
        for name in CLAMPS:
            if name in entries and entries[name]["status"] != "none":
                entries[name] = clamp_measured(films, settings, name)
        acting = [name for name in LIMITS if entries[name]["status"] != "none"]
        for name in acting:
            effect = effect_of(without(**{name: MOST_BOUNCES}))
            entries[name] = measured(name, getattr(settings, name), effect, paths=entries[name]["paths"])
        if len(acting) > 1:
            effect = effect_of(without(**dict.fromkeys(LIMITS, MOST_BOUNCES)))
            entries["all_bounces"] = measured("all_bounces", settings.max_bounces, effect)
        if settings.precision == "fast":
            entries["precision"] = precision_measured(without(precision="strict"))
    order = [*CLAMPS, *LIMITS, "all_bounces", "precision", "invalid_samples"]
    left_out = [made for made in ledger_of(whole, settings, notes) if made["switch"] == "left_out"]
    return [entries[name] for name in order if name in entries] + left_out


def joined(films: list[Film]) -> Film:
    """One film of several seeds, for what counts only: as if the seeds were further samples."""
    whole = Film(films[0].region, films[0].planes)
    for film in films:
        for plane in range(film.planes.sums):
            whole.totals[plane].add(film.sum(plane))
        whole.end += film.samples
        whole.ended += film.ended
    return whole


def measured(switch: str, setting, effect: Effect, **more) -> dict:
    return entry(switch, setting, "measured", effect.removed, [effect.low, effect.high], effect.luminance, **more)


def clamp_measured(films: list[Film], settings: Settings, name: str) -> dict:
    """A clamp needs no second render: its films hold what it cut off."""
    kind, pairs = CLAMPS.index(name), []
    for film in films:
        cuts = [film.cut(bool(k), 0) + film.cut(bool(k), 1) for k in (0, 1)]
        whole = luminance_of_film(film) + sum(cuts) / film.samples
        pairs.append((whole - cuts[kind] / film.samples, whole))
    return measured(name, getattr(settings, name), effect_of(pairs))


def precision_measured(pairs: list[tuple[np.ndarray, np.ndarray]]) -> dict:
    """Fast precision against strict: an equivalence test. `equivalent`: the picture's interval lies within IMAGE_BOUND;
    `worst_tile`: the largest end of a tile's interval, `tiles`: the share of tiles within TILE_BOUND."""
    effect = effect_of(pairs)
    worst, share = worst_tile(pairs)
    if all((a == b).all() for a, b in pairs):
        return nothing("precision", "fast", equivalent=True, worst_tile=0.0, tiles=1.0)
    return measured("precision", "fast", effect, equivalent=bool(max(-effect.low, effect.high) <= IMAGE_BOUND),
                    worst_tile=worst, tiles=share)
