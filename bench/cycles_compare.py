"""Isophote against Cycles, picture against picture, as a statistical statement.

    python -m bench.cycles_compare [FILE.blend ...] [--size 160] [--samples 32] [--replicates 16] [--report FOLDER]

Each scene is rendered `replicates` times by each engine, with `samples` samples and another seed each
time; bench/replicates.py says what is computed from them. Without files all scenes of bench/scenes.py
are compared. Prints a row of JSON for each scene; --report writes README.md and pictures.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from bench.common import print_row
from bench.comparison_report import write_report
from bench.cycles_process import Cycles, exported, same_settings
from bench.replicates import compare_replicates, render_film, render_replicates, uploaded
from bench.scenes import ignis_box, made_scenes, own_scenes
from isophote.compare import differing_floats
from isophote.device import DeviceError
from isophote.openmp import processor_name
from isophote.passes import PASSES, with_catchers
from isophote.scene import Scene
from isophote.settings import Settings

OPENCL_SIZE, OPENCL_SAMPLES = 64, 4  # PoCL is slow: enough for bits


def render_both(blend: Path, longest: int, samples: int, replicates: int, over=None) -> dict:
    """Both engines' replicates (K, h, w, 3), "isophote" and "cycles", and what they were rendered from. `over`: a
    colour of the background, for films with alpha.

    "seconds": of each engine, from the file to the last picture.
    """
    started = time.perf_counter()
    with Cycles(blend, longest) as cycles:
        theirs = np.stack([cycles.render(samples, seed, over) for seed in range(replicates)])
        info = cycles.info
    between = time.perf_counter()
    settings = same_settings(info, samples=samples)
    scene = exported(blend, tuple(info["size"]))
    settings = with_catchers(settings, scene)
    ours = render_replicates(scene, settings, range(replicates), over)
    seconds = {"isophote": time.perf_counter() - between, "cycles": between - started}
    return {"isophote": ours, "cycles": theirs, "scene": scene, "settings": settings, "info": info, "seconds": seconds}


def same_bits(scene: Scene, settings: Settings) -> dict:
    """Floats of Combined that differ between OpenMP and the first OpenCL device, for a small version of the scene."""
    width, height = (int(n) for n in scene.resolution)
    scale = min(1.0, OPENCL_SIZE / max(width, height))
    size = np.array([max(1, round(width * scale)), max(1, round(height * scale))], np.int32)
    small = replace(scene, arrays=scene.arrays | {"resolution": size})
    pictures = []
    try:
        for name in ("openmp", "opencl"):
            asked = replace(settings, device=name, samples=OPENCL_SAMPLES)
            with uploaded(small, asked) as device:
                pictures.append({"Combined": PASSES["combined"].make(render_film(device, small, asked))})
                device_name = f"{device.name}, {device.driver}"
    except DeviceError as error:
        return {"why_not": str(error)}
    differing, compared, _ = differing_floats(*pictures)
    return {"device": device_name, "size": size.tolist(), "samples": OPENCL_SAMPLES, "differing": differing,
            "compared": compared}


def compare_scene(blend: Path, options: argparse.Namespace) -> tuple[dict, dict]:
    """The row of one scene, and its two pictures."""
    both = render_both(blend, options.size, options.samples, options.replicates)
    row = {
        "scene": blend.stem,
        "size": both["info"]["size"],
        "samples": options.samples,
        "replicates": options.replicates,
        "cycles": both["info"],
        "notes": both["scene"].notes,
        **compare_replicates(both["isophote"], both["cycles"]),
        "opencl": same_bits(both["scene"], both["settings"]),
        "processor": f"{processor_name()}, {os.cpu_count()} threads",
    }
    return row, {engine: both[engine].mean(axis=0) for engine in ("cycles", "isophote")}


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="bench.cycles_compare", description="Compare Isophote with Cycles.")
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--size", type=int, default=160, help="longer side in pixels, 0: the file's own size")
    parser.add_argument("--samples", type=int, default=32, help="of each replicate")
    parser.add_argument("--replicates", type=int, default=16)
    parser.add_argument("--report", type=Path, help="folder for README.md and the pictures")
    parser.add_argument("--made", type=Path, help="folder that holds or gets the scenes of make_bench_scenes.py")
    return parser.parse_args()


def main() -> int:
    options = parse()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        made = options.made or Path(folder)
        for blend in options.files or [*own_scenes(), *ignis_box(), *made_scenes(made)]:
            row, pictures = compare_scene(blend, options)
            print_row(row)
            rows.append(row)
            if options.report:
                write_report(options.report, row, pictures)
    return 0 if all(row["agrees"] for row in rows) else 1


if __name__ == "__main__":
    raise SystemExit(main())
