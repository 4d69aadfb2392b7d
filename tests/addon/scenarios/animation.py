# SPDX-License-Identifier: GPL-3.0-or-later
"""Four frames as an animation and one by one: the camera moves, then nothing does, then the cube. What is kept when."""

import sys
from contextlib import suppress
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from common import FOLDER, exr_output, render_to, report, small_scene  # noqa: E402
from isophote_addon import kept  # noqa: E402

import isophote.prepare  # noqa: E402
from isophote.opencl import OpenCLDevice  # noqa: E402

scene = small_scene()
exr_output(scene)
camera, cube = scene.camera, bpy.data.objects["Cube"]
for frame, shift, angle in ((1, 0.0, 0.0), (2, 0.5, 0.0), (3, 0.5, 0.0), (4, 0.5, 0.3)):
    camera.location.x = 7.4 + shift
    camera.keyframe_insert("location", frame=frame)
    cube.rotation_euler.z = angle
    cube.keyframe_insert("rotation_euler", frame=frame)
scene.frame_start, scene.frame_end = 1, 4

made, inner = [], isophote.prepare.make_geometry


def counted(scene, before=None):
    geometry = inner(scene, before)
    assert geometry.wide_tree  # a new one needs a BVH2
    made.append("kept" if geometry is before else "built" if geometry.trees else "refitted")
    return geometry


isophote.prepare.make_geometry = counted


def animation(name, persistent):
    made.clear()
    scene.render.use_persistent_data = persistent
    scene.render.filepath = str(FOLDER / name)
    bpy.ops.render.render(animation=True)
    return {"made": list(made), "left": len(kept._geometries)}


found = {"usual": animation("usual_", False), "persistent": animation("persistent_", True)}
found["again"] = animation("again_", True)
found["off"] = animation("off_", False)["left"]
for frame in range(1, 5):
    scene.frame_set(frame)
    render_to(scene, f"still_{frame:04d}.exr")
found["still"] = made[-4:]
opened, inner_init = [], OpenCLDevice.__init__


def counting(self, *arguments):
    opened.append(self)
    inner_init(self, *arguments)


OpenCLDevice.__init__ = counting
scene.isophote.device, scene.isophote.wait_for_kernels = "opencl", True
found["opencl"] = animation("opencl_", False) | {"opened": len(opened), "devices": len(kept._devices)}
found["opencl_persistent"] = animation("opencl_persistent_", True) | {"opened": len(opened),
                                                                      "devices": len(kept._devices)}
render_to(scene, "once_more.exr")
scene.isophote.device = "openmp"
found["opencl_after"] = {"opened": len(opened), "devices": len(kept._devices)}
render_to(scene, "last.exr")
found["after"] = len(kept._geometries)
found["devices_after"] = len(kept._devices)
cube.data.vertices[0].co.x += 1.0
scene.camera.scale = (0.0, 0.0, 0.0)  # refused, before the change is seen
with suppress(RuntimeError):
    render_to(scene, "refused.exr")
scene.camera.scale = (1.0, 1.0, 1.0)
render_to(scene, "persistent_last.exr")
scene.render.use_persistent_data = False
render_to(scene, "still_last.exr")
scene.render.use_persistent_data = True
render_to(scene, "last.exr")
bpy.ops.wm.read_homefile(use_factory_startup=True, app_template="")
found["loaded"] = len(kept._geometries)
report(**found)
