"""The benches that `python -m bench` runs, with what it gives them and how their rows are shown."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass

SCENES = "{scenes}"  # stands for exported scenes, .npz: cornell, monkeys, glassbox


@dataclass(frozen=True)
class Bench:
    """A program bench/NAME.py that prints rows of JSON.

    `needs`: "bpy" (a Python with that wheel), "opencl" (a driver), "scenes" (see SCENES). `columns` maps
    a table's headings to dotted paths in a row; without them every plain value is shown. `pivot` is
    (path of the line, format of the heading, path of the value): one line for each scene, say, with a
    column for each device.
    """

    name: str
    what: str
    arguments: tuple[str, ...] = ()
    quick: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
    columns: dict[str, str] | None = None
    pivot: tuple[str, str, str] | None = None

    @property
    def exists(self) -> bool:
        return importlib.util.find_spec(f"bench.{self.name}") is not None


BENCHES = {bench.name: bench for bench in (
    Bench("build", "building trees: triangles a second"),
    Bench("rays", "rays a second by kind, against Embree"),
    Bench("compile", "OpenCL kernels: from a compiler and from caches", quick=("cornell_like", "--rounds", "1"),
          needs=("opencl",),
          columns={"scene": "scene", "device": "device", "operations": "operations", "cold, s": "cold",
                   "our cache": "ours", "driver's cache": "driver", "uncached": "uncached",
                   "entry, bytes": "entry_bytes", "generate": "kernels.generate", "extend": "kernels.extend",
                   "shade": "kernels.shade", "connect": "kernels.connect", "accumulate": "kernels.accumulate"}),
    Bench("export", "exporting scenes from Blender", needs=("bpy",)),
    Bench("device_speed", "samples a second of devices",
          (SCENES, "--devices", "openmp,opencl", "--precisions", "strict,fast"),
          (SCENES, "--devices", "openmp", "--samples", "2", "--rounds", "1"), ("scenes",),
          pivot=("scene", "{device} {precision} {threads}", "msamples_per_second")),
    Bench("cycles_speed", "samples a second against Cycles on the CPU", quick=("--samples", "2", "--rounds", "1"),
          needs=("bpy",),
          columns={"scene": "scene", "Isophote / Cycles, median": "ratio_median", "lowest": "ratio_min",
                   "highest": "ratio_max", "threads": "threads", "samples": "samples"}),
    Bench("error_over_time", "error over time against Cycles", quick=("--reference", "512", "--rounds", "1"),
          needs=("bpy",)),
    Bench("cycles_compare", "pictures against Cycles: means, tiles, pixels, noise", ("--report", "docs/comparison"),
          ("--size", "64", "--replicates", "4"), ("bpy",),
          columns={"scene": "scene", "noise, mean of pixels": "noise.mean", "median pixel": "noise.median",
                   "agrees": "agrees"}),
    Bench("parity", "the same bits: devices, threads, splits, resuming",
          (SCENES, "--devices", "openmp,opencl", "--size", "32x32", "--samples", "1024"),
          (SCENES, "--devices", "openmp", "--size", "16x16", "--samples", "64"), ("scenes",),
          columns={"scene": "scene", "device": "name", "threads": "threads", "split": "split", "resumed": "resumed",
                   "equal": "equal", "verdict": "verdict"}),
    Bench("study", "the founding report's experiments"),
)}
