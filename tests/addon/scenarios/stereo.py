# SPDX-License-Identifier: GPL-3.0-or-later
"""A glowing room seen by two eyes, in every way that cameras converge, by Cycles and by this engine: a file a view."""

import sys
from pathlib import Path

import bpy

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[3] / "blend_scenes")]
from common import exr_output, render_to, report  # noqa: E402
from make_cameras import furnish  # noqa: E402

MODES = ("OFFAXIS", "PARALLEL", "TOE")
# Camera, spherical stereo, pole merge.
CAMERAS = (("perspective", False, False), ("equirectangular", True, False), ("equirectangular", True, True))

names, scene = [], bpy.context.scene
for camera, spherical, merge in CAMERAS:
    for mode in MODES:
        for ob in list(scene.objects):
            bpy.data.objects.remove(ob)
        furnish(scene, camera, "place")
        scene.render.use_multiview = True
        exr_output(scene)
        scene.render.image_settings.views_format = "INDIVIDUAL"
        stereo = scene.camera.data.stereo
        stereo.convergence_mode, stereo.interocular_distance, stereo.convergence_distance = mode, 0.4, 2.5
        stereo.use_spherical_stereo, stereo.use_pole_merge = spherical, merge
        scene.cycles.samples = scene.isophote.samples = 8
        scene.isophote.filter_width = 0.01
        names.append(f"{camera}_{mode}_{merge}")
        for engine in ("CYCLES", "ISOPHOTE"):
            scene.render.engine = engine
            render_to(scene, f"{names[-1]}_{engine}.exr")
report(names=names)
