# SPDX-License-Identifier: GPL-3.0-or-later
"""The same frame whole, as a region with and without cropping, at half the size, transparent."""

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from common import exr_output, render_to, report, small_scene  # noqa: E402

scene = small_scene(97, 61)
render = scene.render
render.film_transparent = True
exr_output(scene)
render_to(scene, "full.exr")

render.use_border = True
render.border_min_x, render.border_max_x = 0.31, 0.77
render.border_min_y, render.border_max_y = 0.2, 0.83
render.use_crop_to_border = True
render_to(scene, "crop.exr")
render.use_crop_to_border = False
render_to(scene, "region.exr")

render.use_border = False
render.resolution_percentage = 50
render_to(scene, "half.exr")

render.film_transparent = False
render.pixel_aspect_x = 2.0
render_to(scene, "opaque.exr")
report(border=[render.border_min_x, render.border_min_y, render.border_max_x, render.border_max_y],
       version=list(bpy.app.version))
