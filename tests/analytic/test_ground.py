"""Rays that leave a surface: never back into it, however large, tilted or far away, and never out through a corner."""

import numpy as np
import pytest

from tests.scenes import (
    POINT,
    SUN,
    Builder,
    assert_mean,
    ball,
    box,
    diffuse,
    join,
    look_at,
    pixels,
    place,
    quad,
    render,
)

INSIDE = np.s_[:, ::-1]


def ground(size, height, tilt, parts=1):
    """A square of 2 `size` metres at `height` on the camera's axis, in `parts` x `parts` pieces."""
    along, across = np.array((np.cos(tilt), 0, -np.sin(tilt))), np.array((0.0, 1.0, 0.0))
    center = np.array((0.0, 0.0, height)) + 0.3 * size * along + 0.2 * size * across
    steps = (np.arange(parts) - (parts - 1) / 2) * 2 / parts
    return join(*(quad(center + size * (a * along + b * across), size / parts * along, size / parts * across)
                  for a in steps for b in steps))


@pytest.mark.parametrize("size", [1.0, 500.0, 1e4])
@pytest.mark.parametrize("height", [-0.01, -0.1, -1.7, -30.0])
@pytest.mark.parametrize("tilt", [0.0, 1e-4, 0.3])
def test_large_ground_does_not_shadow_itself(size, height, tilt):
    """Albedo a under a white world is a. Rays that meet their own plane again would lose a share of it."""
    b = Builder((8, 8))
    b.world = 1.0
    b.look((0, 0, 0), (0, 0, -1), 0.3 * min(1, size / -height), clip=(1e-6, 1e5), up=(0, 1, 0))
    b.add(ground(size, height, tilt), diffuse(0.5))
    assert_mean(render(b.make(), 512), 0.5, 0.002)


@pytest.mark.parametrize("parts", [2, 9])
def test_neighbours_in_the_same_plane_do_not_shadow(parts):
    b = Builder((16, 16))
    b.world = 1.0
    b.look((0, 0, 0), (0, 0, -1), 1.0, up=(0, 1, 0))
    b.add(ground(20.0, -3.0, 0.2, parts), diffuse(0.5))
    assert_mean(render(b.make(), 512), 0.5, 0.002)


@pytest.mark.parametrize("scale", [1.0, 1e-3, 300.0])
def test_instances_do_not_shadow_themselves(scale):
    """An instance's hits suffer two changes of space; a second instance far away makes the mesh shared."""
    b = Builder((8, 8))
    b.world = 1.0
    b.look((0, 0, 0), (0, 0, -1), 0.2, up=(0, 1, 0))
    mesh, material = b.mesh(quad((0.1, 0.07, 0), (1, 0, 0), (0, 1, 0))), b.material(diffuse(0.5))
    b.instance(mesh, material, matrix=place((0, 0, -2 * scale), (2 * scale, -3 * scale, 0.7 * scale), 0.4))
    b.instance(mesh, material, matrix=place((0, 0, 90 * scale), scale))
    assert_mean(render(b.make(), 512), 0.5, 0.002)


@pytest.mark.parametrize("radius", [1e-3, 1.0, 1e4])
def test_convex_bodies_do_not_shadow_themselves(radius):
    b = Builder((8, 8))
    b.world = 1.0
    b.look((0, 0, 3 * radius), (0, 0, 0), 0.2, clip=(radius, 10 * radius), up=(0, 1, 0))
    b.add(ball(radius=radius, rings=16), diffuse(0.5))
    assert_mean(render(b.make(), 512), 0.5, 0.002)


@pytest.mark.parametrize("shape", ["box", "turned box", "ball", "instances"])
def test_closed_rooms_stay_black(shape):
    """Not one path of some millions finds its way out of a closed room into a bright world."""
    b = Builder((32, 32))
    b.world = 1e6
    b.look((0.3, -0.2, 0.4), (1, 1, 0.2), 1.5)
    b.lamp(SUN, 1e6, look_at((1, 2, 3), (0, 0, 0)), (0.1, 0))
    b.lamp(POINT, 1e6, look_at((9, 2, 3), (0, 0, 0)), (0.1, 0))
    vertices, triangles = ball(radius=1.5, rings=9) if shape == "ball" else box()
    if shape == "turned box":
        turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
        vertices = vertices @ turn.T * 1.37 + 0.011
    mesh, material = b.mesh((vertices, triangles[INSIDE])), b.material(diffuse(0.9))
    b.instance(mesh, material)
    if shape == "instances":
        b.instances[0] = (mesh, place((0.01, 0.02, 0.03), (1.7, 1.3, 1.1), 0.3), (material,), 31, ())
        b.instance(mesh, material, matrix=place((7, 0, 0)))
    assert not pixels(render(b.make(), 256))[..., 0].any()
