# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes noise.blend: Noise, White Noise, Checker, Gradient and, where Blender has it (before 4.1), Musgrave Textures.

    python blend_scenes/nodes/make_noise.py -- FOLDER     (a Python with bpy; or blender -b --python ...)
"""

from __future__ import annotations

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from points import across, linked, make_patches, point

DIMENSIONS = ("1D", "2D", "3D", "4D")
KINDS = ("FBM", "MULTIFRACTAL", "HYBRID_MULTIFRACTAL", "RIDGED_MULTIFRACTAL", "HETERO_TERRAIN")
HAS_KINDS = bpy.app.version >= (4, 1, 0)
INPUTS = {"Scale": 4.0, "Detail": 2.5, "Roughness": 0.6, "W": across(-1.0, 1.0), "Vector": point}
SHAPE = {"Lacunarity": 2.3, "Offset": 0.3, "Gain": 1.5}


def noise(dimensions="3D", kind="FBM", shows="Fac", normalize=True, **inputs):
    """Of `inputs`, functions of the graph are linked, and None is left as it is."""
    settings = {"noise_dimensions": dimensions}
    settings |= {"noise_type": kind, "normalize": normalize} if HAS_KINDS else {}
    given = {**INPUTS, **(SHAPE if HAS_KINDS else {}), **inputs}
    return lambda g: g.node("TexNoise", outputs=shows, settings=settings, **linked(g, given))


def noises():
    kinds = KINDS if HAS_KINDS else KINDS[:1]
    for dimensions in DIMENSIONS:
        for kind in kinds:
            yield f"noise {dimensions} {kind}", noise(dimensions, kind)
        yield f"noise {dimensions} color", noise(dimensions, shows="Color")
        yield f"noise {dimensions} distorted", noise(dimensions, Distortion=1.5)
        yield f"noise {dimensions} detail 15", noise(dimensions, Detail=15.0)
        yield f"noise {dimensions} far away", noise(dimensions, Vector=few_far_away, W=one_of_two)
    yield "noise generated", noise(Vector=None)
    yield "noise detail 0", noise(Detail=0.0)
    yield "noise no roughness", noise(Roughness=0.0)
    yield "noise linked distortion", noise(Distortion=across(-1.0, 2.0))
    yield "noise linked scale", noise(Scale=across(-3.0, 3.0))
    yield "noise linked roughness", noise(Roughness=across(-0.2, 1.2))
    for kind in kinds:
        yield f"noise linked detail {kind}", noise(kind=kind, Detail=across(-0.5, 5.0))
    if HAS_KINDS:
        yield "noise not normalized", noise(normalize=False)
        yield "noise linked lacunarity", noise(Lacunarity=across(0.5, 3.0))


def musgrave(dimensions, kind, **inputs):
    settings = {"musgrave_dimensions": dimensions, "musgrave_type": kind}
    given = {"Scale": 4.0, "Detail": 2.5, "Dimension": 0.8, "W": across(-1.0, 1.0), "Vector": point, **SHAPE, **inputs}
    return lambda g: g.node("TexMusgrave", settings=settings, **linked(g, given))


def musgraves():
    for kind in KINDS:
        for dimensions in DIMENSIONS:
            yield f"musgrave {dimensions} {kind}", musgrave(dimensions, kind)
        yield f"musgrave {kind} detail below 1", musgrave("3D", kind, Detail=0.4)
        yield f"musgrave {kind} linked", musgrave("3D", kind, Detail=across(0.0, 5.0), Dimension=across(0.0, 2.0))


def checkered(g, first, second):
    """Two colours, between which there are no pixels."""
    return g.node("TexChecker", outputs="Color", Vector=point(g), Color1=first, Color2=second, Scale=3.1)


def few_far_away(g):
    """Two points at which coordinates repeat, or are too large for more than half cells."""
    return checkered(g, (123456.3, -99999.9, 300000.2), (7654321.0, -1e6, 2.5e8))


def one_of_two(g):
    """Two such numbers: one that is constant is reckoned in float64, and far away that makes a difference."""
    return g.math("MULTIPLY_ADD", checkered(g, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), 1e6, -7654321.5)


def white_noise(dimensions, shows):
    """Of few numbers, because any that is a rounding error off gives another."""
    def build(g):
        return g.node("TexWhiteNoise", outputs=shows, settings={"noise_dimensions": dimensions}, W=one_of_two(g),
                      Vector=checkered(g, (0.1, 0.2, 0.3), (-3.0, 5.0, 7.5)))
    return build


def checker(shows="Color", **inputs):
    given = {"Color1": (0.8, 0.1, 0.3), "Color2": (0.2, 0.4, 0.6), "Vector": point, "Scale": 3.3, **inputs}
    return lambda g: g.node("TexChecker", outputs=shows, **linked(g, given))


def around_origin(g):
    return g.vector(across(-1.0, 1.0)(g), g.math("MULTIPLY_ADD", g.place(1), -1.6, 0.1), 0.0)


def gradient(kind, vector=around_origin, shows="Color"):
    return lambda g: g.node("TexGradient", outputs=shows, settings={"gradient_type": kind},
                            **linked(g, {"Vector": vector}))


def patterns():
    for dimensions in DIMENSIONS:
        yield f"white noise {dimensions}", white_noise(dimensions, "Value")
        yield f"white noise {dimensions} color", white_noise(dimensions, "Color")
    yield "checker", checker()
    yield "checker generated", checker(Vector=None)
    yield "checker factor", checker("Fac")
    yield "checker negative", checker(Vector=around_origin)
    yield "checker linked", checker(Scale=across(1.0, 3.0), Color1=across(0.0, 1.0))
    for kind in ("LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "SPHERICAL", "QUADRATIC_SPHERE", "RADIAL"):
        yield f"gradient {kind}", gradient(kind)
    yield "gradient generated", gradient("EASING", None)
    yield "gradient factor", gradient("DIAGONAL", point, "Fac")


if __name__ == "__main__":
    make_patches("noise", [*noises(), *patterns(), *(() if HAS_KINDS else musgraves())])
