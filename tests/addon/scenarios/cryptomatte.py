# SPDX-License-Identifier: GPL-3.0-or-later
"""Cryptomatte of parents, collections' instances, veils and a lens, and the compositor's matte of one object, by Cycles
and by this engine into multilayer EXRs."""

import math
import sys
from pathlib import Path

import addon_utils
import bpy

sys.path.insert(0, str(Path(__file__).parent))
from common import exr_output, render_to, report, small_scene  # noqa: E402

SAMPLES = 128

addon_utils.enable("cycles")
scene = small_scene(72, 48, SAMPLES)
scene.isophote.transparent_bounces = scene.cycles.transparent_max_bounces = 8
cube = bpy.data.objects["Cube"]
cube.location.z = 1
for name in ("Middle", "Top"):
    bpy.ops.object.empty_add()
    bpy.context.object.name = name
cube.parent, bpy.data.objects["Middle"].parent = bpy.data.objects["Middle"], bpy.data.objects["Top"]
bpy.ops.mesh.primitive_plane_add(size=30)
bpy.context.object.name = 'Floor of "stones" ä'

veil = bpy.data.materials.new("Veil")
veil.use_nodes = True
nodes, links = veil.node_tree.nodes, veil.node_tree.links
mix = nodes.new("ShaderNodeMixShader")
mix.inputs[0].default_value = 0.4
links.new(nodes.new("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[1])
links.new(nodes["Principled BSDF"].outputs[0], mix.inputs[2])
links.new(mix.outputs[0], nodes["Material Output"].inputs["Surface"])
bpy.ops.mesh.primitive_uv_sphere_add(radius=0.9)
ball = bpy.context.object
ball.name = "Ball"
ball.data.materials.append(veil)
kept = bpy.data.collections.new("Kept")
for collection in ball.users_collection:
    collection.objects.unlink(ball)
kept.objects.link(ball)
for place in ((-3, 0, 1), (2, -3, 1), (2, 3, 1)):
    instance = bpy.data.objects.new("Instance", None)
    instance.instance_type, instance.instance_collection, instance.location = "COLLECTION", kept, place
    scene.collection.objects.link(instance)
bpy.ops.mesh.primitive_cube_add(size=1, location=(0, -3, 0.5))
both = bpy.context.object
both.name = "Both"
for name in ("Left", "Right"):
    both.data.materials.append(bpy.data.materials.new(name))
for polygon in both.data.polygons:
    polygon.material_index = int(polygon.normal.z > 0.5)
scene.camera.location, scene.camera.rotation_euler = (0, -14, 5), (math.radians(74), 0, 0)
scene.camera.data.dof.use_dof, scene.camera.data.dof.focus_distance = True, 12
scene.camera.data.dof.aperture_fstop = 0.2

layer = bpy.context.view_layer
layer.use_pass_cryptomatte_object = layer.use_pass_cryptomatte_material = layer.use_pass_cryptomatte_asset = True
layer.pass_cryptomatte_depth = 5
if hasattr(scene, "compositing_node_group"):  # 5.0 and newer
    tree = scene.compositing_node_group = bpy.data.node_groups.new("Compositing", "CompositorNodeTree")
    tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    output = tree.nodes.new("NodeGroupOutput")
else:
    scene.use_nodes = True
    tree = scene.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("CompositorNodeComposite")
tree.nodes.new("CompositorNodeRLayers")  # or 3.4 would render nothing
node = tree.nodes.new("CompositorNodeCryptomatteV2")
node.source, node.scene, node.layer_name, node.matte_id = "RENDER", scene, "ViewLayer.CryptoObject", "Ball"
tree.links.new(node.outputs["Matte"], output.inputs[0])
cycles = scene.cycles
cycles.device, cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = "CPU", SAMPLES, False, False
exr_output(scene, multilayer=True)
for engine in ("CYCLES", "ISOPHOTE"):
    scene.render.engine = engine
    node.layer_name, node.matte_id = "ViewLayer.CryptoObject", "Ball"
    render_to(scene, f"{engine}.exr")
report(version=bpy.app.version)
