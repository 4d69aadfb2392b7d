# SPDX-License-Identifier: GPL-3.0-or-later
"""A glowing room before which a camera moves and turns while its shutter is open, by Cycles and by this engine."""

import sys
from pathlib import Path

import bpy

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[3] / "blend_scenes")]
from common import exr_output, render_to, report  # noqa: E402
from make_cameras import furnish  # noqa: E402

KEYS = {1: ((0.5, -0.3, 0.7), (1.2, 0.15, 0.4)), 3: ((0.9, -0.1, 0.2), (1.4, 0.3, 1.2)),
        5: ((-0.4, 0.6, 0.1), (1.0, -0.4, 0.9))}
# Camera, where the frame lies, shutter's time in frames, Cycles' steps, whether the shutter opens slowly.
CAMERAS = (("perspective", "CENTER", 2.0, 1, False), ("perspective", "START", 2.0, 3, False),
           ("perspective", "END", 1.0, 2, True), ("equirectangular", "CENTER", 3.0, 3, False))

names, scene = [], bpy.context.scene
for name, position, shutter, steps, slowly in CAMERAS:
    for ob in list(scene.objects):
        bpy.data.objects.remove(ob)
    furnish(scene, name, "place")
    camera, render = scene.camera, scene.render
    for frame, (camera.location, camera.rotation_euler) in KEYS.items():
        camera.keyframe_insert("location", frame=frame)
        camera.keyframe_insert("rotation_euler", frame=frame)
    scene.frame_set(3)
    render.use_motion_blur, render.motion_blur_shutter = True, shutter
    holder = render if hasattr(render, "motion_blur_position") else scene.cycles
    holder.motion_blur_position, camera.cycles.motion_steps = position, steps
    if slowly:
        points = render.motion_blur_shutter_curve.curves[0].points
        points[0].location, points[-1].location = (0.0, 0.0), (1.0, 1.0)
        render.motion_blur_shutter_curve.update()
    exr_output(scene)
    scene.cycles.samples = scene.isophote.samples = 128
    scene.isophote.filter_width = 0.01
    names.append(f"{name}_{position}")
    for engine in ("CYCLES", "ISOPHOTE"):
        render.engine = engine
        render_to(scene, f"{names[-1]}_{engine}.exr")
        assert scene.frame_current == 3

# Objects that move and meshes that deform, beside the camera.
for name in ("moving", "bending"):
    bpy.ops.mesh.primitive_cube_add(size=1.0, location=(1.5, 1.0, 0.5))
    bpy.context.object.name = name
    keyed = bpy.context.object
    if name == "bending":
        keyed.shape_key_add(name="Basis")
        key = keyed.shape_key_add(name="Key")
        key.data[0].co.z += 1.0
        keyed, what, values = key, "value", (0.0, 1.0)
    else:
        what, values = "location", ((-2.0, -1.0, 0.0), (-1.0, -1.5, 1.0))
    for frame, value in zip((1, 5), values, strict=True):
        setattr(keyed, what, value)
        keyed.keyframe_insert(what, frame=frame)
scene.frame_set(3)
names.append("objects")
for engine in ("CYCLES", "ISOPHOTE"):
    scene.render.engine = engine
    render_to(scene, f"objects_{engine}.exr")
    assert scene.frame_current == 3

# The same from frame to frame, for the Vector pass.
scene.render.use_motion_blur = False
layer = bpy.context.view_layer
layer.use_pass_vector = True
exr_output(scene, multilayer=True)
for camera_name in ("perspective", "equirectangular"):
    scene.camera.data.type = "PERSP" if camera_name == "perspective" else "PANO"
    for engine in ("CYCLES", "ISOPHOTE"):
        scene.render.engine = engine
        render_to(scene, f"vectors_{camera_name}_{engine}.exr")
        assert scene.frame_current == 3
report(names=names)
