# SPDX-License-Identifier: GPL-3.0-or-later
"""All kinds of closures, rendered with every pass by Cycles and by this engine into multilayer EXRs."""

import math
import sys
from pathlib import Path

import addon_utils
import bpy

sys.path.insert(0, str(Path(__file__).parent))
from common import exr_output, render_to, report, small_scene  # noqa: E402

SAMPLES = 256

addon_utils.enable("cycles")
scene = small_scene(80, 48, SAMPLES)
for thing in [thing for thing in bpy.data.objects if thing.type != "CAMERA"]:
    bpy.data.objects.remove(thing)


def material(name, kind, parent=None, **inputs):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    output = nodes["Material Output"]
    nodes.remove(nodes["Principled BSDF"])
    node = nodes.new(kind)
    for socket, value in inputs.items():
        node.inputs[socket.replace("_", " ")].default_value = value
    shader = node.outputs[0]
    if parent:
        mix, other = nodes.new("ShaderNodeMixShader"), nodes.new(parent)
        mix.inputs[0].default_value = 0.5
        links.new(shader, mix.inputs[1])
        links.new(other.outputs[0], mix.inputs[2])
        shader = mix.outputs[0]
    links.new(shader, output.inputs["Surface"])
    return made


def ball(x, y, made):
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.8, location=(x, y, 0.8), segments=32, ring_count=16)
    bpy.ops.object.shade_smooth()
    bpy.context.object.data.materials.append(made)


bpy.ops.mesh.primitive_plane_add(size=12)
bpy.context.object.data.materials.append(material("Floor", "ShaderNodeBsdfDiffuse", Color=(0.7, 0.5, 0.3, 1)))
ball(-4, 0, material("Principled", "ShaderNodeBsdfPrincipled", Base_Color=(0.1, 0.5, 0.8, 1), Roughness=0.3))
ball(-2, 0, material("Glass", "ShaderNodeBsdfGlass", Color=(0.9, 1, 0.8, 1), Roughness=0.2, IOR=1.4))
ball(0, 0, material("Glossy", "ShaderNodeBsdfGlossy", Color=(0.9, 0.6, 0.2, 1), Roughness=0.3))
ball(2, 0, material("Mixed", "ShaderNodeBsdfDiffuse", "ShaderNodeBsdfTransparent", Color=(0.8, 0.2, 0.2, 1)))
ball(4, 0, material("Translucent", "ShaderNodeBsdfTranslucent", Color=(0.4, 0.8, 0.4, 1)))
bpy.ops.mesh.primitive_plane_add(size=2, location=(0, 3, 3), rotation=(math.radians(75), 0, 0))
bpy.context.object.data.materials.append(material("Panel", "ShaderNodeEmission", Color=(1, 0.8, 0.6, 1), Strength=3))
bpy.ops.object.light_add(type="AREA", location=(-4, -4, 6), rotation=(math.radians(40), 0, math.radians(-40)))
bpy.context.object.data.energy, bpy.context.object.data.size = 500, 2
scene.world.node_tree.nodes["Background"].inputs[0].default_value = (0.2, 0.3, 0.5, 1)
scene.camera.location, scene.camera.rotation_euler = (0, -13, 5), (math.radians(74), 0, 0)

layer = bpy.context.view_layer
for kind in ("diffuse", "glossy", "transmission"):
    for of in ("direct", "indirect", "color"):
        setattr(layer, f"use_pass_{kind}_{of}", True)
layer.use_pass_emit = layer.use_pass_environment = layer.use_pass_ambient_occlusion = True
scene.world.light_settings.distance = 2.5
layer.use_pass_uv = layer.use_pass_mist = layer.use_pass_object_index = layer.use_pass_material_index = True
layer.cycles.denoising_store_passes = True
for number, thing in enumerate(bpy.data.objects):
    thing.pass_index = number + 2
for number, made in enumerate(bpy.data.materials):
    made.pass_index = 3 * number + 1
for name, kind in (("Place", "COLOR"), ("Share", "VALUE")):
    aov = layer.aovs.add()
    aov.name, aov.type = name, kind
def aov_outputs(tree) -> list:
    made = []
    for name in ("Place", "Share"):
        made.append(tree.nodes.new("ShaderNodeOutputAOV"))
        setattr(made[-1], "aov_name" if hasattr(made[-1], "aov_name") else "name", name)
        tree.links.new(tree.nodes.new("ShaderNodeNewGeometry").outputs["Position"], made[-1].inputs["Color"])
    return made


for output in aov_outputs(bpy.data.materials["Floor"].node_tree):
    output.inputs["Value"].default_value = 0.25
group, nodes = bpy.data.node_groups.new("Outputs", "ShaderNodeTree"), bpy.data.materials["Glass"].node_tree.nodes
if hasattr(group, "interface"):  # 4.0 and newer
    group.interface.new_socket("Share", in_out="INPUT", socket_type="NodeSocketFloat")
else:
    group.inputs.new("NodeSocketFloat", "Share")
within, entered = nodes.new("ShaderNodeGroup"), group.nodes.new("NodeGroupInput")
within.node_tree = group
within.inputs["Share"].default_value = 3.0
for output in aov_outputs(group):
    group.links.new(entered.outputs["Share"], output.inputs["Value"])
for name in ("Sky", "Lights"):
    bpy.ops.scene.view_layer_add_lightgroup(name=name)
scene.world.lightgroup = "Sky"
for thing in bpy.data.objects:
    if thing.type == "LIGHT" or any(slot.material.name == "Panel" for slot in thing.material_slots):
        thing.lightgroup = "Lights"
mist = scene.world.mist_settings
mist.start, mist.depth, mist.falloff = 9.0, 12.0, "QUADRATIC"
cycles, own = scene.cycles, scene.isophote
cycles.device, cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = "CPU", SAMPLES, False, False
cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = cycles.light_sampling_threshold = 0
cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces, cycles.transmission_bounces = 8, 4, 4, 8
own.max_bounces, own.diffuse_bounces, own.glossy_bounces, own.transmission_bounces = 8, 4, 4, 8
exr_output(scene, multilayer=True)
scene.render.engine = "CYCLES"
render_to(scene, "cycles.exr")
scene.render.engine = "ISOPHOTE"
render_to(scene, "isophote.exr")
report(version=bpy.app.version)
