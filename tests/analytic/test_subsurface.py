"""Light below surfaces: what comes back from a half-space, and white objects that stay white."""

import numpy as np
import pytest

from tests.scenes import Builder, assert_mean, ball, box, mean_and_error, place, program, quad, render

MEAN_COSINES, WEIGHTS = np.polynomial.legendre.leggauss(400)
MEAN_COSINES, WEIGHTS = 0.5 * (MEAN_COSINES + 1), 0.5 * WEIGHTS


def below(color=1.0, radius=1.0, **others):
    """A program of one walk; the closure is smooth, and does not bend light, unless it is said to."""
    c, r = np.broadcast_to(color, 3), np.broadcast_to(radius, 3)
    params = dict(anisotropy=0.0, ior=1.0, roughness=0.0, diffuse=0.0) | others
    params |= {f"{name}_{channel}": float(v) for name, rgb in (("albedo", c), ("radius", r))
               for channel, v in zip("rgb", rgb, strict=True)}
    return program(("subsurface", c, params))


def scattering_albedo(color):
    """Of isotropic scattering, the fit of Wrenninge, Villemin and Hery 2017."""
    blend = np.power(color, 0.25)
    low = 1.8260523782 * np.arctan(5.112467903378 * color) ** 1.09686102424
    high = 0.496310210422 * np.arctan(4.2350090365 * color) ** 2.40602999408
    return (1 - blend) * low + blend * high


def h_function(mu, albedo):
    """Chandrasekhar 1960, "Radiative Transfer", section 38: of isotropic scattering, by iteration of
    1/H = sqrt(1 - albedo) + albedo/2 int x H(x)/(mu + x) dx."""
    h = np.ones_like(MEAN_COSINES)

    def inverse(at):
        kernel = MEAN_COSINES / (np.reshape(at, (-1, 1)) + MEAN_COSINES)
        return np.sqrt(1 - albedo) + 0.5 * albedo * kernel @ (WEIGHTS * h)

    for _ in range(400):
        h = 0.5 * (h + 1 / inverse(MEAN_COSINES))
    return 1 / inverse(mu)


def slab(instructions, mu, analytic=False):
    """A slab as good as infinite, seen from an angle whose cosine is mu, in a white world."""
    b = Builder((8, 8))
    b.world = 1.0
    b.look((5 * np.sqrt(1 - mu * mu), 0, 5 * mu), (0, 0, 0), 0.5, orthographic=True, up=(0, 1, 0))
    b.add(box((0, 0, -400), (1000, 1000, 400)), instructions)
    return b.make()


@pytest.mark.parametrize("precision", ["strict", "reference"])
@pytest.mark.parametrize("mu", [1.0, 0.3])
def test_half_space_returns_what_theory_says(mu, precision):
    """The plane albedo 1 - H(mu) sqrt(1 - albedo) of isotropic scattering; for each channel another albedo and
    extinction, so that it tests how they are weighed against each other, too."""
    color = np.array((0.8, 0.5, 0.1))
    expected = [1 - h_function(mu, a).item() * np.sqrt(1 - a) for a in scattering_albedo(color)]
    film = render(slab(below(color, (1.0, 0.3, 2.0)), mu), 1024, precision=precision)
    assert_mean(film, np.array(expected), accuracy=0.01)


@pytest.mark.parametrize("anisotropy", [0.0, 0.6])
def test_half_space_has_the_users_colour(anisotropy):
    """Entered by Lambert's law, within what the fit errs; at an anisotropy of 0.9 that is a quarter."""
    color = np.array((0.8, 0.5, 0.2))
    film = render(slab(below(color, (1.0, 0.3, 2.0), anisotropy=anisotropy, diffuse=1.0), 1.0), 1024)
    mean, _ = mean_and_error(film)
    assert mean[:3] == pytest.approx(color, rel=0.03)


@pytest.mark.parametrize("precision", ["strict", "reference"])
@pytest.mark.parametrize("shape", ["sphere", "mesh", "instance", "mirrored"])
@pytest.mark.parametrize("others", [{}, dict(anisotropy=0.7, ior=1.5, roughness=0.5)], ids=["isotropic", "forward"])
def test_white_stays_white(shape, others, precision):
    """A white object in a white world does not show; with one extinction every path brings 1."""
    b = Builder((8, 8))
    b.world = 1.0
    b.look((0, 0, 3), (0, 0, 0), 0.2, up=(0, 1, 0))
    white = b.material(below(1.0, 0.1, **others))
    if shape == "sphere":
        b.sphere((0, 0, 0), 1, white)
    else:
        body = b.mesh(ball(rings=12))
        b.instance(body, white, matrix=place(scale=(-1, 1, 1) if shape == "mirrored" else (1, 1, 1)))
        if shape != "mesh":
            b.instance(body, white, matrix=place((50, 0, 0)))
    assert_mean(render(b.make(), 256, precision=precision), 1.0, accuracy=0.002, rounding=2e-4)


@pytest.mark.parametrize("radius", [(0.5, 0.1, 0.02), (0.003, 0.003, 0.003)], ids=["coloured", "dense"])
def test_white_stays_white_beyond_the_last_flight(radius):
    """Walks of hundreds of flights, which go straight out in the end, and channels of which each would go elsewhere."""
    b = Builder((8, 8))
    b.world = 1.0
    b.look((0, 0, 3), (0, 0, 0), 0.2, up=(0, 1, 0))
    b.add(ball(rings=12), below(1.0, radius))
    assert_mean(render(b.make(), 2048), 1.0, accuracy=0.005, rounding=3e-3)


def test_others_inside_do_not_matter():
    """Only the object that light has entered stops it: a black core changes nothing, a second skin neither."""
    means = []
    for core in (False, True):
        b = Builder((8, 8))
        b.world = 1.0
        b.look((0, 0, 3), (0, 0, 0), 0.2, up=(0, 1, 0))
        b.add(ball(rings=12), below((0.9, 0.7, 0.4), 0.5))
        if core:
            b.sphere((0, 0, 0), 0.9, b.material(program(("diffuse", 0.0))))
            b.add(ball(radius=0.7, rings=6), below(0.5))
        means.append(render(b.make(), 64))
    assert (means[0].sum(0) == means[1].sum(0)).all()


def test_open_surfaces_lose_light():
    """Below a sheet there is nothing that would send all light back."""
    b = Builder((8, 8))
    b.world = 1.0
    b.look((0, 0, 3), (0, 0, 0), 0.2, up=(0, 1, 0))
    b.add(quad((0, 0, 0), (1, 0, 0), (0, 1, 0)), below(0.9, 5.0))
    mean, _ = mean_and_error(render(b.make(), 256))
    assert 0.0 < mean[0] < 0.5
