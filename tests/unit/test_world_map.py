"""The world as a light: its map integrates to 1, its power is right, and drawing it changes nothing but the noise."""

import ctypes

import numpy as np
import pytest

from isophote.records import numbers
from isophote.values import Value, call1
from isophote.world_map import LUMINANCE
from tests.kernel_lib import compiled
from tests.scenes import Builder, ball, diffuse, emission, mean_and_error, quad, ready, render

N = numbers()
PROBE = """
#include "world.h"
extern "C" {
void probe_sample(const World *world, const float *map, int n, const float *u, float *direction, float *pdf) {
  Scene s;
  s.world = world; s.world_map = map;
  for (int i = 0; i < n; i++) {
    WorldSample w = sample_world(s, make_real2(u[2 * i], u[2 * i + 1]), world->features);
    direction[3 * i] = w.direction.x; direction[3 * i + 1] = w.direction.y; direction[3 * i + 2] = w.direction.z;
    pdf[i] = w.pdf;
  }
}
void probe_pdf(const World *world, const float *map, int n, const float *d, float *pdf) {
  Scene s;
  s.world = world; s.world_map = map;
  for (int i = 0; i < n; i++) pdf[i] = pdf_world(s, make_real3(d[3 * i], d[3 * i + 1], d[3 * i + 2]), world->features);
}
}
"""


def direction():
    """Where a world is seen, as three Values."""
    call = call1("object_point").call
    return [Value(call, k) for k in range(3)]


def spot(height=400.0, cosine=0.99):
    """Bright in a cone around (0.6, 0, 0.8), grey elsewhere."""
    x, _, z = direction()
    inside = 1.0 - call1("less_than", 0.6 * x + 0.8 * z, cosine)
    return emission((0.5 + inside * height, 0.4 + inside * height, 0.3 + inside * (0.5 * height)))


SUN = (0.6, 0.0, 0.8, float(np.arccos(0.99)))  # that spot as a disc that is drawn apart


def under(world, **others):
    """A ball on a floor under a world of some instructions."""
    b = Builder((8, 8))
    b.look((0, -6, 2.5), (0, 0, 0.6), 0.45)
    b.add(quad((0, 0, 0), (4, 0, 0), (0, 4, 0)), diffuse(0.7))
    shape = ball(radius=1.0, rings=8)
    b.add((shape[0] + (0, 0, 1.0), shape[1]), diffuse((0.6, 0.3, 0.2)))
    return b.make(world_material=[b.material(world)], **others)


@pytest.fixture(scope="module")
def library():
    return compiled(PROBE, ("-O2", "-Wno-unused-function"))


def call(library, name, prepared, n, given, *outputs):
    made = [np.empty(shape, np.float32) for shape in outputs]
    given = np.ascontiguousarray(given, np.float32)
    arrays = [prepared.buffers["world"], prepared.buffers["world_map"], n, given, *made]
    getattr(library, name)(*[a.ctypes.data_as(ctypes.c_void_p) if isinstance(a, np.ndarray) else a for a in arrays])
    return made


def sphere(n=1 << 18):
    """Directions spread evenly."""
    rng = np.random.default_rng(0)
    d = rng.standard_normal((n, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


@pytest.mark.parametrize("sun", [(), SUN], ids=["map", "sun"])
def test_density_is_1_over_the_sphere_and_that_of_what_is_drawn(library, sun):
    prepared = ready(under(spot(), world_sun=np.reshape(sun, (-1, 4))))
    assert bool(prepared.features & N["FEATURE_WORLD_SUN"]) == bool(sun)
    (pdf,) = call(library, "probe_pdf", prepared, 1 << 18, sphere(), (1 << 18,))
    spread = pdf.std(dtype=np.float64) * 4 * np.pi / 512
    assert abs(pdf.mean(dtype=np.float64) * 4 * np.pi - 1.0) < 4 * spread
    u = np.random.default_rng(1).random((1 << 16, 2))
    drawn, density = call(library, "probe_sample", prepared, 1 << 16, u, (1 << 16, 3), (1 << 16,))
    np.testing.assert_allclose(np.linalg.norm(drawn, axis=1), 1.0, atol=1e-6)
    (again,) = call(library, "probe_pdf", prepared, 1 << 16, drawn, (1 << 16,))
    assert (np.abs(again / density - 1.0) < 1e-3).mean() > 0.999  # at cells' edges rounding finds the neighbour
    # The solid angle of the whole sphere, by drawing.
    inverse = 1.0 / density.astype(np.float64)
    assert abs(inverse.mean() - 4 * np.pi) < 4 * inverse.std() / 256


def test_bright_directions_are_drawn_in_proportion(library):
    prepared = ready(under(spot()))
    u = np.random.default_rng(2).random((1 << 16, 2))
    drawn, _ = call(library, "probe_sample", prepared, 1 << 16, u, (1 << 16, 3), (1 << 16,))
    solid, around = 2 * np.pi * 0.01, 2 * np.pi * 0.015  # the cone, and with it what its edge's cells reach
    bright, dim = np.array([400.0, 400.0, 200.0]) @ LUMINANCE, np.array([0.5, 0.4, 0.3]) @ LUMINANCE
    expected = (bright * solid + dim * around) / (bright * solid + dim * 4 * np.pi)
    assert abs((drawn @ (0.6, 0.0, 0.8) > 0.985).mean() - expected) < 0.005


def test_power_is_right():
    x, _, z = direction()
    square = x * x + 2.0 * z * z
    light = ready(under(emission((square, 0.5 * square, 1.0)))).buffers["lights"]
    assert light["kind"].tolist() == [N["LIGHT_WORLD"]]
    np.testing.assert_allclose(light["radiance"][0], (1.0, 0.5, 1.0), rtol=1e-3)


def test_dark_and_even_worlds_are_left_to_closures():
    x = direction()[0]
    for world in (emission((x * 0.0 + 1.0, 1.0, 1.0)), emission(tuple(call1("ray_is", data=1) for _ in range(3)))):
        features = ready(under(world)).features
        assert features & N["FEATURE_WORLD"] and not features & N["FEATURE_WORLD_LIGHT"]


@pytest.mark.parametrize("precision", ["strict", "reference"])
def test_drawing_the_world_changes_nothing_but_the_noise(precision):
    world = spot(8.0, 0.7)  # so smooth that closures alone find it
    drawn = render(under(world), 1024, max_bounces=2, precision=precision)
    unseen = N["RAY_TRANSMISSION"]  # by rays that this scene has none of: then closures alone find the world
    left = render(under(world, world_hidden=unseen), 1024, max_bounces=2, precision=precision)
    (a, error_a), (b, error_b) = mean_and_error(drawn), mean_and_error(left)
    assert (np.abs(a - b) < 4 * np.hypot(error_a, error_b)).all(), (a, b, error_a, error_b)


def test_a_small_sun_costs_no_noise():
    world = spot(4e4, 0.9999)
    picture, error = mean_and_error(render(under(world), 256, max_bounces=1))
    assert (error < 0.01 * picture).all(), (picture, error)


def test_a_sun_smaller_than_cells_is_found_where_its_place_is_known():
    half, (x, y, z) = 1e-3, direction()
    off = (x - 0.6) * (x - 0.6) + y * y + (z - 0.8) * (z - 0.8)
    inside = call1("less_than", off, 4.0 * np.sin(half / 2) ** 2) * (8.0 / half ** 2)
    world, sun = emission((inside + 0.5, inside + 0.4, 0.5 * inside + 0.3)), [(0.6, 0.0, 0.8, half)]
    prepared = ready(under(world, world_sun=sun))
    assert prepared.features & N["FEATURE_WORLD_SUN"]
    np.testing.assert_allclose(prepared.buffers["lights"]["radiance"][0], (2.5, 2.4, 1.3), rtol=1e-2)
    picture, error = mean_and_error(render(under(world, world_sun=sun), 256, max_bounces=1))
    assert (error < 0.01 * picture).all(), (picture, error)


def test_a_sun_that_does_not_shine_is_left_to_the_map():
    prepared = ready(under(spot(0.0), world_sun=[SUN]))
    assert not prepared.features & N["FEATURE_WORLD_SUN"]


def test_a_sun_in_a_black_sky_is_drawn():
    x, _, z = direction()
    inside = 1.0 - call1("less_than", 0.6 * x + 0.8 * z, 0.99)
    picture, error = mean_and_error(render(under(emission((inside,) * 3), world_sun=[SUN]), 256, max_bounces=1))
    assert (error < 0.01 * picture).all() and (picture > 0.0).all(), (picture, error)
