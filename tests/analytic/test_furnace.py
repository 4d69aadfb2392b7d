"""Scenes in balance: white furnaces, closed boxes that glow, and the bounce limits that cut their series off."""

import numpy as np
import pytest

from tests.scenes import (
    Builder,
    assert_exactly,
    assert_mean,
    ball,
    box,
    diffuse,
    place,
    program,
    quad,
    render,
)

INSIDE = np.s_[:, ::-1]
COLOUR = np.array((0.8, 0.5, 0.2))


def in_furnace(instructions, analytic=True, radiance=1.0):
    """A sphere that fills the view, in a world of one radiance; analytic, or a smooth mesh."""
    b = Builder()
    b.world = radiance
    b.look((0, 0, 3), (0, 0, 0), 0.2, up=(0, 1, 0))
    material = b.material(instructions)
    if analytic:
        b.sphere((0, 0, 0), 1, material)
    else:
        b.instance(b.mesh(ball(rings=24)), material)
    return b.make()


def closed(instructions, shape=None, turned=INSIDE):
    """The inside of a box, seen from its middle."""
    b = Builder()
    vertices, triangles = shape or box()
    b.look((0.1, 0.2, 0.3), (1, 0.5, 0.2), 1.0)
    b.add((vertices, triangles[turned]), instructions)
    return b.make()


# ------------------------------------------------------------------ furnace


@pytest.mark.parametrize("analytic", [True, False])
def test_white_diffuse_vanishes(analytic):
    """Albedo 1 in a world of radiance 1: closures are sampled in proportion, so every path brings exactly 1."""
    assert_exactly(render(in_furnace(diffuse(1.0), analytic), 64), 1.0)


def test_convex_diffuse_reflects_its_albedo():
    """No light comes back to a convex body: its radiance is albedo times world."""
    radiance = np.array((0.3, 2.0, 7.0))
    assert_mean(render(in_furnace(diffuse(COLOUR), True, radiance), 512), COLOUR * radiance)


@pytest.mark.parametrize("instructions", [
    program(("diffuse", 0.4), ("transparent", 0.6)),
    program(("diffuse", 0.3), ("glossy", 0.7, dict(roughness=0.0, multiscatter=0))),
    program(("glossy", 1.0, dict(roughness=0.0, multiscatter=0))),
    program(("refraction", 1.0, dict(roughness=0.0, ior=1.0))),
    program(("glass", 1.0, dict(roughness=0.0, ior=1.5, multiscatter=0))),
    program(("diffuse", 0.75), ("glossy", 0.0, dict(roughness=0.0, multiscatter=0)), ("emission", 0.25)),
], ids=["veil", "varnish", "mirror", "nothing", "glass", "glowing"])
def test_lossless_mixes_vanish(instructions):
    """Mixes whose weights add up to 1, or that emit what is missing."""
    assert_mean(render(in_furnace(instructions), 1024), 1.0, 0.002, rounding=5e-6)


@pytest.mark.parametrize("roughness,multiscatter", [(0.1, 0), (0.3, 1), (0.8, 1)])
def test_rough_reflection_keeps_or_loses_as_its_table_says(roughness, multiscatter):
    """Rough mirrors on a sphere: with compensation all light comes back, to the table's 0.2 %."""
    film = render(in_furnace(program(("glossy", 1.0, dict(roughness=roughness, multiscatter=multiscatter)))), 1024)
    mean = film.sum(0).mean() / film.replicate_samples[0]
    assert abs(mean - 1) < 0.002 if multiscatter else 0.95 < mean < 1.0


# ------------------------------------------------------------------ geometric series


@pytest.mark.parametrize("shape", [box(), ball(radius=2, rings=12)], ids=["box", "ball"])
def test_closed_diffuse_body(shape):
    """Emission E and albedo a on all walls: radiance E / (1 - a) everywhere."""
    albedo, emitted = np.array((0.5, 0.3, 0.1)), np.array((1.0, 2.0, 3.0))
    film = render(closed(program(("diffuse", albedo), ("emission", emitted)), shape), 1024, max_bounces=200,
                  diffuse_bounces=200)
    assert_mean(film, emitted / (1 - albedo), 0.003)


def test_roulette_has_no_bias():
    """Albedo 0.9 needs hundreds of bounces; roulette ends most paths early and keeps the mean."""
    scene = closed(program(("diffuse", (0.9, 0.6, 0.05)), ("emission", 1.0)))
    film = render(scene, 1024, max_bounces=254, diffuse_bounces=254)
    limited = (1 - 0.9 ** 256) / 0.1  # 255 bounces behind the camera's hit
    assert_mean(film, (limited, 2.5, 1 / 0.95), 0.015)


def series(albedo, terms):
    return sum(np.asarray(albedo) ** k for k in range(terms))


@pytest.mark.parametrize("limit", [0, 1, 2, 3, 7])
@pytest.mark.parametrize("which", ["max_bounces", "diffuse_bounces"])
def test_diffuse_bounces_count_as_in_cycles(which, limit):
    """Limit 0 is direct light: the wall's own emission and what the walls send to it; each bounce adds a term."""
    scene = closed(program(("diffuse", COLOUR), ("emission", 1.0)))
    assert_mean(render(scene, 512, **{which: limit}), series(COLOUR, limit + 2), 0.003)


@pytest.mark.parametrize("limit", [0, 1, 4])
@pytest.mark.parametrize("which", ["max_bounces", "glossy_bounces"])
def test_glossy_bounces_count_as_in_cycles(which, limit):
    """A box of mirrors: light comes by closures alone, and the last bounce still sees what it hits."""
    mirror = program(("glossy", COLOUR, dict(roughness=0.0, multiscatter=0)), ("emission", 1.0))
    assert_mean(render(closed(mirror), 512, **{which: limit}), series(COLOUR, limit + 2), 0.003)


def test_limits_of_other_kinds_do_not_count():
    scene = closed(program(("diffuse", 0.5), ("emission", 1.0)))
    assert_mean(render(scene, 512, glossy_bounces=0, transmission_bounces=0, transparent_bounces=0), 2.0, 0.003)


def planes_in_front(count, instructions):
    """`count` planes between the camera and a world of radiance 1."""
    b = Builder((4, 4))
    b.world = 1.0
    # Off the middle: a ray that meets the diagonal exactly counts as hitting both triangles.
    material, mesh = b.material(instructions), b.mesh(quad((20, 0, 0), (50, 0, 0), (0, 50, 0)))
    for k in range(count):
        b.instance(mesh, material, matrix=place((0, 0, -1 - 0.1 * k)))
    return b.make()


@pytest.mark.parametrize("limit", [0, 1, 5])
@pytest.mark.parametrize("which,instructions", [
    ("transmission_bounces", program(("refraction", 0.5, dict(roughness=0.0, ior=1.0)))),
    ("max_bounces", program(("refraction", 0.5, dict(roughness=0.0, ior=1.0)))),
    ("transparent_bounces", program(("transparent", 0.5))),
], ids=["transmission", "all", "transparent"])
def test_crossings_count_as_in_cycles(which, instructions, limit):
    """A limit of n lets light through n + 1 surfaces, and the next one is black."""
    for count, seen in ((limit + 1, 0.5 ** (limit + 1)), (limit + 2, 0.0)):
        samples = 64 if which == "transparent_bounces" else 1 << 14
        film = render(planes_in_front(count, instructions), samples, **{which: limit})
        if which == "transparent_bounces" or not seen:
            assert_exactly(film, seen)
        else:  # roulette decides at each crossing
            assert_mean(film, seen, 0.03)
