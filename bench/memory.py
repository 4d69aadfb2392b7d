"""Bytes a triangle: what the CPU and an OpenCL device hold, what building takes, and what Cycles holds.

    python -m bench.memory [SCENE.npz|SCENE.blend ...] [--device opencl]

`scene` are the buffers that every device has, `tree` the CPU's own tree, `peak` the most that preparing
and building took beyond the loaded scene (Linux). `device` is what the OpenCL device holds of the scene.
`cycles` and `cycles_peak` are what Cycles itself says on its CPU ("Mem", with Embree's tree), for .blend
files where there is a bpy. Paths and film go with the picture, not with the scene, and are left out of all but
Cycles', of which they are a few megabytes at 64 pixels. Prints a row of JSON for each scene.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from bench.common import ROOT, print_row
from bench.cycles_process import Cycles, find_python
from bench.scenes import made_scenes
from isophote.blender_process import export_blend
from isophote.device import DeviceError, open_device
from isophote.prepare import prepare
from isophote.scene import load_scene
from isophote.settings import Settings
from isophote.validate import clean

MIB = 1 << 20


def resident(name: str) -> int:
    """VmRSS or VmHWM of this process in bytes."""
    with open("/proc/self/status") as file:
        return int(re.search(name + r":\s+(\d+)", file.read()).group(1)) << 10


def measure(path: Path, spec: str) -> dict:
    """What we hold, in bytes; in a process of its own, so that the peak is this scene's."""
    scene = clean(load_scene(path))[0]
    before = resident("VmRSS")
    Path("/proc/self/clear_refs").write_text("5")  # the peak counts from here
    prepared = prepare(scene)
    cpu = open_device("openmp", Settings())
    cpu.upload(prepared)
    row = {"triangles": len(scene.triangles), **cpu.memory, "peak": resident("VmHWM") - before}
    cpu.close()
    try:
        device = open_device(spec, Settings(device=spec))
        device.upload(prepared)
        row |= {"device_name": device.name, "device": device.memory["scene"]}
        device.close()
    except DeviceError as error:
        row["device_name"] = str(error)
    return row


def cycles_memory(blend: Path) -> dict[str, int]:
    """What Cycles said last of its memory, in bytes. Raises CyclesError."""
    with Cycles(blend, longest=64) as cycles:
        cycles.seconds(1, 0)
        said = re.findall(r"\| Mem:([\d.]+)M, Peak:([\d.]+)M \|", "".join(cycles.said))
    return {name: round(float(value) * MIB) for name, value in zip(("cycles", "cycles_peak"), said[-1], strict=True)}


def row_of(path: Path, spec: str) -> dict:
    """Bytes and bytes a triangle of one scene."""
    with tempfile.TemporaryDirectory(prefix="isophote_memory_") as folder:
        exported, held = path, {}
        if path.suffix == ".blend":
            exported, held = Path(folder) / "scene.npz", cycles_memory(path)
            export_blend(path, exported, blender=find_python())
        command = [sys.executable, "-m", "bench.memory", str(exported), "--child", "--device", spec]
        done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
    held = json.loads(done.stdout.splitlines()[-1]) | held
    triangles = held["triangles"]
    each = {f"{name}_a_triangle": round(held[name] / triangles, 1)
            for name in ("scene", "tree", "peak", "device", "cycles", "cycles_peak") if name in held}
    return {"scene_name": path.stem, **held, **each}


def main() -> None:
    parser = argparse.ArgumentParser(prog="bench.memory", description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", type=Path)
    parser.add_argument("--device", default="opencl")
    parser.add_argument("--made", type=Path, help="folder that holds or gets the scenes of make_bench_scenes.py")
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child:
        print_row(measure(options.scenes[0], options.device))
        return
    with tempfile.TemporaryDirectory() as folder:
        for path in options.scenes or made_scenes(options.made or Path(folder), ("monkeys",)):
            print_row(row_of(path, options.device))


if __name__ == "__main__":
    main()
