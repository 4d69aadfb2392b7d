"""Passes of what is seen, not of light: mist, coordinates, pass indices, what guides a denoiser."""

import numpy as np
import pytest

from isophote.passes import make_named, make_passes
from isophote.session import Session
from isophote.settings import Settings
from tests.parity.scenes.shown import NAMED, shown
from tests.scenes import Builder, diffuse, program, quad, render

CORNER = 4  # DOMAIN_ number
NAMES = ("uv", "mist", "object_index", "material_index", "denoising_normal", "denoising_albedo", "denoising_depth")


def passes_of(scene, samples=4, **settings):
    return make_passes(render(scene, samples, passes=NAMES, **settings), NAMES)


@pytest.mark.parametrize("orthographic", [False, True])
@pytest.mark.parametrize("falloff", [1.0, 2.0, 0.5])
def test_mist_of_a_wall(falloff, orthographic):
    """From the camera, or along its axis, by the falloff; where nothing is seen there is mist."""
    b = Builder((8, 4))
    b.look((0, 0, 0), (0, 0, -1), 1.0, orthographic=orthographic, up=(0, 1, 0))
    b.add(quad((-5, 0, -5), (5, 0, 0), (0, 9, 0)), diffuse(0.5))
    made = passes_of(b.make(mist=(3.0, 4.0, falloff)), filter_width=0.0)["Mist"][..., 0]
    x, y = (np.arange(8)[None] + 0.5) / 4 - 1, (np.arange(4)[:, None] + 0.5) / 4 - 0.5
    distance = 5 * np.ones((4, 8)) if orthographic else 5 * np.sqrt(1 + x * x + y * y)
    expected = np.clip((distance - 3) / 4, 0, 1) ** falloff
    np.testing.assert_allclose(made[:, :4], expected[:, :4], rtol=1e-5)
    assert (made[:, 4:] == 1).all()


def test_mist_behind_a_veil_is_thicker():
    b = Builder((4, 4))
    b.look((0, 0, 0), (0, 0, -1), 1.0, orthographic=True, up=(0, 1, 0))
    b.add(quad((0.3, 0, -2), (9, 0, 0), (0, 9, 0)), program(("transparent", 0.25), ("diffuse", 0.5)))
    b.add(quad((0.3, 0, -4), (9, 0, 0), (0, 9, 0)), diffuse(0.5))
    made = passes_of(b.make(mist=(0.0, 8.0, 1.0)), 4096, filter_width=0.0)["Mist"]
    middle = 1 - (0.75 * (1 - 2 / 8) + 0.25 * (1 - 4 / 8))
    assert made.mean() == pytest.approx(middle, abs=5e-3)


def test_uv_follows_the_map():
    b = Builder((8, 4))
    b.look((0, 0, 0), (0, 0, -1), 1.0, orthographic=True, up=(0, 1, 0))
    corners = np.array([[0, 0], [2, 0], [2, 3], [0, 0], [2, 3], [0, 3]])
    mesh = b.mesh(quad((0, 0, -2), (1, 0, 0), (0, 0.5, 0)), attributes=[(CORNER, corners)])
    b.instance(mesh, b.material(diffuse(0.5)))
    made = passes_of(b.make(uv_attribute=[0]), filter_width=0.0)["UV"]
    x, y = np.meshgrid((np.arange(8) + 0.5) / 8, (np.arange(4) + 0.5) / 4)
    np.testing.assert_allclose(made, np.stack([2 * x, 3 * y, np.ones_like(x)], axis=-1), rtol=1e-5)


def test_indices_are_those_of_what_sample_0_sees():
    made = passes_of(shown(), 1)
    assert set(made["IndexOB"].ravel().tolist()) == {0.0, 1.0, 2.0, 3.0, 7.0, 40000.0}
    of = made["IndexOB"], made["IndexMA"]
    for object_index, material_index in ((0, 0), (1, 0), (2, 5), (3, 0), (7, 9), (40000, 0)):
        assert (of[1][of[0] == object_index] == material_index).all()
    assert set(np.unique(made["UV"][of[0][..., 0] == 3])) == {0.0}


def test_a_denoiser_looks_into_mirrors():
    """A floor seen in a mirror at 45 degrees: its albedo is tinted, its distance that of the whole way."""
    b = Builder((4, 4))
    b.look((0, 0, 4), (0, 0, 0), 1e-3, up=(0, 1, 0))
    mirror = program(("glossy", (0.9, 0.5, 0.2), dict(roughness=0.0, multiscatter=0)))
    b.add(quad((0, 0.1, 0), (1, 0, 1), (0, 1, 0)), mirror)
    b.add(quad((-3, 0.1, 0), (0, 0, 9), (0, 9, 0)), diffuse((0.6, 0.7, 0.8)))
    made = passes_of(b.make(), 256)
    albedo = np.multiply((0.6, 0.7, 0.8), (0.9, 0.5, 0.2))
    np.testing.assert_allclose(made["Denoising Albedo"].mean((0, 1)), albedo, rtol=1e-3)
    np.testing.assert_allclose(np.abs(made["Denoising Normal"]).mean((0, 1)), (1, 0, 0), atol=1e-3)
    assert made["Denoising Depth"].mean() == pytest.approx(4 + 3 * (0.9 + 0.5 + 0.2) / 3, rel=1e-3)


def test_aovs_of_the_first_surface():
    """Numbers and colours of each material, constant and not; a colour has an alpha where something is seen."""
    film = render(shown(), 1, passes=("combined", "object_index", "position"), named=NAMED)
    made, passes = make_named(film), make_passes(film, ("object_index", "position"))
    assert made["Mask"].shape == (16, 20, 4) and made["Height"].shape == (16, 20, 1)
    of, position = passes["IndexOB"][..., 0], passes["Position"]
    np.testing.assert_allclose(made["Mask"][of == 1][:, :3], position[of == 1], rtol=1e-5)
    np.testing.assert_allclose(made["Height"][of == 1], position[of == 1][:, :1], rtol=1e-5)
    assert (made["Mask"][of == 2] == (1, 0.5, 0.25, 1)).all() and (made["Height"][of == 2] == 3).all()
    assert not made["Mask"][(of != 1) & (of != 2)].any()


def test_aovs_are_those_of_the_scene():
    with pytest.raises(ValueError, match="passes value:Depth of a scene that has color:Mask, value:Height"):
        Session(shown(), Settings(named=("value:Depth",)))
