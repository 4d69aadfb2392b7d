# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture of shapes: balls, tori, monkeys and tiles side by side, each with a material of its own."""

from __future__ import annotations

from pathlib import Path

import bpy

COLUMNS = 6


def empty_scene() -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = 0.0, 0.0, 0.0, 1.0
    scene.view_settings.view_transform = "Standard"


def add_camera(place, rotation=(0.0, 0.0, 0.0), width: float | None = None) -> None:
    """Orthographic, `width` metres wide, or with Blender's own lens."""
    data = bpy.data.cameras.new("Camera")
    if width:
        data.type, data.ortho_scale = "ORTHO", width
    camera = bpy.data.objects.new("Camera", data)
    camera.location, camera.rotation_euler = place, rotation
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera


def new_material(name: str):
    """(material, its tree, the output node)."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    return material, tree, tree.nodes.new("ShaderNodeOutputMaterial")


def emitting(name: str, build, scale: float = 0.5, shift: float = 0.5):
    """A material that emits what build(tree) returns, an output socket, times a scale and shifted."""
    material, tree, output = new_material(name)
    light = tree.nodes.new("ShaderNodeEmission")
    mapped = tree.nodes.new("ShaderNodeCombineXYZ")
    parts = tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(build(tree), parts.inputs[0])
    for k in range(3):
        scaled = tree.nodes.new("ShaderNodeMath")
        scaled.operation = "MULTIPLY_ADD"
        scaled.inputs[1].default_value, scaled.inputs[2].default_value = scale, shift
        tree.links.new(parts.outputs[k], scaled.inputs[0])
        tree.links.new(scaled.outputs[0], mapped.inputs[k])
    tree.links.new(mapped.outputs[0], light.inputs["Color"])
    tree.links.new(light.outputs[0], output.inputs["Surface"])
    return material


def node_output(kind: str, output: str, inputs=None, **properties):
    """A function of a tree that adds a node and returns one of its outputs."""
    def build(tree):
        node = tree.nodes.new(kind)
        for name, value in properties.items():
            setattr(node, name, value)
        for name, value in (inputs or {}).items():
            node.inputs[name].default_value = value
        return node.outputs[output]
    build.label = " ".join([kind.removeprefix("ShaderNode"), output, *map(str, (inputs or properties).values())])
    return build


def add_shape(shape: str, name: str, place, material, scale=(1.0, 1.0, 1.0), rotation=(0.0, 0.0, 0.0)):
    """A smooth ball or monkey, a torus or a flat tile, with UV map, colour attribute and a custom property."""
    make = {"ball": lambda: bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=0.45),
            "monkey": lambda: bpy.ops.mesh.primitive_monkey_add(size=0.9),
            "torus": lambda: bpy.ops.mesh.primitive_torus_add(major_radius=0.3, minor_radius=0.14),
            "tile": lambda: bpy.ops.mesh.primitive_plane_add(size=0.9)}
    make[shape]()
    ob = bpy.context.active_object
    ob.name, ob.location, ob.scale, ob.rotation_euler = name, place, scale, rotation
    for polygon in ob.data.polygons:
        polygon.use_smooth = shape != "tile"
    colors = ob.data.color_attributes.new("Paint", "FLOAT_COLOR", "CORNER")
    for k, each in enumerate(colors.data):
        each.color = k % 3 / 2.0, k % 5 / 4.0, k % 7 / 6.0, 0.25 + k % 2 / 2.0
    ob["tint"] = 0.1, 0.6, 0.9
    ob.color, ob.pass_index = (0.2, 0.5, 0.8, 0.6), 3
    ob.data.materials.append(material)
    return ob


def place_of(number: int, columns: int = COLUMNS) -> tuple[float, float, float]:
    return number % columns + 0.5, -(number // columns) - 0.5, 0.0


def frame(count: int, columns: int = COLUMNS) -> None:
    """An orthographic camera over so many patches."""
    rows = -(-count // columns)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 32 * columns, 32 * rows
    scene.render.resolution_percentage = 100
    add_camera((columns / 2.0, -rows / 2.0, 10.0), width=float(max(columns, rows)))


def save_all(scenes: dict, folder: str) -> None:
    """Makes each scene and writes it as NAME.blend."""
    for name, make in scenes.items():
        make()
        bpy.ops.wm.save_as_mainfile(filepath=str(Path(folder) / f"{name}.blend"))
