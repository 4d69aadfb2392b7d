# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel says was left out: of a cube with hair shader, before and after its render, and of an empty layer."""

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from common import render_to, report, small_scene  # noqa: E402
from isophote_addon import left_out  # noqa: E402

scene = small_scene()
tree = bpy.data.objects["Cube"].active_material.node_tree
surface = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL").inputs["Surface"]
tree.links.new(tree.nodes.new("ShaderNodeBsdfHair").outputs[0], surface)
before = left_out.lines(scene.name, "ViewLayer")
empty = scene.view_layers.new("Empty")
for child in empty.layer_collection.children:
    child.exclude = True
render_to(scene, "picture.png")
report(before=before, after=left_out.lines(scene.name, "ViewLayer"), empty=left_out.lines(scene.name, "Empty"))
