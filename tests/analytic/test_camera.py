"""The camera and the passes of the first hit: known points in known pixels, exact values on planes and spheres."""

import numpy as np
import pytest

from isophote.passes import make_passes
from isophote.prepare import blackman_harris_table
from tests.scenes import EVERY_PASS, Builder, diffuse, emission, look_at, pixels, place, program, quad, render

SIZE = (24, 16)
MATRIX = look_at((1, -2, 3), (0.3, 0.5, 0), (0.2, 0.1, 1))


def camera(orthographic, tangent=0.7) -> Builder:
    b = Builder(SIZE)
    b.look((1, -2, 3), (0.3, 0.5, 0), tangent, orthographic, up=(0.2, 0.1, 1))
    return b


def on_film(points, orthographic, tangent=0.7):
    """Pixels from the lower left, (n, 2), and distances along the axis of points (n, 3)."""
    local = (points - MATRIX[:, 3]) @ MATRIX[:, :3]
    plane = local[:, :2] if orthographic else local[:, :2] / -local[:, 2:]
    return (plane / tangent + (1, SIZE[1] / SIZE[0])) * SIZE[0] / 2, -local[:, 2]


@pytest.mark.parametrize("orthographic", [False, True], ids=["perspective", "orthographic"])
def test_points_appear_in_their_pixels(orthographic):
    """Tiny glowing spheres: all their light lies within the filter around the projected point, and its centre is it."""
    rng = np.random.default_rng(11)
    for _ in range(8):
        pixel, depth = rng.uniform((4, 4), (SIZE[0] - 4, SIZE[1] - 4)), rng.uniform(2, 6)
        plane = (pixel * 2 / SIZE[0] - (1, SIZE[1] / SIZE[0])) * 0.7
        local = np.array([*(plane if orthographic else plane * depth), -depth])
        point = MATRIX[:, :3] @ local + MATRIX[:, 3]
        np.testing.assert_allclose(on_film(point[None], orthographic)[0][0], pixel)
        b = camera(orthographic)
        b.sphere(point, 0.04 * (1 if orthographic else depth), b.material(emission(1.0)))
        seen = pixels(render(b.make(), 2048, filter_width=3.0))[..., 0]
        y, x = np.nonzero(seen)
        assert len(x) and np.abs(x + 0.5 - pixel[0]).max() < 3.9 and np.abs(y + 0.5 - pixel[1]).max() < 3.9
        center = np.array([(seen * (grid + 0.5)).sum() for grid in np.mgrid[:SIZE[1], :SIZE[0]][::-1]]) / seen.sum()
        np.testing.assert_allclose(center, pixel, atol=0.1)


@pytest.mark.parametrize("orthographic", [False, True], ids=["perspective", "orthographic"])
def test_passes_of_a_plane(orthographic):
    """Depth, position, normal and albedo where each pixel's ray meets a tilted plane; the filter is a point."""
    point, normal = np.array((0.2, 0.4, 0.1)), np.array((0.1, -0.3, 1.0))
    normal /= np.linalg.norm(normal)
    u = np.cross(normal, (1, 0, 0))
    u /= np.linalg.norm(u)
    v = np.cross(normal, u)
    albedo = np.array((0.1, 0.5, 0.9))
    b = camera(orthographic, 0.4)
    b.add(quad(point + 3 * u, 20 * u, 20 * v), diffuse(albedo))
    film = render(b.make(), 4, passes=EVERY_PASS, filter_width=0.0)
    made = make_passes(film, EVERY_PASS)
    y, x = np.mgrid[:SIZE[1], :SIZE[0]] + 0.5
    plane = np.stack([x / SIZE[0] * 2 - 1, (y / SIZE[1] * 2 - 1) * SIZE[1] / SIZE[0]], axis=-1) * 0.4
    along = plane[..., :1] * MATRIX[:, 0] + plane[..., 1:] * MATRIX[:, 1]
    origin = MATRIX[:, 3] + (along if orthographic else 0)
    direction = -MATRIX[:, 2] + (0 if orthographic else along)
    t = ((point - origin) @ normal / (direction @ normal))[..., None]  # directions have length 1 along the axis
    np.testing.assert_allclose(made["Depth"], t, rtol=5e-6)
    np.testing.assert_allclose(made["Position"], origin + t * direction, atol=2e-5)
    np.testing.assert_allclose(made["Normal"], np.broadcast_to(normal, made["Normal"].shape), atol=1e-6)
    np.testing.assert_allclose(made["Albedo"], np.broadcast_to(albedo, made["Albedo"].shape), rtol=1e-6)
    assert (made["Sample Count"] == 4).all() and made["Combined"][..., 3].min() == 1


def test_normals_face_the_camera_and_turn_with_instances():
    """From behind the normal is turned round; under a squeezing, mirroring matrix it stays perpendicular."""
    normal = np.array((0.0, 0.6, 0.8))
    for mirror in (1, -1):
        b = Builder((4, 4))
        b.look((0, 0, 5), (0, 0, 0), 0.01, up=(0, 1, 0))
        mesh, material = b.mesh(quad((0.1, 0, 0), (1, 0, 0), (0, 0.8, -0.6))), b.material(diffuse(0.5))
        matrix = place((0, 0, 0), (2 * mirror, 3, 0.5))
        b.instance(mesh, material, matrix=matrix)
        b.instance(mesh, material, matrix=place((0, 0, -50)))
        expected = np.linalg.inv(matrix[:, :3]).T @ normal
        expected *= np.sign(expected[2]) / np.linalg.norm(expected)
        seen = make_passes(render(b.make(), 4, passes=EVERY_PASS), EVERY_PASS)["Normal"]
        np.testing.assert_allclose(seen, np.broadcast_to(expected, seen.shape), atol=1e-6)


def test_smooth_normals_are_interpolated():
    b = Builder((4, 4))
    b.look((0.25, 0.25, 5), (0.25, 0.25, 0), 1e-4, up=(0, 1, 0))
    normals = np.array(((0, 0, 1), (0.6, 0, 0.8), (0, 0.6, 0.8)))
    b.add((np.array(((0, 0, 0), (1, 0, 0), (0, 1, 0))), np.array([[0, 1, 2]])), diffuse(0.5), normals=normals)
    expected = np.array((0.5, 0.25, 0.25)) @ normals
    seen = make_passes(render(b.make(), 4, passes=EVERY_PASS), EVERY_PASS)["Normal"]
    np.testing.assert_allclose(seen, np.broadcast_to(expected / np.linalg.norm(expected), seen.shape), atol=1e-3)


def test_passes_of_a_sphere_and_of_nothing():
    b = Builder((9, 9))
    b.look((0, 0, 3), (0, 0, 0), 0.5, up=(0, 1, 0))
    b.sphere((0, 0, 0), 1, b.material(program(("diffuse", 0.3), ("emission", 0.2))))
    made = make_passes(render(b.make(), 2, passes=EVERY_PASS, filter_width=0.0), EVERY_PASS)
    np.testing.assert_allclose(made["Depth"][4, 4], 2, rtol=1e-6)
    np.testing.assert_allclose(made["Normal"][4, 4], (0, 0, 1), atol=1e-6)
    np.testing.assert_allclose(made["Position"], made["Normal"] * (made["Depth"] < 1e9), atol=1e-6)  # a unit sphere
    assert made["Depth"][0, 0] == np.float32(1e10) and not made["Normal"][0, 0].any()


def test_depth_and_position_are_those_of_the_first_sample():
    """Blender's depth has no mean across an edge: whatever the samples, every value is one of two surfaces."""
    b = Builder((16, 4))
    b.look((0, 0, 0), (0, 0, -1), 0.5, up=(0, 1, 0))
    b.add(quad((5, 0, -2), (5, 0, 0), (0, 9, 0)), diffuse(0.5))
    b.add(quad((0.5, 0.1, -7), (40, 0, 0), (0, 40, 0)), diffuse(0.5))
    depth = make_passes(render(b.make(), 64, passes=EVERY_PASS), EVERY_PASS)["Depth"]
    near = np.isclose(depth, 2, rtol=1e-5)
    assert (near | np.isclose(depth, 7, rtol=1e-5)).all() and 0 < near.sum() < depth.size


@pytest.mark.parametrize("start,end,seen", [(0.5, 10, 1), (2.5, 10, 2), (0.5, 1.5, 0), (2.5, 2.9, 0)])
def test_clipping_along_the_axis(start, end, seen):
    """Planes at 2 and 3 metres; clip distances count along the axis for all pixels."""
    b = Builder((8, 8))
    b.look((0, 0, 0), (0, 0, -1), 2.0, clip=(start, end), up=(0, 1, 0))
    for k, z in enumerate((-2, -3)):
        b.add(quad((1, 0, z), (30, 0, 0), (0, 30, 0)), emission(k + 1.0))
    assert (pixels(render(b.make(), 8))[..., 0] == seen).all()


def test_filter_is_the_blackman_harris_window():
    """The table inverts the integral of the window; the light of a thin line spreads over pixels as the window says."""
    table = blackman_harris_table().astype(float)
    assert table[0] == -1 and table[-1] == 1 and (np.diff(table) > 0).all()  # as Cycles: the width is half the window's
    np.testing.assert_allclose(table, -table[::-1], atol=1e-5)
    x = np.linspace(-1, 1, 200001)
    phase = np.pi * (x + 1)
    window = 0.35875 - 0.48829 * np.cos(phase) + 0.14128 * np.cos(2 * phase) - 0.01168 * np.cos(3 * phase)
    mass = np.cumsum(window) / window.sum()

    b = Builder((8, 8))
    b.look((0, 0, 0), (0, 0, -1), 4.0, up=(0, 1, 0))  # a pixel is 1 m wide at distance 1
    b.add(quad((0.5, 0.3, -1), (0.02, 0, 0), (0, 50, 0)), emission(1.0))
    seen = pixels(render(b.make(), 8192, filter_width=1.5))[..., 0].mean(0)
    for column in range(8):
        low, high = (np.interp((offset - column + 4) / 1.5, x, mass, 0, 1) for offset in (-0.02, 0.02))
        sigma = np.sqrt((high - low) / (8192 * 8)) + 1e-9
        assert abs(seen[column] - (high - low)) < 5 * sigma + 0.01 * (high - low), column


@pytest.mark.parametrize("orthographic", [False, True], ids=["perspective", "orthographic"])
@pytest.mark.parametrize(("blades", "ratio"), [(0, 1.0), (0, 2.0), (6, 1.0), (4, 0.5)])
def test_blur_of_a_lens(orthographic, blades, ratio):
    """Second moments of a glowing point's picture, in focus and out of it: those of its circle of confusion.

    A lens of radius r in focus at f shows a point at distance d spread over the lens' shape times r |1/f - 1/d| at
    distance 1, or r |1 - d/f| where rays are parallel. The mean of x^2 is 1/4 over the unit disk, and
    (2 + cos(2 pi / n)) / 12 over the regular polygon of n corners on the unit circle.
    """
    radius, focus, tangent = 0.2, 3.0, 0.5
    unit = 0.25 if blades == 0 else (2 + np.cos(2 * np.pi / blades)) / 12

    def moments(lens, distance):
        b = Builder((32, 32))
        b.look((0, 0, 0), (0, 0, -1), tangent, orthographic, up=(0, 1, 0), lens=lens)
        b.sphere((0, 0, -distance), 0.04 * (1 if orthographic else distance), b.material(emission(1.0)))
        seen = pixels(render(b.make(), 2048))[..., 0]
        grid = np.arange(32) - 15.5
        return np.array([(seen * grid ** 2).sum(), (seen * grid[:, None] ** 2).sum()]) / seen.sum()

    sharp = moments((0, 0, 0, 0, 0), 4.0)
    lens = (radius, focus, blades, 0.3, ratio)
    np.testing.assert_allclose(moments(lens, focus), moments((0, 0, 0, 0, 0), focus), rtol=0.05)
    for distance in (2.0, 4.5):
        spread = radius * abs(1 - distance / focus) / (1 if orthographic else distance) * 16 / tangent
        wanted = sharp + unit * spread ** 2 * np.array([ratio ** -2, 1])
        np.testing.assert_allclose(moments(lens, distance), wanted, rtol=0.03)
