# SPDX-License-Identifier: GPL-3.0-or-later
"""Opens each .blend file of the command line and renders it small on each device: NAME_DEVICE.exr."""

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from common import exr_output, render_to, report, small_scene  # noqa: E402

FILES = sys.argv[sys.argv.index("--") + 2:]
WIDTH = 48

for file in FILES:
    bpy.ops.wm.open_mainfile(filepath=file)
    render = bpy.context.scene.render
    scene = small_scene(WIDTH, max(1, WIDTH * render.resolution_y // render.resolution_x), samples=4)
    exr_output(scene)
    scene.isophote.wait_for_kernels = True
    for device in ("openmp", "opencl"):
        scene.isophote.device = device
        render_to(scene, f"{Path(file).stem}_{device}.exr")
report(files=len(FILES), version=list(bpy.app.version))
