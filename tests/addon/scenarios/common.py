# SPDX-License-Identifier: GPL-3.0-or-later
"""What the scenarios share. They run inside Blender, as `--python scenario.py -- FOLDER ...`."""

import json
import sys
from pathlib import Path

import bpy

FOLDER = Path(sys.argv[sys.argv.index("--") + 1])


def small_scene(width=64, height=48, samples=8):
    """Blender's default cube with this engine, small and quick."""
    scene = bpy.context.scene
    render = scene.render
    render.engine = "ISOPHOTE"
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    scene.isophote.samples = samples
    return scene


def exr_output(scene, multilayer=False):
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):  # 5.0 and newer
        settings.media_type = "MULTI_LAYER_IMAGE" if multilayer else "IMAGE"
    settings.file_format = "OPEN_EXR_MULTILAYER" if multilayer else "OPEN_EXR"
    settings.color_depth = "32"


def render_to(scene, name):
    scene.render.filepath = str(FOLDER / name)
    bpy.ops.render.render(write_still=True)


def report(**findings):
    print("SCENARIO", json.dumps(findings), flush=True)
