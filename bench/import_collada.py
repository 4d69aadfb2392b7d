# SPDX-License-Identifier: GPL-3.0-or-later
"""A COLLADA file as a .blend, by Blender's own importer (bpy up to 4.5).

    python bench/import_collada.py FILE.dae OUT.blend

Such files seldom have lights, and cameras that other programs put into them: here a camera looks at everything,
under a sun and a grey sky.
"""

from __future__ import annotations

import math
import os
import sys

import bpy
from mathutils import Vector


def add(name: str, data, place=(0.0, 0.0, 0.0), towards=(0.0, 0.0, -1.0)):
    """An object that looks along `towards`, as cameras and lamps look along their -z."""
    ob = bpy.data.objects.new(name, data)
    ob.location, ob.rotation_euler = place, Vector(towards).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(ob)
    return ob


def light_and_look(scene) -> None:
    corners = [ob.matrix_world @ Vector(corner) for ob in scene.objects if ob.type == "MESH" for corner in ob.bound_box]
    low, high = (Vector(f(c[k] for c in corners) for k in range(3)) for f in (min, max))
    centre, radius = (low + high) / 2.0, (high - low).length / 2.0
    camera, towards = bpy.data.cameras.new("Camera"), Vector((-0.4, -1.0, -0.25)).normalized()
    scene.camera = add("Camera", camera, centre - towards * radius / math.sin(camera.angle / 2.0), towards)
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = 3.0, math.radians(5.0)
    add("Sun", sun, towards=(-0.9, -0.6, -1.0))
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = 0.4, 0.4, 0.4, 1.0


def main() -> None:
    source, out = sys.argv[1:3]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.collada_import(filepath=source)
    bpy.context.view_layer.update()
    scene = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = 512
    light_and_look(scene)
    bpy.ops.wm.save_as_mainfile(filepath=out)


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    os._exit(0)  # the bpy module sometimes hangs while it is torn down
