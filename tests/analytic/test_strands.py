"""Strands against what is known of them: how much of a picture they cover, how light falls on them, what passes."""

import numpy as np
import pytest

from isophote.records import numbers
from tests.scenes import SUN, Builder, assert_mean, diffuse, emission, look_at, pixels, place, program, quad, render

HALF = 0.5  # of the square that the camera sees, metres
WIDE = dict(filter_width=3.0)  # with narrower filters those of all pixels do not add up to 1 so nearly
RIPPLE = 1e-4  # by which they do not with these


def seen_along_y(size=(16, 16), half=HALF, distance=3.0) -> Builder:
    b = Builder(size)
    b.look((0, -distance, 0), (0, 0, 0), half, orthographic=True)
    return b


def cone_area(length, r0, r1):
    """What a segment between two balls covers, seen from the side: a trapezium between their common tangents, m^2."""
    cosine = np.sqrt(1.0 - ((r0 - r1) / length) ** 2)
    return length * (r0 + r1) * cosine ** 3


@pytest.mark.parametrize(("r0", "r1"), [(0.1, 0.1), (0.15, 0.05), (0.02, 0.12), (0.2, 0.0)])
def test_a_segment_covers_its_cone(r0, r1):
    b = seen_along_y()
    b.instance(b.strands([[(-0.2, 0, 0.1), (0.1, 0, -0.1)]], [[r0, r1]]), b.material(emission()))
    covered = cone_area(np.hypot(0.3, 0.2), r0, r1) / (2 * HALF) ** 2
    assert_mean(render(b.make(), 4096, **WIDE), covered, accuracy=0.004, rounding=RIPPLE)


def test_of_two_balls_one_within_the_other_has_no_cone():
    b = seen_along_y()
    b.instance(b.strands([[(0, 0, 0), (0.05, 0, 0)]], [[0.3, 0.1]]), b.material(emission()))
    assert (pixels(render(b.make(), 64))[..., :3] == 0).all()


def test_where_they_bend_they_are_round():
    """At a right angle two thick segments and a quarter of their common ball cover the square's corner."""
    b = seen_along_y()
    b.instance(b.strands([[(-0.2, 0, -0.1), (0.1, 0, -0.1), (0.1, 0, 0.2)]], 0.1), b.material(emission()))
    area = 2 * 0.3 * 0.2 - 0.1 ** 2 + np.pi * 0.1 ** 2 / 4  # both have one square in common, of which one side is twice
    assert_mean(render(b.make(), 4096, **WIDE), area / (2 * HALF) ** 2, accuracy=0.004, rounding=RIPPLE)


@pytest.mark.parametrize("scale", [(2.0, 2.0, 2.0), (1.0, 1.0, 0.5), (-1.0, 3.0, 1.5)])
def test_instances_are_scaled_and_mirrored(scale):
    """Seen along y, the area of a straight strand grows by the scales of x and z."""
    b = seen_along_y()
    mesh = b.strands([[(-0.1, 0, 0.02), (0.1, 0, 0.02)]], 0.05)
    b.instance(mesh, b.material(emission()), matrix=place((0, 0, 0), scale))
    area = cone_area(0.2, 0.05, 0.05) * abs(scale[0] * scale[2])
    assert_mean(render(b.make(), 4096, **WIDE), area / (2 * HALF) ** 2, accuracy=0.006, rounding=RIPPLE)


def test_thin_and_far_ones_keep_their_width():
    """A hair of 1 mm, 200 m away, seen through a telescope."""
    b = Builder((8, 8))
    b.look((0, -200, 0), (0, 0, 0), 5e-3 / 200)
    b.instance(b.strands([[(0, 0, -0.1), (0, 0, 0.1)]], 1e-3), b.material(emission()))
    assert_mean(render(b.make(), 8192, **WIDE), 0.2, accuracy=0.005, rounding=1e-3)


def test_light_from_the_viewer_falls_on_a_cylinder():
    """Lambert's cosine over the width of a cylinder is pi / 4 in the mean."""
    b = seen_along_y(half=0.1)
    b.instance(b.strands([[(0, 0, -2), (0, 0, 2)]], 0.05), b.material(diffuse(0.6)))
    b.lamp(SUN, 2.0, look_at((0, -3, 0), (0, 0, 0)))
    assert_mean(render(b.make(), 4096, **WIDE), 0.5 * 0.6 * 2.0 / np.pi * np.pi / 4, accuracy=0.004, rounding=RIPPLE)


def test_white_strands_vanish_in_a_white_world():
    """But for tapered ones, whose normals are those of strands that are not."""
    rng = np.random.default_rng(3)
    root = rng.uniform(-0.3, 0.3, (40, 1, 3))
    points = root + np.cumsum(rng.normal(0, 0.1, (40, 5, 3)), axis=1)
    b = seen_along_y()
    b.world = 1.0
    b.instance(b.strands(points, rng.uniform(0.002, 0.03, (40, 1))), b.material(diffuse(1.0)))
    assert_mean(render(b.make(), 512, max_bounces=200, diffuse_bounces=200), 1.0, accuracy=1e-3)


@pytest.mark.parametrize(("points", "radii", "twice"), [
    (np.linspace((0, 0, -2), (0, 0, 2), 101), 0.1, 0.001),
    ([(0.3 * np.sin(0.1 * k), 0.3 * np.cos(0.1 * k), 0.02 * k - 1) for k in range(101)], 0.1, 0.01),
    ([(-1, 0, 0), (0, 0, 0), (-0.1, 0.02, 0), (1, 0, 0)], 0.1, 0.08),
    ([(-1, 0, 0), (-0.1, 0, 0), (-0.05, 0, 0), (1, 0, 0)], (0.2, 0.2, 0.1, 0.1), 0.11)],
    ids=["short segments", "a screw", "folded", "one ball in another"])
def test_light_passes_a_transparent_strand_once(points, radii, twice):
    """Whatever segments it is of: fronts within it do not count, but in skins (SKIN of strand.h), and where it folds or
    is no strand at all."""
    b = seen_along_y(size=(64, 64), half=0.4)
    b.world = 1.0
    b.instance(b.strands([points], [np.broadcast_to(radii, len(points))]), b.material(program(("transparent", 0.3))))
    seen = pixels(render(b.make(), 64, transparent_bounces=1000, filter_width=0.01))[..., 0]
    met = (1.0 - seen).sum() / 0.7  # pixels' worth of rays that met it, each once
    again = np.maximum(0.3 - seen, 0.0).sum() / (0.3 - 0.09)
    assert met > 0.1 * seen.size and again < twice * met


def test_shadow_rays_pass_it_once_too():
    b = seen_along_y(half=0.02)
    b.add(quad((0, 0, 0), (1, 0, 0), (0, 0, 1)), diffuse(0.5))
    b.instance(b.strands([[(-5, -5, 0), (5, -5, 0)]], 0.3), b.material(program(("transparent", 0.3))), visibility=16)
    b.lamp(SUN, 2.0, look_at((0, -3, 0), (0, 0, 0)))
    assert_mean(render(b.make(), 64), 0.3 * 0.5 * 2.0 / np.pi, accuracy=1e-4)


def tube(points, radius, sides=48):
    """Triangles of a straight tube between two points."""
    a, b = np.asarray(points, float)
    axis = (b - a) / np.linalg.norm(b - a)
    x = np.cross(axis, (0.3, 0.5, 0.8))
    x /= np.linalg.norm(x)
    angle = np.linspace(0, 2 * np.pi, sides, endpoint=False)[:, None]
    ring = radius * (np.cos(angle) * x + np.sin(angle) * np.cross(axis, x))
    k = np.arange(sides)
    after = (k + 1) % sides
    return np.concatenate([a + ring, b + ring]), np.concatenate([
        np.stack([k, after, sides + after], axis=1), np.stack([k, sides + after, sides + k], axis=1)])


def test_they_look_like_tubes_of_triangles():
    """Light, shadows and bounces among strands whose ends are out of sight."""
    lines = [[(-3, 0.1, 0.1), (3, 0.1, 0.25)], [(-3, -0.1, -0.1), (3, 0.2, 0.0)], [(0.1, 0, -3), (-0.1, 0.3, 3)]]
    films = []
    for as_strands in (True, False):
        b = seen_along_y()
        b.world = 0.2
        material = b.material(diffuse((0.8, 0.6, 0.4)))
        if as_strands:
            b.instance(b.strands(lines, 0.08), material)
        else:
            for line in lines:
                b.instance(b.mesh(tube(line, 0.08 * np.sqrt(2 * np.pi / 48 / np.sin(2 * np.pi / 48)))), material)
        b.lamp(SUN, 2.0, look_at((2, -3, 3), (0, 0, 0)), (0.1, 0))
        films.append(pixels(render(b.make(), 2048))[..., :3])
    np.testing.assert_allclose(films[0].mean((0, 1)), films[1].mean((0, 1)), rtol=0.004)


def test_attributes_go_by_vertex_and_segment():
    from isophote.materials import make_instruction
    from isophote.values import ARITHMETIC

    n = numbers()
    along, segment = (ARITHMETIC.call("attribute", data=k)[0] for k in (0, 1))
    b = seen_along_y(size=(64, 4), half=0.5)
    mesh = b.strands([[(-1, 0, 0), (0, 0, 0), (1, 0, 0)]], 0.4,
                     attributes=[(n["DOMAIN_VERTEX"], [[0.0], [1.0], [3.0]]), (n["DOMAIN_TRIANGLE"], [[5.0], [7.0]])])
    b.instance(mesh, b.material([make_instruction("emission", (along, segment, 0.0))]))
    seen = pixels(render(b.make(), 256))[1]
    x = (np.arange(64) + 0.5) / 64 - 0.5
    np.testing.assert_allclose(seen[4:-4, 0], np.where(x < 0, 1.0 + x, 1.0 + 2.0 * x)[4:-4], atol=0.02)
    np.testing.assert_allclose(seen[[10, 54], 1], [5.0, 7.0], rtol=1e-6)
