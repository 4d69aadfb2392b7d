"""Inputs, normals and tangents as kernels compute them, in pictures of a plane that glows with them, against formulas.

The plane lies at z = 0, from -1 to 1, and fills the picture; the camera looks down at it from 3 m above.
"""

import numpy as np
import pytest

from isophote.records import numbers
from isophote.values import ARITHMETIC, Value, call1, rewritten, varies
from tests.scenes import Builder, pixels, place, program, quad, render

SIZE = 8
ACROSS = (np.arange(SIZE) - 3.5) / 4
UP = (0.0, 0.0, 1.0)


def outputs(name, *inputs, **data):
    return ARITHMETIC.call(name, inputs, **data)


def seen(weight, matrix=None, tilt=0.0, attributes=(), sides=(1, 0, 0)) -> np.ndarray:
    """Radiances (8, 8, 3), shifted by 2 on the way so that none is negative; `tilt` moves the camera to the side."""
    builder = Builder(size=(SIZE, SIZE))
    builder.look((3 * np.tan(tilt), 0, 3), (0, 0, 0), tangent=1.0, orthographic=True, up=(0, 1, 0))
    mesh = builder.mesh(quad((0, 0, 0), sides, (0, 1, 0)), attributes=attributes)
    glow = program(("emission", [part + 2.0 for part in weight]))
    builder.instance(mesh, builder.material(glow), matrix=matrix)
    return pixels(render(builder.make(), 16, filter_width=0.001))[..., :3] - 2.0


def unit(v) -> np.ndarray:
    return np.asarray(v, float) / np.linalg.norm(v, axis=-1, keepdims=True)


def assert_everywhere(picture, wanted, atol=2e-6):
    np.testing.assert_allclose(picture, np.broadcast_to(wanted, picture.shape), atol=atol)


def test_length_of_the_ray_and_its_kind():
    n = numbers()
    camera, other = (call1("ray_is", data=mask) for mask in (n["RAY_CAMERA"] | n["RAY_GLOSSY"], n["RAY_SHADOW"]))
    assert_everywhere(seen([call1("ray_length"), camera, other]), (3.0 - 1e-3, 1.0, 0.0), atol=1e-5)


def test_footprint_is_a_pixel_wide():
    steps = outputs("footprint")
    for step in (steps[:3], steps[3:6]):
        lengths = np.linalg.norm(seen(step), axis=-1)
        np.testing.assert_allclose(lengths, 2.0 / SIZE, rtol=1e-5)


@pytest.mark.parametrize("mirror", [1, -1])
def test_what_is_evaluated_beside_the_point_is_the_same_place(mirror):
    """An attribute that holds x of the object, after a step: x after that step, in plain and mirrored objects."""
    shape = quad((0, 0, 0), (1, 0, 0), (0, 1, 0))
    attributes = [(numbers()["DOMAIN_VERTEX"], shape[0][:, :1])]
    steps = outputs("footprint")
    u, v = outputs("barycentric")
    for axis in (0, 1):
        moved = outputs("attribute_at", u + steps[6 + 2 * axis], v + steps[7 + 2 * axis], data=0)[0]
        picture = seen([moved, steps[3 * axis], 0.0], place(scale=(mirror, 1, 1)), attributes=attributes)
        np.testing.assert_allclose(picture[..., 0], mirror * (ACROSS + picture[..., 1]), atol=2e-3)


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.0, 1.4])
def test_mirrored_view_leaves_the_surface(angle):
    """Steep normals are bent just so far that the mirrored view leaves at a cosine of 0.01."""
    normal = (np.sin(angle), 0.0, np.cos(angle))
    bent = seen(outputs("visible_normal", *normal)[:3])
    leaves = 2.0 * bent[..., 2] ** 2 - 1.0  # the viewer stands along z
    assert_everywhere(np.linalg.norm(bent, axis=-1), 1.0, 1e-6)
    assert_everywhere(leaves, max(np.cos(2.0 * angle), 0.01), 1e-5)


def test_nothing_is_mirrored_by_the_back_of_a_normal():
    values = [outputs("visible_normal", *normal)[3] for normal in ((0.6, 0.0, 0.8), (0.6, 0.0, 0.01), (0.6, 0.0, -0.8))]
    assert_everywhere(seen(values), (1.0, 1.0, 0.0))


@pytest.mark.parametrize("strength, distance", [(1.0, 0.5), (0.4, 2.0), (1.7, -0.5), (0.0, 1.0)])
def test_bump_follows_the_slope(strength, distance):
    """Of the height x^2 / 2, whose slope is x; differences look half a footprint to the side of where they are."""
    position, step = outputs("position"), outputs("footprint")
    width = 0.01

    def height(x):
        return x * x * 0.5

    heights = [height(position[0]), *(height(position[0] + step[3 * axis] * width) for axis in (0, 1))]
    bent = seen(outputs("bump", *UP, *heights, strength, distance, number=width))
    slope = np.stack([-distance * ACROSS, 0 * ACROSS, 1 + 0 * ACROSS], axis=-1)
    wanted = unit(max(strength, 0.0) * unit(slope) + (1.0 - strength) * np.array(UP))
    np.testing.assert_allclose(bent, np.broadcast_to(wanted, bent.shape), atol=5e-3)


def test_bump_keeps_a_normal_that_it_cannot_bend():
    infinite = (Value(call1("position").call, 0) + 2.0) * 3e38 * 3e38
    flat = seen(outputs("bump", *UP, 0.0, infinite, 0.0, 1.0, 1.0, number=1.0))
    assert_everywhere(flat, UP)


def test_rewritten_expressions_see_the_other_place():
    x, y, _ = (Value(call1("position").call, k) for k in range(3))
    height = x * y + 1.0

    def moved(call, inputs):
        return (x + 1.0, y, 0.0) if call.name == "position" else None

    assert rewritten(height, moved) == (x + 1.0) * y + 1.0
    assert rewritten(height, lambda call, inputs: None) == height
    assert rewritten(2.0, moved) == 2.0
    assert not varies(rewritten(height, lambda call, inputs: (1.0, 2.0, 3.0) if call.name == "position" else None))


@pytest.mark.parametrize("space", [UP, (0.3, -0.5, 0.4)])
@pytest.mark.parametrize("scale", [(1, 1, 1), (-1, 1, 1), (2, 1, 1)])
def test_vectors_along_tangents(space, scale):
    """Turned to the world as normals are; the tangent is the object's x axis, and fronts stay fronts if mirrored."""
    normal = outputs("smooth_normal")
    picture = seen(outputs("tangent_space", *space, 1.0, 0.0, 0.0, 1.0, *normal), place(scale=scale))
    assert_everywhere(picture, unit(np.array(space) / np.array(scale)), 1e-5)


def test_backs_turn_normals_to_the_viewer():
    turned = place(scale=(1, 1, 1)) @ np.diag([1.0, -1.0, -1.0, 1.0])
    normal = outputs("tangent_space", 0.3, -0.5, 0.4, 1.0, 0.0, 0.0, 1.0, *outputs("smooth_normal"))
    assert_everywhere(seen(normal, turned), -unit((0.3, 0.5, -0.4)), 1e-6)
    assert_everywhere(seen(outputs("blended_normal", 0.6, 0.0, -0.8, 1.0), turned), (-0.6, 0.0, 0.8), 1e-6)


def test_no_tangent_leaves_the_normal():
    picture = seen(outputs("tangent_space", 0.5, 0.2, 0.1, 0.0, 0.0, 0.0, 1.0, *outputs("smooth_normal")))
    assert_everywhere(picture, UP)


def test_normals_of_length_zero():
    assert_everywhere(seen(outputs("unit_normal", 0.0, 0.0, 0.0)), UP)
    assert_everywhere(seen(outputs("blended_normal", 0.0, 0.0, 0.0, 1.0)), UP)
    infinite = (Value(call1("position").call, 0) + 2.0) * 3e38 * 3e38
    assert_everywhere(seen(outputs("unit_normal", infinite, 0.0, 0.0)), UP)


@pytest.mark.parametrize("strength", [0.0, 0.5, 1.0, 2.0])
def test_blended_normals(strength):
    given = np.array([0.6, 0.0, 0.8])
    picture = seen(outputs("blended_normal", *given, strength))
    assert_everywhere(picture, unit(np.array(UP) + strength * (given - np.array(UP))), 1e-6)


@pytest.mark.parametrize("turns", [0.0, 0.25, 0.4, -1.75])
def test_tangents_turn_about_normals(turns):
    angle = 2.0 * np.pi * turns
    picture = seen(outputs("turned_tangent", 1.0, 0.0, 0.0, *UP, turns))
    assert_everywhere(picture, (np.cos(angle), np.sin(angle), 0.0), 1e-6)


@pytest.mark.parametrize("tilt", [0.0, 0.7, 1.3])
def test_what_depends_on_the_angle_to_the_viewer(tilt):
    c, ior = np.cos(tilt), 1.45
    g = np.sqrt(ior * ior - 1.0 + c * c)
    fresnel = 0.5 * ((g - c) / (g + c)) ** 2 * (1.0 + ((c * (g + c) - 1.0) / (c * (g - c) + 1.0)) ** 2)
    values = [call1("fresnel", ior, *UP), call1("facing", 0.5, *UP), call1("facing", 0.8, *UP)]
    picture = seen(values, matrix=place(scale=(8, 8, 1)), tilt=tilt)
    assert_everywhere(picture, (fresnel, 1.0 - c, 1.0 - c ** 2.5), 1e-5)


def test_window_and_camera():
    window = seen(outputs("window_point", *outputs("camera_point")))
    np.testing.assert_allclose(window[..., 0], np.broadcast_to((ACROSS + 1.0) / 2.0, (SIZE, SIZE)), atol=1e-3)
    np.testing.assert_allclose(window[..., 1], np.broadcast_to((ACROSS[:, None] + 1.0) / 2.0, (SIZE, SIZE)), atol=1e-3)
    assert_everywhere(seen(outputs("camera_point"))[..., 2], 3.0)


def test_spheres_have_no_mesh():
    """Inputs of meshes and instances are 0 on an analytic sphere, its normals are its own; no mesh need be there."""
    builder = Builder(size=(SIZE, SIZE))
    builder.look((0, 0, 3), (0, 0, 0), tangent=0.5, orthographic=True, up=(0, 1, 0))
    nothing = [*outputs("barycentric"), call1("wireframe", 9.0), *outputs("footprint")[6:], *outputs("object_location")]
    up = [outputs("smooth_normal")[2], outputs("to_object_normal", *outputs("true_normal"))[2]]
    builder.sphere((0, 0, 0), 1.0, builder.material(program(("emission", [sum(nothing), *up]))))
    picture = pixels(render(builder.make(), 4, filter_width=0.001))[..., :3]
    heights = np.sqrt(1.0 - (ACROSS / 2)[:, None] ** 2 - (ACROSS / 2) ** 2)
    assert_everywhere(picture[..., 0], 0.0)
    np.testing.assert_allclose(picture[..., 1:], np.stack([heights, heights], axis=-1), atol=1e-3)
