# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a scene with hair.

    python blend_scenes/nodes/make_strands.py -- OUT.blend KIND        (or blender -b --python ...)

KIND: one of KINDS.
"""

import math
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from shapes import emitting, new_material, node_output  # noqa: E402


def empty_scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = 96, 72, 100
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.5, 0.6, 0.8, 1.0)
    scene.camera = add("camera", bpy.data.cameras.new("camera"), (0.0, -6.0, 2.6))
    scene.camera.rotation_euler = (math.radians(71.0), 0.0, 0.0)
    lamp = add("lamp", bpy.data.lights.new("lamp", "AREA"), (2.5, -3.0, 4.0))
    lamp.data.energy, lamp.data.size = 300.0, 1.5
    lamp.rotation_euler = (math.radians(42.0), 0.0, math.radians(40.0))
    add("floor", plane(6.0), material=coloured("floor", (0.6, 0.6, 0.6)))
    return scene


def add(name, data, location=(0.0, 0.0, 0.0), material=None):
    ob = bpy.data.objects.new(name, data)
    ob.location = location
    bpy.context.scene.collection.objects.link(ob)
    if material:
        data.materials.append(material)
    return ob


def taken(data):
    """The mesh of what an operator has just added, without its object."""
    bpy.data.objects.remove(bpy.context.object)
    return data


def plane(half, parts=1):
    """With a UV map."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=parts, y_subdivisions=parts, size=2.0 * half)
    return taken(bpy.context.object.data)


def ball(radius=0.7):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=radius)
    mesh = taken(bpy.context.object.data)
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    return mesh


def coloured(name, colour, shader="ShaderNodeBsdfDiffuse", **inputs):
    material, tree, output = new_material(name)
    node = tree.nodes.new(shader)
    node.inputs[0].default_value = (*colour, 1.0)
    for key, value in inputs.items():
        node.inputs[key].default_value = value
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return material


def numbers_shown(name, *numbers):
    """Emits what Hair Info says, as red, green and blue: (output, by how much it is multiplied)."""
    def build(tree):
        info, joined = tree.nodes.new("ShaderNodeHairInfo"), tree.nodes.new("ShaderNodeCombineXYZ")
        for socket, (output, factor) in zip(joined.inputs, numbers, strict=True):
            times = tree.nodes.new("ShaderNodeMath")
            times.operation = "MULTIPLY"
            tree.links.new(info.outputs[output], times.inputs[0])
            times.inputs[1].default_value = factor
            tree.links.new(times.outputs[0], socket)
        return joined.outputs[0]
    return emitting(name, build, 1.0, 0.0)


def grow(ob, count, length, radius, slot=1, **others):
    """A particle system's hair; `others` are settings of it."""
    system = ob.modifiers.new("hair", "PARTICLE_SYSTEM").particle_system
    settings = system.settings
    settings.type, settings.count, settings.hair_length, settings.hair_step = "HAIR", count, length, 4
    settings.root_radius, settings.tip_radius, settings.radius_scale = 1.0, 0.0, 2.0 * radius
    settings.render_step, settings.material, settings.use_advanced_hair = 3, slot, True
    for name, value in others.items():
        setattr(settings, name, value)
    return system


def fur(scene):
    """Parents on a ball; on a plane bent ones, with another taper, in a colour from the UV map."""
    one = add("ball", ball(), (-1.2, 0.0, 0.75), coloured("skin", (0.3, 0.2, 0.15)))
    one.data.materials.append(coloured("fur", (0.7, 0.45, 0.2)))
    grow(one, 400, 0.5, 0.02, slot=2, brownian_factor=0.05)  # Cycles loses some 3D curves that are straight
    other = add("patch", plane(0.9, 3), (1.3, 0.0, 0.02), coloured("earth", (0.25, 0.2, 0.15)))
    material, tree, output = new_material("grass")
    shader, place = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeUVMap")
    tree.links.new(place.outputs[0], shader.inputs["Color"])
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    other.data.materials.append(material)
    grow(other, 300, 0.8, 0.025, slot=2, shape=0.5, tip_radius=0.3, brownian_factor=0.08, use_close_tip=True)


def children(scene):
    """Interpolated children that curl; simple ones without the emitter; an instance that is squeezed and mirrored."""
    one = add("ball", ball(), (-1.2, 0.0, 0.75), coloured("skin", (0.5, 0.3, 0.2)))
    grow(one, 40, 0.5, 0.012, child_type="INTERPOLATED", rendered_child_count=12, kink="CURL", kink_amplitude=0.05,
         kink_frequency=3.0)
    other = add("patch", plane(0.5, 2), (0.6, 0.4, 0.02), coloured("hair", (0.2, 0.3, 0.6)))
    grow(other, 30, 0.9, 0.012, child_type="SIMPLE", rendered_child_count=10, roughness_1=0.05, child_radius=0.2)
    other.show_instancer_for_render = False
    twin = add("twin", other.data, (2.2, 0.0, 0.02))
    twin.modifiers.new("hair", "PARTICLE_SYSTEM").particle_system.settings = other.particle_systems[0].settings
    twin.scale = (-1.0, 0.7, 1.3)


def info(scene):
    """What Hair Info says."""
    kinds = [numbers_shown("numbers", ("Is Strand", 0.5), ("Intercept", 1.0), ("Length", 1.0)),
             numbers_shown("more", ("Thickness", 20.0), ("Random", 1.0), ("Thickness", 0.0)),
             emitting("tangents", node_output("ShaderNodeHairInfo", "Tangent Normal")),
             emitting("normals", node_output("ShaderNodeNewGeometry", "Normal"))]
    for k, material in enumerate(kinds):
        ob = add(material.name, plane(0.45), (-1.8 + 1.2 * k, 0.0, 0.02), material)
        grow(ob, 30, 0.7 + 0.2 * k, 0.03, brownian_factor=0.1)


def curves(scene):
    """A Curves object with radii of its points, a colour of its curves, one of its points."""
    data = bpy.data.hair_curves.new("curves")
    sizes = [4, 2, 7, 5, 3, 6]
    data.add_curves(sizes)
    points, radii = [], []
    for k, size in enumerate(sizes):
        for j in range(size):
            t = j / (size - 1)
            points += [-1.5 + 0.6 * k + 0.3 * math.sin(3 * t + k), 0.2 * math.cos(2 * t * k), 0.1 + 1.6 * t]
            radii.append(0.08 * (1.0 - 0.7 * t) + 0.02 * (j % 2))
    data.points.foreach_set("position", points)
    data.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", radii)
    tint = data.attributes.new("tint", "FLOAT_COLOR", "CURVE")
    tint.data.foreach_set("color", [c for k in range(len(sizes)) for c in (0.2 + 0.1 * k, 0.8 - 0.1 * k, 0.4, 1.0)])
    along = data.attributes.new("along", "FLOAT", "POINT")
    along.data.foreach_set("value", [(k % 3) / 3.0 for k in range(len(radii))])
    material, tree, output = new_material("tinted")
    shader, glow, sum_ = (tree.nodes.new(kind) for kind in (
        "ShaderNodeBsdfDiffuse", "ShaderNodeEmission", "ShaderNodeAddShader"))
    for name, said, socket in (("tint", "Color", shader.inputs["Color"]), ("along", "Fac", glow.inputs["Strength"])):
        node = tree.nodes.new("ShaderNodeAttribute")
        node.attribute_name = name
        tree.links.new(node.outputs[said], socket)
    for k, node in enumerate((shader, glow)):
        tree.links.new(node.outputs[0], sum_.inputs[k])
    tree.links.new(sum_.outputs[0], output.inputs["Surface"])
    add("curves", data, material=material)


def shaders(scene):
    """Closures on strands."""
    kinds = [coloured("clear", (0.5, 0.6, 0.9), "ShaderNodeBsdfTransparent"),
             coloured("shiny", (0.8, 0.7, 0.5), "ShaderNodeBsdfGlossy", Roughness=0.3),
             coloured("thin", (0.3, 0.7, 0.3), "ShaderNodeBsdfTranslucent"),
             coloured("plain", (0.6, 0.3, 0.2), "ShaderNodeBsdfPrincipled")]
    for k, material in enumerate(kinds):
        ob = add(material.name, plane(0.5), (-1.8 + 1.2 * k, 0.0, 0.02), material)
        ob.show_instancer_for_render = False
        grow(ob, 60, 0.9, 0.03, brownian_factor=0.1)


def monkey(scene):
    """For looking at: a monkey's head with 43,000 hairs, brighter towards their tips."""
    scene.render.resolution_x, scene.render.resolution_y = 640, 480
    scene.camera.rotation_euler[0], scene.camera.data.lens = math.radians(76.0), 60.0
    bpy.data.lights["lamp"].energy = 170.0
    bpy.ops.mesh.primitive_monkey_add(size=2.2, location=(0.0, 0.0, 1.15))
    head = bpy.context.object
    head.rotation_euler = (math.radians(-14.0), 0.0, math.radians(24.0))
    head.modifiers.new("smooth", "SUBSURF").render_levels = 2
    material, tree, output = new_material("fur")
    shader, place, ramp = (tree.nodes.new(kind) for kind in (
        "ShaderNodeBsdfPrincipled", "ShaderNodeHairInfo", "ShaderNodeValToRGB"))
    shader.inputs["Roughness"].default_value = 0.4
    for element, colour in zip(ramp.color_ramp.elements, ((0.1, 0.04, 0.02), (0.85, 0.5, 0.22)), strict=True):
        element.color = (*colour, 1.0)
    tree.links.new(place.outputs["Intercept"], ramp.inputs[0])
    tree.links.new(ramp.outputs[0], shader.inputs["Base Color"])
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    for each in (coloured("skin", (0.2, 0.1, 0.06)), material):
        head.data.materials.append(each)
    grow(head, 2700, 0.13, 0.003, slot=2, child_type="INTERPOLATED", rendered_child_count=16, brownian_factor=0.01,
         object_align_factor=(0.0, 0.0, -0.03), clump_factor=0.3, roughness_2=0.01, tip_radius=0.1)
    light = add("rim", bpy.data.lights.new("rim", "AREA"), (-3.0, 3.0, 4.0))
    light.data.energy, light.data.size = 250.0, 2.0
    light.rotation_euler = (math.radians(-50.0), 0.0, math.radians(40.0))


KINDS = {"fur": fur, "children": children, "info": info, "curves": curves, "shaders": shaders, "monkey": monkey}
RIBBONS = ("children", "shaders")  # as Cycles draws hair unless it is asked for 3D curves

if __name__ == "__main__":
    path, kind = sys.argv[sys.argv.index("--") + 1:][:2]
    made = empty_scene()
    made.cycles_curves.shape = "RIBBONS" if kind in RIBBONS else "THICK"
    KINDS[kind](made)
    bpy.ops.wm.save_as_mainfile(filepath=path)
