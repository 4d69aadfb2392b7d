"""Scenes of any size, anywhere: the same bits times 2^k, rounding noise times 10^k and far from the origin."""

import importlib.util
from functools import cache

import numpy as np
import pytest

from isophote.volumes import has_volumes
from tests.extremes.table import Row, step
from tests.extremes.variants import (
    changed,
    differing,
    film,
    instanced,
    moved,
    reference,
    rounding,
    scaled,
    scaled_vertices,
)
from tests.kernel_lib import ROOT
from tests.parity.scenes import SCENES
from tests.scenes import RECTANGLE, Builder, ball, box, diffuse, emission, look_at, program, quad

EXPONENTS = step((-20, -19, -13, -8, -3, -1, 1, 2, 7, 12, 19, 20), range(-20, 21))
SAMPLES = step(4, 16)


def room():
    """A bit of everything that has a place: meshes and spheres, a lamp, a panel, glass, a world."""
    b = Builder((12, 10))
    b.world = 0.3
    b.look((0, -4, 2), (0, 0, 0.5), 0.6, clip=(0.125, 1024))
    b.add(quad((0, 0, 0), (4, 0, 0), (0, 3, 0)), diffuse((0.7, 0.5, 0.3)))
    b.add(quad((0, 0.3, 3), (0.5, 0, 0), (0, -0.5, 0)), emission((2, 3, 4)))
    b.add(box((-1, 0.2, 0.4), 0.4), program(("glass", 1.0, dict(roughness=0.3, ior=1.45, multiscatter=1))))
    shape = ball((1, 0, 0.6), 0.6, rings=6)
    b.add(shape, program(("glossy", 0.8, dict(roughness=0.2, multiscatter=1))), normals=ball(rings=6)[0])
    b.lamp(RECTANGLE, 30.0, look_at((2, -2, 3), (0, 0, 0)), (0.5, 0.3))
    return b.make()


@pytest.mark.parametrize("how", ["applied", "matrices"])
def test_powers_of_two_change_no_bit(how):
    """Every scene of the parity suite, and one of them instanced, as meshes that grow or as matrices that do.

    But not those whose materials compute values, for textures in space do not grow with what they are on, nor volumes,
    whose densities are per metre.
    """
    scenes = {name: make() for name, make in SCENES.items()} | {"room": room(), "room, instanced": instanced(room())}
    scenes["in motion"] = changed(scenes["between_frames"], vectors=0)
    scenes = {name: scene for name, scene in scenes.items() if not (len(scene.step_op) or has_volumes(scene))}
    grow = scaled_vertices if how == "applied" else scaled
    exponents = f"{len(EXPONENTS)} of -20 ... 20"
    with Row("scale", f"2^k, k = {exponents}, {how}, {len(scenes)} scenes", "floats that differ") as row:
        for name, scene in scenes.items():
            original = film(scene, SAMPLES)
            for exponent in EXPONENTS:
                row.see(differing(original, film(grow(scene, 2.0 ** exponent), SAMPLES)), f"{name}, 2^{exponent}")


@pytest.mark.parametrize("space", ["applied", "instanced"])
def test_powers_of_ten_are_rounding(space):
    """Lengths are no longer scaled exactly: paths that touch an edge take another turn, the others agree."""
    scene = room() if space == "applied" else instanced(room())
    exact = reference(scene, SAMPLES * 16)
    powers = step((-6, -3, -1, 1, 3, 6), range(-6, 7))
    with Row("scale", f"10^k, k = -6 ... 6, {space}", "median pixel, relative to float64", 1e-5) as row:
        for power in powers:
            row.see(rounding(film(scaled(scene, 10.0 ** power), SAMPLES * 16), exact), f"10^{power}")


# ------------------------------------------------------------------ far from the origin


@cache
def make_origin():
    """The exporter's, which needs no Blender; its package is loaded without it."""
    spec = importlib.util.spec_from_file_location("export_origin", ROOT / "addon" / "export" / "origin.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.make_origin


def seen_from(scene, offset):
    """A scene `offset` metres away in Blender's world, as it is exported: relative to the grid near its camera."""
    far = moved(scene, offset)
    origin = make_origin()(far.camera_to_world[:, 3], float(far.camera_clip[0]))
    return changed(moved(far, -origin), origin=origin)


DISTANCES = step((1e3, 1e5, 1e7), (1e3, 1e4, 1e5, 1e6, 1e7))


@pytest.mark.parametrize("space", ["applied", "instanced"])
def test_far_from_the_origin(space):
    """Moved by a multiple of the grid nothing changes; else rounding differs, as it does between two near places."""
    scene = room() if space == "applied" else instanced(room())
    original, exact = film(scene, 4), reference(scene, SAMPLES * 16)
    with Row("far from the origin", f"grid points, 1e3 ... 1e7 m away, {space}", "floats that differ") as row:
        for distance in DISTANCES:
            offset = np.round(np.array((1, -0.7, 0.3)) * distance / 128) * 128
            row.see(differing(original, film(seen_from(scene, offset), 4)), distance)
    with Row("far from the origin", f"any place 1e3 ... 1e7 m away, {space}",
             "median pixel, relative to float64", 1e-5) as row:
        for distance in DISTANCES:
            there = seen_from(scene, np.array((1, -0.7, 0.3)) * distance + 0.37)
            row.see(rounding(film(there, SAMPLES * 16), exact), distance)
