"""Lights: tiny and bright, huge and dim, straight along axes; the weights between two ways of sampling."""

import itertools

import numpy as np
import pytest

from tests.conftest import missing
from tests.extremes.probe import run_cpp, run_opencl
from tests.extremes.table import Row, step
from tests.extremes.variants import film, instanced, rgb
from tests.scenes import (
    CAMERA,
    ELLIPSE,
    POINT,
    RECTANGLE,
    SUN,
    Builder,
    diffuse,
    emission,
    look_at,
    mean_and_error,
    quad,
)

# ------------------------------------------------------------------ size

SIZES = step((-6, -3, 0, 1, 3, 5, 6), range(-6, 7))


def floor(side=1e5) -> Builder:
    """A white floor seen around the origin."""
    b = Builder((8, 8))
    b.look((2, -6, 7), (0, 0, 0), 1e-7)
    b.add(quad((0.3 * side, 0, 0), (side, 0, 0), (0, side, 0)), diffuse(1.0))
    return b


def over_square(half):
    """Irradiance under the middle of a square of radiance 1 in height 1, both horizontal (Lambert 1760)."""
    far = np.sqrt(1 + half * half)
    return 4 * half / far * np.arctan(half / far)


def over_disk(radius):
    return np.pi * radius ** 2 / (1 + radius ** 2)


def lit(kind, size):
    """(scene, irradiance) of a light of `size` metres, 1 m above the floor, that brings about 1 W/m^2."""
    b, above = floor(), look_at((0, 0, 1.0), (0, 0, 0))
    if kind == "mesh":
        irradiance = over_square(size / 2)
        b.add(quad((0, 0, 1), (0, size / 2, 0), (size / 2, 0, 0)), emission(1 / irradiance), visibility=31 - CAMERA)
    elif kind == POINT:  # a ball that ends 1 m above the floor
        radius = size / 2
        b.lamp(POINT, (1 + radius) ** 2 * 4 * np.pi, look_at((0, 0, 1 + radius), (0, 0, 0)), (radius, 0),
               visibility=31 - CAMERA)
    else:
        irradiance = (over_square if kind == RECTANGLE else over_disk)(size / 2)
        area = size * size * (1 if kind == RECTANGLE else np.pi / 4)
        b.lamp(kind, np.pi * area / irradiance, above, (size, size), visibility=31 - CAMERA)
    return b.make()


@pytest.mark.parametrize("kind", [RECTANGLE, ELLIPSE, POINT, "mesh"], ids=["rectangle", "ellipse", "sphere", "mesh"])
def test_power_of_tiny_and_huge_lights(kind, request):
    name = request.node.callspec.id
    widest = "1e5" if kind == "mesh" else "1e6"
    with Row("tiny bright and huge dim lights", f"{name}, 1e-6 ... {widest} m wide in 1 m, 1 W/m^2",
             "power, relative, beyond 3 standard errors", 1e-3) as row:
        for power in SIZES[:-1] if kind == "mesh" else SIZES:
            scene = lit(kind, 10.0 ** power)
            made = film(scene, step(1024, 8192), max_bounces=0)
            mean, error = mean_and_error(made)
            assert error[0] * np.pi < 2e-3, f"too noisy to tell at 1e{power}: {error[0] * np.pi:.1e}"
            row.see(max(0.0, abs(mean[0] * np.pi - 1) - 3 * error[0] * np.pi), f"1e{power} m")
            assert np.isfinite(rgb(made)).all() and rgb(made).min() > 0.1


# ------------------------------------------------------------------ directions

DIRECTIONS = [np.array(d, float) for d in itertools.product((-1, 0, 1), repeat=3) if any(d)]
SLIGHTLY = np.linalg.qr(np.eye(3) + 1e-3 * np.random.default_rng(1).normal(size=(3, 3)))[0]
SLIGHTLY = SLIGHTLY * np.sign(np.diag(SLIGHTLY))  # a turn by about 1e-3


def facing(direction, turn, kind):
    """A square that faces a light and an orthographic camera, both straight along `direction`; turned afterwards."""
    toward = direction / np.linalg.norm(direction)
    helper = np.array((1, 0, 0)) if direction[0] == 0 else np.array((0, 1, 0)) if direction[1] == 0 \
        else np.cross(direction, (0, 0, 1))
    u = np.cross(helper, toward)
    u /= np.linalg.norm(u)
    v = np.cross(toward, u)
    toward, u, v = (turn @ axis for axis in (toward, u, v))
    b = Builder((8, 8))
    b.look(3 * toward, (0, 0, 0), 0.5, orthographic=True, up=v)
    b.add(quad(0.1 * u + 0.07 * v, u, v), diffuse(1.0))
    strength = np.pi if kind == SUN else 4 * np.pi ** 2 * 25
    b.lamp(kind, strength, look_at(5 * toward, (0, 0, 0), v), visibility=31 - CAMERA)
    return b.make()


@pytest.mark.parametrize("space", ["applied", "instanced"])
def test_all_26_directions(space):
    """Camera and sun straight along axes and diagonals: radiance 1, to rounding, as when all is turned a little."""
    with Row("light straight along an axis", f"all 26 directions, sun and point, {space}",
             "pixel, relative to the closed form and to the turned scene", 2e-6) as row:
        for direction in DIRECTIONS:
            for kind in (SUN, POINT):
                scenes = facing(direction, np.eye(3), kind), facing(direction, SLIGHTLY, kind)
                straight, turned = (rgb(film(instanced(s) if space == "instanced" else s, 4, max_bounces=0))
                                    for s in scenes)
                row.see(straight / turned - 1, f"{direction} kind {kind}")
                if kind == SUN:
                    row.see(straight - 1, f"{direction}, closed form")


# ------------------------------------------------------------------ weights

WEIGHTS = "real2 p = make_real2(in[0], in[1]); out[0] = mis_weight(p.x, p.y); out[1] = mis_weight(p.y, p.x);"


def test_weights_of_any_densities():
    """Densities whose squares overflow or vanish: both weights are in [0, 1] and add up to 1."""
    powers = 10.0 ** np.arange(-37, 39)
    pairs = np.array(list(itertools.product(powers, powers)), np.float32)
    exact = run_cpp("light.h", WEIGHTS, pairs.astype(np.float64), 2, reference=True)
    with Row("pdf ratios in MIS", "densities 1e-37 ... 1e38, all pairs", "weight off float64's", 1e-6) as row:
        made = run_cpp("light.h", WEIGHTS, pairs, 2)
        try:
            other = run_opencl("light.h", WEIGHTS, pairs, 2)
        except LookupError as error:
            missing(str(error))
        assert np.array_equal(made.view(np.uint32), other.view(np.uint32)), "OpenMP and OpenCL differ"
        row.see(made - exact, "float64")
        row.see(made.astype(float).sum(1) - 1, "sum")
