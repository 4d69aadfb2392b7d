"""Volumes against known answers: what they absorb, emit and scatter, where they begin and end."""

import numpy as np
import pytest

from bench.parity import expose
from isophote.device import open_device
from isophote.film import LIMITS, Film
from isophote.passes import film_planes
from isophote.planes import INVALID
from isophote.settings import Settings
from isophote.validate import validate
from isophote.values import ARITHMETIC
from tests.analytic.test_subsurface import h_function
from tests.scenes import (
    POINT,
    SUN,
    Builder,
    assert_exactly,
    assert_mean,
    ball,
    box,
    diffuse,
    emission,
    mean_and_error,
    medium,
    pixels,
    place,
    program,
    quad,
    ready,
    render,
)

SIGMA = np.array([0.2, 1.0, 3.0])
BOTH = pytest.mark.parametrize("precision", ["strict", "reference"])


def through_box(volume, surface=(), half=1.0, height=5.0, world=1.0) -> Builder:
    """A box around the origin, seen from above in parallel."""
    b = Builder((4, 4))
    b.world = world
    b.look((0, 0, height), (0, 0, 0), 0.5, orthographic=True, up=(0, 1, 0))
    b.add(box(half=half), list(surface), volume=volume)
    return b


def phase(cosine, g):
    return (1 - g * g) / (4 * np.pi * (1 + g * g - 2 * g * cosine) ** 1.5)


@BOTH
@pytest.mark.parametrize("surface", [(), ("transparent", 1.0), ("refraction", 1.0, dict(roughness=0, ior=1))],
                         ids=["nothing", "transparent", "refraction"])
def test_a_slab_absorbs(surface, precision):
    """Beer and Lambert."""
    film = render(through_box(medium(SIGMA), program(surface) if surface else ()).make(), 16, precision=precision)
    assert_exactly(film, np.exp(-2 * SIGMA), 1e-5)


@BOTH
def test_the_camera_may_be_inside(precision):
    b = through_box(medium(SIGMA), height=0.25)
    assert_exactly(render(b.make(), 4, precision=precision), np.exp(-1.249 * SIGMA), 1e-5)
    b.add(box(half=(0.4, 0.4, 0.1)), [], volume=medium(2.0))  # below it
    b.sphere((0, 0, 0.25), 0.2, b.material([], volume=medium(1.0)))  # around it
    b.add(box(center=(0, 0, 0.8), half=0.1), [], volume=medium(7.0))  # above, where it does not look
    b.look((0, 0, 0.25), (0, 0, 0), 0.01, orthographic=True, up=(0, 1, 0))
    assert_exactly(render(b.make(), 4, precision=precision), np.exp(-1.249 * SIGMA - 0.4 - 0.199), 1e-3)


def test_volumes_add_up():
    b = through_box(medium(SIGMA))
    b.add(box(half=(2, 2, 0.5)), [], volume=medium(0.3))
    b.add(box(center=(0, 0, 1), half=(2, 2, 0.5)), [], volume=medium(0.1))
    b.sphere((0, 0, 0), 10.0, b.material([], volume=medium(0.01)))
    film = render(b.make(), 4)
    seen = pixels(film)[1:3, 1:3, :3].mean((0, 1))
    assert seen == pytest.approx(np.exp(-2 * SIGMA - 0.3 - 0.1 - 0.01 * 15), rel=2e-3)


@BOTH
def test_a_slab_glows(precision):
    glow = np.array([1.0, 2.0, 0.5])
    film = render(through_box(medium(SIGMA, glow=glow), world=0.0).make(), 4, precision=precision)
    assert_exactly(film, glow * (1 - np.exp(-2 * SIGMA)) / SIGMA, 1e-5)
    assert_exactly(render(through_box(medium(glow=glow), world=0.0).make(), 4, precision=precision), 2 * glow, 1e-6)


def add_body(b: Builder, shape: str, material: int) -> None:
    """A sphere, or a box or a ball as an instance, mirrored or not."""
    if shape == "sphere":
        b.sphere((0, 0, 0), 1, material)
        return
    body = b.mesh(box() if shape == "box" else ball(rings=6))
    b.instance(body, material, matrix=place(scale=(-1, 1, 1) if shape == "mirrored" else 1))
    b.instance(body, material, matrix=place((50, 0, 0)))


@BOTH
@pytest.mark.parametrize("shape", ["box", "sphere", "mirrored"])
@pytest.mark.parametrize("anisotropy", [0.0, 0.7, -0.5, 1.0])
def test_white_volumes_do_not_show(shape, anisotropy, precision):
    """What scatters all light in a white world is invisible; of one extinction for all channels each path brings 1."""
    b = Builder((8, 8))
    b.world = 1.0
    b.look((0, 0, 4), (0, 0, 0), 0.2, up=(0, 1, 0))
    add_body(b, shape, b.material([], volume=medium(scattering=2.0, anisotropy=anisotropy)))
    film = render(b.make(), 64, precision=precision, max_bounces=250, volume_bounces=250)
    assert_mean(film, 1.0, accuracy=0.002, rounding=2e-4)


def test_white_volumes_of_coloured_extinction_do_not_show():
    b = through_box(medium(scattering=(0.5, 1.0, 4.0), anisotropy=0.3))
    assert_mean(render(b.make(), 4096, max_bounces=250, volume_bounces=250), 1.0, accuracy=0.004)


@BOTH
@pytest.mark.parametrize("anisotropy", [0.0, 0.6, -0.9])
@pytest.mark.parametrize("below", [False, True])
def test_single_scattering_of_a_slab(below, anisotropy, precision):
    """Of a sharp sun overhead, seen from above and from below."""
    absorbed, scattered, sun = 0.3 * SIGMA, 0.7 * SIGMA, 2.0
    b = through_box(medium(absorbed, scattered, anisotropy), half=(30, 30, 0.5), world=0.0)
    if below:
        b.look((0, 0, -5), (0, 0, 0), 0.5, orthographic=True, up=(0, 1, 0))
    b.lamp(SUN, sun)
    expected = scattered * sun * phase(1 if below else -1, anisotropy)
    expected = expected * (np.exp(-SIGMA) if below else (1 - np.exp(-2 * SIGMA)) / (2 * SIGMA))
    film = render(b.make(), 2048, volume_bounces=0, max_bounces=0, precision=precision)
    assert_mean(film, expected, accuracy=0.02)


@pytest.mark.parametrize("mu", [1.0, 0.3])
def test_half_space_returns_what_theory_says(mu):
    """The plane albedo 1 - H(mu) sqrt(1 - albedo) of isotropic scattering, of each channel another albedo."""
    albedo, extinction = np.array((0.9, 0.6, 0.2)), np.array((1.0, 2.0, 0.7))
    b = Builder((4, 4))
    b.world = 1.0
    b.look((5 * np.sqrt(1 - mu * mu), 0, 5 * mu), (0, 0, 0), 0.5, orthographic=True, up=(0, 1, 0))
    b.add(box((0, 0, -400), (1000, 1000, 400)), [], volume=medium((1 - albedo) * extinction, albedo * extinction))
    expected = np.array([1 - h_function(mu, a).item() * np.sqrt(1 - a) for a in albedo])
    film = render(b.make(), 2048, max_bounces=250, volume_bounces=250)
    assert_mean(film, expected, accuracy=0.02)


@BOTH
@pytest.mark.parametrize("size", [0.0, 0.1])
def test_lamps_shine_through(size, precision):
    """A floor under an absorbing slab, lit through it by a sun; and as much by a lamp that closures run into."""
    b = Builder((4, 4))
    b.look((0, 0, 0.5), (0, 0, 0), 0.2, orthographic=True, up=(0, 1, 0))
    b.add(quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), diffuse(0.5))
    b.add(box((0, 0, 2), (90, 90, 0.5)), [], volume=medium(SIGMA))
    b.lamp(SUN, 3.0, size=(size, 0))
    film = render(b.make(), 64, precision=precision)
    assert_mean(film, 3.0 * 0.5 / np.pi * np.exp(-SIGMA), accuracy=0.01, rounding=1e-5 + size * size)


def test_lamps_are_seen_through_volumes():
    """By the camera, half-way in the slab and behind it, whatever scatters there."""
    for volume, more in ((medium(SIGMA), 1.0001), (medium(0.5 * SIGMA, 0.5 * SIGMA), 1.6)):
        b = through_box(volume, world=0.0)
        b.look((0, 0, 0.5), (0, 0, 0), 0.05, orthographic=True, up=(0, 1, 0))
        b.lamp(POINT, 4 * np.pi * np.pi, place((0, 0, 0)), size=(0.2, 0))
        b.add(quad((0, 0, -0.5), (1, 0, 0), (0, 1, 0)), diffuse(0.0))
        seen = pixels(render(b.make(), 1, volume_bounces=0))[..., :3].mean((0, 1))
        bare = pixels(render(_without_volume(b), 1))[..., :3].mean((0, 1))
        assert (seen >= bare * np.exp(-SIGMA * 0.345)).all()  # from 0.499 to 0.2, or less where the ball is not as high
        assert (seen <= bare * np.exp(-SIGMA * 0.299) * more).all()


def _without_volume(b: Builder):
    b.volumes = dict.fromkeys(b.volumes, 0)
    b.materials[b.instances[0][2][0]] = program(("transparent", 1.0))
    return b.make()


def test_world_volumes():
    """Around everything; nothing comes through without end, but in channels that it lets pass."""
    b = Builder((4, 4))
    b.world = 1.0
    b.look((0, 0, 2), (0, 0, 0), 0.1, orthographic=True, up=(0, 1, 0))
    b.add(quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), emission(1.0))
    assert_exactly(render(b.make(**b.fill_world(medium(SIGMA))), 4), np.exp(-1.999 * SIGMA), 1e-5)
    b.instances.clear()
    b.meshes.clear()
    assert_exactly(render(b.make(**b.fill_world(medium((0.1, 0.0, 1e-30)))), 4), (0.0, 1.0, 0.0), 1e-6)


def test_past_its_last_bounce_a_path_is_not_scattered():
    """The limit counts in the ledger."""
    b = through_box(medium(scattering=2.0))
    film = render(b.make(), 64, volume_bounces=0)
    ended = dict(zip(LIMITS, film.ended, strict=True))
    assert ended["volume_bounces"] > 0 and not ended["max_bounces"]
    mean, _ = mean_and_error(film)
    assert (mean < 0.95).all()


def test_more_volumes_than_paths_can_remember():
    """Eight count, as a note says."""
    b = through_box(medium(0.01))
    for k in range(19):
        b.add(box(half=(1 - 0.01 * k, 1 - 0.01 * k, 1 - 1e-6 * k)), [], volume=medium(0.01))
    scene = b.make()
    assert any("more than 8 volumes" in problem.what for problem in validate(scene))
    assert pixels(render(scene, 4))[..., :3] == pytest.approx(np.exp(-2 * 0.01 * 8), rel=1e-4)


@pytest.mark.parametrize("volume", [medium(1e6), medium(0, 1e6), medium(1e-30, 1e-30), medium(0, 1e-30),
                                    medium(0, 1e30), medium(1e30, 1e-30), medium(0, 1.0, 5.0),
                                    medium(1e-30, glow=1e-30)],
                         ids=range(8))
def test_extremes_are_numbers(volume):
    film = render(through_box(volume).make(), 16)
    assert not film.sum(INVALID).any() and np.isfinite(pixels(film)).all()
    assert (pixels(film)[..., :3] >= 0).all() and pixels(film)[..., :3].max() < 1.2


# ------------------------------------------------------------------ what differs from point to point


def ramp(low: float, high: float):
    """Numbers that go from low at z = -1 to high at z = 1."""
    return ARITHMETIC.call("position")[2] * (0.5 * (high - low)) + 0.5 * (high + low)


@BOTH
def test_an_uneven_slab_absorbs(precision):
    """Of a density that grows evenly the mean counts; ratio and delta tracking are right on average."""
    dense = [ramp(0.0, 2.0 * s) for s in (0.2, 1.0, 1.5)]
    film = render(through_box(program(("extinction", dense))).make(), 2048, precision=precision)
    assert_mean(film, np.exp(-2 * np.array((0.2, 1.0, 1.5))), accuracy=0.01)


@BOTH
def test_an_uneven_slab_casts_shadows(precision):
    b = Builder((4, 4))
    b.look((0, 0, -1.5), (0, 0, -2), 0.2, orthographic=True, up=(0, 1, 0))
    b.add(quad((0, 0, -2), (9, 0, 0), (0, 9, 0)), diffuse(0.5))
    b.add(box((0, 0, 0), (90, 90, 1)), [], volume=program(("extinction", [ramp(0.5, 1.5)] * 3)))
    b.lamp(SUN, 3.0)
    assert_mean(render(b.make(), 2048, precision=precision), 3.0 * 0.5 / np.pi * np.exp(-2), accuracy=0.02)


@BOTH
def test_an_uneven_slab_glows(precision):
    """The emission of a slab whose density and glow grow together: glow / density is the same everywhere."""
    dense = ramp(0.1, 1.9)
    volume = program(("extinction", [dense] * 3), ("emission", [dense * 3.0, dense, dense * 0.5]))
    film = render(through_box(volume, world=0.0).make(), 4096, precision=precision)
    assert_mean(film, np.array((3.0, 1.0, 0.5)) * (1 - np.exp(-2)), accuracy=0.01)


@BOTH
@pytest.mark.parametrize("shape", ["box", "sphere", "mirrored"])
def test_uneven_white_volumes_do_not_show(shape, precision):
    b = Builder((6, 6))
    b.world = 1.0
    b.look((0, 0, 4), (0, 0, 0), 0.2, up=(0, 1, 0))
    x, _, z = ARITHMETIC.call("object_point")
    dense = x * x * 3.0 + 0.1
    white = b.material([], volume=program(("extinction", [dense, dense * 2.0, dense]),
                                          ("scattering", [dense, dense * 2.0, dense], dict(anisotropy=z * 0.5))))
    add_body(b, shape, white)
    film = render(b.make(), 1024, precision=precision, max_bounces=250, volume_bounces=250)
    assert_mean(film, 1.0, accuracy=0.005, rounding=1e-3)


def test_too_low_majorants_keep_the_mean():
    """Weights are negative there."""
    b = through_box(program(("extinction", [ramp(0.0, 2.0)] * 3)))
    prepared = ready(b.make())
    prepared.buffers["materials"]["majorant"] *= 0.6
    settings = Settings(samples=8192, volume_bounces=8)
    device = open_device("openmp", settings)
    device.upload(prepared)
    film = expose(device, Film((0, 0, 4, 4), film_planes(settings)), 8192, settings)
    device.close()
    assert_mean(film, np.exp(-2), accuracy=0.02)


def test_volumes_do_not_ask_for_surfaces():
    with pytest.raises(AssertionError, match="asks for what surfaces have"):
        through_box(program(("extinction", list(ARITHMETIC.call("shading_normal"))))).make()
