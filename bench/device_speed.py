"""Samples a second of devices, on scenes that are already exported.

    python -m bench.device_speed SCENE.npz ... [--devices openmp,opencl:0] [--precisions strict,fast]
                                 [--threads 1,2,16] [--samples 64] [--rounds 3] [--bounces 8]

One item of `samples` samples of the whole frame is rendered once to warm up and then `rounds` times; the
median counts. Threads multiply the rows of openmp only. Prints a row of JSON each: million camera
samples a second, seconds of preparing the scene and of compiling kernels. Needs no Blender.
"""

from __future__ import annotations

import argparse
import statistics
import time
from pathlib import Path

import numpy as np

from bench.common import print_row, seconds_of
from isophote.device import open_device
from isophote.prepare import prepare
from isophote.records import numbers
from isophote.scene import load_scene
from isophote.schedule import BLOCK, WorkItem
from isophote.settings import Settings
from isophote.validate import clean


def measure(prepared, settings: Settings, samples: int, rounds: int) -> dict:
    """One row: a device with one precision and number of threads, on one prepared scene."""
    device = open_device(settings.device, settings)
    try:
        device.upload(prepared)
        width, height = prepared.resolution
        sums = np.zeros((numbers()["PLANES_COMBINED"], height, width), np.float32)
        item = WorkItem((0, 0, width, height), 0, samples)
        seconds = [seconds_of(lambda: device.render(item, settings, sums, lambda: False)) for _ in range(1 + rounds)]
        speed = width * height * samples / statistics.median(seconds[1:]) / 1e6
        return {"name": device.name, "driver": device.driver, "strict": device.strict,
                "msamples_per_second": round(speed, 3), "seconds": [round(s, 4) for s in seconds[1:]],
                "compile_seconds": round(device.compile_seconds, 2)}
    finally:
        device.close()


def variants(devices: list[str], precisions: list[str], threads: list[int]):
    for device in devices:
        for precision in precisions:
            for count in threads if device == "openmp" else [0]:
                yield device, precision, count


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="+", type=Path)
    parser.add_argument("--devices", default="openmp")
    parser.add_argument("--precisions", default="strict")
    parser.add_argument("--threads", default="0", help="0: all cores")
    parser.add_argument("--samples", type=int, default=BLOCK)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--bounces", type=int, default=8, help="limit of every kind")
    options = parser.parse_args()
    limits = {f"{kind}_bounces": options.bounces for kind in ("max", "diffuse", "glossy", "transmission")}
    for path in options.scenes:
        started = time.perf_counter()
        prepared = prepare(clean(load_scene(path))[0])
        loading = round(time.perf_counter() - started, 2)
        for device, precision, threads in variants(options.devices.split(","), options.precisions.split(","),
                                                   [int(n) for n in options.threads.split(",")]):
            settings = Settings(device=device, precision=precision, threads=threads, **limits)
            row = measure(prepared, settings, options.samples, options.rounds)
            print_row({"scene": path.stem, "device": device, "precision": precision, "threads": threads,
                       "load_and_build_seconds": loading, **row})


if __name__ == "__main__":
    main()
