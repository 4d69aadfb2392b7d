# SPDX-License-Identifier: GPL-3.0-or-later
"""Two view layers, the second without the cube, with all passes, into one multilayer EXR."""

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from common import exr_output, render_to, report, small_scene  # noqa: E402

scene = small_scene()
cube = bpy.data.objects["Cube"]
own = bpy.data.collections.new("OnlyCube")
scene.collection.children.link(own)
for collection in cube.users_collection:
    collection.objects.unlink(cube)
own.objects.link(cube)
layers = [bpy.context.view_layer, scene.view_layers.new("Empty")]
layers[1].layer_collection.children["OnlyCube"].exclude = True
for layer in layers:
    layer.use_pass_z = layer.use_pass_normal = layer.use_pass_position = True
    for kind in ("diffuse", "glossy", "transmission"):
        for of in ("direct", "indirect", "color"):
            setattr(layer, f"use_pass_{kind}_{of}", True)
    layer.use_pass_emit = layer.use_pass_environment = True
    layer.isophote.albedo = layer.isophote.sample_count = layer.isophote.error = layer.isophote.invalid = True
for name in ("Depth", "CryptoObject01", "Combined_Key", "Own"):
    layers[0].aovs.add().name = name
exr_output(scene, multilayer=True)
render_to(scene, "passes.exr")
camera = scene.camera.matrix_world
report(camera=list(camera.translation), distance=(camera.translation - cube.location).length)
