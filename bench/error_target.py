"""Whether renders with a wanted error reach it, and whether stopping for it biases the picture.

    python -m bench.error_target FILE.npz ... [--targets 20,10,5] [--size 64] [--seeds 24] [--reference 4096]

Renders of several seeds stop as `isophote render --error E --uniform` does (isophote/session.py): at the first fixed
number of samples at which the film claims the wanted error. The reference is the mean of pieces with seeds of their
own, each of a fixed number of samples. Of luminance, which errors are measured as in bench/coverage.py.

`reached` is the measured error that 95 % of the pixels keep over the wanted one (the median, `reached_low` and
`reached_high` of the seeds); `samples` the median, lowest and highest number. `bias` is what stopping does to the
picture's mean, in per cent of it: the mean difference of each stopped picture to the same seed's at the median number,
which nothing decided; `bias_95` is half its 95 % interval (Student's t). `tiles_off` is the share of tiles whose mean
over the seeds is off the reference by more than their joint 95 % interval, `tiles_off_fixed` the same for pictures at
the median number: what the test makes of tiles without bias. Prints a row of JSON for each scene and target.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy import stats

from bench.common import print_row
from bench.coverage import ROUNDING, scene_of
from bench.parity import expose
from bench.replicates import mean_and_variance, uploaded, welch_dof
from isophote.confidence import FLOOR, SHARE, claim_of
from isophote.film import COMBINED_PLANES, Film
from isophote.schedule import next_decision
from isophote.settings import Settings
from isophote.statistics import luminance_of, sums_over_tiles

PIECE = 256  # samples of the reference's pieces
FIRST_SEED = 1000  # of the pieces; test renders have 1, 2, ...
MOST = 1 << 14  # samples of a render


@dataclass
class Run:
    """One seed's luminance by number of samples, and that number where it stops for each target, the largest first."""

    pictures: dict[int, np.ndarray]
    stops: list[int]


def run_to(device, region, settings: Settings, targets: list[float]) -> Run:
    """A render to the smallest target, and one decision further, so that others' median is there too."""
    film, run, more = Film(region, COMBINED_PLANES), Run({}, []), 3
    while more and film.samples < MOST:
        expose(device, film, next_decision(film.samples), settings)
        run.pictures[film.samples] = luminance_of(film).mean
        most = claim_of(film).most
        while most and len(run.stops) < len(targets) and most.value <= targets[len(run.stops)]:
            run.stops.append(film.samples)
        more -= len(run.stops) == len(targets)
    return run


def bias_of(values: np.ndarray, references: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(mean difference, half its 95 % interval) of independent values and references, over the first axis (Welch)."""
    (mean, variance), (reference, own) = mean_and_variance(values), mean_and_variance(references)
    t = stats.t.ppf(0.975, welch_dof(variance, own, len(values), len(references)))
    return mean - reference, t * np.sqrt(variance + own)


def tiles_off(pictures: np.ndarray, pieces: np.ndarray) -> float:
    """The share of tiles whose means differ beyond their 95 % interval; those that only rounding moves are left out."""
    sums = [np.stack([sums_over_tiles(image) for image in images]) for images in (pictures, pieces)]
    off, half = bias_of(*sums)
    return float((np.abs(off) > half)[half > ROUNDING * sums[1].mean(axis=0)].mean())


def target_row(target: float, at: int, runs: list[Run], pieces: np.ndarray) -> dict:
    samples = [run.stops[at] for run in runs]
    usual = sorted(samples)[len(samples) // 2]
    pictures = np.stack([run.pictures[run.stops[at]] for run in runs])
    fixed = np.stack([run.pictures[usual] for run in runs if usual in run.pictures])
    reference = pieces.mean(axis=0)
    floor = np.maximum(reference, FLOOR * reference.mean())
    # The reference's own error is part of the difference: what is left is the picture's.
    shares = [1.0 / (1.0 + count / (PIECE * len(pieces))) for count in samples]
    reached = [float(np.quantile(np.abs(picture - reference) / floor, SHARE)) * own ** 0.5 / target
               for picture, own in zip(pictures, shares, strict=True)]
    pairs = [(run.pictures[run.stops[at]] - run.pictures[usual]).mean() for run in runs if usual in run.pictures]
    off, variance = mean_and_variance(np.array(pairs))
    half = stats.t.ppf(0.975, len(pairs) - 1) * np.sqrt(variance)
    return {"target": target, "seeds": len(runs), "samples": usual, "samples_low": min(samples),
            "samples_high": max(samples), "reached": float(np.median(reached)), "reached_low": min(reached),
            "reached_high": max(reached), "bias": 100.0 * float(off / reference.mean()),
            "bias_95": 100.0 * float(half / reference.mean()),
            "tiles_off": tiles_off(pictures, pieces), "tiles_off_fixed": tiles_off(fixed, pieces)}


def main() -> None:
    parser = argparse.ArgumentParser(prog="bench.error_target", description=__doc__.split("\n")[0])
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--targets", default="20,10,5", help="per cent, falling")
    parser.add_argument("--size", type=int, default=64, help="longer side in pixels")
    parser.add_argument("--seeds", type=int, default=24)
    parser.add_argument("--reference", type=int, default=4096, help="samples")
    parser.add_argument("--device", default="openmp")
    options = parser.parse_args()
    targets = sorted((float(text) / 100.0 for text in options.targets.split(",")), reverse=True)
    settings = Settings(samples=PIECE, device=options.device, wait_for_kernels=True)
    for path in options.files:
        scene = scene_of(path, options.size)
        region = (0, 0, *(int(n) for n in scene.resolution))
        with uploaded(scene, settings) as device:
            runs = [run_to(device, region, replace(settings, seed=1 + k), targets) for k in range(options.seeds)]
            pieces = np.stack([
                luminance_of(expose(device, Film(region, COMBINED_PLANES), PIECE,
                                    replace(settings, seed=FIRST_SEED + k))).mean
                for k in range(options.reference // PIECE)])
        for at, target in enumerate(targets):
            stopped = [run for run in runs if len(run.stops) > at]
            if len(stopped) > 1:
                print_row({"scene": path.stem, **target_row(target, at, stopped, pieces)})


if __name__ == "__main__":
    main()
