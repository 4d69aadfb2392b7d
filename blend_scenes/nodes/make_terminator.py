# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene of smooth shapes of few faces under grazing light, where the shadow terminator shows.

    python blend_scenes/nodes/make_terminator.py -- OUT.blend

Balls, monkeys and a torus with geometry offsets of 0, 0.1 (Blender's own) and 0.4, mirrored, instanced and seen from
inside, under a sun, a lamp and a dim sky. Needs bpy.
"""

from __future__ import annotations

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from shapes import add_camera, empty_scene, new_material  # noqa: E402

COLUMNS = 4
SHAPES = (("ball", 0.1, 1.0), ("monkey", 0.1, 1.0), ("ball", 0.4, -1.0), ("torus", 0.1, 1.0),
          ("ball", 0.0, 1.0), ("bowl", 0.1, 1.0), ("twin", 0.1, 0.8), ("leaf", 0.2, 1.0))


def grey(kind: str = "ShaderNodeBsdfDiffuse"):
    material, tree, output = new_material(kind)
    shader = tree.nodes.new(kind)
    shader.inputs["Color"].default_value = 0.8, 0.7, 0.6, 1.0
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def add(shape: str, offset: float, width: float, place) -> None:
    """A smooth shape; `bowl` is the inside of a ball's lower half, `twin` an instance, `leaf` translucent."""
    if shape == "monkey":
        bpy.ops.mesh.primitive_monkey_add(size=0.9)
    elif shape == "torus":
        bpy.ops.mesh.primitive_torus_add(major_radius=0.3, minor_radius=0.14, major_segments=10, minor_segments=6)
    else:
        bpy.ops.mesh.primitive_uv_sphere_add(segments=10, ring_count=6, radius=0.45)
    ob = bpy.context.active_object
    if shape == "bowl":
        faces = [polygon.vertices[:] for polygon in ob.data.polygons if polygon.center.z < 0.0]
        bowl = bpy.data.meshes.new("bowl")
        bowl.from_pydata([vertex.co[:] for vertex in ob.data.vertices], [], faces)
        ob.data = bowl
    ob.location, ob.scale, ob.rotation_euler = place, (width, 1.0, 0.9), (0.3, 0.2, 0.1)
    ob.data.polygons.foreach_set("use_smooth", [True] * len(ob.data.polygons))
    ob.data.materials.append(grey("ShaderNodeBsdfTranslucent" if shape == "leaf" else "ShaderNodeBsdfDiffuse"))
    owner = ob if hasattr(ob, "shadow_terminator_geometry_offset") else ob.cycles
    owner.shadow_terminator_geometry_offset = offset
    if shape == "twin":
        twin = ob.copy()
        twin.location.x += 1000.0
        bpy.context.scene.collection.objects.link(twin)


def main() -> None:
    empty_scene()
    scene = bpy.context.scene
    for number, (shape, offset, width) in enumerate(SHAPES):
        add(shape, offset, width, (number % COLUMNS + 0.5, -(number // COLUMNS) - 0.5, 0.0))
    lamps = ("SUN", (0, 0, 0), (0.0, 1.3, 0.4), 2.0), ("POINT", (2.0, 1.0, 0.6), (0, 0, 0), 15.0)
    for kind, place, turn, energy in lamps:
        lamp = bpy.data.objects.new(kind, bpy.data.lights.new(kind, kind))
        lamp.data.energy, lamp.location, lamp.rotation_euler = energy, place, turn
        scene.collection.objects.link(lamp)
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = 0.05, 0.06, 0.08, 1.0
    scene.render.resolution_x, scene.render.resolution_y = 48 * COLUMNS, 96
    scene.render.resolution_percentage = 100
    cycles = scene.cycles
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    add_camera((2.0, -1.0, 10.0), width=float(COLUMNS))
    bpy.ops.wm.save_as_mainfile(filepath=sys.argv[-1])


if __name__ == "__main__":
    main()
