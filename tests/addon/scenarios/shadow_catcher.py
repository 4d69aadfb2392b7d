# SPDX-License-Identifier: GPL-3.0-or-later
"""A cube over a floor that catches its shadow, by Cycles and by this engine, with and without a pass of its own."""

import sys
from pathlib import Path

import addon_utils
import bpy

sys.path.insert(0, str(Path(__file__).parent))
from common import exr_output, render_to, report, small_scene  # noqa: E402

SAMPLES = 64

addon_utils.enable("cycles")
scene = small_scene(32, 24, SAMPLES)
scene.render.film_transparent = True
scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = SAMPLES, False, False
floor = bpy.data.meshes.new("floor")
floor.from_pydata([(-9, -9, -1), (9, -9, -1), (9, 9, -1), (-9, 9, -1)], [], [(0, 1, 2, 3)])
catcher = bpy.data.objects.new("floor", floor)
catcher.is_shadow_catcher = True
scene.collection.objects.link(catcher)
bpy.data.objects["Cube"].data.materials.clear()  # which leaves it grey and diffuse in all versions
exr_output(scene, multilayer=True)
layer = scene.view_layers[0]
for engine in ("CYCLES", "ISOPHOTE"):
    scene.render.engine = engine
    for apart in (False, True):
        layer.cycles.use_pass_shadow_catcher = apart
        render_to(scene, f"{engine.lower()}_{'apart' if apart else 'combined'}.exr")
report(done=True)
