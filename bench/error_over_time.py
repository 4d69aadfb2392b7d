"""Error over samples and over time of Isophote's OpenMP device and of Cycles on the CPU, against a long reference.

    python -m bench.error_over_time [FILE.blend ...] [--size 128] [--samples 4,8,16,32,64,128] [--seeds 4]
                                    [--reference 4096] [--rounds 3] [--cache FOLDER]

relMSE is the mean over pixels and channels of (x - r)^2 / (r^2 + 0.01 mean(r)^2). The reference r is the
plain mean of a long render of each engine, which first have to agree (bench/replicates.py); it is made of
pieces with seeds that no test picture has, and what their spread says of its own noise is taken off the
relMSE. No adaptive sampling, denoising, clamping or filtered glossy; bounce limits are the file's for both.

Time is samples times seconds a sample, timed as in bench/cycles_speed.py (in turn, at the file's own size,
without loading and tree). `samples_ratio` is how many samples Cycles needs for the error that Isophote
has, over Isophote's, by interpolation of the logarithms; `time_ratio` the same for seconds.
`rays_per_sample` are Isophote's, counted: rays of paths and shadow rays. Cycles has no such counter; its
roulette lets at most as much live on as ours (the root of the throughput from the second bounce on, against
twice the throughput) and decides once it has traced the ray.
--cache keeps references, Cycles' pictures and nothing of Isophote's but its reference: empty it where a
change was meant to change pictures' means. --rounds 0 leaves time out. Prints a row of JSON for each scene.
"""

from __future__ import annotations

import argparse
import json
import os
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from bench.cycles_process import Cycles, exported, same_settings
from bench.cycles_speed import time_scene
from bench.replicates import mean_and_variance, mean_ratios, render_film, uploaded
from bench.scenes import made_scenes
from isophote.passes import PASSES

PIECE = 256  # samples of one of the references' pieces
FIRST_SEED = 1000  # of the references; test pictures have 1, 2, ...
FLOOR = 0.01  # of the mean's square, added to the denominator
FIREFLIES = 0.001  # share of the largest errors that `trimmed` leaves out

Render = Callable[[int, int], np.ndarray]  # samples, seed: float32 (h, w, 3)


def kept(folder: Path, name: str, make: Callable[[], np.ndarray]) -> np.ndarray:
    """An array from the cache, or made and put there."""
    path = folder / f"{name}.npy"
    if not path.exists():
        np.save(path, make())
    return np.load(path)


def pieces_of(render: Render, samples: int) -> np.ndarray:
    """A long render as pieces of their own seeds, (K, h, w, 3)."""
    return np.stack([render(PIECE, FIRST_SEED + k) for k in range(samples // PIECE)])


def relative_errors(pictures: np.ndarray, reference: np.ndarray, noise: np.ndarray) -> dict:
    """relMSE of (K, h, w, 3), its noise-free part; `trimmed` without the FIREFLIES largest of it."""
    below = reference ** 2 + FLOOR * reference.mean() ** 2
    errors = ((pictures - reference) ** 2 - noise) / below
    ordered = np.sort(errors.mean(axis=-1).reshape(len(pictures), -1), axis=1)
    most = ordered.shape[1] - int(FIREFLIES * ordered.shape[1])
    return {"mean": float(ordered.mean()), "trimmed": float(ordered[:, :most].mean())}


def samples_needed(errors: list[float], counts: list[int], error: float) -> float | None:
    """Samples at which an engine with these errors has `error`; None outside of what was rendered."""
    if not min(errors) <= error <= max(errors):
        return None
    order = np.argsort(errors)
    return float(np.exp(np.interp(np.log(error), np.log(np.array(errors)[order]), np.log(np.array(counts)[order]))))


def samples_ratio(ours: list[float], theirs: list[float], counts: list[int]) -> dict:
    """By our number of samples: Cycles' over ours at equal error; and `all`, their geometric mean."""
    ratios = {count: needed / count for count, error in zip(counts, ours, strict=True)
              if (needed := samples_needed(theirs, counts, error)) is not None}
    mean = float(np.exp(np.mean(np.log(list(ratios.values()))))) if ratios else None
    return {str(count): ratio for count, ratio in ratios.items()} | {"all": mean}


def measure(blend: Path, options: argparse.Namespace, folder: Path) -> dict:
    counts = [int(n) for n in options.samples.split(",")]
    seeds = range(1, options.seeds + 1)
    name = f"{blend.stem}_{options.size}"
    with Cycles(blend, options.size) as cycles:
        info = cycles.info
        theirs = {n: kept(folder, f"{name}_cycles_{n}x{options.seeds}",
                          lambda n=n: np.stack([cycles.render(n, seed) for seed in seeds])) for n in counts}
        reference_cycles = kept(folder, f"{name}_reference_cycles_{options.reference}",
                                lambda: pieces_of(cycles.render, options.reference))
    settings = same_settings(info, samples=PIECE)
    scene = exported(blend, tuple(info["size"]))
    with uploaded(scene, settings) as device:
        def render(samples: int, seed: int) -> np.ndarray:
            film = render_film(device, scene, replace(settings, samples=samples, seed=seed))
            return PASSES["combined"].make(film)[..., :3]

        ours = {n: np.stack([render(n, seed) for seed in seeds]) for n in counts}
        rays = device.rays / (sum(counts) * len(seeds) * ours[counts[0]][0, ..., 0].size)
        reference_ours = kept(folder, f"{name}_reference_isophote_{options.reference}",
                              lambda: pieces_of(render, options.reference))
    (mean_a, var_a), (mean_b, var_b) = mean_and_variance(reference_ours), mean_and_variance(reference_cycles)
    reference, noise = (mean_a + mean_b) / 2, (var_a + var_b) / 4
    errors = {engine: [relative_errors(pictures[n], reference, noise) for n in counts]
              for engine, pictures in (("isophote", ours), ("cycles", theirs))}
    row = {"scene": blend.stem, "size": info["size"], "bounces": info["bounces"],
           "sampling_pattern": info["sampling_pattern"], "samples": counts, "seeds": options.seeds,
           "rays_per_sample": {"paths": float(rays[0]), "shadow": float(rays[1])},
           "reference_samples": [options.reference] * 2,
           "references_means": mean_ratios(reference_ours, reference_cycles),
           "reference_noise": relative_errors(noise[None] ** 0.5 + reference, reference, np.zeros_like(noise))["mean"]}
    for kind in ("mean", "trimmed"):
        a, b = ([error[kind] for error in errors[engine]] for engine in ("isophote", "cycles"))
        row |= {f"isophote_{kind}": a, f"cycles_{kind}": b, f"samples_ratio_{kind}": samples_ratio(a, b, counts),
                f"error_ratio_{kind}": [x / y for x, y in zip(a, b, strict=True)]}
    if options.rounds:
        speed = time_scene(blend, 8, options.rounds, os.cpu_count() or 1)
        row["speed"] = speed
        for kind in ("mean", "trimmed"):
            row[f"time_ratio_{kind}"] = {n: ratio and ratio * speed["ratio_median"]
                                         for n, ratio in row[f"samples_ratio_{kind}"].items()}
    return row


def main() -> None:
    parser = argparse.ArgumentParser(prog="bench.error_over_time", description="Error over time against Cycles.")
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--size", type=int, default=128, help="longer side in pixels")
    parser.add_argument("--samples", default="4,8,16,32,64,128", help="a pixel, of the test pictures")
    parser.add_argument("--seeds", type=int, default=4, help="test pictures of each engine and number of samples")
    parser.add_argument("--reference", type=int, default=4096, help="samples of each engine's reference")
    parser.add_argument("--rounds", type=int, default=3, help="of timing; 0: none")
    parser.add_argument("--cache", type=Path, help="folder of what is kept from run to run")
    parser.add_argument("--made", type=Path, help="folder that holds or gets the scenes of make_bench_scenes.py")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.cache or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for blend in options.files or made_scenes(options.made or Path(temporary)):
            print(json.dumps(measure(blend, options, folder)), flush=True)


if __name__ == "__main__":
    main()
