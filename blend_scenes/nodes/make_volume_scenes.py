# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a scene of balls on a floor with volumes around them.

    python blend_scenes/nodes/make_volume_scenes.py -- OUT.blend KIND

KIND: fog (of the world, with a spot's beam), inside (the camera in a box of haze, another one in it, glass filled with
liquid, daylight), glow (a volume that shines, in another one),
clouds (densities by noise and gradients, in colours).
"""

import os
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import bpy
from make_worlds import add, new_scene, shader


def fill(tree, kind, **inputs):
    """Adds a node to what feeds the Volume of a tree's output."""
    output = next(node for node in tree.nodes if node.type.startswith("OUTPUT"))
    node, volume = tree.nodes.new(kind), output.inputs["Volume"]
    for name, value in inputs.items():
        node.inputs[name].default_value = value
    if not volume.is_linked:
        tree.links.new(node.outputs[0], volume)
        return
    both = tree.nodes.new("ShaderNodeAddShader")
    tree.links.new(volume.links[0].from_socket, both.inputs[0])
    tree.links.new(node.outputs[0], both.inputs[1])
    tree.links.new(both.outputs[0], volume)


def medium(name, *parts):
    """A material without a surface."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.node_tree.nodes.clear()
    material.node_tree.nodes.new("ShaderNodeOutputMaterial")
    for kind, inputs in parts:
        fill(material.node_tree, kind, **inputs)
    return material


def feed(tree, socket, kind, output, **properties):
    """Makes a node and links its output to a socket, or to that of this name of the tree's volume; returns the node."""
    node = tree.nodes.new(kind)
    for name, value in properties.items():
        setattr(node, name, value)
    if isinstance(socket, str):
        socket = next(each for each in tree.nodes if each.type == "PRINCIPLED_VOLUME").inputs[socket]
    tree.links.new(node.outputs[output], socket)
    return node


def box(scene, name, material, location, half):
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners, [], [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    mesh.materials.append(material)
    add(scene, name, mesh, location, scale=half)


def lamp(scene, kind, energy, location, rotation=(0, 0, 0), **properties):
    data = bpy.data.lights.new(kind.lower(), kind)
    data.energy = energy
    for name, value in properties.items():
        setattr(data, name, value)
    add(scene, kind.lower(), data, location, rotation)


def make(kind):
    scene = new_scene()
    scene.cycles.volume_bounces = 8
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.35, 0.4, 1.0)
    if kind == "fog":
        fill(scene.world.node_tree, "ShaderNodeVolumeScatter", Density=0.06, Anisotropy=0.4, Color=(0.9, 0.8, 0.7, 1.0))
        fill(scene.world.node_tree, "ShaderNodeVolumeAbsorption", Density=0.02, Color=(0.4, 0.6, 1.0, 1.0))
        lamp(scene, "SPOT", 2000.0, (-3, 1, 4), (0.0, -0.6, 0.0), spot_size=0.6, shadow_soft_size=0.1)
        lamp(scene, "AREA", 150.0, (3, -2, 4), (0.3, 0.6, 0.0), size=1.0)
    elif kind == "inside":
        box(scene, "haze", medium("haze", ("ShaderNodeVolumeScatter", {"Density": 0.08, "Anisotropy": 0.3})),
            (0, -1, 3.5), (5.5, 6.5, 3.8))
        smoke = medium("smoke", ("ShaderNodeVolumePrincipled", {"Density": 2.0}))
        box(scene, "smoke", smoke, (0, -1, 0.8), (0.6, 0.6, 0.7))
        glass = bpy.data.objects["glossy"].data.materials
        glass[0] = shader("glass", "ShaderNodeBsdfGlass", Roughness=0.0, IOR=1.33)
        fill(glass[0].node_tree, "ShaderNodeVolumeAbsorption", Density=1.0, Color=(0.9, 0.5, 0.3, 1.0))
        lamp(scene, "AREA", 300.0, (-3, -2, 5), (0.3, -0.5, 0.0), size=2.0)
    elif kind == "clouds":
        scene.cycles.volume_step_rate, scene.cycles.volume_max_steps = 0.3, 1024
        cloud = medium("cloud", ("ShaderNodeVolumePrincipled", {"Anisotropy": 0.3}))
        bumps = feed(cloud.node_tree, "Density", "ShaderNodeMath", 0, operation="MULTIPLY")
        bumps.inputs[1].default_value = 6.0
        above = feed(cloud.node_tree, bumps.inputs[0], "ShaderNodeMath", 0, operation="SUBTRACT", use_clamp=True)
        above.inputs[1].default_value = 0.45
        noise = feed(cloud.node_tree, above.inputs[0], "ShaderNodeTexNoise", 0)
        noise.inputs["Scale"].default_value = 4.0
        feed(cloud.node_tree, "Color", "ShaderNodeTexNoise", 1)
        box(scene, "cloud", cloud, (0, -1, 1.2), (1.2, 0.8, 0.7))
        glow = {"Density": 1.0, "Emission Color": (1.0, 0.4, 0.1, 1.0)}
        ember = medium("ember", ("ShaderNodeVolumePrincipled", glow))
        feed(ember.node_tree, "Emission Strength", "ShaderNodeTexGradient", 1, gradient_type="QUADRATIC")
        box(scene, "ember", ember, (0, 2.5, 1.0), (1.5, 0.3, 0.7))
        fill(scene.world.node_tree, "ShaderNodeVolumeScatter", Density=0.02)
        lamp(scene, "AREA", 300.0, (-3, -2, 5), (0.3, -0.5, 0.0), size=2.0)
    else:
        fire = medium("fire", ("ShaderNodeEmission", {"Color": (1.0, 0.5, 0.1, 1.0), "Strength": 2.0}),
                      ("ShaderNodeVolumeAbsorption", {"Density": 0.5}))
        cloud = medium("cloud", ("ShaderNodeVolumeScatter", {"Density": 0.5, "Color": (0.9, 0.9, 1.0, 1.0)}))
        box(scene, "fire", fire, (0, 0, 0.8), (0.4, 0.4, 0.7))
        box(scene, "cloud", cloud, (0, 0, 1.5), (2.8, 2.0, 1.6))
    return scene


if __name__ == "__main__":
    out, which = sys.argv[sys.argv.index("--") + 1:]
    make(which)
    bpy.ops.wm.save_as_mainfile(filepath=out)
    os._exit(0)
