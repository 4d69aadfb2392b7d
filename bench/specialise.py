"""What it is worth to compile, upload and run only what a scene uses: time, memory and compile time with and without.

    python -m bench.specialise SCENE.npz|FOLDER ... [--devices openmp,opencl] [--samples 16] [--rounds 3]

"Without" are the same kernels with every feature and every operation, and the arrays that they then read: a slot for
each triangle, the albedo tables. Both render the same frame in turn, after a first time; `speed` is the median of
samples a second with, over those without. `compile` is what kernels take from the driver's compiler, in a process of
their own without any cache. `same_bits` says whether the two sums are equal. Of a folder all scenes are measured.
Prints a row of JSON for each scene and device. Needs no Blender.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from bench.common import ROOT, in_turn, medians, print_row, seconds_of
from bench.compile import SWITCHED_OFF
from isophote.device import open_device
from isophote.kernel_build import KernelBuild
from isophote.materials import OPERATIONS, closure_mask
from isophote.prepare import Prepared, loaded_albedo_tables, prepare
from isophote.records import feature_names, numbers
from isophote.scene import load_scene
from isophote.schedule import WorkItem
from isophote.settings import Settings
from isophote.validate import clean

# Features that a scene has only with arrays that others lack.
WANTING = ("WORLD", "WORLD_LIGHT", "WORLD_SUN", "SHINES", "CAMERA_MOTION", "MOTION", "DEFORMATION", "LINKING",
           "TERMINATOR")


def generalised(prepared: Prepared) -> Prepared:
    """The same scene for kernels that know everything; what the scene would have to have for it stays out."""
    n = numbers()
    features = sum(bit for name, bit in n.items() if name.startswith("FEATURE_"))
    wanting = [n[f"FEATURE_{name}"] for name in WANTING]
    if not len(prepared.buffers["lights"]):
        wanting.append(n["FEATURE_LIGHTS"])
    features &= prepared.features | ~sum(wanting)
    world = prepared.buffers["world"].copy()
    world["features"] = features
    slots = prepared.buffers["slots"]
    if not len(slots):
        slots = np.zeros(prepared.buffers["indices"].size // 3, slots.dtype)
    buffers = prepared.buffers | {"world": world, "slots": slots, "albedo_tables": loaded_albedo_tables()}
    operations = closure_mask(number for number, _ in OPERATIONS.values())
    return replace(prepared, buffers=buffers, features=features, operations=operations)


def measure(prepared: Prepared, spec: str, samples: int, rounds: int) -> dict:
    """One row: one device, the scene as it is and generalised."""
    ways = {"with": prepared, "without": generalised(prepared)}
    width, height = prepared.resolution
    settings = Settings(device=spec, passes=("combined",))
    item = WorkItem((0, 0, width, height), 0, samples)
    devices = {way: open_device(spec, settings) for way in ways}
    sums = {way: np.zeros((numbers()["PLANES_COMBINED"], height, width), np.float32) for way in ways}
    try:
        for way, device in devices.items():
            if device.kind == "opencl":  # starts the driver's compiler: who is first would pay for it
                KernelBuild(device.cl, device.context, device.device, "__kernel void nothing() {}", [], None)
            device.upload(ways[way])
            device.render(item, settings, sums[way], lambda: False)
        same = bool((sums["with"].view(np.uint32) == sums["without"].view(np.uint32)).all())

        def timed(way: str) -> float:
            return seconds_of(lambda: devices[way].render(item, settings, sums[way], lambda: False))

        seconds = in_turn({way: lambda way=way: timed(way) for way in ways}, rounds)
        speeds = [without / alone for alone, without in zip(seconds["with"], seconds["without"], strict=True)]
        left_out = [name for name, used in feature_names(prepared.features).items() if not used]
        return {"left_out": left_out, "operations": prepared.operations.bit_count(), "device": spec,
                "name": devices["with"].name, "driver": devices["with"].driver,
                "speed": round(statistics.median(speeds), 3), "speed_min": round(min(speeds), 3),
                "speed_max": round(max(speeds), 3), "seconds": medians(seconds),
                "compile": {way: round(device.compile_seconds, 2) for way, device in devices.items()},
                "scene_bytes": {way: sum(ways[way].traced_sizes().values()) if device.kind == "opencl"
                                else sum(array.nbytes for array in ways[way].buffers.values())
                                for way, device in devices.items()},
                "same_bits": same}
    finally:
        for device in devices.values():
            device.close()


def measured_alone(scene: Path, spec: str, options) -> dict:
    """The row of a process without kernel caches; PoCL keeps an empty one, else it compiles for every launch."""
    command = [sys.executable, "-m", "bench.specialise", str(scene), "--child", "--devices", spec,
               "--samples", str(options.samples), "--rounds", str(options.rounds)]
    with tempfile.TemporaryDirectory(prefix="isophote_specialise_") as folder:
        environment = os.environ | SWITCHED_OFF | {"POCL_KERNEL_CACHE": "1", "POCL_CACHE_DIR": folder}
        done = subprocess.run(command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


def main() -> None:
    parser = argparse.ArgumentParser(prog="bench.specialise", description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="+", type=Path)
    parser.add_argument("--devices", default="openmp,opencl")
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child:
        print_row(measure(prepare(clean(load_scene(options.scenes[0]))[0]), options.devices, options.samples,
                          options.rounds))
        return
    for given in options.scenes:
        for path in sorted(given.glob("*.npz")) if given.is_dir() else [given]:
            for spec in options.devices.split(","):
                print_row({"scene": path.stem, **measured_alone(path.resolve(), spec, options)})


if __name__ == "__main__":
    main()
