"""How often what a render says of its own error is true: tiles' and pixels' intervals, and the error of 95 % of pixels.

    python -m bench.coverage [FILE.npz ...] [--rare] [--size 64] [--samples 4,8,...,1024] [--seeds 16]

Each scene is rendered with several seeds, and its film is looked at on the way. The reference of a seed is
the mean of the other seeds' last films; the reference's own error, from the spread of those, is added to the
interval's. Of luminance. Tiles and pixels without noise that have the reference's value are left out of shares.

`tiles`: share of tiles (8 x 8) whose 95 % interval holds the reference, of all; `unsure`: share that is flagged;
`wrong`: share of the others whose interval does not hold it; `lows` of it those below the reference.
`sure`: how many others there were. `pixels`: the same as `tiles` for pixels with the Error pass, which is
1.96 standard deviations pooled over the tile. `error` is the measured relative error that 95 % of pixels
keep (confidence.relative_errors says relative to what), `claimed` the median of the seeds' claims over it, and
`claimed_low`, `claimed_high` the extremes. --rare adds the scenes of tests/rare_scenes.py. Prints a row of JSON
for each scene and number of samples.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from bench.common import print_row
from bench.parity import expose
from bench.replicates import mean_and_variance, uploaded
from isophote.confidence import FLOOR, SHARE, Tiles, error_of_most, relative_errors, tiles_of
from isophote.film import COMBINED_PLANES, Film
from isophote.scene import Scene, load_scene, resized
from isophote.settings import Settings
from isophote.statistics import Z95, luminance_of, pool, sums_over_tiles

COUNTS = (4, 8, 16, 32, 64, 128, 256, 512, 1024)
ROUNDING = 1e-6  # relative: what float32 sums leave of a constant


@dataclass(frozen=True)
class Look:
    """A film at one number of samples: its pixels' mean luminance and the Error pass's variance, and its claims."""

    picture: np.ndarray
    variance: np.ndarray
    tiles: Tiles
    claimed: float | None


def look_at(film: Film) -> Look:
    seen = luminance_of(film)
    tiles = tiles_of(seen)
    errors = relative_errors(seen, tiles)
    return Look(seen.mean, pool(seen.variance), tiles, None if errors is None else error_of_most(errors).value)


def looks_of(scene: Scene, settings: Settings, counts, seeds) -> list[list[Look]]:
    """By seed and by number of samples."""
    region = (0, 0, *(int(n) for n in scene.resolution))
    found = []
    with uploaded(scene, settings) as device:
        for seed in seeds:
            film, chosen = Film(region, COMBINED_PLANES), replace(settings, seed=seed)
            found.append([look_at(expose(device, film, count, chosen)) for count in counts])
    return found


def held(value, low, high, reference, variance) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(held, lies below the reference, has noise) of intervals of `value`, the reference having a `variance`.

    Each half of an interval is lengthened as independent errors add.
    """
    below = reference - value
    half = np.where(below > 0.0, high - value, value - low)
    exact = np.abs(below) <= ROUNDING * reference
    return exact | (np.abs(below) <= np.hypot(half, Z95 * np.sqrt(variance))), below > 0.0, ~(exact & (half == 0.0))


def share(of: np.ndarray, among: np.ndarray) -> float | None:
    """The share of `among` that is `of`; None where there is nothing."""
    return float(of[among].mean()) if among.any() else None


def coverage_rows(looks: list[list[Look]], counts) -> Iterator[dict]:
    """A row for each number of samples."""
    last = np.stack([seed[-1].picture for seed in looks])
    pixels = sums_over_tiles(np.ones(last.shape[1:]))
    for at, count in enumerate(counts):
        tiles, singles, measured, claimed = [], [], [], []
        for seed, own in enumerate(looks):
            look, others = own[at], np.delete(last, seed, axis=0)
            reference, variance = mean_and_variance(others)
            of_tiles = mean_and_variance([sums_over_tiles(other) / pixels for other in others])
            tiles.append((*held(look.tiles.mean, *look.tiles.interval(), *of_tiles), look.tiles.unsure))
            half = Z95 * np.sqrt(look.variance)
            singles.append(held(look.picture, look.picture - half, look.picture + half, reference, variance))
            floor = np.maximum(reference, FLOOR * reference.mean())
            # The spread of the others is the reference's error: what of the difference is this picture's own.
            own_share = 1.0 / (1.0 + count / (counts[-1] * len(others)))
            difference = np.abs(look.picture - reference) * np.sqrt(own_share)
            measured.append(float(np.quantile(difference / floor, SHARE)))
            claimed.append(look.claimed)
        holds, lower, noisy, unsure = (np.stack(part) for part in zip(*tiles, strict=True))
        sure = noisy & ~unsure
        ratios = [c / m for c, m in zip(claimed, measured, strict=True) if c is not None and m > 0.0] or [None]
        single_holds, _, single_noisy = (np.stack(part) for part in zip(*singles, strict=True))
        yield {"samples": count, "tiles": share(holds, noisy), "unsure": share(unsure, noisy),
               "wrong": share(~holds, sure), "lows": share(~holds & lower, sure), "sure": int(sure.sum()),
               "pixels": share(single_holds, single_noisy), "error": float(np.median(measured)),
               "claimed": None if ratios[0] is None else float(np.median(ratios)),
               "claimed_low": min(ratios), "claimed_high": max(ratios)}


def scene_of(path: Path, side: int) -> Scene:
    """The scene in a file, its longer side `side` pixels."""
    scene = load_scene(path)
    longer = max(int(n) for n in scene.resolution)
    return resized(scene, tuple(max(1, round(int(n) * side / longer)) for n in scene.resolution))


def main() -> None:
    parser = argparse.ArgumentParser(prog="bench.coverage", description=__doc__.split("\n")[0])
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--rare", action="store_true")
    parser.add_argument("--size", type=int, default=64, help="longer side in pixels")
    parser.add_argument("--samples", default=",".join(map(str, COUNTS)), help="a pixel, increasing")
    parser.add_argument("--seeds", type=int, default=16)
    parser.add_argument("--device", default="openmp")
    options = parser.parse_args()
    counts = sorted(int(n) for n in options.samples.split(","))
    scenes = {path.stem: lambda path=path: scene_of(path, options.size) for path in options.files}
    if options.rare:
        from tests.rare_scenes import SCENES

        scenes |= SCENES
    settings = Settings(samples=counts[-1], device=options.device, wait_for_kernels=True)
    for name, make in scenes.items():
        for row in coverage_rows(looks_of(make(), settings, counts, range(1, options.seeds + 1)), counts):
            print_row({"scene": name, **row})


if __name__ == "__main__":
    main()
