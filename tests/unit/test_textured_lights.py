"""Emission that varies: estimates for choosing lights, and drawing them changes nothing but the noise."""

from dataclasses import replace

import numpy as np
import pytest

from isophote.device import open_device
from isophote.emission import mean_radiance, points_of_triangle
from isophote.film import Film
from isophote.passes import film_planes
from isophote.prepare import Prepared
from isophote.records import make_records, numbers
from isophote.settings import Settings
from isophote.values import ARITHMETIC, call1
from tests.scenes import Builder, diffuse, emission, expose, full_frame, mean_and_error, place, program, quad, ready

N = numbers()


def across():
    """From 0 to 1 over the emitter's first side."""
    x, _, _ = ARITHMETIC.call("object_point")
    return 0.5 * x + 0.5


def lit(*instructions, matrix=None, parts=1):
    """A floor under a hanging emitter of the given material, instanced so many times side by side."""
    b = Builder((8, 8))
    b.look((0, -5, 2), (0, 0, 0.7), 0.5)
    b.add(quad((0, 0, 0), (4, 0, 0), (0, 4, 0)), diffuse(0.7))
    b.add(quad((0, 2, 1), (2, 0, 0), (0, 0.2, 1)), program(("glossy", 0.8, dict(roughness=0.3, multiscatter=0))))
    material, mesh = b.material(list(instructions)), b.mesh(quad((0, 0, 0), (1, 0, 0), (0, -0.5, 0)))
    for k in range(parts):
        b.instance(mesh, material, matrix=place((1.5 * k, 0, 1.5), 0.6) if matrix is None else matrix)
    return b.make()


def film_of(scene, prepared: Prepared, samples=1024):
    settings = Settings(samples=samples, max_bounces=3, diffuse_bounces=3, glossy_bounces=3)
    device = open_device("openmp", settings)
    try:
        device.upload(prepared)
        return expose(device, Film(full_frame(scene), film_planes(settings)), samples, settings)
    finally:
        device.close()


def without_lights(prepared: Prepared) -> Prepared:
    """The same for closures alone to find."""
    world = prepared.buffers["world"].copy()
    features = prepared.features & ~(N["FEATURE_LIGHTS"] | N["FEATURE_SHINES"] | N["FEATURE_LAMPS"])
    world["features"], world["light_count"], world["lamp_count"], world["light_depth"] = features, 0, 0, 0
    empty = {"lights": make_records("Light", 0), "light_tree": make_records("LightCluster", 0), "world": world}
    return replace(prepared, buffers=prepared.buffers | empty, features=features)


def test_points_are_spread_evenly_over_the_triangle():
    points = points_of_triangle(64)
    assert (points >= 0.0).all() and (points.sum(axis=1) <= 1.0).all()
    np.testing.assert_allclose(points.mean(axis=0), 1 / 3, atol=0.02)


def test_estimates_are_means():
    scene = lit(*emission((across(), across() * across(), 2.0)), parts=2)
    lights = ready(scene).buffers["lights"]
    assert len(lights) == 4 and (lights["flags"] == N["LIGHT_COMPUTED"]).all()
    total = lights["radiance"][:2].mean(axis=0)  # both triangles of a square
    np.testing.assert_allclose(total, (1 / 2, 1 / 3, 2.0), rtol=0.05)


def test_both_sides_count():
    lights = ready(lit(*emission(tuple(call1("backfacing") * 3.0 for _ in range(3))))).buffers["lights"]
    np.testing.assert_allclose(lights["radiance"], 1.5)


def test_what_does_not_shine_is_no_light():
    x = across()
    assert not len(ready(lit(*emission((x * 1e-30 - 1.0, x - 2.0, 0.0)))).buffers["lights"])


@pytest.mark.parametrize("matrix", [None, place((0, 0, 1.5), (-0.6, 0.5, 0.6), 0.4)], ids=["plain", "mirrored"])
def test_drawing_changes_nothing_but_the_noise(matrix):
    scene = lit(*emission((6.0 * across(), 6.0 * across() * across(), 3.0)), matrix=matrix)
    prepared = ready(scene)
    assert prepared.features & N["FEATURE_SHINES"]
    (a, error_a), (b, error_b) = (mean_and_error(film_of(scene, each)) for each in (prepared, without_lights(prepared)))
    assert (np.abs(a - b) < 4 * np.hypot(error_a, error_b)).all(), (a, b, error_a, error_b)
    assert (error_a < 0.6 * error_b).all()


def test_a_textured_light_is_that_of_its_constant():
    """Where the program gives the same everywhere, so do the pictures, to rounding."""
    same = call1("less_than", across(), 10.0) * 4.0
    scenes = [lit(*emission((same, same, same))), lit(*emission(4.0))]
    pictures = [mean_and_error(film_of(scene, ready(scene), 64))[0] for scene in scenes]
    np.testing.assert_allclose(*pictures, rtol=1e-5)


def test_mean_radiance_of_nothing_is_nothing():
    made = mean_radiance(ready(lit(*emission(across()))).buffers, np.zeros(0, int), np.zeros(0, int), np.zeros((0, 3)))
    assert made.shape == (0, 3)
