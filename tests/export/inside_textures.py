"""Procedural textures in this version of Blender: every output in every mode becomes steps, without a note."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import bpy
from common import add, export, material, node, notes_of, run_all, square

ALL = ("Noise", "Musgrave", "WhiteNoise", "Checker", "Gradient", "Voronoi", "Wave", "Magic", "Brick")
KINDS = [kind for kind in ALL if hasattr(bpy.types, f"ShaderNodeTex{kind}")]
MODES = ("noise_dimensions", "noise_type", "musgrave_dimensions", "musgrave_type", "gradient_type",
         "voronoi_dimensions", "feature", "distance", "wave_type", "bands_direction", "rings_direction", "wave_profile")


def settings_of(kind) -> list[tuple]:
    """(property, value) of each mode, each of them changed alone."""
    properties = getattr(bpy.types, f"ShaderNodeTex{kind}").bl_rna.properties
    return [(name, item.identifier) for name in MODES if name in properties for item in properties[name].enum_items]


def shown(kind, number, setting=None):
    """A material that glows with an output of a texture, None where there is no such one in a mode."""
    def build(tree, output):
        emission = node(tree, "ShaderNodeEmission", output.inputs["Surface"])
        texture = tree.nodes.new(f"ShaderNodeTex{kind}")
        if setting:
            setattr(texture, *setting)
        coordinates = tree.nodes.new("ShaderNodeTexCoord")
        for socket in (texture.inputs.get("Vector"), texture.inputs.get("W")):
            if socket is not None:
                tree.links.new(coordinates.outputs["Object"], socket)
        tree.links.new(texture.outputs[number], emission.inputs["Color"])
    return material(f"{kind} {number} {setting}", build)


def test_every_output_in_every_mode():
    made = [shown(kind, number, setting) for kind in KINDS for setting in (None, *settings_of(kind))
            for number in range(outputs_of(kind))]
    for each in made:
        add(each.name, square(materials=(each,)))
    scene = export()
    assert len(made) > 100 and len(scene.step_op) > len(made)
    assert not [note for each in made for note in notes_of(scene, each.name)]


def outputs_of(kind) -> int:
    tree = bpy.data.node_groups.new("probe", "ShaderNodeTree")
    return len(tree.nodes.new(f"ShaderNodeTex{kind}").outputs)


def test_unlinked_textures_have_generated_coordinates():
    add("square", square(materials=(material("plain", lambda tree, output: tree.links.new(
        tree.nodes.new("ShaderNodeTexNoise").outputs[0],
        node(tree, "ShaderNodeEmission", output.inputs["Surface"]).inputs["Color"])),)))
    scene = export()
    assert scene.mesh_attributes.shape[1] == 1 and not notes_of(scene, "plain")


run_all(sys.modules[__name__])
