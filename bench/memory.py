"""Bytes a triangle: what is held while the CPU or an OpenCL device renders, what building takes, what Cycles holds.

    python -m bench.memory [SCENE.npz|SCENE.blend ...] [--device opencl]

`cpu` is all that a render of a still on the CPU holds of the scene, each array once: what shading reads (`meshes` of
it in vertices, indices, normals and slots) and the CPU's `tree`; the scene's own arrays are gone by then but for those
that are read as they are. `resident` is what the process has grown by from before the scene was loaded until a sample
of 64 x 64 pixels is rendered: also code, film and paths. `device`
is what the OpenCL device holds of the scene, `device_host` what the host keeps meanwhile. `peak` is the most that
preparing and building took, with the loaded scene (Linux).
`cycles` and `cycles_peak` are what Cycles itself says on its CPU ("Mem", with Embree's tree), for .blend
files where there is a bpy. Paths and film go with the picture, not with the scene, and are left out of all but
Cycles', of which they are a few megabytes at 64 pixels. Prints a row of JSON for each scene.
"""

from __future__ import annotations

import argparse
import ctypes
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
from isophote.device import DeviceError
from isophote.scene import Scene, load_scene, resized
from isophote.session import Session
from isophote.settings import Settings

MIB = 1 << 20


def resident(name: str) -> int:
    """VmRSS or VmHWM of this process in bytes."""
    with open("/proc/self/status") as file:
        return int(re.search(name + r":\s+(\d+)", file.read()).group(1)) << 10


def trimmed() -> int:
    """VmRSS once the C library has given back what is free."""
    ctypes.CDLL(None).malloc_trim(0)
    return resident("VmRSS")


def rendering(scene: Scene, spec: str) -> tuple[Session, dict[str, int]]:
    """A session that has rendered a sample, and what it holds in bytes by name."""
    session = Session(resized(scene, (64, 64)), Settings(device=spec, samples=1, wait_for_kernels=True))
    session.run()
    assert session.scene_hash  # the scene's arrays are gone
    geometry = session.prepared.geometry.bytes
    return session, {"meshes": geometry["meshes"], **session.device.memory, "bvh2": geometry["bvh2"],
                     "host": sum(array.nbytes for array in session.prepared.buffers.values()) + geometry["bvh2"]
                     + geometry["wide_tree"]}


def measure(path: Path, spec: str) -> dict:
    """What we hold, in bytes; in a process of its own, so that the peak is this scene's."""
    empty = trimmed()
    scene = load_scene(path)
    row, loaded = {"triangles": len(scene.triangles)}, sum(array.nbytes for array in scene.arrays.values())
    before = trimmed()
    Path("/proc/self/clear_refs").write_text("5")  # the peak counts from here
    session, held = rendering(scene, "openmp")
    row |= {"peak": resident("VmHWM") - before + loaded, "meshes": held["meshes"], "tree": held["tree"],
            "cpu": held["host"]}
    del scene
    row["resident"] = trimmed() - empty
    session.close()
    try:
        session, held = rendering(load_scene(path), spec)
        row |= {"device_name": session.device.name, "device": held["scene"], "device_host": held["host"]}
        session.close()
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
    names = ("meshes", "tree", "cpu", "resident", "device", "device_host", "peak", "cycles",
             "cycles_peak")
    each = {f"{name}_a_triangle": round(held[name] / triangles, 1) for name in names if name in held}
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
