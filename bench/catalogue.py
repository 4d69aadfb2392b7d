"""The benches that `python -m bench` runs, with what it gives them and how their rows are shown."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass

# In arguments: exported scenes (.npz: cornell, monkeys, glassbox), and the folder in which scenes lie or are made.
SCENES, FOLDER = "{scenes}", "{folder}"
MADE = ("--made", FOLDER)
STUDY = "docs/study/rows"


@dataclass(frozen=True)
class Bench:
    """A program bench/NAME.py that prints rows of JSON.

    `needs`: "bpy" (a Python with that wheel), "opencl" (a driver), "scenes" (see SCENES), "own scenes"
    (those of blend_scenes, exported into FOLDER). `columns` maps a table's headings to dotted paths in a
    row; without them every plain value is shown. `pivot` is (path of the line, format of the heading,
    path of the value): one line for each scene, say, with a column for each device. A bench with `then`,
    the arguments of a second run, keeps its rows itself and makes a page of its own.
    """

    name: str
    what: str
    arguments: tuple[str, ...] = ()
    quick: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
    columns: dict[str, str] | None = None
    pivot: tuple[str, str, str] | None = None
    then: tuple[str, ...] = ()

    @property
    def exists(self) -> bool:
        return importlib.util.find_spec(f"bench.{self.name}") is not None


BENCHES = {bench.name: bench for bench in (
    Bench("build", "building trees: triangles a second, beside Embree's builders",
          quick=("--counts", "100000", "--rounds", "1"),
          columns={"scene": "scene", "triangles": "triangles", "builder": "builder", "threads": "threads",
                   "million triangles/s": "mtriangles_per_second", "boxes, s": "stages.boxes", "split": "stages.split",
                   "join": "stages.join", "collapse": "stages.collapse", "expected cost": "sah", "depth": "depth"}),
    Bench("rays", "rays a second by kind, against Embree",
          quick=("--triangles", "100000", "--rays", "65536", "--rounds", "1"),
          columns={"scene": "scene", "triangles": "triangles", "rays": "kind", "against": "against",
                   "ours / Embree": "ratio", "lowest": "ratio_min", "highest": "ratio_max",
                   "single rays": "ratio_single", "ours, Mrays/s": "isophote_mrays",
                   "packets": "isophote_packet_mrays", "Embree": "embree_mrays", "its packets": "embree_packet_mrays",
                   "hits that differ": "differ"}),
    Bench("compile", "OpenCL kernels: from a compiler and from caches", quick=("cornell_like", "--rounds", "1"),
          needs=("opencl",),
          columns={"scene": "scene", "device": "device", "operations": "operations", "cold, s": "cold",
                   "our cache": "ours", "driver's cache": "driver", "uncached": "uncached",
                   "entry, bytes": "entry_bytes", "generate": "kernels.generate", "extend": "kernels.extend",
                   "shade": "kernels.shade", "connect": "kernels.connect", "accumulate": "kernels.accumulate"}),
    Bench("memory", "bytes a triangle, ours and Cycles'", MADE, needs=("bpy",),
          columns={"scene": "scene_name", "triangles": "triangles", "meshes": "meshes_a_triangle",
                   "CPU's tree": "tree_a_triangle", "CPU, all": "cpu_a_triangle", "peak of building": "peak_a_triangle",
                   "OpenCL device": "device_a_triangle", "Cycles (CPU)": "cycles_a_triangle",
                   "its peak": "cycles_peak_a_triangle"}),
    Bench("export", "from Blender's scene to the first sample: seconds by stage, first and next frames",
          ("--folder", FOLDER), ("--folder", FOLDER, "--scenes", "flat", "--triangles", "20000", "--rounds", "1"),
          ("bpy",)),
    Bench("frames", "frames in which only the camera moved: seconds by what is kept from the frame before",
          (SCENES, "--devices", "openmp,opencl"),
          (SCENES, "--devices", "openmp", "--size", "64x48", "--frames", "2", "--rounds", "1"), ("scenes",),
          columns={"scene": "scene", "device": "device", "kept": "kept", "prepare, s": "prepare", "upload": "upload",
                   "sample": "sample", "until the picture": "total"}),
    Bench("device_speed", "samples a second of devices",
          (SCENES, "--devices", "openmp,opencl", "--precisions", "strict,fast"),
          (SCENES, "--devices", "openmp", "--samples", "2", "--rounds", "1"), ("scenes",),
          pivot=("scene", "{device} {precision} {threads}", "msamples_per_second")),
    Bench("scaling", "samples a second over threads, beside processes that share nothing", (SCENES,),
          (SCENES, "--threads", "1,2", "--rounds", "1", "--seconds", "0.05", "--side", "64"), ("scenes",),
          columns={"scene": "scene", "threads": "threads", "Msamples/s": "msamples_per_second",
                   "processes": "control_msamples_per_second", "scaling": "scaling",
                   "of processes": "control_scaling", "efficiency": "efficiency", "lowest": "efficiency_min",
                   "highest": "efficiency_max", "threads a core": "threads_per_core", "MHz": "mhz"}),
    Bench("device_rays", "closest hits a second of an OpenCL device, in rooms of many triangles",
          quick=("--triangles", "3000", "--samples", "1", "--rounds", "1"), needs=("opencl",),
          columns={"triangles": "triangles", "device": "name", "camera, Grays/s": "grays_per_second.primary",
                   "bounce 1": "grays_per_second.bounce 1", "bounce 2": "grays_per_second.bounce 2",
                   "all after the camera's": "grays_per_second.diffuse"}),
    Bench("cycles_speed", "samples a second against Cycles on the CPU", MADE,
          (*MADE, "--samples", "2", "--rounds", "1"), needs=("bpy",),
          columns={"scene": "scene", "Isophote / Cycles, median": "ratio_median", "lowest": "ratio_min",
                   "highest": "ratio_max", "threads": "threads", "samples": "samples"}),
    Bench("error_over_time", "error over time against Cycles", MADE,
          (*MADE, "--reference", "512", "--samples", "4,8", "--seeds", "2", "--rounds", "1"), ("bpy",),
          columns={"scene": "scene", "samples": "samples", "error, ours / Cycles'": "error_ratio_mean",
                   "without fireflies": "error_ratio_trimmed", "speed, ours / Cycles'": "speed.ratio_median",
                   "time to equal error, Cycles' / ours": "time_ratio_mean",
                   "without its fireflies": "time_ratio_trimmed"}),
    Bench("coverage", "how often what a render says of its own error is true", (SCENES, "--rare"),
          (SCENES, "--rare", "--seeds", "3", "--samples", "16,64"), ("scenes",),
          columns={"scene": "scene", "samples": "samples", "tiles that hold": "tiles", "unsure": "unsure",
                   "wrong of the others": "wrong", "pixels that hold": "pixels", "error of 95 %": "error",
                   "claimed / measured": "claimed", "lowest": "claimed_low", "highest": "claimed_high"}),
    Bench("error_target", "whether renders with a wanted error reach it, and what stopping for it does to the picture",
          (SCENES,), (SCENES, "--targets", "50", "--seeds", "3", "--reference", "512"), ("scenes",),
          columns={"scene": "scene", "wanted": "target", "samples": "samples", "fewest": "samples_low",
                   "most": "samples_high", "reached / wanted": "reached", "lowest": "reached_low",
                   "highest": "reached_high", "bias, %": "bias", "+-": "bias_95", "tiles off": "tiles_off",
                   "without a decision": "tiles_off_fixed"}),
    Bench("specialise", "kernels and arrays for what a scene uses, and for everything", (FOLDER,),
          (FOLDER, "--samples", "1", "--rounds", "1"), ("opencl", "scenes", "own scenes"),
          columns={"scene": "scene", "device": "device", "operations of 10": "operations", "left out": "left_out",
                   "speed, with / without": "speed", "compile, s": "compile.with", "without": "compile.without",
                   "scene, bytes": "scene_bytes.with", "bytes without": "scene_bytes.without",
                   "same bits": "same_bits"}),
    Bench("fast_bias", "what fast precision does to pictures: pairs with strict ones", (SCENES, "--rare"),
          (SCENES, "--pairs", "3", "--samples", "16"), ("scenes",),
          columns={"scene": "scene", "device": "device", "bias, %": "bias", "from": "low", "to": "high",
                   "within 0.05 %": "image", "tiles within 0.5 %": "tiles", "tiles beyond": "tiles_beyond",
                   "relMSE": "rel_mse", "noise": "noise"}),
    Bench("rounding", "what float32 does to pictures: strict ones against float64, sample by sample",
          (SCENES, "--rare"), (SCENES, "--samples", "16"), ("scenes",),
          columns={"scene": "scene", "noise": "noise", "rounding": "rounding", "noise / rounding": "ratio",
                   "samples turned": "turned", "their relMSE": "turns", "noise / all": "ratio_all", "bias, %": "bias",
                   "+-": "bias_95"}),
    Bench("cycles_compare", "pictures against Cycles: means, tiles, pixels, noise",
          (*MADE, "--report", "docs/comparison"),
          (*MADE, "--size", "64", "--replicates", "4"), ("bpy",),
          columns={"scene": "scene", "noise, mean of pixels": "noise.mean", "median pixel": "noise.median",
                   "agrees": "agrees"}),
    Bench("parity", "the same bits: devices, threads, splits, resuming",
          (SCENES, "--devices", "openmp,opencl", "--size", "32x32", "--samples", "1024"),
          (SCENES, "--devices", "openmp", "--size", "16x16", "--samples", "64"), ("scenes",),
          columns={"scene": "scene", "device": "name", "threads": "threads", "split": "split", "resumed": "resumed",
                   "equal": "equal", "verdict": "verdict"}),
    Bench("study", "the founding report's experiments", ("measure", "-o", STUDY, "--scenes", FOLDER),
          ("measure", "-o", "build/study", "--scenes", FOLDER, "--budget", "1"), ("opencl", "own scenes"),
          then=("draw", STUDY, "-o", "docs/study")),
)}
