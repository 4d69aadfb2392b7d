"""Nodes of lamps: programs, photometric files, what is a constant after all."""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import bpy
import numpy as np
from common import add, export, near, node, notes_of, run_all

WATTS = 4 * np.pi / 177.83
FILE = """IESNA:LM-63-1995
[TEST] 1
TILT={tilt}
1 1000 2.0 3 {count} 1 1 0 0 0
0.5 1 100
0 45, 90
{around}
{rows}
"""


def lamp(build, kind="POINT"):
    data = bpy.data.lights.new(kind, kind)
    data.color, data.energy = (1.0, 0.5, 0.25), 20.0
    data.use_nodes = True
    tree = data.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputLight")
    build(tree, node(tree, "ShaderNodeEmission", output.inputs[0]))
    return add("lamp", data)


def linked(kind, output, into, **settings):
    """Feeds an input of the Emission with an output of a new node."""

    def build(tree, emission):
        made = tree.nodes.new(kind)
        for name, value in settings.items():
            setattr(made, name, value)
        tree.links.new(made.outputs[output], emission.inputs[into])

    return build


def test_a_graph_is_a_program_of_its_own():
    lamp(linked("ShaderNodeTexCoord", "Normal", "Color"))
    scene = export()
    assert scene.light_material.tolist() == [1] and len(scene.material_first) == 2 and len(scene.step_op)
    near(scene.light_strength, [(20, 10, 5)])
    assert not scene.notes


def test_what_is_constant_is_strength():
    lamp(linked("ShaderNodeObjectInfo", "Color", "Color")).color = (0.5, 1.0, 2.0, 1.0)
    scene = export()
    near(scene.light_strength, [(10, 10, 10)])
    assert scene.light_material.tolist() == [0] and not len(scene.step_op)


def test_shaders_are_mixed():
    def build(tree, emission):
        tree.nodes.remove(emission)
        mix = tree.nodes.new("ShaderNodeMixShader")
        node(tree, "ShaderNodeEmission", mix.inputs[1], Strength=4.0)
        node(tree, "ShaderNodeBsdfDiffuse", mix.inputs[2])
        tree.links.new(mix.outputs[0], tree.nodes["Light Output"].inputs["Surface"])

    lamp(build)
    scene = export()
    near(scene.light_strength, [(40, 20, 10)])
    assert "diffuse" in notes_of(scene, "lamp")[0]


def test_photometric_files():
    from addon.export.photometry import NotPhotometric, parse_photometry

    def parsed(around, rows, tilt="NONE"):
        table = parse_photometry(FILE.format(tilt=tilt, count=len(around.split()), around=around, rows="\n".join(rows)))
        across, down = int(table[0]), int(table[1])
        return np.degrees(table[2:2 + across]), table[2 + across + down:].reshape(across, down) / WATTS

    angles, watts = parsed("0", ["1 2 3"])
    near(angles, (0, 360), 1e-3)
    near(watts, [(1, 2, 3)] * 2)
    angles, watts = parsed("0 45 90", ["1 2 3", "4 5 6", "7 8 9"], "INCLUDE\n1\n2\n0 90\n1 0.5")
    near(angles, range(0, 361, 45), 1e-3)
    near(watts[:, 0], (1, 4, 7, 4, 1, 4, 7, 4, 1))
    angles, watts = parsed("0 120 240", ["1 2 3", "4 5 6", "7 8 9"])
    near(angles, (0, 120, 240, 360), 1e-3)
    near(watts[3], watts[0])
    for text in ("", "TILT=NONE\n1 2 3", FILE.format(tilt="NONE", count=2, around="5 90", rows="1 2 3\n4 5 6")):
        try:
            parse_photometry(text)
        except NotPhotometric:
            continue
        raise AssertionError(text)


def test_ies_texture_of_text_and_file():
    text = bpy.data.texts.new("luminaire")
    text.write(FILE.format(tilt="NONE", count=1, around="0", rows="10 5 0"))
    lamp(linked("ShaderNodeTexIES", 0, "Strength", ies=text))
    inside = export()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "lamp.ies"
        path.write_text(text.as_string())
        bpy.data.lights["POINT"].node_tree.nodes["IES Texture"].mode = "EXTERNAL"
        bpy.data.lights["POINT"].node_tree.nodes["IES Texture"].filepath = str(path)
        outside = export()
        path.unlink()
        gone = export()
    np.testing.assert_array_equal(inside.value_tables, outside.value_tables)
    near(inside.value_tables[:2], (2, 3))
    near(gone.light_strength, np.array([(20, 10, 5)]) * 100.0)
    assert not inside.notes and "lamp.ies" in notes_of(gone, "lamp")[0]


def test_light_falloff_is_a_program():
    lamp(linked("ShaderNodeLightFalloff", "Linear", "Strength"))
    scene = export()
    assert scene.light_material.tolist() == [1] and not scene.notes


run_all(sys.modules[__name__])
