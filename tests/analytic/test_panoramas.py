"""Panoramic cameras: what each pixel shows on a sphere around the camera, and where a pixel's point says it is seen,
against the projections' formulas in float64."""

import numpy as np
import pytest

from isophote.passes import make_passes
from isophote.records import numbers
from isophote.values import ARITHMETIC
from tests.scenes import EVERY_PASS, Builder, diffuse, look_at, pixels, program, quad, render

SIZE = (24, 16)
PLACE, RADIUS, CLIP = np.array((0.3, -0.2, 0.5)), 4.0, 0.25
BLENDER = look_at(PLACE, (2.0, 1.0, 1.5), (0.2, 0.1, 1))  # axes of Blender's camera: right, up, back
POLYNOMIAL = (0.0, -5.8e-2, 1e-4, 9.5e-5, -7.7e-6)
# Kind, window (left, right, bottom, top) and how far it sees.
CAMERAS = {
    "EQUIRECTANGULAR": ((-np.pi, np.pi, -np.pi / 2, np.pi / 2), 0),
    "CYLINDER": ((-2.0, 2.5, -1.0, 1.5), 0),
    "CUBE_FACE": ((-np.pi / 4, np.pi / 4, -np.pi / 4, np.pi / 4), 0),
    "MIRROR_BALL": ((-2, 2, -2, 2), 2.0),
    "EQUIDISTANT": ((-2.0, 2.0, -1.9, 1.9), 1.9),
    "EQUISOLID": ((-1.8, 1.8, -1.2, 1.2), 1.5),
    "POLYNOMIAL": ((-18, 18, -12, 12), 1.2),
}


def direction(kind, x, y, reach):
    """Directions right, up, forward (n, 3) of window points, and whether the camera sees there."""
    r, phi = np.hypot(x, y), np.arctan2(y, x)
    seen = np.ones(x.shape, bool)
    if kind == "EQUIRECTANGULAR":
        d = np.sin(x) * np.cos(y), np.sin(y), np.cos(x) * np.cos(y)
    elif kind == "CYLINDER":
        d = np.sin(x), y, np.cos(x)
    elif kind == "CUBE_FACE":
        d = np.tan(x), np.tan(y), np.ones(x.shape)
    else:
        if kind == "EQUIDISTANT":
            theta, seen = r, r <= reach
        elif kind == "POLYNOMIAL":
            theta = -np.polynomial.polynomial.polyval(r, POLYNOMIAL)
            seen = np.abs(theta) <= reach
        else:
            theta, seen = 2 * np.arcsin(np.minimum(r / 2, 1)), r <= reach
        d = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)
    d = np.stack(d, axis=-1)
    return d / np.linalg.norm(d, axis=-1, keepdims=True), seen


def camera(kind, lens=(0, 1, 0, 0, 1), shift=(0.0, 0.0)) -> Builder:
    window, reach = CAMERAS[kind]
    b = Builder(SIZE)
    right, up, back = BLENDER[:, :3].T
    axes = (right, back, -up) if kind == "MIRROR_BALL" else (-back, -right, -up)
    b.camera = dict(camera_kind=numbers()[f"CAMERA_{kind}"], camera_clip=(CLIP, 100.0), camera_lens=lens,
                    camera_to_world=np.stack([*axes, PLACE], axis=1), camera_panorama=(reach, *POLYNOMIAL, *shift),
                    camera_window=np.add(window, (shift[0], shift[0], shift[1], shift[1])))
    return b


def seen_by(kind, shift=(0.0, 0.0)):
    """Directions in the world of the pixels' middles, and whether the camera sees there."""
    left, right, bottom, top = np.add(CAMERAS[kind][0], (shift[0], shift[0], shift[1], shift[1]))
    y, x = (np.mgrid[:SIZE[1], :SIZE[0]] + 0.5) / np.array(SIZE[::-1])[:, None, None]
    local, seen = direction(kind, left + (right - left) * x, bottom + (top - bottom) * y, CAMERAS[kind][1])
    return local * (1, 1, -1) @ BLENDER[:, :3].T, seen


@pytest.mark.parametrize("kind", CAMERAS)
def test_pixels_show_their_directions(kind):
    b = camera(kind, shift=(0.05, -0.02))
    b.sphere((0, 0, 0), RADIUS, b.material(diffuse(0.5)))
    b.world = 1.0
    made = make_passes(render(b.make(), 4, passes=EVERY_PASS, filter_width=0.0), EVERY_PASS)
    d, seen = seen_by(kind, (0.05, -0.02))
    along = d @ PLACE
    distance = -along + np.sqrt(along**2 + RADIUS**2 - PLACE @ PLACE)
    np.testing.assert_allclose(made["Position"][seen], (PLACE + d * distance[..., None])[seen], atol=1e-5)
    np.testing.assert_allclose(made["Depth"][seen][..., 0], distance[seen], rtol=2e-6)
    assert (made["Depth"][~seen] == np.float32(1e10)).all() and not made["Combined"][~seen][:, :3].any()
    assert (made["Combined"][..., 3] == 1).all()
    assert seen.all() == (kind in ("EQUIRECTANGULAR", "CYLINDER", "CUBE_FACE"))


@pytest.mark.parametrize("kind", CAMERAS)
def test_window_coordinates_are_the_pixels_own(kind):
    b = camera(kind)
    window = ARITHMETIC.call("window_point", ARITHMETIC.call("camera_point", ()))
    b.sphere((0, 0, 0), RADIUS, b.material(program(("emission", list(window)))))
    picture = pixels(render(b.make(), 1, filter_width=0.0))
    y, x = (np.mgrid[:SIZE[1], :SIZE[0]] + 0.5) / np.array(SIZE[::-1])[:, None, None]
    seen = seen_by(kind)[1]
    np.testing.assert_allclose(picture[seen][:, :2], np.stack([x, y], axis=-1)[seen], atol=3e-6)


@pytest.mark.parametrize("kind", CAMERAS)
def test_footprint_is_as_wide_as_a_pixel(kind):
    """Against differences of the formulas; at the rim, where neighbours are unseen or far apart, it need not be."""
    b = camera(kind)
    step = ARITHMETIC.call("footprint", ())
    b.sphere((0, 0, 0), RADIUS, b.material(program(("emission", [part + 9.0 for part in step[:3]]))))
    picture = pixels(render(b.make(), 1, filter_width=0.0))[..., :3] - 9.0
    d, seen = seen_by(kind)
    window, reach = CAMERAS[kind]
    left, right, bottom, top = window
    y, x = (np.mgrid[:SIZE[1], :SIZE[0]] + 0.5) / np.array(SIZE[::-1])[:, None, None]
    x, y = left + (right - left) * x, bottom + (top - bottom) * y
    wide, high = 1e-4 * (right - left), 1e-4 * (top - bottom)
    across = np.linalg.norm(direction(kind, x + wide, y, 9)[0] - direction(kind, x - wide, y, 9)[0], axis=-1)
    up = np.linalg.norm(direction(kind, x, y + high, 9)[0] - direction(kind, x, y - high, 9)[0], axis=-1)
    angle = (across / SIZE[0] + up / SIZE[1]) / 2 / 2e-4
    along = d @ PLACE
    distance = -along + np.sqrt(along**2 + RADIUS**2 - PLACE @ PLACE)
    inner = seen & (np.hypot(x / right, y / top) < 0.8) if reach else seen
    found = np.linalg.norm(picture, axis=-1)
    np.testing.assert_allclose(found[inner], (angle * distance)[inner], rtol=0.15)


def test_a_turning_camera_shows_the_mean_of_what_it_sees():
    """By 1.2 radians about the world's z while the shutter is open: the mean of the directions on the way."""
    angle, poses = 1.2, []
    for part in (-0.5, -0.25, 0.0, 0.25, 0.5):
        poses.append((*np.zeros(3), 0, 0, np.sin(part * angle / 2), np.cos(part * angle / 2)))
    b = camera("EQUIRECTANGULAR")
    b.camera["camera_to_world"][:, 3] = 0.0
    point = ARITHMETIC.call("position", ())
    b.sphere((0, 0, 0), RADIUS, b.material(program(("emission", [part + 9.0 for part in point]))))
    picture = pixels(render(b.make(camera_poses=poses), 256, filter_width=0.0))[..., :3] - 9.0
    shrink = np.sin(angle / 2) / (angle / 2)
    np.testing.assert_allclose(picture, seen_by("EQUIRECTANGULAR")[0] * RADIUS * (shrink, shrink, 1), atol=4e-3)


@pytest.mark.parametrize("curve,middle", [((), 0.5), ((0.0, 1.0), 2 / 3), ((1.0, 0.0, 0.0), 1 / 6)])
def test_a_shutter_that_opens_slowly_weighs_times(curve, middle):
    """A camera that moves along x before a plane that glows with x: the mean place is the curve's mean time."""
    b = Builder((8, 8))
    b.look((0, 0, 3), (0, 0, 0), tangent=1.0, orthographic=True, up=(0, 1, 0))
    point = ARITHMETIC.call("position", ())
    b.add(quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), program(("emission", [part + 9.0 for part in point])))
    poses = [(x, 0, 3, 0, 0, 0, 1) for x in (-1, 0, 1)]
    picture = pixels(render(b.make(camera_poses=poses, shutter_curve=curve), 256, filter_width=0.0))[..., :3] - 9.0
    across = (np.arange(8) - 3.5) / 4
    np.testing.assert_allclose(picture[..., 0], np.broadcast_to(across + 2 * middle - 1, (8, 8)), atol=1e-2)
    assert picture[..., 0].mean() == pytest.approx(2 * middle - 1, abs=2e-3)
    np.testing.assert_allclose(picture[..., 1], np.broadcast_to(across[:, None], (8, 8)), atol=1e-4)


def test_what_lies_in_focus_is_a_sphere():
    """Through a wide lens each pixel of a sphere in focus still shows its own direction and nothing else."""
    b = camera("EQUIDISTANT", lens=(0.2, RADIUS, 5, 0.3, 1.4))
    b.camera["camera_to_world"][:, 3] = 0.0
    point = ARITHMETIC.call("position", ())
    b.sphere((0, 0, 0), RADIUS, b.material(program(("emission", [part + 9.0 for part in point]))))
    d, seen = seen_by("EQUIDISTANT")
    picture = pixels(render(b.make(), 64, filter_width=0.0))[..., :3] - 9.0
    np.testing.assert_allclose(picture[seen], (d * RADIUS)[seen], atol=2e-5)
