# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene of normals that nodes make: normal maps, bump, displacement, and anisotropy along tangents.

    python blend_scenes/nodes/make_normals.py -- FOLDER

Writes normals.blend: shapes under a sun and a sky, plain, mirrored and instanced, some with their backs to the camera;
and steps.blend: shapes that glow with the normal that bump makes of heights that jump.
Needs bpy.
"""

from __future__ import annotations

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from shapes import COLUMNS, add_shape, emitting, empty_scene, frame, new_material, place_of, save_all  # noqa: E402


def with_normal(build, shader: str = "ShaderNodeBsdfDiffuse", roughness: float = 0.3):
    """A shader whose normal build(tree) makes; the displacement of the output where build.displaces."""
    material, tree, output = new_material("normal")
    closure = tree.nodes.new(shader)
    if shader != "ShaderNodeBsdfDiffuse":
        closure.inputs["Roughness"].default_value = roughness
    tree.links.new(closure.outputs[0], output.inputs["Surface"])
    made = build(tree)
    tree.links.new(made, output.inputs["Displacement"] if made.name == "Displacement" else closure.inputs["Normal"])
    return material


def curved(tree, node, socket: str, vector: bool = False):
    """Links an input to x (x + y) of the object, or to a colour that follows the UV map to steep angles."""
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    parts = tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(coordinates.outputs["UV" if vector else "Object"], parts.inputs[0])
    if vector:
        color = tree.nodes.new("ShaderNodeCombineXYZ")
        for k in range(2):
            tree.links.new(parts.outputs[k], color.inputs[k])
        color.inputs[2].default_value = 0.8
        tree.links.new(color.outputs[0], node.inputs[socket])
        return
    total, product = tree.nodes.new("ShaderNodeMath"), tree.nodes.new("ShaderNodeMath")
    product.operation = "MULTIPLY"
    for k in range(2):
        tree.links.new(parts.outputs[k], total.inputs[k])
    tree.links.new(parts.outputs[0], product.inputs[0])
    tree.links.new(total.outputs[0], product.inputs[1])
    tree.links.new(product.outputs[0], node.inputs[socket])


def normal_map(space: str, strength: float, fixed=None):
    def build(tree):
        node = tree.nodes.new("ShaderNodeNormalMap")
        node.space, node.inputs["Strength"].default_value = space, strength
        if fixed:
            node.inputs["Color"].default_value = (*fixed, 1.0)
        else:
            curved(tree, node, "Color", vector=True)
        return node.outputs[0]
    return build


def bump(strength: float, distance: float, invert: bool = False):
    def build(tree):
        node = tree.nodes.new("ShaderNodeBump")
        node.invert = invert
        node.inputs["Strength"].default_value, node.inputs["Distance"].default_value = strength, distance
        curved(tree, node, "Height")
        return node.outputs[0]
    return build


def displacement(kind: str, space: str, scale: float):
    def build(tree):
        node = tree.nodes.new(kind)
        node.space, node.inputs["Scale"].default_value = space, scale
        vector = kind == "ShaderNodeVectorDisplacement"
        curved(tree, node, "Vector" if vector else "Height", vector)
        return node.outputs[0]
    return build


def brushed(shader: str, inputs: dict, along: str | None):
    """An anisotropic shader: along its own tangent, along that around an axis or that of the UV map."""
    material, tree, output = new_material("brushed")
    closure = tree.nodes.new(shader)
    for name, value in ({"Roughness": 0.4} | inputs).items():
        closure.inputs[name].default_value = value
    tree.links.new(closure.outputs[0], output.inputs["Surface"])
    if along:
        tangent = tree.nodes.new("ShaderNodeTangent")
        tangent.direction_type, tangent.axis = ("UV_MAP", "Z") if along == "UV" else ("RADIAL", along)
        tree.links.new(tangent.outputs[0], closure.inputs["Tangent"])
    return material


def make_normals() -> None:
    empty_scene()
    steep = 0.5 + 0.5 * 0.8660254, 0.5, 0.75
    cases = [normal_map("TANGENT", 1.0), normal_map("TANGENT", 0.4), normal_map("TANGENT", 1.7),
             normal_map("TANGENT", 1.0, steep), normal_map("OBJECT", 1.0), normal_map("WORLD", 0.6),
             normal_map("BLENDER_OBJECT", 1.0, (0.6, 0.4, 0.1)), normal_map("BLENDER_WORLD", 0.8, (0.4, 0.7, 0.2)),
             normal_map("WORLD", 1.0, (0.5,) * 3),
             bump(1.0, 1.0), bump(0.5, 2.0), bump(1.0, 1.0, True),
             displacement("ShaderNodeDisplacement", "OBJECT", 1.0),
             displacement("ShaderNodeDisplacement", "WORLD", 1.0),
             displacement("ShaderNodeVectorDisplacement", "OBJECT", 0.1),
             displacement("ShaderNodeVectorDisplacement", "TANGENT", 0.1)]
    shaders = ("ShaderNodeBsdfDiffuse", "ShaderNodeBsdfGlossy", "ShaderNodeBsdfPrincipled")
    number = 0
    for build in cases:
        for shader in shaders:
            shape = ("ball", "tile", "torus")[number // 3 % 3]
            tilt = (3.3, 0.3, 0.2) if number % 9 == 1 else (0.4, 0.3, 0.2)  # some show their backs
            ob = add_shape(shape, f"patch {number}", place_of(number, 9), with_normal(build, shader, 0.35),
                           scale=(-1.0 if number % 2 else 1.0, 1.0, 0.7), rotation=tilt)
            if number % 4 > 1:  # with a twin far away it is an instance
                twin = ob.copy()
                twin.location.x += 1000.0
                bpy.context.scene.collection.objects.link(twin)
            number += 1
    glossy, principled, metal = (f"ShaderNodeBsdf{name}" for name in ("Anisotropic", "Principled", "Metallic"))
    for shader, inputs in ((glossy, {"Anisotropy": 0.7}), (glossy, {"Anisotropy": -0.5, "Rotation": 0.1}),
                           (principled, {"Anisotropic": 0.8, "Metallic": 1.0}),
                           (principled, {"Anisotropic": 0.5, "Anisotropic Rotation": 0.3}),
                           (metal, {"Anisotropy": 0.9})):
        for along in (None, "Z", "UV"):
            shape = ("ball", "torus", "tile")[number % 3]
            add_shape(shape, f"patch {number}", place_of(number, 9), brushed(shader, inputs, along),
                      scale=(1.0, 1.0, 0.7), rotation=(0.4, 0.3, 0.2))
            number += 1
    lamp = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    lamp.data.energy, lamp.data.angle, lamp.rotation_euler = 2.0, 0.3, (0.5, 0.6, 0.0)
    bpy.context.scene.collection.objects.link(lamp)
    background = bpy.context.scene.world.node_tree.nodes["Background"]
    background.inputs[0].default_value = 0.3, 0.4, 0.5, 1.0
    frame(number, 9)


def steps(width: float, coordinates: str):
    """The normal of a Bump node whose height jumps from square to square."""
    def build(tree):
        node, checker = tree.nodes.new("ShaderNodeBump"), tree.nodes.new("ShaderNodeTexChecker")
        checker.inputs["Scale"].default_value = 9.0
        node.inputs["Filter Width"].default_value, node.inputs["Distance"].default_value = width, 0.1
        tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs[coordinates], checker.inputs["Vector"])
        tree.links.new(checker.outputs["Fac"], node.inputs["Height"])
        return node.outputs[0]
    return build


def make_steps() -> None:
    """Heights that jump show where bump looks: how far, and along which axes. The lens is wide and begins far off."""
    empty_scene()
    widths, number = (0.1, 0.5, 1.0, 3.0), 0
    for coordinates in ("Object", "UV", "Generated"):
        for width in widths:
            for shape in ("ball", "torus"):
                material = emitting(f"{coordinates} {width} {number}", steps(width, coordinates))
                add_shape(shape, f"patch {number}", place_of(number), material, rotation=(0.4, 0.3, 0.2))
                number += 1
    frame(number)
    scene, rows = bpy.context.scene, number // COLUMNS
    camera, high = scene.camera, 4.0
    camera.data.type, camera.data.clip_start, camera.location.z = "PERSP", 2.0, high
    camera.data.lens = camera.data.sensor_width * high / max(COLUMNS, rows)
    scene.cycles.filter_width = 0.01


if __name__ == "__main__":
    save_all({"normals": make_normals, "steps": make_steps}, sys.argv[-1])
