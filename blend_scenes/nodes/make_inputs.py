# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of the input nodes: each output of each node on a shape of its own.

    python blend_scenes/nodes/make_inputs.py -- FOLDER

Writes inputs.blend and instances.blend (shapes emit the values, noise-free) and paths.blend (Light Path, over floors
that scatter light in different ways). Needs bpy.
"""

from __future__ import annotations

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from shapes import add_shape, emitting, empty_scene, frame, new_material, node_output, place_of, save_all  # noqa: E402


def make_inputs() -> None:
    empty_scene()
    other = bpy.data.objects.new("Other", None)
    other.location, other.rotation_euler, other.scale = (1.0, -2.0, 0.3), (0.3, 0.2, 0.9), (1.0, 2.0, 0.5)
    bpy.context.scene.collection.objects.link(other)
    bpy.context.view_layer["strength"] = 0.7
    cases = [node_output("ShaderNodeTexCoord", name) for name in
             ("Generated", "Normal", "UV", "Object", "Camera", "Window", "Reflection")]
    cases.append(node_output("ShaderNodeTexCoord", "Object", object=other))
    cases += [node_output("ShaderNodeNewGeometry", name) for name in
              ("Position", "Normal", "Tangent", "True Normal", "Incoming", "Parametric", "Backfacing",
               "Random Per Island", "Pointiness")]
    cases += [node_output("ShaderNodeObjectInfo", name) for name in
              ("Location", "Color", "Alpha", "Object Index", "Material Index", "Random")]
    cases += [node_output("ShaderNodeLayerWeight", name, {"Blend": blend}) for name in ("Fresnel", "Facing")
              for blend in (0.2, 0.5, 0.8)]
    cases += [node_output("ShaderNodeFresnel", "Fac", {"IOR": ior}) for ior in (0.7, 1.45)]
    cases += [node_output("ShaderNodeCameraData", name) for name in ("View Vector", "View Z Depth", "View Distance")]
    cases += [node_output("ShaderNodeTangent", "Tangent", axis=axis) for axis in "XYZ"]
    cases.append(node_output("ShaderNodeTangent", "Tangent", direction_type="UV_MAP"))
    cases += [node_output("ShaderNodeAttribute", name, attribute_name="Paint") for name in ("Color", "Fac", "Alpha")]
    cases.append(node_output("ShaderNodeAttribute", "Color", attribute_name="tint", attribute_type="OBJECT"))
    cases.append(node_output("ShaderNodeAttribute", "Color", attribute_name="strength", attribute_type="VIEW_LAYER"))
    cases.append(node_output("ShaderNodeVertexColor", "Color", layer_name="Paint"))
    cases.append(node_output("ShaderNodeVertexColor", "Alpha"))
    cases.append(node_output("ShaderNodeUVMap", "UV"))
    cases.append(node_output("ShaderNodeWireframe", "Fac", {"Size": 0.03}))
    cases.append(node_output("ShaderNodeWireframe", "Fac", {"Size": 2.0}, use_pixel_size=True))
    cases += [node_output("ShaderNodeHairInfo", "Is Strand"), node_output("ShaderNodeParticleInfo", "Random"),
              node_output("ShaderNodeLightPath", "Ray Length"), node_output("ShaderNodeLightPath", "Is Camera Ray")]
    shapes = ("ball", "torus", "monkey")
    for number, build in enumerate(cases):
        material = emitting(f"{number}", build, 0.1, 0.5)
        material.pass_index = 2
        mirrored = -1.0 if number % 2 else 1.0
        add_shape(shapes[number % 3], build.label, place_of(number), material,
                  scale=(mirrored, 1.0, 0.8), rotation=(0.4, 0.3, 0.2))
    frame(len(cases))
    bpy.context.scene.cycles.filter_width = 0.01  # a pixel is the value at its centre


def seen_by(name: str, output: str, scale: float):
    """Transparent or emitting, by an output of Light Path: so that shadow rays ask for it, too."""
    material, tree, end = new_material(name)
    path = tree.nodes.new("ShaderNodeLightPath")
    scaled = tree.nodes.new("ShaderNodeMath")
    scaled.operation, scaled.use_clamp, scaled.inputs[1].default_value = "MULTIPLY", True, scale
    tree.links.new(path.outputs[output], scaled.inputs[0])
    clear, diffuse = tree.nodes.new("ShaderNodeBsdfTransparent"), tree.nodes.new("ShaderNodeBsdfDiffuse")
    mixed = tree.nodes.new("ShaderNodeMixShader")
    tree.links.new(scaled.outputs[0], mixed.inputs[0])
    tree.links.new(diffuse.outputs[0], mixed.inputs[1])
    tree.links.new(clear.outputs[0], mixed.inputs[2])
    tree.links.new(mixed.outputs[0], end.inputs["Surface"])
    return material


def plain(shader: str, roughness: float | None = None):
    material, tree, end = new_material(shader)
    node = tree.nodes.new(shader)
    if roughness is not None:
        node.inputs["Roughness"].default_value = roughness
    tree.links.new(node.outputs[0], end.inputs["Surface"])
    return material


def make_paths() -> None:
    """Balls over a floor, a mirror and glass: what they are follows from how rays get to them."""
    empty_scene()
    floors = [plain("ShaderNodeBsdfDiffuse"), plain("ShaderNodeBsdfGlossy", 0.0), plain("ShaderNodeBsdfGlossy", 0.3),
              plain("ShaderNodeBsdfGlass", 0.0)]
    outputs = [("Is Camera Ray", 1.0), ("Is Shadow Ray", 0.7), ("Is Diffuse Ray", 1.0), ("Is Glossy Ray", 1.0),
               ("Is Singular Ray", 1.0), ("Is Reflection Ray", 1.0), ("Is Transmission Ray", 1.0), ("Ray Length", 0.2),
               ("Ray Depth", 0.3), ("Diffuse Depth", 0.4), ("Glossy Depth", 0.4), ("Transmission Depth", 0.4),
               ("Transparent Depth", 0.4)]
    number = 0
    for output, scale in outputs:
        for floor in floors:
            x, y, _ = place_of(number, 8)
            add_shape("tile", f"floor {number}", (x, y, -0.4), floor)
            add_shape("ball", f"ball {number}", (x, y, 0.1), seen_by(f"{output} {number}", output, scale),
                      scale=(0.5, 0.5, 0.5))
            number += 1
    lamp = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    lamp.data.energy, lamp.data.angle, lamp.rotation_euler = 2.0, 0.2, (0.5, 0.5, 0.0)
    bpy.context.scene.collection.objects.link(lamp)
    bpy.context.scene.world.node_tree.nodes["Background"].inputs[0].default_value = 0.4, 0.4, 0.4, 1.0
    frame(number, 8)


def grid(name: str, place) -> bpy.types.Object:
    """A square of nine faces with a UV map, from which others are instanced."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=3, y_subdivisions=3, size=0.9)
    ob = bpy.context.active_object
    ob.name, ob.location = name, place
    ob["tint"] = 0.9, 0.3, 0.1
    return ob


def make_instances() -> None:
    """Tiles that faces and particles of a grid carry: what they know of themselves and of what carries them."""
    empty_scene()
    faces = [node_output("ShaderNodeTexCoord", name, from_instancer=True) for name in ("Generated", "UV")]
    faces += [node_output("ShaderNodeUVMap", "UV", from_instancer=True),
              node_output("ShaderNodeObjectInfo", "Random"), node_output("ShaderNodeObjectInfo", "Location"),
              node_output("ShaderNodeAttribute", "Color", attribute_name="tint", attribute_type="INSTANCER")]
    particles = [node_output("ShaderNodeParticleInfo", name) for name in
                 ("Index", "Random", "Age", "Lifetime", "Location", "Size")]
    for number, build in enumerate(faces + particles):
        carrier = grid(f"grid {number}", place_of(number))
        shape = "tile" if number < len(faces) else "ball"  # particles turn what they carry
        tile = add_shape(shape, build.label, place_of(number), emitting(f"{number}", build, 0.1, 0.3),
                         scale=(0.2, 0.2, 0.2))
        if number < len(faces):
            carrier.instance_type, carrier.show_instancer_for_render = "FACES", False
            tile.parent, tile.location = carrier, (0.0, 0.0, 0.0)
            continue
        tile.location.z = -5.0  # far below: only the particles' copies show
        tile.location.x += 100.0
        carrier.show_instancer_for_render = False
        settings = carrier.modifiers.new("particles", "PARTICLE_SYSTEM").particle_system.settings
        settings.count, settings.frame_start, settings.frame_end, settings.lifetime = 20, 0.0, 1.0, 40.0
        settings.render_type, settings.instance_object, settings.particle_size = "OBJECT", tile, 0.5
        settings.physics_type, settings.size_random, settings.lifetime_random = "NO", 0.5, 0.3
    bpy.context.scene.frame_set(1)  # where particle systems begin
    frame(len(faces + particles))
    bpy.context.scene.cycles.filter_width = 0.01


if __name__ == "__main__":
    save_all({"inputs": make_inputs, "instances": make_instances, "paths": make_paths}, sys.argv[-1])
