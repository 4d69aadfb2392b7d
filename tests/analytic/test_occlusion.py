"""The Ambient Occlusion pass, by known answers."""

import numpy as np
import pytest

from isophote.passes import make_passes
from tests.scenes import Builder, ball, box, diffuse, emission, medium, program, quad, render

NAME = "ambient_occlusion"


def occlusion(builder: Builder, distance: float, samples=256, **settings) -> np.ndarray:
    """(h, w, 3)"""
    film = render(builder.make(occlusion_distance=distance), samples, passes=(NAME,), filter_width=0.0, **settings)
    return make_passes(film, [NAME])["AO"]


def floor_and_wall(material, size=(16, 4)) -> Builder:
    """Seen from above, x from 0 to 1 away from a wall that shines; the camera cannot see the wall."""
    b = Builder(size)
    b.look((0.5, 0, 50), (0.5, 0, 0), 0.5, orthographic=True, up=(0, 1, 0))
    b.add(quad((50, 0, 0), (50, 0, 0), (0, 50, 0)), material)
    b.add(quad((0, 0, 50), (0, 0, 50), (0, 50, 0)), emission((9, 9, 9)))
    return b


@pytest.mark.parametrize("distance", [0.0, 0.4, 0.8, 1e6])
def test_beside_a_wall(distance):
    """Of a wall at d what is nearer than R covers the part x > d / R of the unit disk onto which directions project."""
    made = occlusion(floor_and_wall(diffuse(0.2)), distance)
    d = (np.arange(16) + 0.5) / 16
    c = np.clip(d / distance, 0.0, 1.0) if distance else np.ones(16)
    expected = 1.0 - (np.arccos(c) - c * np.sqrt(1.0 - c * c)) / np.pi
    np.testing.assert_allclose(made.mean(0)[:, 0], expected, atol=0.01)
    assert (made[..., 0] == made[..., 1]).all() and (made[..., 0] == made[..., 2]).all()


def test_black_and_mirrors_are_seen_as_well():
    for material in (diffuse(0.0), program(("glossy", 0.9, dict(roughness=0.0, multiscatter=0)))):
        assert occlusion(floor_and_wall(material), 1e6).mean() == pytest.approx(0.5, abs=0.01)


def test_a_veil_takes_its_part():
    """It is seen itself, with nothing above it; and the floor below it, of which it lets light through twice."""
    b = Builder((4, 4))
    b.look((0, 0, 50), (0, 0, 0), 0.5, orthographic=True, up=(0, 1, 0))
    b.add(quad((0, 0, 0), (900, 0, 0), (0, 900, 0)), diffuse(0.5))
    b.add(quad((0, 100, 0.1), (900, 0, 0), (0, 900, 0)), program(("transparent", (0.5, 0.25, 1.0)), ("diffuse", 0.3)))
    made = occlusion(b, 1e6, 4096).mean((0, 1))
    through = np.array([0.5, 0.25, 1.0])
    np.testing.assert_allclose(made, 1.0 - through + through * through, atol=0.01)
    assert occlusion(b, 0.05, 4096).mean((0, 1)) == pytest.approx(np.ones(3), abs=0.015)


@pytest.mark.parametrize("device", ["openmp", "opencl"])
def test_volumes_take_their_part(device):
    """Of the camera's way down into a box, and of all ways of the pass's length; an empty one takes nothing."""
    for sigma in (1e-9, 0.5):
        b = Builder((4, 4))
        b.look((0, 0, 50), (0, 0, 0), 0.5, orthographic=True, up=(0, 1, 0))
        b.add(quad((0, 0, 0), (90, 0, 0), (0, 90, 0)), diffuse(0.5))
        b.add(box((0, 0, 0), (9, 9, 2)), [], volume=medium(sigma))
        made = occlusion(b, 1.0, 16, device=device)
        np.testing.assert_allclose(made, np.exp(-sigma * (2 + 1)), rtol=1e-5)


def test_smooth_facets_do_not_occlude_each_other():
    """A ball of few facets over which rays begin where the round surface is: nothing is near it."""
    b = Builder((16, 16))
    b.look((0, 0, 50), (0, 0, 0), 0.5, orthographic=True, up=(0, 1, 0))
    shape = ball((0, 0, 0), 1.0, rings=6)
    b.add(shape, diffuse(0.5), normals=ball(rings=6)[0])
    lifted, flat = (render(b.make(occlusion_distance=5.0, instance_terminator=[offset]), 256, passes=(NAME,),
                           filter_width=0.0) for offset in (0.4, 0.0))
    lifted, flat = (make_passes(film, [NAME])["AO"].mean() for film in (lifted, flat))
    assert flat < lifted <= 1.0 + 1e-6


def test_nothing_where_nothing_is_seen():
    b = Builder((4, 4))
    assert not occlusion(b, 1.0, 4).any()
    b.add(quad((0, 0, -1), (9, 0, 0), (0, 9, 0)), program(("holdout", 1.0)))
    assert not occlusion(b, 1.0, 4).any()
