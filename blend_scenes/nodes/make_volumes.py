# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a scene with one ball for each kind of volume, as make_shaders.py does for surfaces.

    python blend_scenes/nodes/make_volumes.py OUT.blend [WORD]    # only those whose names hold WORD
"""

import json
import os
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import bpy
from make_shaders import GOLD, LEAF, ROSE, make_scene, make_shader

GREY, WHITE = (0.8, 0.8, 0.8), (1.0, 1.0, 1.0)
GLASS = ("ShaderNodeBsdfGlass", {}, {"Color": WHITE, "Roughness": 0.0, "IOR": 1.3})
VEIL = ("ShaderNodeBsdfTransparent", {}, {"Color": GOLD})
DIFFUSE = ("ShaderNodeBsdfDiffuse", {}, {"Color": LEAF})


def absorb(**inputs):
    return "ShaderNodeVolumeAbsorption", {}, {"Color": ROSE, "Density": 2.0} | inputs


def scatter(phase="HENYEY_GREENSTEIN", **inputs):
    return "ShaderNodeVolumeScatter", {"phase": phase}, {"Color": ROSE, "Density": 3.0} | inputs


def principled(**inputs):
    named = {name.replace("_", " "): value for name, value in inputs.items()}
    return "ShaderNodeVolumePrincipled", {}, {"Color": ROSE, "Density": 3.0} | named


def glow(strength=0.5, color=GOLD):
    return "ShaderNodeEmission", {}, {"Color": color, "Strength": strength}


def grid() -> dict:
    """Name -> (surface or None, a volume, or "mix" or "add" and two of them)."""
    return {
        "absorption": (None, absorb()),
        "absorption, dense": (None, absorb(Density=20.0)),
        "absorption in glass": (GLASS, absorb()),
        "absorption in a veil": (VEIL, absorb(Color=LEAF)),
        "emission": (None, glow()),
        "emission and absorption": (None, ("add", glow(), absorb())),
        "scatter": (None, scatter()),
        "scatter, thin": (None, scatter(Density=0.3, Color=GREY)),
        "scatter, dense": (None, scatter(Density=30.0)),
        "scatter, anisotropy 0.8": (None, scatter(Anisotropy=0.8)),
        "scatter, anisotropy -0.5": (None, scatter(Anisotropy=-0.5)),
        "scatter, anisotropy 1": (None, scatter(Anisotropy=1.0, Density=1.0)),
        "scatter and absorption": (None, ("add", scatter(Color=GREY), absorb(Color=LEAF))),
        "two scatters mixed": (None, ("mix", scatter(Anisotropy=0.7), scatter(Anisotropy=-0.3))),
        "scatter in glass": (GLASS, scatter(Color=GREY, Density=2.0)),
        "scatter under diffuse": (("mix", DIFFUSE, VEIL), scatter(Color=GREY)),
        "rayleigh": (None, scatter("RAYLEIGH")),
        "draine": (None, scatter("DRAINE", Anisotropy=0.5, Alpha=0.8)),
        "mie, small": (None, scatter("MIE", Diameter=1.0)),
        "mie": (None, scatter("MIE", Diameter=20.0)),
        "principled": (None, principled()),
        "principled, absorption colour": (None, principled(Absorption_Color=LEAF, Anisotropy=0.3)),
        "principled, emission": (None, principled(Emission_Strength=0.5, Emission_Color=GOLD)),
        "principled, blackbody": (None, principled(Blackbody_Intensity=1.0, Temperature=1500.0)),
    }


def connect(tree, shader, socket):
    """Links a node, or the mix or the sum of two of them."""
    if shader[0] in ("mix", "add"):
        both = tree.nodes.new(f"ShaderNode{shader[0].title()}Shader")
        for one, place in zip(shader[1:], both.inputs[-2:], strict=True):
            tree.links.new(make_shader(tree, *one), place)
        tree.links.new(both.outputs[0], socket)
    elif shader:
        tree.links.new(make_shader(tree, *shader), socket)


def fill(name, surface, volume):
    tree = bpy.data.materials[name].node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    if surface:
        connect(tree, surface, output.inputs["Surface"])
    connect(tree, volume, output.inputs["Volume"])


if __name__ == "__main__":
    out, word = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else ""
    chosen = {name: of for name, of in grid().items() if word in name}
    make_scene(dict.fromkeys(chosen, DIFFUSE))
    for name, of in chosen.items():
        fill(name, *of)
    bpy.context.scene.cycles.volume_bounces = 12
    bpy.ops.wm.save_as_mainfile(filepath=out)
    print("SHADERS " + json.dumps(list(chosen)), flush=True)
    os._exit(0)
