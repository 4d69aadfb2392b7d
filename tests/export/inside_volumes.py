"""Volumes: what nodes absorb, scatter and emit, which materials have one, and what a volume cannot ask for."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import bpy
import numpy as np
from common import NAMES, add, export, mesh, near, notes_of, run_all

from isophote.materials import OF_VOLUMES, OPERATIONS


def filled(kind, surface=None, link=None, **inputs):
    """A scene of a triangle whose material has a volume, and that volume's instructions by name."""
    material = bpy.data.materials.new("fog")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output, made = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new(kind)
    for name, value in inputs.items():
        made.inputs[name.replace("_", " ")].default_value = value
    tree.links.new(made.outputs[0], output.inputs["Volume"])
    if surface:
        tree.links.new(tree.nodes.new(surface).outputs[0], output.inputs["Surface"])
    if link:
        source, name = link
        tree.links.new(tree.nodes.new(source).outputs[name], made.inputs["Density"])
    add("box", mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)], materials=[material]))
    scene = export()
    (number,) = scene.material_volume[scene.material_volume > 0] - 1
    rows = range(*scene.material_first[number:number + 2])
    return scene, {NAMES[int(scene.instruction_op[row])][0]: row for row in rows}


def test_absorption_and_scattering():
    scene, rows = filled("ShaderNodeVolumeAbsorption", Color=(0.5, 0.8, 1.0, 1.0), Density=2.0)
    assert list(rows) == ["extinction"] and not scene.notes
    near(scene.instruction_weight[rows["extinction"]], (1.0, 0.4, 0.0))
    assert scene.material_first[1] == scene.material_first[0]  # a boundary without a surface


def test_scattering():
    scene, rows = filled("ShaderNodeVolumeScatter", Color=(0.5, 0.8, 1.0, 1.0), Density=2.0, Anisotropy=0.3)
    for name in ("extinction", "scattering"):
        near(scene.instruction_weight[rows[name]], (1.0, 1.6, 2.0))
    near(scene.instruction_params[rows["scattering"]][:2], (0.3, 0.0))


def test_principled():
    scene, rows = filled("ShaderNodeVolumePrincipled", Color=(0.5, 0.5, 0.5, 1.0), Density=2.0,
                         Absorption_Color=(0.25, 0.0, 1.0, 1.0), Emission_Strength=3.0)
    near(scene.instruction_weight[rows["scattering"]], (1.0, 1.0, 1.0))
    near(scene.instruction_weight[rows["extinction"]], (1.5, 2.0, 1.0))
    near(scene.instruction_weight[rows["emission"]], (3.0, 3.0, 3.0))


def test_a_black_surface_is_one():
    scene, _ = filled("ShaderNodeVolumeAbsorption", surface="ShaderNodeBsdfDiffuse")
    assert scene.material_first[1] > 0


def test_what_differs_has_steps():
    scene, rows = filled("ShaderNodeVolumeScatter", link=("ShaderNodeTexNoise", 0))
    number = int(scene.material_volume.max()) - 1
    assert scene.material_steps[number + 1] > scene.material_steps[number] and not scene.notes
    assert (scene.mesh_attributes[:, :, 1] == 1).all()  # the box of the texture space


def test_there_is_no_surface_inside():
    scene, rows = filled("ShaderNodeVolumeScatter", link=("ShaderNodeTexCoord", "UV"))
    assert "no surface" in notes_of(scene, "fog")[0] and not scene.instruction_weight[list(rows.values())].any()


def test_worlds():
    world = bpy.data.worlds.new("world")
    bpy.context.scene.world = world
    world.use_nodes = True
    tree = world.node_tree
    fog = tree.nodes.new("ShaderNodeVolumeScatter")
    tree.links.new(fog.outputs[0], next(n for n in tree.nodes if n.type == "OUTPUT_WORLD").inputs["Volume"])
    scene = export()
    assert scene.world_volume > 0 and not scene.notes
    assert np.isin(scene.instruction_op, [OPERATIONS[name][0] for name in OF_VOLUMES]).all()


run_all(sys.modules[__name__])
