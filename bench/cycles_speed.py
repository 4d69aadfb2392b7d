"""Samples a second of Isophote's OpenMP device and of Cycles on the CPU, in turn in one run.

    python -m bench.cycles_speed [FILE.blend ...] [--samples 8] [--rounds 3] [--threads 0]

Both keep the scene and its tree; each round times Cycles, Isophote, Cycles, Isophote, ..., so that a
change of the machine's load meets both. Cycles' time is that of its last samples only, the difference
of two renders of WARM and WARM + samples: what Blender does around a frame falls out. Isophote's is
Device.render, which has nothing around it. On a shared machine trust the median of the rounds' ratios,
not the seconds. Without files: cornell, monkeys, glassbox, at their own 720x720.
Prints a row of JSON for each scene.
"""

from __future__ import annotations

import argparse
import os
import statistics
import tempfile
from dataclasses import replace
from pathlib import Path

from bench.common import in_turn, print_row, seconds_of
from bench.cycles_process import Cycles, exported, same_settings
from bench.replicates import render_film, uploaded
from bench.scenes import made_scenes
from isophote.openmp import processor_name

WARM = 1  # samples of the shorter of Cycles' two renders


def cycles_seconds(cycles: Cycles, samples: int, seed: int) -> float:
    """Time of `samples` samples without what is around them."""
    seconds = cycles.seconds(WARM + samples, seed) - cycles.seconds(WARM, seed)
    if seconds <= 0.0:
        raise RuntimeError("Cycles took no longer for more samples: it did not render them, or the machine is too busy")
    return seconds


def time_scene(blend: Path, samples: int, rounds: int, threads: int) -> dict:
    with Cycles(blend, threads=threads) as cycles:
        settings = same_settings(cycles.info, samples=samples, threads=threads)
        scene = exported(blend, tuple(cycles.info["size"]))
        with uploaded(scene, settings) as device:
            cycles.seconds(WARM, 0)  # builds its tree
            render_film(device, scene, replace(settings, samples=1))
            seeds = iter(range(1, 2 * rounds + 1))
            times = in_turn({
                "cycles": lambda: cycles_seconds(cycles, samples, next(seeds)),
                "isophote": lambda: seconds_of(
                    lambda: render_film(device, scene, replace(settings, seed=next(seeds))))}, rounds)
            driver = device.driver
            pixels = int(scene.resolution[0]) * int(scene.resolution[1])
            traced = device.rays / ((samples * rounds + 1) * pixels)
            rays = {"paths": float(traced[0]), "shadow": float(traced[1])}
    count = samples * pixels
    ratios = [theirs / ours for theirs, ours in zip(times["cycles"], times["isophote"], strict=True)]
    theirs, ours = (statistics.median(times[engine]) for engine in ("cycles", "isophote"))
    return {
        "scene": blend.stem,
        "size": cycles.info["size"],
        "samples": samples,
        "rounds": rounds,
        "threads": threads,
        "ratio_median": statistics.median(ratios),
        "ratio_min": min(ratios),
        "ratio_max": max(ratios),
        "isophote_samples_per_second": count / ours,
        "cycles_samples_per_second": count / theirs,
        "bounces": cycles.info["bounces"],
        "rays_per_sample": rays,  # Isophote's; Cycles does not count
        "load": os.getloadavg()[0],
        "processor": processor_name(),
        "isophote": driver,
        "cycles": f"Blender {cycles.info['version']}",
    }


def main() -> None:
    parser = argparse.ArgumentParser(prog="bench.cycles_speed", description="Isophote's and Cycles' samples a second.")
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--samples", type=int, default=8)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", type=int, default=0, help="of both; 0: all")
    parser.add_argument("--made", type=Path, help="folder that holds or gets the scenes of make_bench_scenes.py")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for blend in options.files or made_scenes(options.made or Path(folder)):
            row = time_scene(blend, options.samples, options.rounds, options.threads or os.cpu_count() or 1)
            print_row(row)


if __name__ == "__main__":
    main()
