# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders until the error set in the panel is reached."""

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from common import exr_output, render_to, report, small_scene  # noqa: E402

scene = small_scene(samples=4096)
scene.isophote.error_percent = 10.0
bpy.context.view_layer.isophote.sample_count = True
exr_output(scene, multilayer=True)
render_to(scene, "wanted_error.exr")
report()
