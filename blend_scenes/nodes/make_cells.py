# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes cells.blend: Voronoi, Wave, Magic and Brick Textures.

    python blend_scenes/nodes/make_cells.py -- FOLDER     (a Python with bpy; or blender -b --python ...)
"""

from __future__ import annotations

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from points import across, linked, make_patches, point

DIMENSIONS = ("1D", "2D", "3D", "4D")
FEATURES = ("F1", "F2", "SMOOTH_F1", "DISTANCE_TO_EDGE", "N_SPHERE_RADIUS")
HAS_OCTAVES = bpy.app.version >= (4, 0, 0)


def voronoi(dimensions="3D", feature="F1", shows="Distance", metric="EUCLIDEAN", normalize=False, **inputs):
    """Of `inputs`, functions of the graph are linked."""
    settings = {"voronoi_dimensions": dimensions, "feature": feature, "distance": metric}
    settings |= {"normalize": normalize} if HAS_OCTAVES else {}
    given = {"Scale": 3.3, "Smoothness": 0.6, "Randomness": 0.9, "W": across(0.1, 0.9), "Vector": point, **inputs}
    return lambda g: g.node("TexVoronoi", outputs=shows, settings=settings, **linked(g, given))


def voronois():
    for dimensions in DIMENSIONS:
        for feature in FEATURES:
            shows = "Radius" if feature == "N_SPHERE_RADIUS" else "Distance"
            yield f"voronoi {dimensions} {feature}", voronoi(dimensions, feature, shows)
            if feature in FEATURES[:3]:
                place = "W" if dimensions == "1D" else "Position"
                yield f"voronoi {dimensions} {feature} color", voronoi(dimensions, feature, "Color")
                yield f"voronoi {dimensions} {feature} place", voronoi(dimensions, feature, place)
    yield "voronoi 4D W", voronoi("4D", shows="W")
    for feature in FEATURES[:3]:
        for metric in ("MANHATTAN", "CHEBYCHEV"):
            yield f"voronoi {metric} {feature}", voronoi("3D", feature, metric=metric)
        for dimensions in DIMENSIONS:
            yield f"voronoi {dimensions} {feature} MINKOWSKI", voronoi(dimensions, feature, metric="MINKOWSKI",
                                                                       Exponent=0.7)
    yield "voronoi smoothness 0", voronoi(feature="SMOOTH_F1", Smoothness=0.0)
    yield "voronoi linked smoothness", voronoi(feature="SMOOTH_F1", Smoothness=across(0.0, 1.5))
    yield "voronoi linked scale", voronoi(Scale=across(-3.0, 3.0))
    yield "voronoi linked randomness", voronoi(Randomness=across(-0.3, 1.3))
    yield "voronoi linked exponent", voronoi(metric="MINKOWSKI", Exponent=across(0.5, 3.0))
    if HAS_OCTAVES:
        yield from fractals()


def fractals():
    octaves = {"Detail": 2.4, "Roughness": 0.6, "Lacunarity": 1.9, "Scale": 1.5}
    for feature in FEATURES[:4]:
        for normalize in (False, True):
            yield f"voronoi fractal {feature} {normalize}", voronoi(feature=feature, normalize=normalize, **octaves)
        yield f"voronoi fractal {feature} linked", voronoi(feature=feature, normalize=True,
                                                           **{**octaves, "Detail": across(-0.5, 3.0)})
    yield "voronoi fractal color", voronoi(shows="Color", normalize=True, **octaves)
    yield "voronoi fractal place", voronoi(shows="Position", **octaves)
    for metric in ("MANHATTAN", "CHEBYCHEV", "MINKOWSKI"):
        yield f"voronoi normalized {metric}", voronoi(metric=metric, feature="F2", normalize=True, Exponent=1.5)


def wave(kind="BANDS", direction="X", profile="SIN", shows="Color", **inputs):
    settings = {"wave_type": kind, "wave_profile": profile,
                "bands_direction" if kind == "BANDS" else "rings_direction": direction}
    given = {"Scale": 0.7, "Phase Offset": 0.3, "Vector": point, **inputs}
    return lambda g: g.node("TexWave", outputs=shows, settings=settings, **linked(g, given))


def waves():
    for kind, directions in (("BANDS", ("X", "Y", "Z", "DIAGONAL")), ("RINGS", ("X", "Y", "Z", "SPHERICAL"))):
        for direction in directions:
            yield f"wave {kind} {direction}", wave(kind, direction)
    for profile in ("SIN", "SAW", "TRI"):
        yield f"wave {profile}", wave(profile=profile, shows="Fac")
    yield "wave distorted", wave(Distortion=3.0, **{"Detail": 2.5, "Detail Scale": 1.7, "Detail Roughness": 0.4})
    yield "wave linked", wave(Distortion=across(-2.0, 2.0), Scale=across(0.2, 0.8), Detail=across(0.0, 4.0))


def magic(depth=2, shows="Color", **inputs):
    given = {"Scale": 1.3, "Distortion": 1.2, "Vector": point, **inputs}
    return lambda g: g.node("TexMagic", outputs=shows, settings={"turbulence_depth": depth}, **linked(g, given))


def magics():
    for depth in range(11):
        yield f"magic {depth}", magic(depth)
    yield "magic factor", magic(shows="Fac")
    yield "magic not distorted", magic(3, Distortion=0.0)
    yield "magic linked", magic(4, Distortion=across(-2.0, 2.0), Scale=across(-2.0, 2.0))


def brick(shows="Color", settings=None, **inputs):
    given = {"Scale": 2.3, "Mortar Size": 0.06, "Color1": (0.8, 0.1, 0.2), "Color2": (0.1, 0.3, 0.9),
             "Mortar": (0.5, 0.6, 0.4), "Vector": point, **inputs}
    return lambda g: g.node("TexBrick", outputs=shows, settings=settings, **linked(g, given))


def bricks():
    yield "brick", brick()
    yield "brick factor", brick("Fac")
    yield "brick smooth", brick(**{"Mortar Smooth": 0.7, "Mortar Size": 0.1})
    yield "brick bias", brick(Bias=0.4)
    yield "brick shifted", brick(settings={"offset": 0.3, "offset_frequency": 3, "squash": 1.6, "squash_frequency": 2})
    yield "brick linked", brick(**{"Mortar Smooth": across(-0.1, 1.0), "Bias": across(-1.0, 1.0),
                                   "Mortar Size": across(0.0, 0.12), "Row Height": across(0.2, 0.4)})
    yield "brick negative", brick(Scale=-2.3)


if __name__ == "__main__":
    make_patches("cells", [*voronois(), *waves(), *magics(), *bricks()])
