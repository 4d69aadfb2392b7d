"""Broken input: dropped and counted by name, and the rest of the picture as it is without it."""

import numpy as np
import pytest

from isophote.scene import make_scene
from isophote.validate import clean, validate
from tests.extremes.table import Row
from tests.extremes.variants import changed, differing, film, instanced, reference, rgb, rounding
from tests.scenes import (
    CAMERA,
    ELLIPSE,
    POINT,
    RECTANGLE,
    SPOT,
    SUN,
    Builder,
    ball,
    box,
    diffuse,
    emission,
    look_at,
    place,
    program,
    quad,
)

SAMPLES = 8
FAR = 1e12


def plain() -> Builder:
    """What is there with and without the broken things."""
    b = Builder((12, 10))
    b.world = 0.3
    b.look((0, -4, 2), (0, 0, 0.5), 0.6)
    b.add(quad((0, 0, 0), (4, 0, 0), (0, 3, 0)), diffuse((0.7, 0.5, 0.3)))
    b.add(quad((0, 0.3, 3), (0.5, 0, 0), (0, -0.5, 0)), emission((2, 3, 4)))
    b.add(ball((0.5, 0, 0.6), 0.6, rings=6), diffuse(0.6), normals=ball(rings=6)[0])
    b.sphere((-0.8, 0, 0.6), 0.6, b.material(program(("glass", 1.0, dict(roughness=0.1, ior=1.45, multiscatter=1)))))
    return b


def with_triangles(corners):
    """A mesh of its own of these triangles, (n, 3, 3), and one good triangle below the floor."""
    b = plain()
    corners = np.concatenate([np.asarray(corners, float), [[(0, 0, -9), (1, 0, -9), (0, 1, -9)]]])
    b.add((corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)), diffuse(0.5))
    return b


def with_matrix(matrix):
    b = plain()
    b.instance(b.mesh(box()), b.material(emission(1.0)), matrix=matrix)
    return b


def with_sphere(center, radius):
    b = plain()
    b.sphere(center, radius, b.material(emission(1.0)))
    return b


def with_lamp(kind, strength, at, size):
    b = plain()
    b.lamp(kind, strength, place(at), size)
    return b


NAN, INF = np.nan, np.inf
HALF = place((0, 0, 1))
BROKEN = {
    "triangles without area": (with_triangles([[(0, 0, 1)] * 3, [(0, 0, 1), (1, 0, 1), (2, 0, 1)]]),
                               "2 of 3 triangles"),
    "triangles not finite": (with_triangles([[(NAN, 0, 1), (1, 0, 1), (0, 1, 1)], [(INF, 0, 1), (1, 0, 1), (0, 1, 1)]]),
                             "2 of 3 triangles"),
    "vertices at 1e30": (with_triangles([[(0, 5, 0), (1, 5, 0), (0, 1e30, 1e30)], [(0, 5, 1), (1e30, 5, 1), (0, 5, 2)],
                                         [(0, 0, -1e30), (0, 1e30, 0), (1e30, 0, 0)]]), "3 of 4 triangles"),
    "matrix of zeros": (with_matrix(place((0, 0, 1), (0, 0, 0))), "scales it to nothing"),
    "matrix of rank 1": (with_matrix(place((0, 0, 1), (1, 0, 0))), "scales it to nothing"),
    "matrix not finite": (with_matrix(np.where(HALF == 1, NAN, HALF)), "not finite"),
    "sphere of radius 0": (with_sphere((0, 0, 1), 0.0), "radius"),
    "sphere of radius -1": (with_sphere((0, 0, 1), -1.0), "radius"),
    "sphere not finite": (with_sphere((0, NAN, 1), 1.0), "not finite"),
    "lamp not finite": (with_lamp(POINT, NAN, (0, 0, 1), (0, 0)), "not finite"),
    "lamp in infinity": (with_lamp(RECTANGLE, 1.0, (INF, 0, 1), (1, 1)), "not finite"),
}


def test_broken_things_are_dropped_by_name():
    """The notes name each, and no bit of the picture changes."""
    expected = film(plain().make(), SAMPLES)
    with Row("degenerate input", f"dropped: {', '.join(BROKEN)}", "floats that differ from the scene without") as row:
        for name, (builder, what) in BROKEN.items():
            scene = builder.make()
            scene.names = {"meshes": [f"mesh {k}" for k in range(9)], "instances": [f"object {k}" for k in range(9)],
                           "spheres": [f"sphere {k}" for k in range(9)], "lights": ["the lamp"]}
            notes = clean(scene)[1]
            assert len(notes) == 1 and what in notes[0]["what"] and notes[0]["name"], (name, notes)
            row.see(differing(expected, film(scene, SAMPLES)), name)


def empty_mesh():
    b = plain()
    b.instance(b.mesh((np.zeros((0, 3)), np.zeros((0, 3), int))), b.material(emission(1.0)))
    return b


@pytest.mark.parametrize("what", ["empty meshes", "lamps without size"])
def test_what_is_not_there_changes_no_bit(what):
    """Meshes without triangles; areas without size, which have no power to give."""
    expected = film(plain().make(), SAMPLES)
    builders = {"empty meshes": [empty_mesh()],
                "lamps without size": [with_lamp(kind, 0.0, (0, 0, 1), (0, 0)) for kind in
                                       (POINT, SPOT, SUN, RECTANGLE, ELLIPSE)]}[what]
    with Row("degenerate input", f"{what}, dark", "floats that differ from the scene without") as row:
        for number, builder in enumerate(builders):
            row.see(differing(expected, film(builder.make(), SAMPLES)), number)


def test_triangles_that_reach_far():
    """Triangles that reach from the scene to 1e12, before and behind the camera: hit where float64 says."""
    far = [[(0, -9, 0), (1, -9, 0), (0, -FAR, 0)], [(0, -9, 1), (FAR, -9, 1), (0, -9, 2)],
           [(-FAR, -FAR, -FAR), (FAR, -FAR, -FAR), (0, -9, -9)], [(0, 5, 0), (1, 5, 0), (0, FAR, FAR)]]
    with Row("degenerate input", "triangles with a vertex at 1e12", "median pixel, relative to float64", 1e-5) as row:
        for number, corners in enumerate(far):
            scene = with_triangles([corners]).make()
            row.see(rounding(film(scene, 64), reference(scene, 64)), number)


def test_lamps_without_size_shine():
    """Points and suns of size 0 as their limits; areas of no area cannot, and say nothing false: they are black."""
    b = Builder((4, 4))
    b.look((2, -6, 7), (0, 0, 0), 1e-7)
    b.add(quad((6, 0, 0), (20, 0, 0), (0, 20, 0)), diffuse(1.0))
    with Row("degenerate input", "lamps of size 0, 1e-30 and 1e-10", "radiance off its limit, relative; finite",
             1e-5) as row:
        for kind in (POINT, SUN, RECTANGLE, ELLIPSE):
            for size in (0.0, 1e-30, 1e-10):
                b.lamps = []
                b.lamp(kind, np.pi if kind == SUN else np.pi * 16 * (np.pi if kind == POINT else np.pi / 4),
                       look_at((0, 0, 2), (0, 0, 0)), (size, size), visibility=31 - CAMERA)
                seen = rgb(film(b.make(), 4, max_bounces=0))
                dark = kind in (RECTANGLE, ELLIPSE) and size * size < 1e-37
                if dark:
                    row.see(np.where(np.isfinite(seen), 0, INF), (kind, size))
                else:
                    row.see(seen - 1, (kind, size))


def test_mirrored_and_squashed_spaces():
    """det < 0, scales of 1e-3 and 1e3 side by side, one of 1e-6: the same scene as with transforms applied."""
    b = plain()
    b.spheres = []  # analytic spheres have no matrix
    scene = b.make()
    with Row("degenerate input", "matrices: mirrored, scales 1e-3 beside 1e3, 1e-6",
             "median pixel, relative to float64", 1e-4) as row:
        for scales in ((-1, 1, 1), (-1, -1, -1), (1e-3, 1e3, 1), (1, 1, 1e-6), (-1e-3, 2, 1e3)):
            space = instanced(scene, place((0.3, -0.2, 0.1), scales, 0.4))
            row.see(rounding(film(space, 64), reference(space, 64)), scales)


def test_numbers_that_are_none_are_refused():
    """What cannot be left out stops the render, and the message names it: no kernel sees NaN or infinity."""
    scene = plain().make()
    refused = {"camera_to_world": "camera", "camera_window": "camera", "camera_clip": "camera", "origin": "camera",
               "world_radiance": "world", "instruction_weight": "material", "instruction_params": "material"}
    with Row("NaN and infinity anywhere", f"NaN, infinity in {', '.join(refused)}", "arrays that pass") as row:
        for name, thing in refused.items():
            for value in (NAN, INF, -INF):
                array = scene.arrays[name].copy()
                array.reshape(-1)[-1] = value
                found = [p for p in validate(changed(scene, **{name: array})) if p.severity == "error"]
                row.see(0 if found and thing in found[0].thing else 1, name)


def test_nothing_at_all():
    """No object, no light; and a scene of nothing but broken things."""
    b = Builder((4, 4))
    b.world = (0.1, 0.2, 0.3)
    empty = b.make()
    assert [p.severity for p in validate(empty)] == ["warning"]
    b.add((np.zeros((3, 3)), np.array([[0, 1, 2]])), diffuse(1.0))
    with Row("degenerate input", "empty scenes", "pixel off the world's radiance", 1e-6) as row:
        for scene in (empty, b.make()):
            row.see(rgb(film(scene, 4)) / np.array((0.1, 0.2, 0.3)) - 1)
    assert make_scene().content_hash
