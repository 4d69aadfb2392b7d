"""What float32 costs: nothing when a scene is scaled by powers of two, nothing after 2^24 samples, and little against
float64."""

import numpy as np
import pytest

from bench.parity import differing_floats, opened
from isophote.film import COMBINED_PLANES, LIMITS, Film
from isophote.params import make_params
from isophote.passes import make_passes
from isophote.records import params_dtype
from isophote.schedule import BLOCK, WorkItem
from isophote.settings import Settings
from tests.parity.scenes import SCENES, SETTINGS
from tests.scenes import (
    ELLIPSE,
    EVERY_PASS,
    POINT,
    RECTANGLE,
    SPOT,
    SUN,
    Builder,
    ball,
    box,
    diffuse,
    emission,
    look_at,
    mean_and_error,
    pixels,
    place,
    program,
    quad,
    ready,
    render,
)

# ------------------------------------------------------------------ scale


def scaled_scene(exponent):
    """Everything at 2^exponent of its size; lamps' watts grow with the square, so that radiances stay."""
    k = 2.0 ** exponent
    b = Builder((12, 10))
    b.world = 0.3
    b.look(k * np.array((0, -4, 2)), (0, 0, 0.5 * k), 0.6, clip=(0.1 * k, 1000 * k))
    b.add(quad((0, 0, 0), (4 * k, 0, 0), (0, 3 * k, 0)), diffuse((0.7, 0.5, 0.3)))
    b.add(quad((0, 0.3 * k, 3 * k), (0.5 * k, 0, 0), (0, -0.5 * k, 0)), emission((2, 3, 4)))
    rough = b.material(program(("glass", 1.0, dict(roughness=0.3, ior=1.45, multiscatter=1))))
    b.sphere((-k, 0.2 * k, 0.7 * k), 0.7 * k, rough)
    metal = b.material(program(("glossy", 0.8, dict(roughness=0.2, multiscatter=1))))
    mesh = b.mesh(ball(radius=1, rings=5))
    cube = b.mesh(box(half=0.3 * k))
    for x in (0.2, 1.3):
        b.instance(mesh, metal, matrix=place((x * k, 0.4 * k, 0.6 * k), 0.5 * k))
        b.instance(cube, rough, matrix=place((x * k, -0.9 * k, 0.3 * k), 1, x))
    for n, (kind, size) in enumerate([(POINT, (0, 0)), (POINT, (0.2, 0)), (SPOT, (0.1, 0)), (SUN, (0.05, 0)),
                                      (RECTANGLE, (0.5, 0.3)), (ELLIPSE, (0.4, 0.2))]):
        place_of = look_at(k * np.array((n - 2.5, -2, 3 + 0.1 * n)), k * np.array((0.1 * n, 0, 0)))
        strength, size = (0.2, size) if kind == SUN else (30 * k * k, k * np.array(size))
        b.lamp(kind, strength, place_of, size)
    return b.make()


@pytest.fixture(scope="module")
def unscaled():
    return make_passes(render(scaled_scene(0), 64, passes=EVERY_PASS), EVERY_PASS)


@pytest.mark.parametrize("exponent", [-20, -7, -1, 1, 5, 20])
def test_scaling_by_a_power_of_two_changes_no_bit(unscaled, exponent):
    """All of rendering is homogeneous: no length in metres, no epsilon, hides in it. Lengths scale exactly."""
    made = make_passes(render(scaled_scene(exponent), 64, passes=EVERY_PASS), EVERY_PASS)
    for name, image in unscaled.items():
        lengths = name in ("Depth", "Position", "Denoising Depth")
        seen = made[name].astype(float)
        if lengths:  # but not the depth of nothing
            seen = np.where(seen == np.float32(1e10), seen, seen / 2.0 ** exponent)
        assert differing_floats(image, seen.astype(np.float32)) == 0, name


def test_moving_the_scene_by_its_origin_changes_no_bit():
    """The place of the camera in Blender's world is no part of what is rendered."""
    scene, moved = scaled_scene(0), scaled_scene(0)
    moved.arrays["origin"] = np.array((1e7, -3e6, 1.0))
    films = [render(s, 8) for s in (scene, moved)]
    assert differing_floats(films[0].sum(0), films[1].sum(0)) == 0


# ------------------------------------------------------------------ drift


@pytest.mark.slow
def test_no_drift_after_2_to_the_24_samples():
    """A pixel of a constant world: each sample is the same float32, so their mean should be it, too. Of one colour:
    planes of zeros cost the film nothing."""
    radiance = np.array((0.0, 0.1, 0.0))
    b = Builder((1, 1))
    b.world = radiance
    settings = Settings(threads=1, passes=("combined",))
    device = opened("openmp", settings, ready(b.make()))
    film, rays, flag = Film((0, 0, 1, 1), COMBINED_PLANES), np.zeros(2, np.uint64), np.zeros(1, np.int32)
    limits = np.zeros(len(LIMITS), np.uint64)
    params = make_params(WorkItem(film.region, 0, BLOCK), settings, int(film.planes))
    while film.end < 1 << 24:  # without OpenMPDevice.render's thread an item: a quarter of a million of them
        params.view(params_dtype())["first_sample"] = film.end
        assert device.native.render(device.variant, device.buffers, device.tree, params, 1, film.open, rays,
                                    limits, flag)
        film.add_samples(BLOCK)
    assert rays.tolist() == [1 << 24, 0]
    seen = pixels(film)[0, 0]
    assert film.samples == 1 << 24
    assert abs(seen[1] / np.float32(0.1) - 1) < 1e-6 and abs(seen[3] - 1) < 1e-6


@pytest.mark.parametrize("radiance", [0.1, 1 / 3, 12345.6789, 1e-30, 1e30])
def test_no_constant_drifts(radiance):
    """All error is made within a block of 64 samples, so a few blocks show it for any constant."""
    b = Builder((4, 4))
    b.world = radiance
    seen = pixels(render(b.make(), 1024))[..., :3]
    assert np.abs(seen / np.float32(radiance) - 1).max() < 1e-6


# ------------------------------------------------------------------ float32 against float64


@pytest.mark.parametrize("name", SCENES)
def test_reference_build_agrees(name):
    """The same paths in double: their difference is far below the noise, and without a bias."""
    settings = dict(SETTINGS[name], max_bounces=12)
    strict, reference = (render(SCENES[name](), 256, precision=p, **settings) for p in ("strict", "reference"))
    mine, exact = (pixels(film)[..., :3] for film in (strict, reference))
    (mean, error), (other, _) = mean_and_error(strict), mean_and_error(reference)
    assert (np.abs(mean - other) < 0.3 * error).all(), (mean - other) / error
    # Most pixels agree to rounding; in a few a path took another turn at an edge. Shadow rays in uneven volumes draw
    # numbers from the bits of their places (kernels/tracking.h, track_of_shadow), which are others.
    relative = np.abs(mine - exact) / exact.mean()
    assert name == "clouds" or np.median(relative) < 1e-4
    assert differing_floats(strict.sum(0), reference.sum(0)) > 0, "the reference build is not another one"
