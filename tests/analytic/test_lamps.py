"""The light of each lamp on a diffuse floor against closed forms and quadratures in float64, and lamps seen directly.

The camera looks at one point of the floor so closely that all pixels show the same: radiance is
albedo / pi times the irradiance there.
"""

import numpy as np
import pytest

from isophote.values import ARITHMETIC, call1, maximum
from tests.scenes import (
    CAMERA,
    DIFFUSE,
    ELLIPSE,
    GLOSSY,
    POINT,
    RECTANGLE,
    SPOT,
    SUN,
    Builder,
    assert_exactly,
    assert_mean,
    diffuse,
    emission,
    look_at,
    mean_and_error,
    pixels,
    program,
    quad,
    ready,
    render,
)

ALBEDO = np.array((0.8, 0.4, 0.1))
COLOUR = np.array((1.0, 2.0, 0.5))
NO_MIS = 2
UP = np.array((0.0, 0.0, 1.0))


def floor(*lamps, world=0.0, size=20.0, camera=(2.0, -6.0, 7.0)) -> Builder:
    """A floor seen around the origin; the camera itself sees no lamp."""
    b = Builder((8, 8))
    b.world = world
    b.look(camera, (0, 0, 0), 1e-7)
    b.add(quad((0.3 * size, 0, 0), (size, 0, 0), (0, size, 0)), diffuse(ALBEDO))  # its diagonal passes elsewhere
    for kind, strength, matrix, *rest in lamps:
        b.lamp(kind, strength, matrix, *rest, visibility=31 - CAMERA)
    return b


def axes_of(matrix):
    return matrix[:, 0], matrix[:, 1], matrix[:, 2], matrix[:, 3]


def gauss(n, low, high):
    x, w = np.polynomial.legendre.leggauss(n)
    return low + (high - low) * (x + 1) / 2, w * (high - low) / 2


def irradiance_of_points(points, areas, normal):
    """Integral of cos cos' / d^2 over a one-sided emitter, for the origin of a floor that looks up; per radiance."""
    d2 = (points ** 2).sum(-1)
    direction = points / np.sqrt(d2)[..., None]
    return float((np.maximum(direction @ UP, 0) * np.maximum(-(direction @ normal), 0) / d2 * areas).sum())


def rectangle_irradiance(matrix, width, height, n=160):
    """Per radiance. The lamp shines along its -z."""
    u, v, z, position = axes_of(matrix)
    (a, wa), (b, wb) = gauss(n, -width / 2, width / 2), gauss(n, -height / 2, height / 2)
    points = position + a[:, None, None] * u + b[None, :, None] * v
    return irradiance_of_points(points, wa[:, None] * wb, -z)


def ellipse_irradiance(matrix, width, height, n=160):
    u, v, z, position = axes_of(matrix)
    r, wr = gauss(n, 0, 1)
    phi = np.arange(2 * n) * np.pi / n
    a, b = r[:, None] * np.cos(phi) * width / 2, r[:, None] * np.sin(phi) * height / 2
    points = position + a[..., None] * u + b[..., None] * v
    return irradiance_of_points(points, (wr * r)[:, None] * np.full(2 * n, np.pi / n) * width * height / 4, -z)


def polygon_irradiance(corners):
    """Lambert 1760: half the sum of the edges' angles times their normals' cosines; the polygon is above the floor."""
    total = 0.0
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        normal = np.cross(a, b)
        angle = np.arctan2(np.linalg.norm(normal), a @ b)
        total += angle * normal @ UP / np.linalg.norm(normal)
    return abs(total) / 2


def falloff(cosine, cone, blend):
    """Blender's spot: a smooth step over the blended part of the cone."""
    edge = np.cos(cone / 2)
    x = np.clip((cosine - edge) / ((1 - edge) * max(blend, 1e-9)), 0, 1)
    return x * x * (3 - 2 * x)


ABOVE = look_at((0.4, -0.3, 2.0), (0.1, 0.2, 0.0))
SIDE = look_at((3.0, 1.0, 1.2), (0, 0, 0.2))


def test_sharp_point():
    at = np.array((1.0, 2.0, 3.0))
    d2 = at @ at
    film = render(floor((POINT, COLOUR * 50, look_at(at, (0, 0, 0)))).make(), 64, max_bounces=0)
    assert_exactly(film, ALBEDO / np.pi * COLOUR * 50 / (4 * np.pi) * at[2] / d2 ** 1.5, 2e-5)


@pytest.mark.parametrize("flags", [0, NO_MIS], ids=["mis", "no mis"])
@pytest.mark.parametrize("radius", [1e-4, 0.3, 2.9])
def test_sphere_lamp(radius, flags):
    """A diffuse sphere above the horizon gives pi L (r/d)^2 cos; from a speck to one that nearly touches the floor."""
    at = np.array((1.0, 0.5, 3.0))
    d2 = at @ at
    b = floor((POINT, COLOUR, look_at(at, (0, 0, 0)), (radius, 0), (1, 0), flags))
    radiance = COLOUR / (4 * np.pi ** 2 * radius ** 2)
    film = render(b.make(), 2048, max_bounces=0)
    assert_mean(film, ALBEDO / np.pi * np.pi * radiance * radius ** 2 / d2 * at[2] / np.sqrt(d2), 0.003, rounding=2e-5)


@pytest.mark.parametrize("cone,blend", [(0.9, 0.0), (0.9, 0.6), (1.2, 1.0), (0.3, 0.5)])
def test_sharp_spot(cone, blend):
    """Aimed beside the point that is seen; a narrow cone leaves it dark."""
    at, aim = np.array((0.5, 1.0, 3.0)), np.array((1.2, 0.5, 0.0))
    matrix = look_at(at, aim)
    d = np.linalg.norm(at)
    cosine = (at @ matrix[:, 2]) / d
    film = render(floor((SPOT, COLOUR * 50, matrix, (0, 0), (cone, blend))).make(), 64, max_bounces=0)
    expected = falloff(cosine, cone, blend) * 50 / (4 * np.pi) * at[2] / d ** 3
    assert (expected == 0) == (cone == 0.3)
    assert_exactly(film, ALBEDO / np.pi * COLOUR * expected, 1e-4)


def test_spot_with_a_radius():
    """The falloff goes by each direction from the lamp, over the cap that is seen."""
    at, radius, cone, blend = np.array((0.5, 1.0, 3.0)), 0.6, 0.8, 0.7
    matrix = look_at(at, (0.9, 0.6, 0))
    d2 = at @ at
    frame = look_at((0, 0, 0), -at)  # z points at the lamp
    h, weight = gauss(400, 0, 1 - np.sqrt(1 - radius ** 2 / d2))
    phi = np.arange(400) * 2 * np.pi / 400
    sine = np.sqrt(h * (2 - h))[:, None]
    directions = ((sine * np.cos(phi))[..., None] * frame[:, 0] + (sine * np.sin(phi))[..., None] * frame[:, 1]
                  + (1 - h)[:, None, None] * frame[:, 2])
    passed = falloff(directions @ matrix[:, 2], cone, blend) * (directions @ UP) * weight[:, None] * 2 * np.pi / 400
    film = render(floor((SPOT, COLOUR, matrix, (radius, 0), (cone, blend))).make(), 2048, max_bounces=0)
    assert_mean(film, ALBEDO / np.pi * COLOUR / (4 * np.pi ** 2 * radius ** 2) * passed.sum(), 0.003, rounding=2e-5)


@pytest.mark.parametrize("flags", [0, NO_MIS], ids=["mis", "no mis"])
@pytest.mark.parametrize("angle", [0.0, 1e-4, 0.0093, 1.0])
def test_sun(angle, flags):
    """A surface that faces the sun gets E, whatever its angle; a tilted one E cos (all of the disk is above)."""
    toward = np.array((0.5, -0.4, 1.0)) / np.linalg.norm((0.5, -0.4, 1.0))
    b = floor((SUN, COLOUR, look_at(toward, (0, 0, 0)), (angle, 0), (1, 0), flags))
    film = render(b.make(), 2048 if angle else 64, max_bounces=0)
    assert_mean(film, ALBEDO / np.pi * COLOUR * toward[2], 0.003, rounding=2e-5)


AREAS = {RECTANGLE: (rectangle_irradiance, 1.0), ELLIPSE: (ellipse_irradiance, np.pi / 4)}


@pytest.mark.parametrize("flags", [0, NO_MIS], ids=["mis", "no mis"])
@pytest.mark.parametrize("kind", AREAS, ids=["rectangle", "ellipse"])
@pytest.mark.parametrize("matrix,size", [(ABOVE, (1.5, 0.7)), (ABOVE, (1e-3, 2e-3)), (SIDE, (1.0, 0.5))],
                         ids=["above", "tiny", "aside"])
def test_area_lamp(kind, matrix, size, flags):
    irradiance, part = AREAS[kind]
    radiance = COLOUR / (np.pi * size[0] * size[1] * part)
    film = render(floor((kind, COLOUR, matrix, size, (1, 0), flags)).make(), 2048, max_bounces=0)
    assert_mean(film, ALBEDO / np.pi * radiance * irradiance(matrix, *size), 0.004, rounding=2e-5)


@pytest.mark.parametrize("kind", AREAS, ids=["rectangle", "ellipse"])
def test_area_lamp_as_wide_as_the_sky(kind):
    """Light sampling alone is hopeless here; with closures sampled too the floor gets pi L."""
    matrix, size = look_at((0, 0, 1.0), (0, 0, 0)), (2e3, 2e3)
    radiance = COLOUR / (np.pi * size[0] * size[1] * AREAS[kind][1])
    film = render(floor((kind, COLOUR, matrix, size)).make(), 4096, max_bounces=0)
    assert_mean(film, ALBEDO * radiance * (1 - 1e-6), 0.004)


def narrowed(irradiance_points, spread):
    """What half a spread lets through under a cosine, in float64."""
    half = spread / 2
    tangent = np.sqrt(np.maximum(1 - irradiance_points ** 2, 0)) / np.maximum(irradiance_points, 1e-9)
    return np.maximum(np.tan(half) - tangent, 0) / (np.tan(half) - half)


@pytest.mark.parametrize("flags", [0, NO_MIS], ids=["mis", "no mis"])
@pytest.mark.parametrize("kind", AREAS, ids=["rectangle", "ellipse"])
@pytest.mark.parametrize("spread", [0.3, 1.0, 2.5])
def test_area_lamp_with_a_spread(kind, spread, flags):
    matrix, size = look_at((0.1, -0.1, 2.0), (0.05, 0.1, 0.0)), (1.5, 0.7)
    u, v, z, position = axes_of(matrix)
    n = 1200
    grid = (np.arange(n) + 0.5) / n * 2 - 1
    a, b = np.meshgrid(grid, grid)
    inside = (a * a + b * b <= 1) | (kind == RECTANGLE)
    points = position + (a * size[0] / 2)[..., None] * u + (b * size[1] / 2)[..., None] * v
    cosines = points @ z / np.sqrt((points ** 2).sum(-1))
    areas = inside * narrowed(cosines, spread) * size[0] * size[1] / n ** 2
    radiance = COLOUR / (np.pi * size[0] * size[1] * AREAS[kind][1])
    b = floor()
    b.lamp(kind, COLOUR, matrix, size, (1, 0), flags, 31 - CAMERA, spread)
    film = render(b.make(), 2048, max_bounces=0)
    assert_mean(film, ALBEDO / np.pi * radiance * irradiance_of_points(points, areas, -z), 0.004, rounding=2e-4)


@pytest.mark.parametrize("spread", [1e-3, 0.02, 0.5, 2.0])
def test_a_spread_keeps_the_power(spread):
    """Below a lamp so wide that nothing lies beyond, irradiance is pi L whatever the spread (docs/units.md)."""
    matrix, size = look_at((0, 0, 1.0), (0, 0, 0)), (2e2, 2e2)
    b = floor()
    b.lamp(RECTANGLE, COLOUR, matrix, size, (1, 0), 0, 31 - CAMERA, spread)
    film = render(b.make(), 4096, max_bounces=0)
    assert_mean(film, ALBEDO * COLOUR / (np.pi * size[0] * size[1]), 0.004, rounding=1e-3)


@pytest.mark.parametrize("stretch", [(2.0, 1.0, 1.0), (0.5, 1.0, 2.0), (3.0, 3.0, 3.0)])
def test_stretched_spot(stretch):
    """The cone is round in the space that the axes' lengths span."""
    at, cone, blend = np.array((0.5, 1.0, 3.0)), 1.1, 0.7
    matrix = look_at(at, (1.2, 0.5, 0.0))
    local = (-at @ matrix[:, :3]) / stretch
    cosine, d = -local[2] / np.linalg.norm(local), np.linalg.norm(at)
    b = floor((SPOT, COLOUR * 50, matrix * (*stretch, 1.0), (0, 0), (cone, blend)))
    expected = falloff(cosine, cone, blend) * 50 / (4 * np.pi) * at[2] / d ** 3
    assert_exactly(render(b.make(), 64, max_bounces=0), ALBEDO / np.pi * COLOUR * expected, 1e-4)


@pytest.mark.parametrize("flags", [0, NO_MIS], ids=["mis", "no mis"])
@pytest.mark.parametrize("closure,kind", [("diffuse", DIFFUSE), ("glossy", GLOSSY)])
def test_hidden_from_the_rays_of_a_closure(closure, kind, flags):
    """Dark where a closure's rays do not see the lamp, and the same to the bit where others' do not."""
    films = []
    for hidden in (0, kind, (DIFFUSE | GLOSSY) - kind):
        b = floor()
        constants = {"glossy": dict(roughness=0.6, multiscatter=0)}.get(closure, {})
        b.materials[0] = program((closure, ALBEDO, constants))
        b.lamp(RECTANGLE, COLOUR, ABOVE, (1.5, 0.7), (1, 0), flags, 31 - CAMERA - hidden)
        films.append(pixels(render(b.make(), 64, max_bounces=2)))
    assert films[0][..., :3].any() and not films[1][..., :3].any()
    np.testing.assert_array_equal(films[0], films[2])


def test_hidden_from_one_of_two_closures():
    """What is left of a lamp hidden from glossy rays is what the diffuse closure reflects."""
    glossy = ("glossy", 0.5, dict(roughness=0.7, multiscatter=0))
    means = []
    for closures in ([("diffuse", ALBEDO)], [("diffuse", ALBEDO), glossy]):
        b = floor()
        b.materials[0] = program(*closures)
        b.lamp(POINT, COLOUR, ABOVE, (0, 0), (1, 0), 0, 31 - CAMERA - GLOSSY)
        means.append(pixels(render(b.make(), 64, max_bounces=0)))
    np.testing.assert_allclose(*means, rtol=1e-5)


@pytest.mark.parametrize("size", [0.0, 0.8])
def test_a_lamps_own_limit_of_bounces(size):
    """A limit of 0 leaves what one bounce less everywhere leaves of a scene with nothing else that shines."""
    films = []
    for own, most in ((0, 8), (None, 0), (1, 8), (None, 1)):
        b = floor()
        b.add(quad((0, 3, 0), (5, 0, 0), (0, 0, 5)), diffuse(0.7))
        flags = 0 if own is None else own + 1 << 8
        b.lamp(POINT, COLOUR, look_at((0.5, 0.5, 2.0), (0, 0, 0)), (size, 0), (1, 0), flags, 31 - CAMERA)
        films.append(render(b.make(), 1024, max_bounces=most))
    for limited, expected in ((films[0], films[1]), (films[2], films[3])):
        (a, error_a), (b, error_b) = mean_and_error(limited), mean_and_error(expected)
        assert (np.abs(a - b) <= 4 * np.hypot(error_a, error_b) + 1e-5 * b).all(), (a, b)


def test_area_lamps_shine_to_one_side():
    away = look_at((0, 0, 2), (0, 0, 5))
    film = render(floor((RECTANGLE, COLOUR, away, (1, 1)), (ELLIPSE, COLOUR, away, (1, 1))).make(), 256, max_bounces=0)
    assert not pixels(film)[..., :3].any()


@pytest.mark.parametrize("corners", [
    [(0, 0, 1), (1, 0.2, 1.5), (0.3, 1, 1)],
    [(-40, -40, 0.5), (60, -30, 0.6), (0, 70, 0.5)],
    [(0.5, 0, 0.01), (0.5, 1e-2, 0.02), (0.51, 0, 0.02)],
], ids=["small", "huge", "grazing"])
def test_emissive_triangle(corners):
    """Both sides of a triangle shine; Lambert's formula."""
    b = floor()
    b.add((np.array(corners), np.array([[0, 1, 2]])), emission(COLOUR), visibility=31 - CAMERA)
    film = render(b.make(), 8192, max_bounces=0)
    assert_mean(film, ALBEDO / np.pi * COLOUR * polygon_irradiance(np.array(corners, np.float32).astype(float)), 0.005,
                rounding=1e-4)


def test_emissive_sphere_and_mesh_instances():
    """An emissive analytic sphere is found by closures alone; its light is that of the lamp of the same radiance."""
    at, radius = np.array((0.3, 0.2, 1.5)), 1.0
    b = floor()
    b.sphere(at, radius, b.material(emission(COLOUR)), visibility=31 - CAMERA)
    expected = ALBEDO * COLOUR * radius ** 2 * at[2] / (at @ at) ** 1.5
    assert_mean(render(b.make(), 2048, max_bounces=0), expected, 0.005)


def test_many_lights_add_up():
    """Choosing one of many lights has no bias, however unequal they are."""
    near, far = np.array((1, 1, 0.05)), np.array((4, 4, 4.0))
    b = floor((POINT, COLOUR * 1e-3, look_at(near, (0, 0, 0))), (POINT, COLOUR * 80, look_at(far, (0, 0, 0))),
              (SUN, COLOUR * 0.1, look_at((0, 0, 1), (0, 0, 0))), (RECTANGLE, COLOUR * 5, ABOVE, (0.5, 0.5)))
    points = sum(watts / (4 * np.pi) * at[2] / (at @ at) ** 1.5 for at, watts in ((near, 1e-3), (far, 80)))
    area = 5 / (np.pi * 0.25) * rectangle_irradiance(ABOVE, 0.5, 0.5)
    expected = ALBEDO / np.pi * COLOUR * (points + 0.1 + area)
    assert_mean(render(b.make(), 1 << 14, max_bounces=0), expected, 0.005, rounding=2e-5)


def test_lamps_without_light_are_harmless():
    """Strength 0 everywhere: nothing to sample, and nothing is seen."""
    b = Builder((8, 8))
    b.look((0, 0, 5), (0, 0, 0), 0.5, up=(0, 1, 0))
    b.add(quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), diffuse(0.5))
    b.lamp(POINT, 0.0, look_at((0, 0, 2), (0, 0, 0)), (0.5, 0))
    b.lamp(RECTANGLE, 0.0, look_at((0, 0, 2), (0, 0, 5)), (1, 1))
    world = ready(b.make()).buffers["world"]
    assert not world["lamp_count"] and not world["light_count"]  # no records are left to look at
    assert not pixels(render(b.make(), 64))[..., :3].any()
    b.world = 1.0
    assert_mean(render(b.make(), 512), 0.5, 0.005)


# ------------------------------------------------------------------ programs

KINDS = {"point": (POINT, (0.4, 0)), "disk": (POINT, (0.4, 0), 4), "sharp": (POINT, (0, 0)), "spot": (SPOT, (0.3, 0)),
         "sun": (SUN, (0.4, 0)), "rectangle": (RECTANGLE, (1.5, 0.7)), "ellipse": (ELLIPSE, (1.5, 0.7))}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("own", [0, 1, NO_MIS], ids=["plain", "no shadow", "no mis"])
def test_a_program_that_gives_a_constant_changes_no_bit(kind, own):
    """Seen by the camera, by closures and drawn; 2 is a power of 2."""
    films = []
    for factor in (1.0, None):
        b = Builder((8, 8))
        b.look((2, -6, 3), (0, 0, 1), 0.5)
        b.add(quad((2, 0, 0), (9, 0, 0), (0, 9, 0)), diffuse(ALBEDO))
        two = call1("less_than", -1.0, call1("ray_length")) * 2.0
        material = b.material(emission((two, two, two))) if factor is None else None
        number, size, *flags = KINDS[kind]
        flags = (flags[0] if flags else 0) | own
        b.lamp(number, COLOUR * (factor or 0.5), ABOVE, size, (1.2, 0.5), flags, material=material)
        films.append(pixels(render(b.make(), 16, max_bounces=2)))
    assert films[0][..., :3].any()
    np.testing.assert_array_equal(*films)


@pytest.mark.parametrize("flags", [0, NO_MIS], ids=["mis", "no mis"])
@pytest.mark.parametrize("kind", AREAS, ids=["rectangle", "ellipse"])
def test_area_lamp_with_a_program(kind, flags):
    """Brighter towards one side, and as its distance grows."""
    matrix, size, n = look_at((0.4, -0.3, 1.5), (0.1, 0.2, 0.0)), (1.5, 0.7), 800
    u, v, z, position = axes_of(matrix)
    grid = (np.arange(n) + 0.5) / n * 2 - 1
    a, b = np.meshgrid(grid, grid)
    inside = (a * a + b * b <= 1) | (kind == RECTANGLE)
    points = position + (a * size[0] / 2)[..., None] * u + (b * size[1] / 2)[..., None] * v
    shines = np.maximum(points[..., 0], 0) ** 2 * np.linalg.norm(points, axis=-1)
    radiance = COLOUR / (np.pi * size[0] * size[1] * AREAS[kind][1])
    expected = irradiance_of_points(points, inside * shines * size[0] * size[1] / n ** 2, -z)
    scene = floor()
    x = maximum(ARITHMETIC.call("position")[0], 0.0)
    made = x * x * call1("ray_length")
    scene.lamp(kind, COLOUR, matrix, size, (1, 0), flags, 31 - CAMERA, material=scene.material(emission((made,) * 3)))
    film = render(scene.make(), 2048, max_bounces=0)
    assert_mean(film, ALBEDO / np.pi * radiance * expected, 0.005, rounding=2e-4)


def test_lamps_are_chosen_by_what_they_send():
    """Of two lamps the brighter one by its program is drawn more often."""
    lights = []
    for factor in (0.01, 100.0):
        b = floor((POINT, 1.0, ABOVE))
        made = call1("less_than", -1.0, call1("ray_length")) * factor
        b.lamp(POINT, 1.0, SIDE, material=b.material(emission((made,) * 3)))
        lights.append(ready(b.make()).buffers["light_tree"]["intensity"])
    np.testing.assert_allclose(lights[0][1] / lights[0][0], 0.01, rtol=1e-5)
    np.testing.assert_allclose(lights[1][1] / lights[1][0], 100.0, rtol=1e-5)


# ------------------------------------------------------------------ seen by the camera


@pytest.mark.parametrize("kind,size,radiance", [
    (POINT, (0.5, 0), 1 / (4 * np.pi ** 2 * 0.25)),
    (SPOT, (0.5, 0), 1 / (4 * np.pi ** 2 * 0.25)),
    (SUN, (0.5, 0), 1 / (np.pi * np.sin(0.25) ** 2)),
    (RECTANGLE, (1.0, 0.5), 1 / (np.pi * 0.5)),
    (ELLIPSE, (1.0, 0.5), 1 / (np.pi * np.pi * 0.125)),
], ids=["point", "spot", "sun", "rectangle", "ellipse"])
def test_lamp_seen_by_the_camera(kind, size, radiance):
    """Its radiance, exactly, whatever the distance; nothing where the camera is not to see it."""
    b = Builder((4, 4))
    b.look((0, 0, 0), (0, 0, 10), 0.01, up=(0, 1, 0))
    b.lamp(kind, COLOUR, look_at((0, 0, 7), (0, 0, 0), (0, 1, 0)), size, (1.0, 0.0))
    assert_exactly(render(b.make(), 16), COLOUR * radiance)
    b.lamps[0] = (*b.lamps[0][:-1], 31 - CAMERA)
    assert not pixels(render(b.make(), 16))[..., :3].any()


def test_lamps_in_a_mirror():
    """A mirror shows a lamp as bright as it is: no light sampling competes with a delta."""
    b = Builder((4, 4))
    b.look((0, 0, 3), (0, 0, 0), 0.01, up=(0, 1, 0))
    b.add(quad((0.5, 0, 0), (2, 0, 0), (0, 2, 0)), program(("glossy", 1.0, dict(roughness=0.0, multiscatter=0))))
    b.lamp(RECTANGLE, COLOUR, look_at((0, 0, 5), (0, 0, 0), (0, 1, 0)), (1, 1), visibility=31 - CAMERA)
    assert_exactly(render(b.make(), 64), COLOUR / np.pi)


def test_objects_cover_lamps():
    b = Builder((4, 4))
    b.look((0, 0, 0), (0, 0, 10), 0.01, up=(0, 1, 0))
    b.add(quad((0.5, 0, 6), (2, 0, 0), (0, 2, 0)), diffuse(0.0))
    b.lamp(ELLIPSE, COLOUR, look_at((0, 0, 7), (0, 0, 0), (0, 1, 0)), (1, 1))
    assert not pixels(render(b.make(), 16))[..., :3].any()
