"""Catchers of shadows: alpha and factor of what others do to them."""

import numpy as np
import pytest

from isophote.passes import make_passes, matte, shadow_catcher, sums_of
from tests.scenes import (
    ALL,
    CATCHES,
    POINT,
    Builder,
    ball,
    box,
    diffuse,
    emission,
    medium,
    pixels,
    place,
    program,
    quad,
    render,
)

UNSEEN = ALL & ~1  # by the camera
FILM = dict(film_transparent=True, shadow_catchers=True)


def floor(others=True) -> Builder:
    """A floor that catches shadows, seen from above, under two lamps; a board keeps the light of one from it."""
    b = Builder((4, 4))
    b.look((0, 0, 8), (0, 0, 0), 1e-3, up=(0, 1, 0))
    b.add(quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), diffuse(0.5), visibility=CATCHES)
    b.lamp(POINT, (300, 100, 50), place((-2, 0, 4)))
    b.lamp(POINT, (100, 100, 150), place((2, 0, 4)))
    if others:
        b.add(quad((1, 0, 2), (0.5, 0, 0), (0, 0.5, 0)), diffuse(0.0), visibility=UNSEEN)
    return b


def test_the_shadow_is_the_part_of_light_that_is_kept_away():
    film = render(floor().make(), 256, max_bounces=0, **FILM)
    kept = np.array([300, 100, 50]) / np.array([400, 200, 200])
    np.testing.assert_allclose(shadow_catcher(film), np.broadcast_to(kept, (4, 4, 3)), rtol=0.05)
    shown = make_passes(film, ("combined",))["Combined"]
    assert (shown[..., :3] == 0).all()
    np.testing.assert_allclose(shown[..., 3], 1 - shadow_catcher(film).mean(-1), rtol=1e-5)


def test_beside_its_own_pass_combined_is_the_matte():
    film = render(floor().make(), 16, passes=("combined", "shadow_catcher"), film_transparent=True)
    made = make_passes(film, ("combined", "shadow_catcher"))
    assert (made["Combined"] == 0).all() and (made["Shadow Catcher"] < 1).all()


def test_without_others_nothing_is_caught():
    film = render(floor(others=False).make(), 16, **FILM)
    np.testing.assert_allclose(shadow_catcher(film), 1, rtol=1e-6)
    np.testing.assert_allclose(make_passes(film, ("combined",))["Combined"], 0, atol=1e-6)


def test_what_stands_before_a_catcher_is_the_matte():
    b = floor()
    b.look((0, 0, 8), (0, 0, 0), 0.5, up=(0, 1, 0))
    b.add(quad((-4, 0, 3), (4, 0, 0), (0, 9, 0)), emission(2.0))
    film = render(b.make(), 16, **FILM)
    seen = make_passes(film, ("combined",))["Combined"]
    np.testing.assert_array_equal(seen[:, 0], np.broadcast_to((2, 2, 2, 1), (4, 4)))
    assert (matte(film)[:, 3] == 0).all() and (shadow_catcher(film)[:, 0] == 1).all()


def test_where_no_light_arrives_the_shadow_is_black():
    b = Builder((4, 4))
    b.world = 1.0
    b.look((0, 0, 8), (0, 0, 0), 1e-3, up=(0, 1, 0))
    b.add(quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), diffuse(0.5), visibility=CATCHES)
    b.add(box((0, 0, 0), (1, 1, 1)), diffuse(0.0), visibility=UNSEEN)
    shown = make_passes(render(b.make(), 16, **FILM), ("combined",))["Combined"]
    np.testing.assert_array_equal(shown, np.broadcast_to((0, 0, 0, 1), shown.shape))


@pytest.mark.parametrize("device", ["openmp", "opencl"])
def test_light_among_catchers_alone_is_that_of_a_scene_of_them_alone(device):
    """The same but for rounding, whatever else there was: indirect light, emission, mirrors, transparent surfaces."""
    def scene(others):
        b = Builder((8, 8))
        b.world = (0.3, 0.5, 0.7)
        b.look((0, -6, 4), (0, 0, 0), 0.3)
        mesh = b.mesh(quad((0, 0, 0), (2.5, 0, 0), (0, 2.5, 0)))
        half = b.material(program(("diffuse", 0.5), ("transparent", 0.2)))
        b.instance(mesh, half, visibility=CATCHES)
        b.instance(mesh, b.material(program(("glossy", 0.7, dict(roughness=0.2, multiscatter=1)))),
                   matrix=place((0, 2, 1), (1, 0.3, 1), 0.2), visibility=CATCHES)
        b.sphere((-1, 0, 0.5), 0.5, b.material(diffuse(0.8)), visibility=CATCHES)
        b.lamp(POINT, 100, place((2, -2, 4)), (0.3, 0))
        if others:
            b.add(ball((1, 0, 0.5), 0.5, 5), diffuse(0.9), visibility=UNSEEN)
            b.sphere((0, 1, 0.6), 0.4, b.material(emission(0.5)), visibility=UNSEEN)
            b.add(box((0.5, -0.5, 1), (1, 1, 0.5)), [], volume=medium(0.5, 1.0), visibility=UNSEEN)
        return b.make()

    film = render(scene(True), 32, device, **FILM)
    alone = render(scene(False), 32, device, film_transparent=True)
    both = np.stack([alone.sum(c) + alone.sum(4 + c) for c in range(3)], axis=-1)
    np.testing.assert_allclose(sums_of(film, "shadow_catcher")[..., 4:7], both, rtol=1e-5)
    assert (np.abs(shadow_catcher(film) - 1) > 0.01).mean() > 0.2


def test_among_catchers_alone_there_are_no_other_volumes():
    """Fog dims what the camera sees, and the light of all objects; that among catchers alone comes without it."""
    plain = floor(others=False)
    fog = floor(others=False)
    fog.add(box((0, 0, 0), (9, 9, 3)), [], volume=medium(0.2))
    bare, film = (sums_of(render(b.make(), 16, **FILM), "shadow_catcher")[..., 4:7] for b in (plain, fog))
    np.testing.assert_allclose(film, bare * np.exp(-0.2 * 3), rtol=1e-4)


def test_an_opaque_film_needs_the_pass():
    scene = floor().make()
    usual, opaque = render(scene, 16), render(scene, 16, passes=("combined", "shadow_catcher"))
    np.testing.assert_array_equal(pixels(usual), pixels(opaque))
    assert (make_passes(opaque, ("combined", "shadow_catcher"))["Combined"] == 0).all()
