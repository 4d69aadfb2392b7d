# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets up an animation; the command line renders it."""

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from common import small_scene  # noqa: E402

scene = small_scene()
cube = bpy.data.objects["Cube"]
for frame, angle in ((1, 0.0), (2, 0.6)):
    cube.rotation_euler.z = angle
    cube.keyframe_insert("rotation_euler", frame=frame)
