# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a scene of balls on a floor under lamps.

    python blend_scenes/nodes/make_lamps.py -- OUT.blend CASE        (or blender -b --python ...)

CASE: a name of CASES below.
"""

import sys
from math import radians
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import bpy
from make_worlds import add, new_scene, picture, shader


def lamp(kind, **settings):
    data = bpy.data.lights.new(kind, kind)
    for name, value in settings.items():
        setattr(data if hasattr(data, name) else data.cycles, name, value)
    return data


def dark(scene):
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0


# ------------------------------------------------------------------ shapes


def spread(scene):
    """A rectangle, an ellipse and a disk, the last one seen by the camera."""
    add(scene, "rectangle", lamp("AREA", shape="RECTANGLE", size=2.0, size_y=0.7, energy=120.0, spread=radians(60.0)),
        (-2, 0, 3), (0.1, -0.3, 0.3))
    add(scene, "ellipse", lamp("AREA", shape="ELLIPSE", size=1.5, size_y=0.8, energy=90.0, color=(0.5, 0.7, 1.0),
                               spread=radians(25.0)), (1.5, 0, 3.5), (0, 0.1, 0))
    seen = add(scene, "disk", lamp("AREA", shape="DISK", size=1.0, energy=60.0, color=(1.0, 0.6, 0.4),
                                   spread=radians(100.0)), (0, 2, 1.5), (radians(80.0), 0, 0))
    seen.visible_camera = True


def narrow(scene):
    add(scene, "beam", lamp("AREA", shape="SQUARE", size=1.5, energy=30.0, spread=radians(3.0)), (-1, -0.5, 4),
        (0.1, 0.2, 0))
    add(scene, "disk", lamp("AREA", shape="DISK", size=2.5, energy=60.0, spread=radians(10.0)), (1.5, 0, 3))


def stretched(scene):
    add(scene, "spot", lamp("SPOT", energy=600.0, spot_size=radians(50.0), spot_blend=0.4, shadow_soft_size=0.2),
        (-1, -1, 4), (0.3, -0.2, 0.4), (2.0, 0.7, 1.0))
    add(scene, "ball", lamp("SPOT", energy=300.0, spot_size=radians(70.0), spot_blend=0.0, shadow_soft_size=0.3,
                            use_soft_falloff=False), (2, -1, 3), (0.3, 0.4, 0), (1.0, 1.0, 1.8))


# ------------------------------------------------------------------ limits


def hidden(scene):
    """Each of three lamps hidden from a kind of rays."""
    for name, x in (("diffuse", -3), ("glossy", 0), ("transmission", 3)):
        placed = add(scene, name, lamp("AREA", shape="SQUARE", size=1.5, energy=100.0), (x, -1, 4), (0, 0.2 * x, 0))
        setattr(placed, f"visible_{name}", False)


def hidden_mixed(scene):
    """The same beside a ball that is diffuse and glossy at once; rays find no lamps, for Cycles' weights do not add up
    to 1 there."""
    hidden(scene)
    mixed = shader("mixed", "ShaderNodeBsdfPrincipled", Roughness=0.4, Metallic=0.3)
    bpy.data.objects["diffuse"].data.materials[0] = mixed
    for light in bpy.data.lights:
        light.cycles.use_multiple_importance_sampling = False


def bounces(scene):
    """Limits of 0 and 1; without a size, for Cycles' rays find lamps beyond their limits."""
    for x, most in ((-2, 0), (2, 1)):
        color = (1.0, 0.5 + 0.2 * x, 0.3)
        data = lamp("POINT", energy=200.0, shadow_soft_size=0.0, max_bounces=most, color=color)
        add(scene, f"{most}", data, (x, -1, 3))


# ------------------------------------------------------------------ nodes


def nodes_of(data):
    """(tree, its Emission)."""
    data.use_nodes = True
    tree = data.node_tree
    tree.nodes.clear()
    emission = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(emission.outputs[0], tree.nodes.new("ShaderNodeOutputLight").inputs["Surface"])
    return tree, emission


def made(tree, kind, inputs=(), **settings):
    """A node with settings of it, or values of its inputs; `inputs`: pairs of an input and the output that feeds it."""
    node = tree.nodes.new(kind)
    for name, value in settings.items():
        setattr(node, name, value)
    for name, value in inputs:
        if isinstance(value, bpy.types.NodeSocket):
            tree.links.new(value, node.inputs[name])
        else:
            node.inputs[name].default_value = value
    return node


def checker(tree, emission, vector, scale):
    node = made(tree, "ShaderNodeTexChecker", [("Vector", vector), ("Scale", scale), ("Color1", (1.0, 0.3, 0.1, 1.0)),
                                               ("Color2", (0.05, 0.2, 0.6, 1.0))])
    tree.links.new(node.outputs["Color"], emission.inputs["Color"])


def coordinates(scene, output, node="ShaderNodeTexCoord", scale=7.0):
    """One of each kind of lamp, its colour a checker of some coordinates of its own; the area lamps are seen."""
    for number, (kind, place, rotation, size, settings) in enumerate((
            ("POINT", (-2.5, -1, 2.5), (0.3, 0.2, 0.5), (1, 1, 1), dict(energy=150.0, shadow_soft_size=0.3)),
            ("POINT", (2.5, -1, 2.5), (0.3, 0.2, 0.5), (1, 2, 1),
             dict(energy=150.0, shadow_soft_size=0.4, use_soft_falloff=False)),
            ("SPOT", (0, -2, 4), (0.3, 0.1, 0.5), (1, 1, 1),
             dict(energy=500.0, shadow_soft_size=0.2, spot_size=radians(60.0), spot_blend=0.1)),
            ("SUN", (0, 0, 9), (0.5, 0.3, 0.2), (1, 1, 1), dict(energy=0.5, angle=0.6)),
            ("AREA", (0, 2.5, 1.8), (radians(80.0), 0.1, 0.2), (1.5, 1, 1),
             dict(energy=80.0, shape="RECTANGLE", size=1.5, size_y=1.0)))):
        data = lamp(kind, **settings)
        tree, emission = nodes_of(data)
        checker(tree, emission, made(tree, node).outputs[output], scale)
        add(scene, f"{kind} {number}", data, place, rotation, size).visible_camera = kind == "AREA"


def picture_spot(scene):
    """A spot that throws a picture, an area lamp that shines with it."""
    for kind, place, rotation, settings in (
            ("SPOT", (-1, -1.5, 4), (0.2, -0.2, 0.4),
             dict(energy=900.0, spot_size=radians(50.0), shadow_soft_size=0.05)),
            ("AREA", (2, 2, 2), (radians(70.0), 0, 0), dict(energy=100.0, size=1.5))):
        data = lamp(kind, **settings)
        tree, emission = nodes_of(data)
        node = made(tree, "ShaderNodeTexImage", [("Vector", made(tree, "ShaderNodeTexCoord").outputs["UV"])],
                    image=picture(128), extension="CLIP")
        tree.links.new(node.outputs["Color"], emission.inputs["Color"])
        add(scene, kind, data, place, rotation).visible_camera = kind == "AREA"


def graphs(scene):
    """Noise, Blackbody of a ramp, Light Path, Math; object info; mixed shaders."""
    data = lamp("POINT", energy=200.0, shadow_soft_size=0.2)
    tree, emission = nodes_of(data)
    normal = made(tree, "ShaderNodeTexCoord").outputs["Normal"]
    noise = made(tree, "ShaderNodeTexNoise", [("Vector", normal), ("Scale", 3.0)])
    kelvin = made(tree, "ShaderNodeMapRange", [("Value", noise.outputs["Fac"]), (3, 1500.0), (4, 9000.0)])
    warm = made(tree, "ShaderNodeBlackbody", [("Temperature", kelvin.outputs[0])])
    tree.links.new(warm.outputs[0], emission.inputs["Color"])
    add(scene, "noise", data, (-2, -1, 2.5), (0.4, 0.1, 0.2))
    data = lamp("AREA", energy=150.0, size=1.2)
    tree, emission = nodes_of(data)
    split = made(tree, "ShaderNodeSeparateXYZ", [(0, made(tree, "ShaderNodeNewGeometry").outputs["Parametric"])])
    power = made(tree, "ShaderNodeMath", [(0, split.outputs["X"]), (1, 3.0)], operation="POWER")
    length = made(tree, "ShaderNodeLightPath").outputs["Ray Length"]
    length = made(tree, "ShaderNodeMath", [(0, power.outputs[0]), (1, length)], operation="MULTIPLY")
    tree.links.new(length.outputs[0], emission.inputs["Strength"])
    tree.links.new(made(tree, "ShaderNodeObjectInfo").outputs["Color"], emission.inputs["Color"])
    placed = add(scene, "ramp", data, (2, 1, 3), (0.2, 0.4, 0.3))
    placed.color = (0.4, 1.0, 0.6, 1.0)


PHOTOMETRY = """IESNA:LM-63-2002
[TEST] made
TILT=NONE
1 1000 1.5 7 5 1 2 0.1 0.1 0.1
1 0.9 100
0 20 40 60 75 90 180
0 22.5 45 67.5 90
900 800 500 250 90 20 0
900 850 600 350 120 20 0
900 700 300 500 160 20 0
900 600 200 350 90 20 0
900 500 300 150 40 20 0
"""


def photometric(scene):
    """Three lamps with the table of a luminaire, one turned and scaled, one whose vector is a normal."""
    text = bpy.data.texts.new("luminaire")
    text.write(PHOTOMETRY)
    for number, (kind, place, rotation, size) in enumerate((
            ("POINT", (-1.5, -1, 3), (0.3, 0.5, 0.7), (1, 1, 1)), ("SPOT", (2, 0, 3.5), (0.2, 0.1, 1.0), (1, 1.5, 1)),
            ("AREA", (0, 3, 2), (radians(60.0), 0, 0.3), (1, 1, 1)))):
        data = lamp(kind, energy=1.0)
        tree, emission = nodes_of(data)
        node = made(tree, "ShaderNodeTexIES", [("Strength", 0.4)], ies=text)
        if kind == "AREA":
            tree.links.new(made(tree, "ShaderNodeNewGeometry").outputs["Incoming"], node.inputs["Vector"])
        tree.links.new(node.outputs[0], emission.inputs["Strength"])
        add(scene, f"{kind} {number}", data, place, rotation, size)


def falloff(scene):
    """Each output of Light Falloff, with and without smoothing."""
    outputs = (("Quadratic", 2.0), ("Linear", 0.0), ("Linear", 1.0), ("Constant", 0.5))
    for number, (output, smooth) in enumerate(outputs):
        data = lamp("SUN" if number == 2 else "POINT", energy=0.3 if number == 2 else 60.0)
        tree, emission = nodes_of(data)
        node = made(tree, "ShaderNodeLightFalloff", [("Strength", 1.0 if number else 4.0), ("Smooth", smooth)])
        tree.links.new(node.outputs[output], emission.inputs["Strength"])
        add(scene, f"{output} {number}", data, (3 * number - 4.5, -1, 2 + 0.5 * number), (0.2, 0.3, 0))


CASES = {
    "spread": spread,
    "narrow": narrow,
    "stretched": stretched,
    "hidden": hidden,
    "hidden_mixed": hidden_mixed,
    "bounces": bounces,
    "object": lambda scene: coordinates(scene, "Object", scale=5.0),
    "normal": lambda scene: coordinates(scene, "Normal", scale=3.0),
    "uv": lambda scene: coordinates(scene, "UV"),
    "position": lambda scene: coordinates(scene, "Position", "ShaderNodeNewGeometry", scale=5.0),
    "incoming": lambda scene: coordinates(scene, "Incoming", "ShaderNodeNewGeometry", scale=5.0),
    "parametric": lambda scene: coordinates(scene, "Parametric", "ShaderNodeNewGeometry"),
    "picture": picture_spot,
    "graphs": graphs,
    "photometric": photometric,
    "falloff": falloff,
}


if __name__ == "__main__":
    out, case = sys.argv[sys.argv.index("--") + 1:]
    opened = new_scene()
    dark(opened)
    CASES[case](opened)
    bpy.ops.wm.save_as_mainfile(filepath=out)
