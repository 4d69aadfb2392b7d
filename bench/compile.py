"""How long a render waits for its OpenCL kernels: without any cache, from ours, from the driver's; by kernel.

    python -m bench.compile [SCENE.npz ...] [--device opencl] [--precision strict] [--rounds 3]

Each time is that of a process of its own, from an open device to kernels that have run once. Rounds go
in turn through
  cold      no cache holds anything (first use of the driver's compiler included)
  ours      isophote.kernel_cache holds the kernels, the driver's cache is empty
  driver    the driver's cache holds them, ours is off
  uncached  the driver's cache is switched off as well, where it has a switch
Drivers' caches are put into empty folders (POCL_CACHE_DIR, CUDA_CACHE_PATH); of other drivers they stay as
they are. `kernels` are seconds of compiling the program with one kernel alone and of reading its
binary, under a text that no cache knows; `nothing` is the program with none. Without scenes: those of
tests/parity/scenes, from the simplest to the one with the most closures. Prints a row of JSON for each
scene. Needs no Blender.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time
import uuid
from pathlib import Path

import numpy as np

from bench.common import ROOT, in_turn, medians, print_row
from isophote.device import open_device
from isophote.kernel_build import KernelBuild, program_binary
from isophote.opencl import build_options, kernel_source
from isophote.prepare import Prepared, prepare
from isophote.records import feature_names
from isophote.scene import load_scene
from isophote.settings import Settings
from isophote.validate import clean

SWITCHED_OFF = {"ISOPHOTE_KERNEL_CACHE": "off", "POCL_KERNEL_CACHE": "0", "CUDA_CACHE_DISABLE": "1"}


def prepared_scene(name: str) -> Prepared:
    """Of a file, or of a name of tests/parity/scenes."""
    if name.endswith(".npz"):
        return prepare(clean(load_scene(Path(name)))[0])
    from tests.parity.scenes import SCENES

    return prepare(clean(SCENES[name]())[0])


def folders(base: Path, ours: str, drivers: str) -> dict[str, str]:
    """The environment of a process whose caches lie in these folders of `base`."""
    made = {"ISOPHOTE_KERNEL_CACHE": str(base / ours), "POCL_CACHE_DIR": str(base / drivers / "pocl"),
            "CUDA_CACHE_PATH": str(base / drivers / "cuda")}
    for folder in made.values():
        Path(folder).mkdir(parents=True, exist_ok=True)
    return made


def child(scene: str, options, environment: dict[str, str]) -> dict:
    """What `--child` prints, of a process with this environment."""
    command = [sys.executable, "-m", "bench.compile", scene, "--child", "--device", options.device,
               "--precision", options.precision]
    done = subprocess.run(command, cwd=ROOT, env={**os.environ, **environment}, stdout=subprocess.PIPE, text=True,
                          check=True)
    return json.loads(done.stdout.splitlines()[-1])


def compile_once(scene: str, options) -> dict:
    """The child's work: prepare the scene, open the device, upload."""
    prepared = prepared_scene(scene)
    settings = Settings(device=options.device, precision=options.precision, passes=("combined",))
    started = time.perf_counter()
    device = open_device(options.device, settings)
    opened = time.perf_counter() - started
    device.upload(prepared)
    row = {"seconds": device.compile_seconds, "opening": opened, "from": device.kernels_from, "name": device.name,
           "driver": device.driver}
    device.close()
    return row


def measure(scene: str, options) -> dict:
    """The row of one scene."""
    with tempfile.TemporaryDirectory(prefix="isophote_compile_") as folder:
        base = Path(folder)
        filled = child(scene, options, folders(base, "ours", "drivers"))
        number = iter(range(10**6))

        def fresh(ours: str | None = None, drivers: str | None = None) -> dict[str, str]:
            return folders(base, ours or f"ours{next(number)}", drivers or f"drivers{next(number)}")

        ways = {"cold": fresh, "ours": lambda: fresh(ours="ours"),
                "driver": lambda: fresh(drivers="drivers") | {"ISOPHOTE_KERNEL_CACHE": "off"},
                "uncached": lambda: fresh() | SWITCHED_OFF}
        rows: dict[str, list[dict]] = {name: [] for name in ways}

        def timed(name: str) -> float:
            rows[name].append(child(scene, options, ways[name]()))
            return rows[name][-1]["seconds"]

        seconds = in_turn({name: lambda name=name: timed(name) for name in ways}, options.rounds)
        from_cache = all(row["from"] == "cache" for row in rows["ours"])
        entries = [path.stat().st_size for path in (base / "ours").iterdir()]
    return {"device": filled["name"], "driver_name": filled["driver"], "first": round(filled["seconds"], 4),
            **medians(seconds), "opening": medians({"s": [row["opening"] for row in rows["ours"]]})["s"],
            "ours_came_from_cache": from_cache, "entry_bytes": max(entries, default=0)}


def only_kernel(source: str, name: str) -> str:
    """The source without the bodies of all kernels but one."""
    kept, at = [], 0
    for match in re.finditer(r"__kernel\b[^;{]*?\bvoid (\w+)\(", source):
        depth, end = 0, source.index("{", match.end())
        while True:
            depth += {"{": 1, "}": -1}.get(source[end], 0)
            end += 1
            if depth == 0:
                break
        kept.append(source[at:match.start()])
        if match.group(1) == name:
            kept.append(source[match.start():end])
        at = end
    return "".join(kept) + source[at:]


def kernel_names(source: str) -> list[str]:
    return re.findall(r"__kernel\b[^;{]*?\bvoid (\w+)\(", source)


def time_kernels(scene: str, options) -> dict[str, float]:
    """Seconds by kernel, each alone; "nothing" is the program without any."""
    prepared = prepared_scene(scene)
    settings = Settings(device=options.device, precision=options.precision)
    device, source = open_device(options.device, settings), kernel_source()
    flags = build_options(device.device, settings, prepared)

    def built(text: str) -> KernelBuild:
        unique = f"typedef int made_{uuid.uuid4().hex};"  # PoCL's cache looks behind the preprocessor: no comment
        return KernelBuild(device.cl, device.context, device.device, f"{text}\n{unique}\n", flags, None)

    def compiled(name: str) -> float:
        started = time.perf_counter()
        build = built(only_kernel(source, name))
        if name:
            device.cl.Kernel(build.program, name)
            program_binary(device.cl, build.program)
        return time.perf_counter() - started

    # Of kernels only, that this scene's program has. This also starts the compiler.
    names = built(source).program.get_info(device.cl.program_info.KERNEL_NAMES).split(";")
    names = [name for name in kernel_names(source) if name in names]
    found = in_turn({name or "nothing": lambda name=name: compiled(name) for name in ["", *names]}, options.rounds)
    device.close()
    return medians(found)


def parsed() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="bench.compile", description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--device", default="opencl")
    parser.add_argument("--precision", default="strict")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    return parser.parse_args()


def main() -> None:
    options = parsed()
    if options.child:
        print_row(compile_once(options.scenes[0], options))
        return
    if not options.scenes:
        from tests.parity.scenes import SCENES

        options.scenes = list(SCENES)
    for scene in options.scenes:
        prepared = prepared_scene(scene)
        used = [name for name, is_used in feature_names(prepared.features).items() if is_used]
        print_row({"scene": Path(scene).stem, "precision": options.precision, "features": used,
                   "operations": len(np.unique(prepared.buffers["instructions"]["op"])), **measure(scene, options),
                   "kernels": time_kernels(scene, options)})


if __name__ == "__main__":
    main()
