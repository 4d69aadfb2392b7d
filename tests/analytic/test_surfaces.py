"""Light through glass, mirrors and transparent planes, and what clamping does: closed forms."""

import numpy as np
import pytest

from tests.scenes import (
    CAMERA,
    ELLIPSE,
    POINT,
    RECTANGLE,
    Builder,
    assert_exactly,
    assert_mean,
    box,
    diffuse,
    emission,
    look_at,
    pixels,
    place,
    program,
    quad,
    render,
)


def glass(ior, weight=1.0, **tint):
    return program(("glass", weight, dict(roughness=0.0, ior=ior, multiscatter=0, **tint)))


def fresnel(cosine, ior):
    """Reflectance of unpolarised light (Fresnel 1823), by the amplitudes of both polarisations."""
    inside = np.sqrt(1 - (1 - cosine ** 2) / ior ** 2)
    s = (cosine - ior * inside) / (cosine + ior * inside)
    p = (ior * cosine - inside) / (ior * cosine + inside)
    return (s * s + p * p) / 2


# ------------------------------------------------------------------ glass


def test_glass_of_index_one_is_invisible():
    """A sphere and a box of index 1 in front of a scene leave every pixel as it was, but for float32."""
    def scene(filled):
        b = Builder((12, 12))
        b.world = (0.2, 0.4, 0.8)
        b.look((0, -4, 1), (0, 0, 0.5), 0.5)
        b.add(box((0, 3, 0.5), 0.8), emission((3, 2, 1)))
        if filled:
            clear = b.material(glass(1.0))
            b.sphere((0.3, 0, 0.5), 0.7, clear)
            b.instance(b.mesh(box((-0.8, 0.3, 0.4), 0.3)), clear)
        return b.make()
    seen, through = (pixels(render(scene(filled), 64))[..., :3] for filled in (False, True))
    # Where a pixel holds an edge, some samples fall to the other side of it.
    assert np.mean(np.abs(seen - through) > 1e-5 * seen) < 0.1
    np.testing.assert_allclose(seen.mean((0, 1)), through.mean((0, 1)), rtol=1e-3)


@pytest.mark.parametrize("ior", [1.0001, 1.33, 1.5, 2.4])
@pytest.mark.parametrize("angle", [0.0, 0.7, 1.3])
def test_slab_reflects_and_transmits_by_fresnel(ior, angle):
    """A pane between a bright and a dark half space: with R at each side, 2R/(1+R) comes back in all orders."""
    b = Builder((4, 4))
    direction = np.array((np.sin(angle), 0, -np.cos(angle)))
    b.look(-20 * direction, (0, 0, 0), 1e-4, up=(0, 1, 0))
    b.add(box((0, 0, 0), (1e3, 1e3, 0.01)), glass(ior))
    b.add(quad((5, 0, -300), (0, 1e4, 0), (1e4, 0, 0)), emission(1.0))  # what lies behind glows, before it is dark
    reflected = fresnel(np.cos(angle), ior)
    film = render(b.make(), 1 << 14, max_bounces=254, transmission_bounces=254, glossy_bounces=254)
    assert_mean(film, 1 - 2 * reflected / (1 + reflected), 0.01, rounding=1e-5)


def test_glass_ball_in_a_uniform_world_vanishes():
    b = Builder()
    b.world = (1.0, 2.0, 3.0)
    b.look((0, 0, 3), (0, 0, 0), 0.5, up=(0, 1, 0))
    b.sphere((0, 0, 0), 1, b.material(glass(1.5)))
    b.sphere((0.2, 0.2, 0.1), 0.3, b.material(glass(0.7)))
    film = render(b.make(), 256, max_bounces=254, transmission_bounces=254, glossy_bounces=254)
    assert_exactly(film, (1, 2, 3), 1e-4)


def test_two_mirrors_darken_by_each_reflection():
    """A ray between two mirrors at 45 degrees leaves with the square of their colour."""
    colour = np.array((0.9, 0.5, 0.2))
    mirror = program(("glossy", colour, dict(roughness=0.0, multiscatter=0)))
    b = Builder((4, 4))
    b.look((0, 0, 4), (0, 0, 0), 1e-3, up=(0, 1, 0))
    b.world = 2.0
    b.add(quad((0, 0.1, 0), (1, 0, 1), (0, 1, 0)), mirror)
    b.add(quad((-3, 0.1, 0), (1, 0, 1), (0, 1, 0)), mirror)
    assert_mean(render(b.make(), 1 << 14), 2 * colour ** 2, 0.02)


# ------------------------------------------------------------------ transparency


@pytest.mark.parametrize("gap", [0.0, 1e-7, 1e-3])
@pytest.mark.parametrize("kind", ["meshes", "triangles of one mesh", "instances"])
def test_each_of_64_planes_counts_once(kind, gap):
    """Coincident, nearly coincident and separate planes: the transmittance is a^64 in all pixels."""
    kept = np.array((0.99, 0.97, 0.9))
    b = Builder((8, 8))
    b.world = 1.0
    b.look((0, 0, 1), (0.1, 0.2, 0), 0.3, up=(0, 1, 0))
    material = b.material(program(("transparent", kept)))
    offsets = [(8, 0, -gap * k) for k in range(64)]  # their diagonals pass elsewhere
    if kind == "triangles of one mesh":
        shapes = [quad(offset, (20, 0, 0), (0, 20, 0)) for offset in offsets]
        vertices = np.concatenate([s[0] for s in shapes])
        b.instance(b.mesh((vertices, np.concatenate([s[1] + 4 * k for k, s in enumerate(shapes)]))), material)
    else:
        shared = b.mesh(quad((0, 0, 0), (20, 0, 0), (0, 20, 0)))
        for offset in offsets:
            mesh = shared if kind == "instances" else b.mesh(quad((0, 0, 0), (20, 0, 0), (0, 20, 0)))
            b.instance(mesh, material, matrix=place(offset))
    assert_exactly(render(b.make(), 16, transparent_bounces=64), kept ** 64, 2e-5)


def shadowed(planes, kept=0.5, **settings):
    """A floor under a point lamp behind transparent planes, as a share of the light without them."""
    b = Builder((4, 4))
    b.look((0, -3, 1), (0, 0, 0), 1e-4)
    b.add(quad((3, 0, 0), (9, 0, 0), (0, 9, 0)), diffuse(1.0))
    veil, mesh = b.material(program(("transparent", kept))), b.mesh(quad((4, 0, 2), (9, 0, 0), (0, 9, 0)))
    for k in range(planes):
        b.instance(mesh, veil, matrix=place((0, 0, 0.01 * k)))
    b.lamp(POINT, 100.0, place((0, 0, 5)))
    light = pixels(render(b.make(), 16, max_bounces=0, **settings))[..., 0]
    np.testing.assert_allclose(light, light.mean(), rtol=1e-4)
    return light.mean() / (100 / (4 * np.pi) / 25 / np.pi)


@pytest.mark.parametrize("planes", [0, 1, 3, 20])
def test_transparent_shadows(planes):
    assert shadowed(planes) == pytest.approx(0.5 ** planes, rel=1e-4)


@pytest.mark.parametrize("limit", [0, 1, 4])
def test_transparent_shadows_count_as_in_cycles(limit):
    """Shadow rays pass as many surfaces as the limit says, those that the path itself has passed counted in."""
    assert shadowed(limit, transparent_bounces=limit) == pytest.approx(0.5 ** limit, rel=1e-4)
    assert shadowed(limit + 1, transparent_bounces=limit) == 0


def test_coloured_shadows_multiply():
    b = Builder((4, 4))
    b.look((0, -3, 1), (0, 0, 0), 1e-4)
    b.add(quad((3, 0, 0), (9, 0, 0), (0, 9, 0)), diffuse(1.0))
    for z, kept in ((1, (0.9, 0.5, 0.2)), (2, (0.3, 0.6, 0.9))):
        b.add(quad((4, 0, z), (9, 0, 0), (0, 9, 0)), program(("transparent", kept)))
    b.add(quad((-10, 0, 3), (1, 0, 0), (0, 1, 0)), diffuse(0.0))  # opaque, but aside
    b.lamp(POINT, 100.0, place((0, 0, 5)))
    expected = np.array((0.27, 0.3, 0.18)) * 100 / (4 * np.pi) / 25 / np.pi
    assert_exactly(render(b.make(), 16, max_bounces=0), expected, 1e-4)


def test_film_transparent_keeps_what_the_veil_leaves():
    """Behind a veil of transmittance t the film's alpha is 1 - t, and the world is left out of the colour."""
    b = Builder((4, 4))
    b.world = 5.0
    b.add(quad((20, 0, -1), (50, 0, 0), (0, 50, 0)), program(("transparent", 0.75), ("emission", 0.5)))
    seen = pixels(render(b.make(), 64, film_transparent=True))
    np.testing.assert_allclose(seen, np.broadcast_to((0.5, 0.5, 0.5, 0.25), seen.shape), rtol=1e-6)
    np.testing.assert_allclose(pixels(render(b.make(), 64))[..., 0], 0.5 + 0.75 * 5, rtol=1e-6)


def test_holdout_takes_its_share_of_alpha():
    """Behind a veil of transmittance t a holdout of weight w takes t w of the film's alpha, of an opaque one, too; it
    is black in itself."""
    b = Builder((4, 4))
    b.world = 5.0
    b.add(quad((20, 0, -1), (50, 0, 0), (0, 50, 0)), program(("transparent", 0.75), ("emission", 0.5)))
    b.add(quad((20, 0, -2), (50, 0, 0), (0, 50, 0)), program(("holdout", 0.4), ("emission", 0.6)))
    light = 0.5 + 0.75 * 0.6
    alpha = 1 - 0.75 * 0.4
    for film in (True, False):
        seen = pixels(render(b.make(), 64, film_transparent=film))
        np.testing.assert_allclose(seen, np.broadcast_to((light, light, light, alpha), seen.shape), rtol=1e-6)


# ------------------------------------------------------------------ clamping


def test_clamping_limits_each_sample():
    """The lamp's light is one constant: clamped to the limit exactly; indirect light has a limit of its own."""
    b = Builder((4, 4))
    b.look((0, -3, 1), (0, 0, 0), 1e-4)
    b.add(quad((3, 0, 0), (9, 0, 0), (0, 9, 0)), diffuse((1.0, 0.5, 0.0)))
    b.lamp(POINT, 1000.0, place((0, 0, 2)))
    light = 1000 / (4 * np.pi) / 4 / np.pi * np.array((1.0, 0.5, 0.0))
    assert_exactly(render(b.make(), 16, clamp_indirect=0.1), light, 1e-4)
    assert_exactly(render(b.make(), 16, clamp_direct=1e6), light, 1e-4)
    # Cycles' limit is a mean brightness: three times it is the sum that a sample keeps.
    assert_exactly(render(b.make(), 16, clamp_direct=1.0), light / light.sum() * 3, 1e-4)


def test_clamping_indirect_light_only_darkens_it():
    b = Builder((8, 8))
    b.look((0.1, 0.2, 0.3), (1, 0.5, 0.2), 1.0)
    vertices, triangles = box()
    b.add((vertices, triangles[:, ::-1]), program(("diffuse", 0.5), ("emission", 1.0)))
    free, clamped = (render(b.make(), 256, clamp_indirect=limit).sum(0).mean() / 128 for limit in (0, 0.05))
    direct = render(b.make(), 256, max_bounces=0).sum(0).mean() / 128
    assert free == pytest.approx(2, rel=0.02) and direct == pytest.approx(1.5, rel=0.02)
    assert direct - 0.02 < clamped < 1.7


# ------------------------------------------------------------------ visibility


@pytest.mark.parametrize("kind", [RECTANGLE, ELLIPSE])
def test_mirrors_see_lamps_that_the_camera_does_not(kind):
    b = Builder((4, 4))
    b.look((0, 0, 3), (0, 0, 0), 0.01, up=(0, 1, 0))
    b.lamp(kind, 1.0, look_at((0, 0, 1), (0, 0, 5), (0, 1, 0)), (1, 1), visibility=31 - CAMERA)
    assert not pixels(render(b.make(), 16))[..., :3].any()


@pytest.mark.parametrize("hidden", [2, 4, 8])
def test_objects_hide_from_one_kind_of_rays(hidden):
    """A surface of each kind in front of a glowing wall that hides from its rays: black, or bright."""
    kinds = {2: diffuse(1.0), 4: program(("glossy", 1.0, dict(roughness=0.0, multiscatter=0))),
             8: program(("refraction", 1.0, dict(roughness=0.0, ior=1.0)))}
    for kind, instructions in kinds.items():
        b = Builder((4, 4))
        b.look((0, 0, 1), (0, 0, 0), 0.01, up=(0, 1, 0))
        b.add(quad((2, 0, 0), (9, 0, 0), (0, 9, 0)), instructions)
        b.sphere((0, 0, 0), 50, b.material(emission(1.0)), visibility=31 - hidden)  # no light sampling for spheres
        seen = pixels(render(b.make(), 256))[..., 0]
        np.testing.assert_allclose(seen, 0.0 if kind == hidden else 1.0, rtol=1e-5)
