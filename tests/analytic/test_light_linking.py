"""Lights that light, and objects that shadow, only what they are linked to."""

import numpy as np
import pytest

from tests.scenes import (
    POINT,
    RECTANGLE,
    SUN,
    Builder,
    assert_exactly,
    assert_mean,
    box,
    diffuse,
    emission,
    look_at,
    medium,
    pixels,
    place,
    program,
    quad,
    render,
)

ROUGH = program(("glossy", 0.8, dict(roughness=0.3, multiscatter=1)), ("diffuse", 0.1))
DOWN = look_at((0, 0, 3), (0, 0, 0), (0, 1, 0))


def halves(material) -> Builder:
    """Two floors that meet in the picture's middle, seen from above."""
    b = Builder((16, 8))
    b.look((0, 0, 8), (0, 0, 0), 0.4, up=(0, 1, 0))
    for x in (-5, 5):
        b.add(quad((x, 0, 0), (5, 0, 0), (0, 9, 0)), material)
    return b


def left_and_right(film):
    seen = pixels(film)[..., :3]
    return seen[:, :6], seen[:, 10:]  # pixels look a bit beyond their edges


@pytest.mark.parametrize("light", ["point", "sun", "rectangle", "panel", "ball"])
def test_what_is_not_lit_is_black(light):
    """The right floor is in a set that the light does not light, found by drawing or by running into it."""
    b, linked = halves(ROUGH), {}
    instances = [[0, 0], [1, 0]]
    if light in ("point", "sun", "rectangle"):
        kind, strength, size = {"point": (POINT, 500, (0.5, 0)), "sun": (SUN, 3, (0.3, 0)),
                                "rectangle": (RECTANGLE, 300, (3, 2))}[light]
        b.lamp(kind, strength, DOWN, size, visibility=30)
        linked = {"light_unlinked": [[2, 0]]}
    elif light == "panel":
        b.add(quad((0, 0, 3), (1, 0, 0), (0, -1, 0)), emission(5), visibility=30)
        instances.append([0, 0])
        linked = {"instance_unlinked": [[0, 0], [0, 0], [2, 0]]}
    else:
        b.sphere((0, 0, 3), 1, b.material(emission(5)), visibility=30)
        linked = {"sphere_unlinked": [[2, 0]]}
    lit, unlit = left_and_right(render(b.make(instance_sets=instances, **linked), 64, max_bounces=0))
    assert (unlit == 0).all()
    all_lit, _ = left_and_right(render(b.make(), 64, max_bounces=0))
    assert lit.mean() == pytest.approx(all_lit.mean(), rel=0.03 if light == "ball" else 0.01)


def test_chances_of_lights_are_right():
    """Of nine lamps over a floor some do not light it; the rest bring what they bring."""
    b = Builder((4, 4))
    b.look((0, 0, 4), (0, 0, 0), 1e-3, up=(0, 1, 0))
    b.add(quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), diffuse(0.5))
    masks, light = [], 0.0
    for k in range(9):
        x = k - 4.0
        b.lamp(POINT, 50.0 + 200.0 * (k % 3), place((x, 0.5, 2)))
        masks.append([0 if k % 2 else 1 << 40, 0])
        d2 = x * x + 0.25 + 4
        light += (k % 2) * (50.0 + 200.0 * (k % 3)) / (4 * np.pi) * 2 / d2 ** 1.5 * 0.5 / np.pi
    film = render(b.make(light_unlinked=np.array(masks, np.uint64), instance_sets=[[40, 0]]), 1024, max_bounces=0)
    assert_mean(film, light)


@pytest.mark.parametrize("light", ["point", "rectangle", "panel"])
def test_what_does_not_block_casts_no_shadow(light):
    """A board lies over the floor: the light is as if it were not there, and that of another lamp does not arrive."""
    def scene(board):
        b = Builder((8, 8))
        b.look((0, -0.01, 8), (0, 0, 0), 0.05, up=(0, 1, 0))
        b.add(quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), ROUGH)
        instances, linked = [[0, 0]], {}
        if light == "panel":
            b.add(quad((0, 0, 3), (1, 0, 0), (0, -1, 0)), emission(5), visibility=30)
            instances.append([0, 0])
            linked = {"instance_unlinked": [[0, 0], [0, 4]] + [[0, 0]] * board}
        else:
            b.lamp(POINT if light == "point" else RECTANGLE, 300, DOWN, (0, 0) if light == "point" else (3, 2))
            linked = {"light_unlinked": [[0, 4]] + [[0, 0]] * board}
        if board:
            b.add(quad((0, 0, 1), (6, 0, 0), (0, 6, 0)), diffuse(0.0), visibility=30)
            instances.append([0, 2])
            b.lamp(POINT, 1000, place((1, 1, 4)))
            linked.setdefault("light_unlinked", [[0, 0]])
        return b.make(instance_sets=instances, **linked)

    with_board, without = (render(scene(board), 1024, max_bounces=0) for board in (True, False))
    if light == "point":
        assert_mean(with_board, pixels(without)[..., :3].mean((0, 1)))
    else:
        assert pixels(with_board)[..., :3].mean() == pytest.approx(pixels(without)[..., :3].mean(), rel=0.01)


@pytest.mark.parametrize("light", ["rectangle", "panel"])
def test_boundaries_of_volumes_cast_no_shadow(light):
    """Nothing fills a box around a floor under a light that some objects do not stop: it shows nowhere."""
    def scene(boundary):
        b = Builder((8, 8))
        b.look((0, -0.01, 8), (0, 0, 0), 0.05, up=(0, 1, 0))
        b.add(quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), ROUGH)
        instances, unlinked, linked = [[0, 0]], [[0, 0]], {}
        if light == "panel":
            b.add(quad((0, 0, 3), (1, 0, 0), (0, -1, 0)), emission(5), visibility=30)
            instances.append([0, 0])
            unlinked.append([0, 4])
        else:
            b.lamp(RECTANGLE, 300, DOWN, (3, 2))
            linked = {"light_unlinked": [[0, 4]]}
        if boundary:
            b.add(box((0, 0, 0), (5, 5, 2)), [], volume=medium(1e-9))
            instances.append([0, 0])
            unlinked.append([0, 0])
        return b.make(instance_sets=instances, instance_unlinked=unlinked, **linked)

    with_box, without = (render(scene(boundary), 1024, max_bounces=1) for boundary in (True, False))
    assert pixels(with_box)[..., :3].mean() == pytest.approx(pixels(without)[..., :3].mean(), rel=0.01)


def test_mirrors_and_the_camera_see_what_does_not_light_them():
    """As in Cycles: the camera sees every light, a mirror those that light it."""
    for visibility, light in ((31, 5.0), (30, 0.0)):
        b = Builder((4, 4))
        b.look((0, 0, 0), (0, 0, -1), 0.1, up=(0, 1, 0))
        b.add(quad((0, 0, -2), (9, 0, 0), (0, 9, 0)), emission(5), visibility=visibility)
        b.add(quad((0, 0, -4), (9, 0, 0), (0, 9, 0)), program(("glossy", 1.0, dict(roughness=0.0, multiscatter=0))))
        scene = b.make(instance_sets=[[0, 0], [1, 0]], instance_unlinked=[[2, 0], [0, 0]])
        assert_exactly(render(scene, 4), light)
