# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a scene with one ball for each shader of a list, seen from above: bench/shaders.py compares them with Cycles.

    python blend_scenes/nodes/make_shaders.py OUT.blend [WORD]    # only shaders whose names hold WORD

It wants a Python with the bpy wheel, 4.5 or newer. Prints the names in the order of the balls, as JSON.
"""

import json
import math
import os
import sys

import bpy

COLUMNS = 8
RADIUS = 0.45  # of a ball in a cell of 1 x 1
GOLD, LEAF, ROSE = (0.9, 0.6, 0.2), (0.2, 0.5, 0.1), (0.8, 0.3, 0.4)


def principled(**inputs):
    return "ShaderNodeBsdfPrincipled", {}, {"Base Color": ROSE} | {k.replace("_", " "): v for k, v in inputs.items()}


def grid() -> dict:
    """Name -> (node type, properties, inputs), or two of them that are mixed."""
    shaders = {}
    for rough in (0.0, 0.3, 1.0):
        shaders[f"diffuse {rough}"] = ("ShaderNodeBsdfDiffuse", {}, {"Color": ROSE, "Roughness": rough})
    shaders["translucent"] = ("ShaderNodeBsdfTranslucent", {}, {"Color": LEAF})
    for component in ("DIFFUSE", "GLOSSY"):
        for size, smooth in ((0.5, 0.2), (0.8, 0.0)):
            shaders[f"toon {component.lower()} {size}"] = (
                "ShaderNodeBsdfToon", {"component": component}, {"Color": GOLD, "Size": size, "Smooth": smooth})
    for distribution in ("ASHIKHMIN", "MICROFIBER"):
        for rough in (0.1, 0.3, 1.0):
            shaders[f"sheen {distribution.lower()} {rough}"] = (
                "ShaderNodeBsdfSheen", {"distribution": distribution}, {"Color": GOLD, "Roughness": rough})
    for distribution in ("GGX", "MULTI_GGX", "BECKMANN", "ASHIKHMIN_SHIRLEY"):
        for rough in (0.3, 0.8):
            shaders[f"glossy {distribution.lower()} {rough}"] = (
                "ShaderNodeBsdfAnisotropic", {"distribution": distribution}, {"Color": GOLD, "Roughness": rough})
        for amount in (-0.6, 0.8):
            shaders[f"anisotropic {distribution.lower()} {amount}"] = (
                "ShaderNodeBsdfAnisotropic", {"distribution": distribution},
                {"Color": GOLD, "Roughness": 0.4, "Anisotropy": amount, "Rotation": 0.1})
    for kind in ("Refraction", "Glass"):
        for distribution in ("GGX", "BECKMANN"):
            shaders[f"{kind.lower()} {distribution.lower()}"] = (
                f"ShaderNodeBsdf{kind}", {"distribution": distribution}, {"Color": GOLD, "Roughness": 0.4, "IOR": 1.5})
    for fresnel in ("F82", "PHYSICAL_CONDUCTOR"):
        for distribution in ("GGX", "MULTI_GGX"):
            shaders[f"metallic {fresnel.lower()} {distribution.lower()}"] = (
                "ShaderNodeBsdfMetallic", {"fresnel_type": fresnel, "distribution": distribution},
                {"Base Color": GOLD, "Edge Tint": LEAF, "IOR": (0.2, 0.9, 1.1), "Extinction": (3.9, 2.4, 2.2),
                 "Roughness": 0.5})
    shaders["metallic anisotropic"] = ("ShaderNodeBsdfMetallic", {}, {
        "Base Color": GOLD, "Roughness": 0.5, "Anisotropy": 0.9, "Rotation": 0.3})
    shaders |= {
        "principled": principled(),
        "principled diffuse roughness": principled(Diffuse_Roughness=0.8, Specular_IOR_Level=0.0),
        "principled sheen": principled(Sheen_Weight=0.8, Sheen_Roughness=0.3, Sheen_Tint=LEAF),
        "principled sheen, rough": principled(Sheen_Weight=1.0, Sheen_Roughness=1.0),
        "principled coat": principled(Coat_Weight=1.0, Coat_Roughness=0.1),
        "principled coat, rough": principled(Coat_Weight=0.6, Coat_Roughness=0.7, Coat_IOR=2.0, Roughness=0.2),
        "principled coat, tinted": principled(Coat_Weight=0.7, Coat_IOR=1.3, Coat_Tint=GOLD),
        "principled all": principled(Coat_Weight=0.5, Coat_Tint=LEAF, Sheen_Weight=0.5, Metallic=0.3, Alpha=0.8,
                                     Diffuse_Roughness=0.5, Transmission_Weight=0.3, Roughness=0.4),
        "principled metal under coat": principled(Coat_Weight=1.0, Metallic=1.0, Roughness=0.6, Specular_Tint=LEAF),
        "principled anisotropic": principled(Anisotropic=0.9, Metallic=0.5, Roughness=0.4, Anisotropic_Rotation=0.2),
        "principled film": principled(Thin_Film_Thickness=400.0, Thin_Film_IOR=1.4, Roughness=0.3, IOR=2.0),
        "principled film, tinted": principled(Thin_Film_Thickness=250.0, Specular_Tint=GOLD, Specular_IOR_Level=0.9),
        "principled film on glass": principled(Thin_Film_Thickness=500.0, Transmission_Weight=1.0, Roughness=0.2),
        "principled film, smooth glass": principled(Thin_Film_Thickness=15.0, Transmission_Weight=1.0, Roughness=0.0,
                                                    Thin_Film_IOR=1.8),
        "principled film on metal": principled(Thin_Film_Thickness=500.0, Metallic=1.0, Roughness=0.4),
        "two coats": (principled(Coat_Weight=1.0, Roughness=0.2), principled(Sheen_Weight=1.0, Base_Color=LEAF)),
    }
    return shaders


def make_shader(tree, kind, properties, inputs):
    made = tree.nodes.new(kind)
    for name, value in properties.items():
        setattr(made, name, value)
    for name, value in inputs.items():
        socket = next(s for s in made.inputs if s.identifier == name)
        socket.default_value = (*value, 1.0) if isinstance(value, tuple) and len(socket.default_value) == 4 else value
    return made.outputs[0]


def make_material(name, shader):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    surface = tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"]
    if isinstance(shader[0], str):
        tree.links.new(make_shader(tree, *shader), surface)
    else:
        mix = tree.nodes.new("ShaderNodeMixShader")
        for k, one in enumerate(shader):
            tree.links.new(make_shader(tree, *one), mix.inputs[1 + k])
        tree.links.new(mix.outputs[0], surface)
    return material


def make_ball(name, material, x, y):
    """Faceted: where shading and geometric normals differ engines have their own ways."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=RADIUS, location=(x, y, 0))
    ball = bpy.context.object
    ball.name = name
    ball.data.materials.append(material)


def make_scene(shaders):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    rows = math.ceil(len(shaders) / COLUMNS)
    for k, (name, shader) in enumerate(shaders.items()):
        make_ball(name, make_material(name, shader), k % COLUMNS + 0.5, k // COLUMNS + 0.5)
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = COLUMNS * 32, rows * 32
    scene.render.resolution_percentage = 100
    scene.cycles.max_bounces = scene.cycles.glossy_bounces = scene.cycles.transmission_bounces = 12
    scene.cycles.diffuse_bounces = 12
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale = "ORTHO", max(COLUMNS, rows)
    scene.camera = bpy.data.objects.new("camera", camera)
    scene.camera.location = COLUMNS / 2, rows / 2, 10
    scene.collection.objects.link(scene.camera)
    for name, place, color, energy in (("key", (-8, -6, 9), (1.0, 0.9, 0.8), 2500),
                                       ("rim", (16, 14, 3), (0.6, 0.8, 1.0), 1500)):
        lamp = bpy.data.lights.new(name, "AREA")
        lamp.energy, lamp.size, lamp.color = energy, 4, color
        ob = bpy.data.objects.new(name, lamp)
        ob.location = place
        scene.collection.objects.link(ob)
        aim = ob.constraints.new("TRACK_TO")
        aim.target, aim.track_axis, aim.up_axis = bpy.data.objects[next(iter(shaders))], "TRACK_NEGATIVE_Z", "UP_Y"
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.35, 0.4, 1.0)


if __name__ == "__main__":
    out, word = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else ""
    chosen = {name: shader for name, shader in grid().items() if word in name}
    make_scene(chosen)
    bpy.ops.wm.save_as_mainfile(filepath=out)
    print("SHADERS " + json.dumps(list(chosen)), flush=True)
    os._exit(0)  # the bpy module sometimes hangs while it is torn down
