"""What adaptive sampling saves on the way to a wanted error, and whether it biases the picture.

    python -m bench.adaptive FILE.npz|NAME ... [--target 10] [--size 64] [--seeds 16] [--reference 8192] [--away 1]

NAME is a scene of tests/rare_scenes.py. --away 2 has the camera see twice as much to each side: the scene, and around
it its calm background. Each seed is rendered to the wanted error twice, uniform and adaptive, in turns, by the same
session and device. Seconds are the process's, with all that decides: what else the machine does is not part of them;
on OpenCL devices they are the wall's. The reference is the mean of pieces with seeds of their
own, each of a fixed number of samples. Of luminance.

`faster` is the median of the seeds' ratios of time, `fewer` that of samples; `reached` the median of the measured error
that 95 % of the pixels keep over the wanted one, for uniform and for adaptive renders, as bench/error_target.py has it;
`faster_alike` is `faster` as it would be had both reached the same, with time as 1 / error^2. `bias` is the mean
difference of the adaptive pictures to the reference and `paired` that to the uniform pictures of the same seeds, in
per cent of the reference's mean, each with half its 95 % interval (Welch; Student's t). `tiles` is the share of tiles
whose mean is off the reference beyond their joint 95 % interval, `tiles_uniform` the same for the uniform pictures,
`tile_bias` the largest paired difference of a quarter of the picture. Prints a row of JSON for each scene.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy import stats

from bench.common import print_row
from bench.coverage import scene_of
from bench.error_target import FIRST_SEED, PIECE, bias_of, tiles_off
from bench.parity import expose
from bench.replicates import mean_and_variance, uploaded
from isophote.confidence import FLOOR, SHARE
from isophote.device import open_device
from isophote.film import COMBINED_PLANES, Film
from isophote.scene import Scene, resized
from isophote.session import Session
from isophote.settings import Settings
from isophote.statistics import luminance_of

MOST = 1 << 14  # samples of a pixel


@dataclass(frozen=True)
class Run:
    """A render to the wanted error."""

    seconds: float
    counts: np.ndarray  # samples of each pixel
    picture: np.ndarray
    reached: bool

    @property
    def samples(self) -> float:
        return float(self.counts.mean())


def run_to(scene: Scene, settings: Settings, device) -> Run:
    """A session that leaves the device open for the next."""
    session = Session(scene, settings, device)
    clock = time.process_time if settings.device == "openmp" else time.perf_counter
    before = clock()
    last = session.run()
    film, seconds = session.film, clock() - before
    return Run(seconds, np.broadcast_to(film.counts, film.shape), luminance_of(film).mean, last.why_stopped == "error")


def reached_by(run: Run, reference: np.ndarray, samples: int) -> float:
    """The error that 95 % of the pixels keep, without the reference's own share, which has so many samples."""
    floor = np.maximum(reference, FLOOR * reference.mean())
    own = np.abs(run.picture - reference) / np.sqrt(1.0 + run.counts / samples)
    return float(np.quantile(own / floor, SHARE))


def half_interval(values: np.ndarray) -> tuple[float, float]:
    """Mean and half its 95 % interval (Student's t)."""
    mean, variance = mean_and_variance(values)
    return float(mean), float(stats.t.ppf(0.975, len(values) - 1) * np.sqrt(variance))


def quarters(picture: np.ndarray) -> np.ndarray:
    """Means of the four quarters."""
    height, width = picture.shape
    return np.array([part.mean() for rows in np.split(picture, [height // 2]) for part in
                     np.split(rows, [width // 2], axis=1)])


def scene_row(target: float, uniform: list[Run], adaptive: list[Run], pieces: np.ndarray) -> dict:
    reference = pieces.mean(axis=0)
    mean, samples = reference.mean(), PIECE * len(pieces)
    reached = [float(np.median([reached_by(run, reference, samples) for run in runs])) / target
               for runs in (uniform, adaptive)]
    faster = float(np.median([a.seconds / b.seconds for a, b in zip(uniform, adaptive, strict=True)]))
    images = [np.stack([run.picture for run in runs]) for runs in (uniform, adaptive)]
    bias, bias_half = bias_of(images[1].mean(axis=(1, 2)), pieces.mean(axis=(1, 2)))
    pairs = images[1] - images[0]
    paired, paired_half = half_interval(pairs.mean(axis=(1, 2)))
    parts = [half_interval(part) for part in np.stack([quarters(pair) for pair in pairs]).T]
    worst = max(parts, key=lambda part: abs(part[0]))
    return {"target": target, "seeds": len(uniform), "seconds": float(np.median([run.seconds for run in uniform])),
            "samples_uniform": float(np.median([run.samples for run in uniform])),
            "samples": float(np.median([run.samples for run in adaptive])),
            "most": max(int(run.counts.max()) for run in adaptive),
            "faster": faster,
            "fewer": float(np.median([a.samples / b.samples for a, b in zip(uniform, adaptive, strict=True)])),
            "reached": reached, "faster_alike": faster * (reached[0] / reached[1]) ** 2,
            "bias": [100.0 * float(bias / mean), 100.0 * float(bias_half / mean)],
            "paired": [100.0 * paired / mean, 100.0 * paired_half / mean],
            "tiles": tiles_off(images[1], pieces), "tiles_uniform": tiles_off(images[0], pieces),
            "tile_bias": [100.0 * value / mean for value in worst]}


def scene_named(name: str, size: int, away: float) -> Scene:
    """A scene file, or a scene of tests/rare_scenes.py."""
    from tests.rare_scenes import SCENES, UNEVEN

    made = SCENES | UNEVEN
    scene = resized(made[name](), (size, size)) if name in made else scene_of(Path(name), size)
    return replace(scene, arrays=scene.arrays | {"camera_window": np.float32(away) * scene.camera_window})


def main() -> None:
    parser = argparse.ArgumentParser(prog="bench.adaptive", description=__doc__.split("\n")[0])
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--target", type=float, default=10.0, help="per cent")
    parser.add_argument("--size", type=int, default=64, help="longer side in pixels")
    parser.add_argument("--away", type=float, default=1.0, help="how many times as much the camera sees")
    parser.add_argument("--seeds", type=int, default=16)
    parser.add_argument("--reference", type=int, default=8192, help="samples")
    parser.add_argument("--device", default="openmp")
    parser.add_argument("--threads", type=int, default=1, help="waiting threads take a core's time, too")
    options = parser.parse_args()
    target = options.target / 100.0
    settings = Settings(samples=MOST, error_target=target, device=options.device, wait_for_kernels=True,
                        threads=options.threads, passes=("combined",))
    for name in options.scenes:
        scene = scene_named(name, options.size, options.away)
        region = (0, 0, *(int(n) for n in scene.resolution))
        device = open_device(options.device, settings)
        runs: dict[bool, list[Run]] = {False: [], True: []}
        for seed in range(1, options.seeds + 1):
            for adaptive in (False, True) if seed % 2 else (True, False):
                runs[adaptive].append(run_to(scene, replace(settings, seed=seed, adaptive=adaptive), device))
        device.close()
        with uploaded(scene, replace(settings, threads=0)) as device:
            pieces = np.stack([
                luminance_of(expose(device, Film(region, COMBINED_PLANES), PIECE,
                                    replace(settings, seed=FIRST_SEED + k))).mean
                for k in range(options.reference // PIECE)])
        if all(run.reached for both in runs.values() for run in both):
            row = scene_row(target, runs[False], runs[True], pieces)
        else:
            row = {"target": target, "reached": None}
        print_row({"scene": Path(name).stem, "away": options.away, **row})


if __name__ == "__main__":
    main()
