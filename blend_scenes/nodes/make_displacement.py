# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene of displaced meshes: heights and vectors, in all spaces, moving the vertices alone or with bump.

    python blend_scenes/nodes/make_displacement.py -- FOLDER

Writes displacement.blend: subdivided shapes that glow with their normals, and displaced.blend: the same ones, diffuse
and glossy, under a sun and a sky. Needs bpy.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from shapes import add_shape, emitting, empty_scene, frame, new_material, node_output, place_of, save_all  # noqa: E402

COLUMNS = 8
METHODS = "DISPLACEMENT", "BOTH"


def height_of(tree, kind: str):
    """An output socket: noise by the object's coordinates, waves of generated ones, a picture by the UV map."""
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    if kind == "picture":
        texture = tree.nodes.new("ShaderNodeTexImage")
        texture.image = waves()
        tree.links.new(coordinates.outputs["UV"], texture.inputs["Vector"])
        return texture.outputs["Color"]
    texture = tree.nodes.new("ShaderNodeTexNoise" if kind == "noise" else "ShaderNodeTexWave")
    for name, noise, wave in (("Scale", 6.0, 1.5), ("Detail", 1.0, 0.0)):
        texture.inputs[name].default_value = noise if kind == "noise" else wave
    tree.links.new(coordinates.outputs["Object" if kind == "noise" else "Generated"], texture.inputs["Vector"])
    return texture.outputs["Color"]


def waves():
    """A smooth picture of floats, 64 x 64."""
    found = bpy.data.images.get("waves")
    if found:
        return found
    size = 64
    made = bpy.data.images.new("waves", size, size, float_buffer=True, is_data=True)
    turns = [2.0 * math.pi * k / size for k in range(size)]
    pixels = [(0.5 + 0.4 * math.sin(2 * x) * math.cos(3 * y), 0.5 + 0.4 * math.cos(2 * x), 0.5 + 0.3 * math.sin(y), 1.0)
              for y in turns for x in turns]
    made.pixels.foreach_set([part for pixel in pixels for part in pixel])
    made.pack()
    return made


def displacement(kind: str, space: str, source: str, scale: float):
    """A function of a tree that makes the displacement of its output."""
    def build(tree):
        color = height_of(tree, source)
        if kind == "none":  # the colour itself
            middle = tree.nodes.new("ShaderNodeVectorMath")
            middle.operation = "MULTIPLY_ADD"
            middle.inputs[1].default_value, middle.inputs[2].default_value = (scale,) * 3, (-0.5 * scale,) * 3
            tree.links.new(color, middle.inputs[0])
            return middle.outputs[0]
        node = tree.nodes.new(f"ShaderNode{kind}")
        node.space = space
        node.inputs["Scale"].default_value, node.inputs["Midlevel"].default_value = scale, 0.4
        tree.links.new(color, node.inputs["Height" if kind == "Displacement" else "Vector"])
        return node.outputs[0]
    return build


CASES = [displacement("Displacement", "OBJECT", "noise", 0.3), displacement("Displacement", "WORLD", "wave", 0.1),
         displacement("Displacement", "OBJECT", "picture", 0.2),
         displacement("VectorDisplacement", "OBJECT", "noise", 0.4),
         displacement("VectorDisplacement", "WORLD", "picture", 0.2),
         displacement("VectorDisplacement", "TANGENT", "picture", 0.2), displacement("none", "", "noise", 0.3)]
SHAPES = ("ball", True), ("ball", False), ("tile", True), ("monkey", True)  # and whether it is smooth


def shown(number: int, lit: bool):
    """A material without displacement: it glows with its normal, or is diffuse or glossy."""
    if not lit:
        return emitting(f"case {number}", node_output("ShaderNodeNewGeometry", "Normal"))
    material, tree, output = new_material(f"case {number}")
    shader = tree.nodes.new("ShaderNodeBsdfGlossy" if number % 3 == 2 else "ShaderNodeBsdfDiffuse")
    shader.inputs["Roughness"].default_value = 0.4
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def displace(material, build, method: str) -> None:
    tree = material.node_tree
    output = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial")
    tree.links.new(build(tree), output.inputs["Displacement"])
    owner = material if hasattr(material, "displacement_method") else material.cycles
    owner.displacement_method = method


def make_shapes(lit: bool) -> None:
    empty_scene()
    number = 0
    for build in CASES:
        for method in METHODS:
            for shape, smooth in SHAPES:
                material = shown(number, lit)
                displace(material, build, method)
                ob = add_shape(shape, f"patch {number}", place_of(number, COLUMNS), material,
                               scale=(-0.9 if number % 3 == 1 else 0.9, 0.8, 0.7), rotation=(0.4, 0.3, 0.2))
                ob.data.polygons.foreach_set("use_smooth", [smooth] * len(ob.data.polygons))
                if shape == "tile":
                    ob.data.transform(((0.8, 0, 0, 0), (0, 0.8, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)))
                finer = ob.modifiers.new("finer", "SUBSURF")
                finer.levels = finer.render_levels = {"ball": 1, "tile": 5, "monkey": 2}[shape]
                finer.subdivision_type = "SIMPLE" if shape == "tile" else "CATMULL_CLARK"
                if number % 5 == 4:  # with a twin far away it is an instance
                    twin = ob.copy()
                    twin.location.x += 1000.0
                    bpy.context.scene.collection.objects.link(twin)
                number += 1
    frame(number, COLUMNS)
    if not lit:
        bpy.context.scene.cycles.filter_width = 0.01
        return
    lamp = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    lamp.data.energy, lamp.data.angle, lamp.rotation_euler = 2.0, 0.3, (0.5, 0.6, 0.0)
    bpy.context.scene.collection.objects.link(lamp)
    bpy.context.scene.world.node_tree.nodes["Background"].inputs[0].default_value = 0.3, 0.4, 0.5, 1.0


if __name__ == "__main__":
    save_all({"displacement": lambda: make_shapes(False), "displaced": lambda: make_shapes(True)}, sys.argv[-1])
