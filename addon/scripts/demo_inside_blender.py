# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender: renders the scene with Isophote and writes OUT.png and OUT.exr (all passes).

    blender -b FILE --addons isophote_addon --python demo_inside_blender.py -- OUT
"""

import sys

import bpy

out = sys.argv[sys.argv.index("--") + 1]
scene = bpy.context.scene
scene.render.engine = "ISOPHOTE"
settings = scene.render.image_settings
for layer in scene.view_layers:
    layer.use_pass_z = layer.use_pass_normal = True
    layer.isophote.albedo = layer.isophote.error = True
bpy.ops.render.render()
for suffix, kind, media, depth in ((".png", "PNG", "IMAGE", "8"),
                                   (".exr", "OPEN_EXR_MULTILAYER", "MULTI_LAYER_IMAGE", "32")):
    if hasattr(settings, "media_type"):  # 5.0 and newer
        settings.media_type = media
    settings.file_format, settings.color_depth = kind, depth
    bpy.data.images["Render Result"].save_render(out + suffix, scene=scene)
    print(f"Demo: wrote {out}{suffix}", flush=True)
