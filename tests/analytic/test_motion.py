"""Motion blur of objects and of meshes that deform, against shares of time that are known."""

import numpy as np
import pytest

from isophote import motion
from isophote.passes import make_passes
from isophote.records import numbers, records
from isophote.validate import check
from tests.scenes import (
    Builder,
    ball,
    box,
    diffuse,
    emission,
    mean_and_error,
    pixels,
    place,
    program,
    quad,
    ready,
    render,
)

SAMPLES = 512
MIRROR = program(("glossy", 0.9, dict(roughness=0.0, multiscatter=0)))


def flat_view(size=(32, 8), half=4.0):
    """Seen from above, through the pixels' middles; the world is black."""
    b = Builder(size)
    b.look((0, 0, 5), (0, 0, 0), half, orthographic=True, up=(0, 1, 0))
    return b


def middles(count, half):
    return (np.arange(count) + 0.5) / count * 2 * half - half


def seen(b, **arrays):
    return pixels(render(b.make(**arrays), SAMPLES, filter_width=0.0))[..., 0]


def shares(is_inside, x, y, steps=5000):
    """Share of the shutter's time in which points lie within, (len(y), len(x)), rows from below."""
    total = np.zeros((len(y), len(x)))
    for t in (np.arange(steps) + 0.5) / steps:
        total += is_inside(t, x[None, :], y[:, None])
    return total / steps


@pytest.mark.parametrize("count", [2, 3, 5])
@pytest.mark.parametrize("way", ["instance", "mesh"])
def test_a_quad_that_slides(count, way):
    """As an instance or as a mesh that deforms, with keys along the same way."""
    b = flat_view()
    shape, ways = quad((0, 0, 0), (1, 0, 0), (0, 3, 0)), np.linspace(-2, 2, count)
    if way == "instance":
        b.instance(b.mesh(shape), b.material(emission(1.0)), keys=[place((x, 0, 0)) for x in ways])
    else:
        shapes = [(shape[0] + (x, 0, 0), None) for x in ways]
        b.instance(b.mesh((shapes[count // 2][0], shape[1]), shapes=shapes), b.material(emission(1.0)))
    x, y = middles(32, 4.0), middles(8, 1.0)
    known = shares(lambda t, x, y: np.abs(x - (4 * t - 2)) + 0 * y < 1, x, y)
    np.testing.assert_allclose(seen(b), known, atol=4 / SAMPLES)


@pytest.mark.parametrize("count", [2, 3])
def test_a_bar_that_turns(count):
    """By 160 degrees, while it moves and grows; the turn is even between keys."""
    b = flat_view((24, 24), 3.0)
    keys = [place((t - 0.5, 0, 0), (1 + t, 1, 1), np.radians(160) * t) for t in np.linspace(0, 1, count)]
    b.instance(b.mesh(quad((0, 0, 0), (1, 0, 0), (0, 0.3, 0))), b.material(emission(1.0)), keys=keys)

    def is_inside(t, x, y):
        angle, x = np.radians(160) * t, x - (t - 0.5)
        along, across = x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle)
        return (np.abs(along) < 1 + t) & (np.abs(across) < 0.3)

    x = middles(24, 3.0)
    np.testing.assert_allclose(seen(b), shares(is_inside, x, x, 2000), atol=4 / SAMPLES)


def test_the_shutters_curve():
    """Most of the light is of when it is open widest."""
    b = flat_view((16, 2), 2.0)
    b.instance(b.mesh(quad((0, 0, 0), (4, 0, 0), (0, 3, 0))), b.material(emission(1.0)),
               keys=[place((-6, 0, 0)), place((-2, 0, 0))])  # its right edge goes from -2 to 2
    x = (middles(16, 2.0) + 2) / 4
    np.testing.assert_allclose(seen(b, shutter_curve=(0.0, 1.0))[0], 1 - x ** 2, atol=4 / SAMPLES)


def room(keys=None, poses=None):
    """A lit room with a mirror, a ball, an emissive panel; all of it moves, or the camera does."""
    b = Builder((12, 10))
    b.look((0, -3.6, 1), (0, 0, 1), 0.4)
    inwards = box((0, 0, 1), (1, 4, 1))
    for shape, instructions in (
            ((inwards[0], inwards[1][:, ::-1]), diffuse(0.6)),
            (quad((0, 0, 1.99), (0.4, 0, 0), (0, -0.4, 0)), emission((8, 6, 4))),
            (quad((0.6, 0.5, 0.8), (0.3, 0.2, 0), (0, 0, 0.5)), MIRROR),
            ((ball(radius=0.4, rings=6)[0] + (-0.3, 0, 0.5), ball(rings=6)[1]), diffuse((0.2, 0.5, 0.7)))):
        b.instance(b.mesh(shape), b.material(instructions), keys=keys)
    return b.make(**{} if poses is None else {"camera_poses": poses})


def test_a_camera_that_moves_and_a_world_that_moves_the_other_way():
    """The light that enters the camera is the same, from the same random numbers."""
    ways = np.array([(0.3, 0, 0.1), (0, 0, 0), (-0.3, 0, -0.1)])
    moved = room(keys=[place(way) for way in ways])
    poses = [(*((0, -3.6, 1) - way), 0, 0, 0, 1) for way in ways]
    films = [render(scene, 64, max_bounces=4) for scene in (moved, room(poses=poses))]
    a, b = (pixels(film)[..., :3] for film in films)
    off = np.abs(a - b).max(-1) / a.max(-1)
    assert (off < 1e-3).mean() > 0.8  # others have a path that rounding has led elsewhere
    np.testing.assert_allclose(a.mean((0, 1)), b.mean((0, 1)), rtol=0.01)


def furnace(keys=None, shapes=None, emissive=False):
    """Between white walls that send as much as they get every point is as bright."""
    b = Builder((8, 8))
    b.world = 1.0
    b.look((0, -6, 0), (0, 0, 0), 0.2)
    shape = ball(rings=6)
    if shapes:
        made = [(shape[0] * size, None) for size in shapes]
        b.instance(b.mesh((made[len(made) // 2][0], shape[1]), shapes=made), b.material(diffuse(1.0)), keys=keys)
    else:
        b.instance(b.mesh(shape), b.material(diffuse(1.0)), keys=keys)
    return b.make()


TURNED = [place((0, 0, -0.2), (1, 0.8, 1.2), 0.0), place((0, 0, 0), (1.2, 1, 0.9), 1.5), place((0.3, 0, 0), 1, 2.5)]


@pytest.mark.parametrize("precision", ["strict", "reference"])
@pytest.mark.parametrize("keys,shapes", [(TURNED, None), (None, (0.8, 1.0, 1.2)), (TURNED, (1.2, 1.0, 1.3)),
                                         ([m * np.array([-1, 1, 1, 1]) for m in TURNED], None)])
def test_a_furnace_leaks_nothing(keys, shapes, precision):
    """Rays that leave a surface that moves do not meet it again."""
    film = render(furnace(keys, shapes), 64, precision=precision)
    np.testing.assert_allclose(pixels(film)[..., :3], 1.0, rtol=2e-4)


@pytest.mark.parametrize("way", ["instance", "mesh"])
def test_light_from_what_moves(way):
    """The mean of its light on a floor over the way, as from many still panels: drawn, met by chance, and both."""
    ways = np.linspace(-1.5, 1.5, 9)

    def scene(keys):
        b = Builder((6, 6))
        b.look((0, 0, 6), (0, 0, 0), 2.0, orthographic=True, up=(0, 1, 0))
        b.add(quad((0, 0, 0), (3, 0, 0), (0, 3, 0)), diffuse(0.8))
        shape = quad((0, 0, 1.0), (0.4, 0, 0.2), (0, -0.4, 0))
        if way == "instance":
            b.instance(b.mesh(shape), b.material(emission(5.0)), keys=keys, visibility=30)
        else:
            shapes = [(shape[0] + key[:, 3], None) for key in keys]
            middle = shapes[len(shapes) // 2][0], shape[1]
            b.instance(b.mesh(middle, shapes=shapes), b.material(emission(5.0)), visibility=30)
        return b.make()

    moved = render(scene([place((x, 0, 0)) for x in (ways[0], ways[-1])]), 2048)
    still = [render(scene([place((x, 0, 0))] * 2), 512, seed=k) for k, x in enumerate((ways[1:] + ways[:-1]) / 2)]
    known = np.mean([pixels(film)[..., 0].mean() for film in still])
    mean, error = mean_and_error(moved)
    assert abs(mean[0] - known) < 5 * error[0] + 0.004 * known


def test_what_is_flat_for_a_moment():
    """A scale of 0 at a key: covered while it is wide enough."""
    b = flat_view((32, 2), 2.0)
    b.instance(b.mesh(quad((0, 0, 0), (1, 0, 0), (0, 3, 0))), b.material(emission(1.0)),
               keys=[place(scale=(s, 1, 1)) for s in (1, 0, 1)])
    x = np.abs(middles(32, 2.0))
    np.testing.assert_allclose(seen(b)[0], np.maximum(1 - x, 0), atol=4 / SAMPLES)


def test_what_is_mirrored_on_the_way():
    """A mirroring matrix is a turn by half a circle and a stretch that mirrors all axes, as in Cycles: in between there
    is nothing for a moment, and every number is one."""
    def is_inside(t, x, y):
        scale, turn = abs(1 - 2 * t), np.pi * (1 - t)
        return (np.abs(x) < scale) & (np.abs(y) < 0.5 * scale * (abs(np.cos(turn)) + abs(np.sin(turn))))

    b = flat_view((16, 16), 2.0)
    b.instance(b.mesh(box(half=(1, 0.5, 0.5))), b.material(emission(1.0)),
               keys=[place(scale=(s, 1, 1)) for s in (-1, 1)])
    film, x = render(b.make(), SAMPLES, filter_width=0.0), middles(16, 2.0)
    assert not film.sum(numbers()["PLANE_INVALID"]).any()
    np.testing.assert_allclose(pixels(film)[..., 0], shares(is_inside, x, x), atol=4 / SAMPLES)


@pytest.mark.parametrize("sizes", [(1.0, 0.0), (1.0, 0.0, 1.0)])
def test_what_vanishes_for_a_moment(sizes):
    """The last of its keys, or the one in the middle, is a point."""
    b = flat_view((16, 16), 2.0)
    b.instance(b.mesh(box(half=(1, 1, 1))), b.material(emission(1.0)), keys=[place(scale=size) for size in sizes])
    x = middles(16, 2.0)

    def is_inside(t, x, y):
        half = 1 - t if len(sizes) == 2 else abs(1 - 2 * t)
        return (np.abs(x) < half) & (np.abs(y) < half)

    np.testing.assert_allclose(seen(b), shares(is_inside, x, x), atol=4 / SAMPLES)


def test_boxes_hold_all_of_the_way():
    rng = np.random.default_rng(1)
    keys = []
    for k in range(200):
        a, b = (np.linalg.qr(rng.normal(size=(3, 3)))[0] * rng.uniform(0.1, 3, 3) for _ in range(2))
        if k % 3 == 0:
            b = a @ place(angle=rng.uniform(-0.07, 0.07))[:, :3]  # short arcs
        keys += [np.concatenate([m, rng.normal(size=(3, 1)) * 5], axis=1) for m in (a, b)]
    b = Builder()
    mesh = b.mesh(box(half=(1, 0.5, 0.2)))
    for k in range(200):
        b.instance(mesh, b.material(diffuse(0.5)) if not k else 0, keys=keys[2 * k:2 * k + 2])
    scene = b.make()
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-0.5, 0.5) for z in (-0.2, 0.2)])
    objects = np.broadcast_to([corners.min(0), corners.max(0)], (200, 2, 3))
    low, high = motion.swept_boxes(scene, np.arange(200), objects)
    turn, place_, stretch = motion.decomposed(np.array(keys))
    np.testing.assert_allclose(motion.rotations(turn) @ stretch, np.array(keys)[:, :, :3], atol=1e-12)
    lowest, highest = np.full((200, 3), np.inf), np.full((200, 3), -np.inf)
    for t in np.linspace(0, 1, 1501):
        q = motion.rotations(motion.slerp(turn[::2], turn[1::2], t)[0])
        at = np.einsum("nij,njk,ck->nci", q, (1 - t) * stretch[::2] + t * stretch[1::2], corners)
        at += ((1 - t) * place_[::2] + t * place_[1::2])[:, None]
        lowest, highest = np.minimum(lowest, at.min(1)), np.maximum(highest, at.max(1))
        assert (at >= low[:, None]).all() and (at <= high[:, None]).all()
    tight = ((high - low) / (highest - lowest)).max()
    assert tight < 1.02


def vectors_of(b, poses, **others):
    return make_passes(render(b.make(vectors=1, camera_poses=poses, **others), 4, passes=("vector",), filter_width=0.0),
                       ("vector",))["Vector"]


@pytest.mark.parametrize("way", ["instance", "mesh", "camera"])
def test_vectors_between_frames(way):
    """Pixels from the place in the frame before, and to the one in the frame after."""
    b = flat_view((16, 8), 2.0)  # four pixels a metre
    shape = quad((0, 0, 0), (1, 0, 0), (0, 3, 0))
    moves = np.array([(-0.5, 0.25, 0), (0, 0, 0), (0.75, 0, 0)])
    still = [(*((0, 0, 5) - (move if way == "camera" else 0 * move)), 0, 0, 0, 1) for move in moves]
    keys = [place(move) for move in moves] if way == "instance" else None
    shapes = [(shape[0] + move, None) for move in moves] if way == "mesh" else None
    b.instance(b.mesh(shape, shapes=shapes), b.material(diffuse(0.5)), keys=keys)
    made = vectors_of(b, still)
    np.testing.assert_allclose(made[:, 4:12], np.broadcast_to((-2, 1, -3, 0), (8, 8, 4)), atol=1e-4)
    assert not made[:, :4].any() and not made[:, 12:].any()


def test_vectors_of_a_camera_that_turns():
    """A perspective camera that turns by an angle each frame: the tangent of an angle that goes on."""
    b = Builder((16, 4))
    b.look((0, 0, 0), (0, 0, -1), 1.0, up=(0, 1, 0))
    b.add(quad((0, 0, -3), (9, 0, 0), (0, 9, 0)), diffuse(0.5))
    turn = 0.1  # about y: to the left
    poses = [(0, 0, 0, 0, np.sin(k * turn / 2), 0, np.cos(k * turn / 2)) for k in (-1, 0, 1)]
    made = vectors_of(b, poses)
    x = (np.arange(16) + 0.5) / 8 - 1
    angle = np.arctan(x)
    np.testing.assert_allclose(made[1, :, 0], 8 * (np.tan(angle - turn) - x), rtol=1e-4, atol=1e-5)
    np.testing.assert_allclose(made[1, :, 2], 8 * (x - np.tan(angle + turn)), rtol=1e-4, atol=1e-5)


def test_what_cannot_move_is_named():
    b = flat_view()
    b.instance(b.mesh(quad((0, 0, 0), (1, 0, 0), (0, 3, 0))), b.material(emission(1.0)),
               keys=[place((np.nan, 0, 0)), place(), place()])
    scene = b.make()
    scene.names["instances"] = ["lost"]
    problems, cleaned, _ = check(scene)
    assert [str(p) for p in problems if p.severity == "dropped"] == \
        ["lost: its matrix is not finite, or scales it to nothing"]
    assert len(cleaned.key_to_world) == 0 and len(cleaned.instance_mesh) == 0


def test_still_scenes_have_nothing_of_it():
    b = flat_view()
    b.add(quad((0, 0, 0), (1, 0, 0), (0, 3, 0)), emission(1.0))
    buffers = ready(b.make()).buffers
    assert all(len(buffers[name]) == 0 for name in ("motions", "poses", "shapes"))
    assert records()["Pose"].itemsize == 52 and records()["Motion"].itemsize == 24
