# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a scene in which things move while the shutter is open.

    python blend_scenes/make_motion.py -- OUT.blend KIND        (or blender -b --python ...)

KIND: one of KINDS. All are seen at frame 10 of 20.
"""

import math
import sys

import bpy

FRAME = 10


def empty_scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = 96, 72, 100
    render.use_motion_blur, render.motion_blur_shutter = True, 1.0
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.5, 0.6, 0.8, 1.0)
    scene.camera = add("camera", bpy.data.cameras.new("camera"), (0.0, -7.0, 3.0))
    scene.camera.rotation_euler = (math.radians(70.0), 0.0, 0.0)
    add("floor", plane(8.0), material=coloured("floor", (0.6, 0.6, 0.6)))
    return scene


def add(name, data, location=(0.0, 0.0, 0.0), material=None):
    ob = bpy.data.objects.new(name, data)
    ob.location = location
    bpy.context.scene.collection.objects.link(ob)
    if material:
        data.materials.append(material)
    return ob


def plane(half):
    mesh = bpy.data.meshes.new("plane")
    mesh.from_pydata([(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)], [], [(0, 1, 2, 3)])
    return mesh


def block(x=0.5, y=0.5, z=0.5):
    mesh = bpy.data.meshes.new("block")
    corners = [(i * x, j * y, k * z) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]
    mesh.from_pydata(corners, [], [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    return mesh


def ball(radius=0.6, rings=12):
    """With faces of four corners, smooth."""
    points = [(0, 0, radius), (0, 0, -radius)]
    for r in range(1, rings):
        for s in range(2 * rings):
            theta, phi = math.pi * r / rings, math.pi * s / rings
            points.append((radius * math.sin(theta) * math.cos(phi), radius * math.sin(theta) * math.sin(phi),
                           radius * math.cos(theta)))
    n, faces = 2 * rings, []
    for s in range(n):
        t, last = (s + 1) % n, 2 + (rings - 2) * n
        faces += [(0, 2 + s, 2 + t), (1, last + t, last + s)]
        faces += [(2 + r * n + s, 2 + (r + 1) * n + s, 2 + (r + 1) * n + t, 2 + r * n + t) for r in range(rings - 2)]
    mesh = bpy.data.meshes.new("ball")
    mesh.from_pydata(points, [], faces)
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    return mesh


def coloured(name, colour, emission=0.0, textured=False):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader = tree.nodes.new("ShaderNodeEmission" if emission else "ShaderNodeBsdfDiffuse")
    shader.inputs["Color"].default_value = (*colour, 1.0)
    if emission:
        shader.inputs["Strength"].default_value = emission
    if textured:
        place, chequer = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeTexChecker")
        chequer.inputs["Scale"].default_value = 2.3
        tree.links.new(place.outputs["Object"], chequer.inputs["Vector"])
        tree.links.new(chequer.outputs["Color"], shader.inputs["Color"])
    tree.links.new(shader.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


def animate(thing, path, *values):
    """Keys one frame before, at, and after FRAME, between which all goes evenly."""
    for frame, value in zip((FRAME - 1, FRAME, FRAME + 1), values, strict=True):
        setattr(thing, path, value)
        thing.keyframe_insert(path, frame=frame)
    owner = thing.id_data
    for curve in curves_of(owner.animation_data.action):
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"


def curves_of(action):
    if hasattr(action, "fcurves"):
        return list(action.fcurves)
    return [curve for layer in action.layers for strip in layer.strips for bag in strip.channelbags
            for curve in bag.fcurves]


def objects(scene, position="CENTER"):
    """Blocks and balls that slide, turn, grow, mirrored, with a parent, with several steps, with an object texture."""
    scene.render.motion_blur_position = position
    slides = add("slides", block(), (-2.4, 0, 0.7), coloured("red", (0.8, 0.2, 0.1)))
    animate(slides, "location", (-3.0, 0, 0.7), (-2.4, 0.1, 0.9), (-2.0, 0, 0.7))
    turns = add("turns", block(0.8, 0.3, 0.4), (-0.4, 0, 0.8), coloured("chequer", (1, 1, 1), textured=True))
    animate(turns, "rotation_euler", (0, 0, -1.0), (0.2, 0, 0.3), (0, 0.3, 1.6))
    turns.cycles.motion_steps = 3
    grows = add("grows", ball(), (1.2, 0, 0.7), coloured("green", (0.2, 0.7, 0.2)))
    animate(grows, "scale", (0.5, 1.0, 1.0), (1.0, 1.0, 0.8), (1.2, 0.6, 1.0))
    parent = add("parent", None, (2.6, 0, 0.8))
    animate(parent, "rotation_euler", (0, -0.8, 0), (0, 0.1, 0.4), (0, 0.9, 0))
    child = add("child", block(0.3, 0.3, 0.6), (0.4, 0, 0.3), coloured("blue", (0.2, 0.3, 0.8)))
    child.parent, child.scale = parent, (-1.0, 1.0, 0.8)
    stays = add("stays", ball(0.4), (0.2, -1.8, 0.5), coloured("stays", (0.8, 0.7, 0.2)))
    animate(stays, "location", (-0.4, -1.8, 0.5), (0.2, -1.8, 0.5), (1.2, -1.8, 0.5))
    stays.cycles.use_motion_blur = False


def before(scene):
    objects(scene, "END")


def after(scene):
    objects(scene, "START")


def deforming(scene):
    """Shape keys on a smooth ball with faces of four corners, an armature's bone, one that moves as well, one that is
    not to be blurred."""
    places = {"ball": (-2.0, 0, 0.8), "flying": (0.2, 0.4, 0.9), "stays": (0, -1.8, 0.5)}
    for k, (name, place) in enumerate(places.items()):
        mesh = ball(0.7)
        ob = add(name, mesh, place, coloured(name, (0.8, 0.3 + 0.2 * k, 0.2)))
        ob.shape_key_add(name="Basis")
        key = ob.shape_key_add(name="flat")
        for point in key.data:
            point.co.z *= 0.3
            point.co.x *= 1.5
        animate(key, "value", 0.0, 0.4, 1.0)
        if name == "flying":
            animate(ob, "rotation_euler", (0, -0.5, 0), (0, 0, 0), (0.3, 0.8, 0))
        if name == "stays":
            ob.cycles.use_deform_motion = False
    armature = bpy.data.armatures.new("armature")
    rig = add("rig", armature, (2.2, 0, 0.0))
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    bone = armature.edit_bones.new("bone")
    bone.head, bone.tail = (0, 0, 0), (0, 0, 1.5)
    bpy.ops.object.mode_set(mode="OBJECT")
    bar = add("bar", block(0.3, 0.3, 0.75), (2.2, 0, 0.75), coloured("bar", (0.2, 0.4, 0.8)))
    bar.vertex_groups.new(name="bone").add([1, 3, 5, 7], 1.0, "REPLACE")  # the upper corners
    bar.modifiers.new("armature", "ARMATURE").object = rig
    pose = rig.pose.bones["bone"]
    pose.rotation_mode = "XYZ"
    animate(pose, "rotation_euler", (0, 0, -0.7), (0, 0, 0.1), (0.3, 0, 0.9))


def lights(scene):
    """Light of meshes that move and deform, and of a lamp, which stays."""
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.02
    panel = add("panel", plane(0.4), (-1.5, 0, 2.0), coloured("panel", (1.0, 0.8, 0.5), 12.0))
    animate(panel, "location", (-2.5, 0, 1.0), (-1.5, 0.2, 2.0), (0.5, 0, 1.6))
    animate(panel, "rotation_euler", (0.6, 0, 0), (0, 0.6, 0.5), (0, -0.4, 1.0))
    bent = add("bent", block(0.4, 0.1, 0.1), (1.6, 0.3, 1.0), coloured("bent", (0.5, 0.7, 1.0), 8.0))
    bent.shape_key_add(name="Basis")
    key = bent.shape_key_add(name="long")
    for point in key.data:
        point.co.x *= 2.0
        point.co.z += 0.8
    animate(key, "value", 0.0, 0.5, 1.0)
    lamp = bpy.data.lights.new("lamp", "POINT")
    lamp.energy, lamp.shadow_soft_size = 60.0, 0.2
    ob = add("lamp", lamp, (0.0, -1.5, 2.0))
    animate(ob, "location", (-1.0, -1.5, 2.0), (0.0, -1.5, 2.0), (1.5, -1.5, 2.0))
    add("block", block(), (0.3, 0.6, 0.5), coloured("block", (0.7, 0.7, 0.7)))


def instances(scene):
    """A collection that is instanced, whose objects and instancers move."""
    source = bpy.data.collections.new("source")
    for k in range(2):
        ob = bpy.data.objects.new(f"part{k}", block(0.3, 0.2, 0.3) if k else ball(0.35))
        ob.data.materials.append(coloured(f"part{k}", (0.8, 0.3 + 0.3 * k, 0.2)))
        ob.location = (0, 0, 0.8 * k)
        source.objects.link(ob)
        if k:
            animate(ob, "rotation_euler", (0, 0, -1), (0, 0.4, 0), (0.8, 0, 1))
    for k in range(3):
        ob = add(f"instancer{k}", None, (2 * k - 2, 0, 0.4))
        ob.instance_type, ob.instance_collection = "COLLECTION", source
        if k:
            animate(ob, "location", (2 * k - 2.4, 0, 0.4), (2 * k - 2, 0, 0.6), (2 * k - 1.5, 0.2, 0.4))
        if k == 2:
            ob.cycles.motion_steps = 2


KINDS = {each.__name__: each for each in (objects, before, after, deforming, lights, instances)}

if __name__ == "__main__":
    out, kind = sys.argv[sys.argv.index("--") + 1:]
    made = empty_scene()
    KINDS[kind](made)
    made.frame_set(FRAME)
    bpy.ops.wm.save_as_mainfile(filepath=out)
