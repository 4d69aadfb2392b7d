"""Smooth balls of few facets under a sun at their side: what lifted shadow rays make of the terminator."""

import numpy as np
import pytest

from tests.scenes import SUN, Builder, ball, diffuse, look_at, pixels, place, render

SIZE = 48
TURN = 0.1265  # by which a facet looks 4 degrees away from the sun, and its edge 7 degrees towards it


def lit(offset: float, scale=(1, 1, 1), twice=False) -> np.ndarray:
    """Radiance (SIZE, SIZE) of a smooth white ball seen along y under a sun of pi W/m^2 along -x."""
    b = Builder((SIZE, SIZE))
    b.look((0, -3, 0), (0, 0, 0), 1.0, orthographic=True)
    vertices, triangles = ball(rings=8)
    mesh, white = b.mesh((vertices, triangles), normals=vertices), b.material(diffuse(1.0))
    for k in range(1 + twice):
        b.instance(mesh, white, matrix=place((0, 0, 100.0 * k), scale, TURN))
    b.lamp(SUN, np.pi, look_at((1, 0, 0), (0, 0, 0)), (0, 0))
    scene = b.make(instance_terminator=[offset] * (1 + twice))
    return pixels(render(scene, 64, filter_width=0.001, max_bounces=0))[..., 0].reshape(SIZE, SIZE)


def inside():
    x, z = np.meshgrid(*2 * [(np.arange(SIZE) + 0.5) / (SIZE / 2) - 1])
    return x, x * x + z * z < 0.8  # within the outline of the facets


@pytest.mark.parametrize("twice", [False, True])
def test_facets_cast_no_shadow_on_what_looks_round(twice):
    """Facets that look away from the sun are black; with an offset they have Lambert's cosine of their normals."""
    x, there = inside()
    hard, soft = (lit(offset, twice=twice) for offset in (0.0, 0.1))
    rim = there & (x > 0.02) & (x < 0.12)
    assert (hard[rim] == 0).mean() > 0.8
    assert np.abs(soft[rim] - x[rim]).max() < 0.01  # sines of 8 x 16 facets' interpolated normals
    high = there & (x > 0.5)
    assert np.array_equal(hard[high], soft[high]) and (soft[there & (x < -0.05)] == 0).all()


def test_mirrored_balls_are_lit_alike():
    plain, mirrored = (lit(0.1, scale) for scale in ((1, 1, 1), (1, 1, -1)))
    assert np.abs(plain - mirrored[::-1]).mean() < 2e-3
