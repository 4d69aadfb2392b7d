"""Nodes that convert values: each, in each mode that this Blender has, becomes steps or constants, without a note."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import bpy
import numpy as np
from common import ROOT, add, export, material, near, node, notes_of, program, run_all, square

sys.path.insert(0, str(ROOT / "blend_scenes" / "nodes"))
import make_conversions
from patches import Graph

VARIES = 1  # INSTRUCTION_VARIES of kernels/scene_records.h


def flags_of(scene) -> dict:
    """Flags of each material's first instruction."""
    return {name: int(scene.instruction_flags[scene.material_first[k]])
            for k, name in enumerate(scene.names["materials"])}


def check(entries: dict, varying: bool) -> None:
    for name, build in entries.items():
        made = bpy.data.materials.new(name)
        made.use_nodes = True
        made.node_tree.nodes.clear()
        graph = Graph(made.node_tree)
        graph.show(build(graph, make_conversions.Inputs(graph, varying)))
        add(name, square(materials=(made,)))
    scene = export()
    assert not scene.notes, scene.notes
    flags = flags_of(scene)
    assert len(flags) >= len(entries)
    constant = [name for name in entries if not flags[name] & VARIES]
    # What is turned by nothing, or mapped from an empty range, does not vary either.
    assert len(constant) <= 3 if varying else len(constant) == len(entries), constant


def test_numbers():
    check(make_conversions.numbers(), True)


def test_constant_numbers():
    check(make_conversions.numbers(), False)


def test_vectors():
    check(make_conversions.vectors(), True)


def test_constant_vectors():
    check(make_conversions.vectors(), False)


def test_colours():
    check(make_conversions.colours(), True)


def test_constant_colours():
    check(make_conversions.colours(), False)


def emitted(build) -> np.ndarray:
    """The constant colour that a material emits; `build(tree)` returns the socket."""
    def surface(tree, output):
        emission = node(tree, "ShaderNodeEmission", output.inputs["Surface"])
        tree.links.new(build(tree), emission.inputs["Color"])
    add("square", square(materials=(material("tested", surface),)))
    scene = export()
    assert not notes_of(scene, "tested")
    (operation, weight, _), = program(scene, "tested")
    assert operation == "emission"
    return weight


def test_constant_ramps_and_curves_are_blenders_own():
    made = {}

    def build(tree):
        made["ramp"] = ramp = node(tree, "ShaderNodeValToRGB", Fac=0.3711)
        ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].position = (0.2, 0.4, 0.1, 1.0), 0.61
        made["curve"] = curve = node(tree, "ShaderNodeRGBCurve", Fac=1.0)
        curve.mapping.curves[3].points.new(0.4, 0.7)
        curve.mapping.update()
        tree.links.new(ramp.outputs["Color"], curve.inputs["Color"])
        return curve.outputs["Color"]

    found = emitted(build)
    mapping = made["curve"].mapping
    wanted = [mapping.evaluate(mapping.curves[k], mapping.evaluate(mapping.curves[3], x))
              for k, x in enumerate(made["ramp"].color_ramp.evaluate(0.3711)[:3])]
    near(found, wanted, 1e-6)


def test_old_nodes():
    """Separate and Combine RGB and HSV, which 5.0 no longer has."""
    if not hasattr(bpy.types, "ShaderNodeSeparateHSV"):
        return

    def build(tree):
        last = None
        for kind in ("RGB", "HSV"):
            apart, together = (tree.nodes.new(f"ShaderNode{verb}{kind}") for verb in ("Separate", "Combine"))
            if last:
                tree.links.new(last, apart.inputs[0])
            else:
                apart.inputs[0].default_value = (0.7, 0.2, 0.4, 1.0)
            for output, into in zip(apart.outputs, together.inputs, strict=True):
                tree.links.new(output, into)
            last = together.outputs[0]
        return last

    near(emitted(build), (0.7, 0.2, 0.4), 1e-6)


run_all(sys.modules[__name__])
