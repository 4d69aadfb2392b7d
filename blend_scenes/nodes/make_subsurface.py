# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a scene with one ball for each kind of subsurface scattering, as make_shaders.py does for other shaders.

    python blend_scenes/nodes/make_subsurface.py OUT.blend [WORD]    # only those whose names hold WORD
"""

import json
import os
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import bpy
from make_shaders import GOLD, LEAF, ROSE, make_scene, principled

GREY, DARK, WHITE = (0.8, 0.8, 0.8), (0.02, 0.1, 0.5), (1.0, 1.0, 1.0)
SKIN_TONE = (0.8, 0.5, 0.35)


def node(method="RANDOM_WALK", **inputs):
    return ("ShaderNodeSubsurfaceScattering", {"falloff": method},
            {"Color": ROSE, "Scale": 1.0} | {k.replace("_", " "): v for k, v in inputs.items()})


def beneath(method="RANDOM_WALK", **inputs):
    kind, _, given = principled(**inputs)
    return kind, {"subsurface_method": method}, {"Subsurface Weight": 1.0, "Subsurface Scale": 1.0} | given


def grid() -> dict:
    return {
        "node, scale 0.05": node(Scale=0.05),
        "node": node(),
        "node, scale 5": node(Scale=5.0),
        "node, grey": node(Color=GREY, Radius=(1.0, 1.0, 1.0)),
        "node, dark": node(Color=DARK),
        "node, nearly white": node(Color=(0.95, 0.95, 0.95), Scale=2.0),
        "node, anisotropy 0.4": node(Anisotropy=0.4),
        "node, anisotropy 0.9": node(Anisotropy=0.9, Color=GOLD),
        "node, smooth entry": node(Roughness=0.0, IOR=2.0),
        "node, rough entry": node(Roughness=0.5, IOR=1.2),
        "node, a channel without radius": node(Radius=(1.0, 0.0, 0.1)),
        "skin": node("RANDOM_WALK_SKIN", Scale=0.1, Color=SKIN_TONE),
        "skin, scale 1": node("RANDOM_WALK_SKIN", Color=SKIN_TONE),
        "skin, anisotropy 0.8": node("RANDOM_WALK_SKIN", Scale=0.2, Color=SKIN_TONE, Anisotropy=0.8, IOR=1.6),
        "principled": beneath(),
        "principled, weight 0.4": beneath(Subsurface_Weight=0.4, Roughness=0.2),
        "principled, scale 0.05": beneath(Subsurface_Scale=0.05, Specular_IOR_Level=0.0),
        "principled, coat, sheen": beneath(Coat_Weight=1.0, Sheen_Weight=0.6, Subsurface_Radius=(0.3, 0.6, 1.0)),
        "principled, anisotropy 0.7": beneath(Subsurface_Anisotropy=0.7, Base_Color=LEAF),
        "principled, skin": beneath("RANDOM_WALK_SKIN", Base_Color=SKIN_TONE, Subsurface_Scale=0.1),
        "principled, mixed": beneath(Metallic=0.3, Transmission_Weight=0.3, Alpha=0.8, Subsurface_Scale=0.3),
        "two of them": (node(Color=LEAF), node("RANDOM_WALK_SKIN", Color=GOLD, Scale=0.2)),
        "principled, bumped": beneath(Subsurface_Scale=0.2),
        "node, textured": node(),
        "with glass": (node(), ("ShaderNodeBsdfGlass", {}, {"Color": GOLD, "Roughness": 0.3, "IOR": 1.3})),
    }


def add_texture(name):
    """Noise that bumps the surface, or that is its colour."""
    tree = bpy.data.materials[name].node_tree
    shader = next(each for each in tree.nodes if each.type in ("BSDF_PRINCIPLED", "SUBSURFACE_SCATTERING"))
    noise = tree.nodes.new("ShaderNodeTexNoise")
    noise.inputs["Scale"].default_value = 8.0
    if "bumped" in name:
        bump = tree.nodes.new("ShaderNodeBump")
        bump.inputs["Distance"].default_value = 0.1
        tree.links.new(noise.outputs[0], bump.inputs["Height"])
        tree.links.new(bump.outputs[0], shader.inputs["Normal"])
    else:
        tree.links.new(noise.outputs["Color"], shader.inputs["Color"])


if __name__ == "__main__":
    out, word = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else ""
    chosen = {name: shader for name, shader in grid().items() if word in name}
    make_scene(chosen)
    for name in chosen:
        if "bumped" in name or "textured" in name:
            add_texture(name)
    bpy.ops.wm.save_as_mainfile(filepath=out)
    print("SHADERS " + json.dumps(list(chosen)), flush=True)
    os._exit(0)
