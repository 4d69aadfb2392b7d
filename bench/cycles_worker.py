# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles as a process: loads a .blend file once, then renders for each line of JSON on its input.

    python bench/cycles_worker.py FILE.blend LONGEST THREADS

It wants a Python with the bpy wheel; bench/cycles_process.py starts it. LONGEST is the longer side of
the picture in pixels, 0 for the file's own size.

Settings are the file's, but for those that would make Cycles biased (clamping, filtered glossy,
denoising, adaptive sampling) and those that Isophote has one kind of only (the pixel filter).
Prints lines of `ISOPHOTE-CYCLES {json}`: first what it renders, then an answer to each request
{"samples", "seed", "out"}: out names a .npy file, float32 RGBA (h, w, 4), rows from the bottom, or is null.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
from pathlib import Path

import bpy
import numpy as np

MARK = "ISOPHOTE-CYCLES "
BOUNCES = ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "volume_bounces",
           "transparent_max_bounces")
UNBIASED = {
    "use_adaptive_sampling": False,
    "use_denoising": False,
    "sample_clamp_direct": 0.0,
    "sample_clamp_indirect": 0.0,
    "blur_glossy": 0.0,
    "caustics_reflective": True,
    "caustics_refractive": True,
    "use_fast_gi": False,
    "light_sampling_threshold": 0.0,
    "pixel_filter_type": "BLACKMAN_HARRIS",
    "film_exposure": 1.0,
    "use_animated_seed": False,
    "use_sample_subset": True,
    "sampling_pattern": "TABULATED_SOBOL",
    "time_limit": 0.0,
}


def say(answer: dict) -> None:
    print(MARK + json.dumps(answer), flush=True)


def set_size(render, longest: int) -> list[int]:
    """Scale the picture to `longest` pixels; its width and height."""
    size = [side * render.resolution_percentage // 100 for side in (render.resolution_x, render.resolution_y)]
    if longest:
        size = [max(1, round(side * longest / max(size))) for side in size]
    render.resolution_x, render.resolution_y = size
    render.resolution_percentage = 100
    return size


def set_up(longest: int, threads: int) -> dict:
    """Make the scene ready; what is rendered, and which of the file's settings were changed."""
    scene = bpy.context.scene
    render, cycles = scene.render, scene.cycles
    render.engine, cycles.device = "CYCLES", "CPU"
    changed = {}
    for name, value in UNBIASED.items():
        if hasattr(cycles, name) and getattr(cycles, name) != value:
            changed[name] = getattr(cycles, name)
            setattr(cycles, name, value)
    render.use_border = render.use_multiview = render.use_compositing = render.use_sequencer = False
    render.threads_mode, render.threads = "FIXED", threads
    render.use_persistent_data = True  # the tree is built once, for the first request
    image = render.image_settings
    image.file_format, image.color_mode, image.color_depth, image.exr_codec = "OPEN_EXR", "RGBA", "32", "NONE"
    return {
        "version": bpy.app.version_string,
        "size": set_size(render, longest),
        "bounces": {name: getattr(cycles, name) for name in BOUNCES},
        "filter_width": cycles.filter_width,
        "film_transparent": render.film_transparent,
        "sampling_pattern": cycles.sampling_pattern,
        "changed": changed,
    }


def picture(folder: str) -> np.ndarray:
    """The render result, through a float EXR: in the background it has no pixels of its own."""
    path = str(Path(folder) / "picture.exr")
    bpy.data.images["Render Result"].save_render(path)
    image = bpy.data.images.load(path)
    width, height = image.size
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, -1)


def answer(request: dict, folder: str) -> dict:
    """Render one request. `seconds` holds everything that Blender does for a frame: take differences.

    Cycles sends its sample number 0 through the pixel's centre instead of drawing from the filter
    (integrate_camera_sample in src/kernel/integrator/init_from_camera.h), a bias of order 1 / samples
    at edges; so we take samples [n, 2n) of its sequence.
    """
    cycles = bpy.context.scene.cycles
    n, cycles.seed = request["samples"], request["seed"]
    cycles.samples, cycles.sample_offset, cycles.sample_subset_length = 2 * n, n, n
    bpy.context.scene.update_tag()  # Cycles' properties do not tell the kept dependency graph that they changed
    started = time.perf_counter()
    bpy.ops.render.render()
    seconds = time.perf_counter() - started
    if request.get("out"):
        np.save(request["out"], picture(folder))
    return {"seconds": seconds}


def main() -> None:
    path, longest, threads = sys.argv[1:4]
    bpy.ops.wm.open_mainfile(filepath=path)
    say(set_up(int(longest), int(threads)))
    with tempfile.TemporaryDirectory() as folder:
        for line in sys.stdin:
            say(answer(json.loads(line), folder))


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    os._exit(0)  # the bpy module sometimes hangs while it is torn down after a render
