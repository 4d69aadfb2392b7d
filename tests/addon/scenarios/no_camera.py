# SPDX-License-Identifier: GPL-3.0-or-later
"""A render that cannot be. Blender itself refuses one without a camera, so a camera that is none is given."""

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from common import exr_output, render_to, report, small_scene  # noqa: E402

scene = small_scene()
exr_output(scene)
scene.camera = bpy.data.objects["Cube"]
failed = ""
try:
    render_to(scene, "no_camera.exr")
except RuntimeError as error:
    failed = str(error)
report(failed=failed)
