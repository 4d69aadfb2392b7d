"""Lights: what sample_light draws against its density, and what hit_lamp says of the same directions."""

import ctypes
import zlib

import numpy as np
import pytest
from scipy import stats

from isophote import _native
from isophote.records import numbers, params_dtype, records, scene_buffers
from tests.kernel_lib import compiled
from tests.scenes import (
    ELLIPSE,
    POINT,
    RECTANGLE,
    SPOT,
    SUN,
    Builder,
    diffuse,
    emission,
    look_at,
    quad,
    ready,
)

N = numbers()
SAMPLES = 1 << 17
ROWS, COLUMNS, FINE = 12, 24, 40
SIGNIFICANCE = 1e-5

PROBE = """
#include "light.h"
extern "C" {
int probe_size() { return sizeof(Light); }
void probe_sample(const Light *l, const float *p, int n, const float *u, float *direction, float *radiance, float *pdf,
                  float *distance) {
  for (int i = 0; i < n; i++) {
    LightSample s = sample_light(*l, make_real3(p[0], p[1], p[2]), make_real2(u[2 * i], u[2 * i + 1]),
                                 l->kind == LIGHT_TRIANGLE ? 0u : FEATURE_LAMPS | FEATURE_LAMP_SHAPES);
    float d[3] = {s.direction.x, s.direction.y, s.direction.z}, r[3] = {s.radiance.x, s.radiance.y, s.radiance.z};
    for (int k = 0; k < 3; k++) direction[3 * i + k] = d[k], radiance[3 * i + k] = r[k];
    pdf[i] = s.pdf;
    distance[i] = s.distance;
  }
}
void probe_hit(const Light *l, const float *p, int n, const float *d, float t_max, float *radiance, float *pdf,
               int *hit) {
  for (int i = 0; i < n; i++) {
    Ray ray = free_ray(make_real3(p[0], p[1], p[2]), make_real3(d[3 * i], d[3 * i + 1], d[3 * i + 2]), 0.0f, FAR_AWAY);
    LightHit h = hit_lamp(*l, ray, t_max, t_max >= FAR_AWAY, 0u, FEATURE_LAMP_SHAPES);
    float r[3] = {h.radiance.x, h.radiance.y, h.radiance.z};
    for (int k = 0; k < 3; k++) radiance[3 * i + k] = r[k];
    pdf[i] = h.pdf;
    hit[i] = h.hit;
  }
}
}
"""


class Kernel:
    def __init__(self):
        self.library = compiled(PROBE)

    def call(self, name, *arguments):
        getattr(self.library, name)(*[a.ctypes.data_as(ctypes.c_void_p) if isinstance(a, np.ndarray) else a
                                      for a in arguments])

    def sample(self, light, p, u):
        """(directions, radiances, pdfs, distances)."""
        u, p = np.ascontiguousarray(u, np.float32), np.asarray(p, np.float32)
        d, r = np.empty((2, len(u), 3), np.float32)
        pdf, t = np.empty((2, len(u)), np.float32)
        self.call("probe_sample", light, p, len(u), u, d, r, pdf, t)
        return d, r, pdf, t

    def hit(self, light, p, d, t_max=3.0e38):
        """(radiances, pdfs, hits) of rays from p."""
        d, p = np.ascontiguousarray(d, np.float32), np.asarray(p, np.float32)
        r, pdf, hit = np.empty_like(d), np.empty(len(d), np.float32), np.empty(len(d), np.int32)
        self.call("probe_hit", light, p, len(d), d, ctypes.c_float(t_max), r, pdf, hit)
        return r, pdf, hit == 1


@pytest.fixture(scope="module")
def kernel():
    return Kernel()


def record(kind, size, matrix, spot=(1.2, 0.5), flags=0, spread=0.0):
    """A lamp's record as prepare makes it, picked with probability 1."""
    b = Builder()
    b.add(quad((0, 0, 0), (1, 0, 0), (0, 1, 0)), diffuse(0.5))
    b.lamp(kind, (1, 2, 3), matrix, size, spot, flags, spread=spread)
    return ready(b.make()).buffers["lights"]


DOWN = look_at((0.3, -0.2, 2.0), (0.1, 0.1, 0), (0.3, 1, 0))
LAMPS = {
    "point": (POINT, (0.7, 0), DOWN), "small point": (POINT, (0.01, 0), DOWN), "spot": (SPOT, (0.7, 0), DOWN),
    "disk": (POINT, (0.9, 0), DOWN, (1.2, 0.5), N["LIGHT_DISK"]),
    "spot disk": (SPOT, (0.5, 0), DOWN, (1.2, 0.5), N["LIGHT_DISK"]),
    "sun": (SUN, (0.8, 0), DOWN), "small sun": (SUN, (0.01, 0), DOWN),
    "rectangle": (RECTANGLE, (1.5, 0.5), DOWN), "ellipse": (ELLIPSE, (0.6, 1.4), DOWN),
    "stretched spot": (SPOT, (0.5, 0), DOWN * (1.6, 0.7, 1.0, 1.0)),
}
SPREADS = {
    "rectangle": (RECTANGLE, (1.5, 0.5), 0.5), "wide": (RECTANGLE, (1.5, 0.5), 3.0),
    "tiny": (RECTANGLE, (1.5, 0.5), 0.01),
    "ellipse": (ELLIPSE, (1.6, 1.4), 0.5), "disk in it": (ELLIPSE, (2.6, 2.4), 0.4),
    "slim": (ELLIPSE, (2.5, 0.4), 0.7), "whole": (ELLIPSE, (0.3, 0.2), 2.0),
}
PLACES = {"below": (0.0, 0.0, 0.0), "aside": (2.0, 1.0, 0.7)}


@pytest.fixture(params=[(lamp, where) for lamp in LAMPS for where in PLACES], ids=lambda p: f"{p[0]}, {p[1]}")
def case(request):
    lamp, where = request.param
    rng = np.random.default_rng(zlib.crc32(repr(request.param).encode()))
    return record(*LAMPS[lamp]), np.array(PLACES[where]), rng


def cone_around(directions):
    """(frame of 3 rows with the axis last, 1 - cos of a cone) that hold all directions, with a margin."""
    axis = directions.mean(0)
    axis /= np.linalg.norm(axis)
    frame = look_at(axis, (0, 0, 0))[:, :3].T
    off = directions - axis
    return frame, min(2.0, 1.1 * 0.5 * (off * off).sum(1).max() + 1e-9)


def directions_of(frame, h, phi):
    sine = np.sqrt(h * (2 - h))
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), 1 - h], axis=-1) @ frame


def cells_of(frame, size, directions):
    """Row and column of each direction in a grid over the cone, equal in solid angle."""
    off = directions - frame[2]
    h = 0.5 * (off * off).sum(1)
    phi = np.arctan2(directions @ frame[1], directions @ frame[0]) % (2 * np.pi)
    row = np.minimum((h / size * ROWS).astype(int), ROWS - 1)
    return row * COLUMNS + np.minimum((phi / (2 * np.pi) * COLUMNS).astype(int), COLUMNS - 1)


def test_records_have_the_compilers_sizes(kernel):
    """dtypes parsed from the headers against sizeof, for every array of the scene and the settings."""
    assert {name: dtype.itemsize for name, dtype in scene_buffers().items()} | {
        "params": params_dtype().itemsize} == dict(_native.sizes)
    assert kernel.library.probe_size() == records()["Light"].itemsize


def test_sampled_directions_are_hit_with_the_same_density(kernel, case):
    """MIS rests on it: both ways to a direction know the other's pdf, and see the same radiance."""
    light, p, rng = case
    d, radiance, pdf, distance = kernel.sample(light, p, rng.random((20000, 2), np.float32))
    np.testing.assert_allclose(np.linalg.norm(d, axis=1), 1, atol=1e-6)
    assert (pdf > 0).all()
    seen, other, hit = kernel.hit(light, p, d)
    assert hit.mean() > 0.995  # on the rim rounding decides
    np.testing.assert_allclose(other[hit], pdf[hit], rtol=3e-3)
    np.testing.assert_allclose(seen[hit], radiance[hit], rtol=2e-3, atol=1e-3 * radiance.max())
    if distance.max() < 1e30:  # a surface in front of all of it, and one behind it
        assert not kernel.hit(light, p, d, distance.min() * 0.99)[2].any()
        assert kernel.hit(light, p, d, distance.max() * 1.01)[2].mean() > 0.995


def test_density_integrates_to_one(kernel, case):
    light, p, rng = case
    frame, size = cone_around(kernel.sample(light, p, rng.random((20000, 2), np.float32))[0].astype(float))
    side = 1200
    grid = (np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2) + 0.5) / side
    _, pdf, hit = kernel.hit(light, p, directions_of(frame, size * grid[:, 0], 2 * np.pi * grid[:, 1]))
    assert (pdf * hit).astype(float).mean() * 2 * np.pi * size == pytest.approx(1, abs=4e-3)


def test_samples_follow_their_density(kernel, case):
    """Chi-squared over a grid of directions."""
    light, p, rng = case
    d = kernel.sample(light, p, rng.random((SAMPLES, 2), np.float32))[0].astype(float)
    frame, size = cone_around(d)
    observed = np.bincount(cells_of(frame, size, d), minlength=ROWS * COLUMNS)
    rows, columns = ((np.arange(n * FINE) + 0.5) / (n * FINE) for n in (ROWS, COLUMNS))
    h, phi = np.meshgrid(rows, columns, indexing="ij")
    _, pdf, hit = kernel.hit(light, p, directions_of(frame, size * h.ravel(), 2 * np.pi * phi.ravel()))
    density = (pdf * hit).astype(float).reshape(ROWS, FINE, COLUMNS, FINE).mean((1, 3)).ravel()
    inside = hit.reshape(ROWS, FINE, COLUMNS, FINE).all((1, 3)).ravel()  # the rim's cells are judged together
    expected = density * 2 * np.pi * size / (ROWS * COLUMNS) * SAMPLES
    assert inside.sum() > 20
    chi2 = ((observed - expected)[inside] ** 2 / expected[inside]).sum()
    assert stats.chi2.sf(chi2, inside.sum()) > SIGNIFICANCE, (chi2, inside.sum())
    rest = expected[~inside].sum()
    assert abs(observed[~inside].sum() - rest) < 5 * np.sqrt(rest) + 0.01 * SAMPLES


@pytest.mark.parametrize("lamp", SPREADS)
@pytest.mark.parametrize("place", [(0.0, 0.0, 0.0), (0.7, 0.2, 0.3)], ids=["below", "aside"])
def test_spreads_are_drawn_where_they_light(kernel, lamp, place):
    """What is drawn is hit with the same density and radiance; nothing is drawn in vain but in the corners around an
    ellipse; and the mean over what is drawn is the irradiance."""
    kind, size, spread = SPREADS[lamp]
    light, rng = record(kind, size, DOWN, spread=spread), np.random.default_rng(zlib.crc32(lamp.encode()))
    d, radiance, pdf, _ = kernel.sample(light, place, rng.random((SAMPLES, 2), np.float32))
    drawn = pdf > 0
    exact = spread_irradiance(light[0], np.array(place), half=spread / 2)
    if not drawn.any():
        assert exact == 0.0
        return
    assert drawn.mean() > (0.99 if kind == RECTANGLE else 0.5)
    seen, other, hit = kernel.hit(light, place, d[drawn])
    assert hit.mean() > 0.995
    np.testing.assert_allclose(other[hit], pdf[drawn][hit], rtol=3e-3)
    np.testing.assert_allclose(seen[hit], radiance[drawn][hit], rtol=2e-3, atol=2e-3 * radiance.max())
    facing = -light["normal"][0].astype(float)
    weighed = np.where(drawn, radiance[:, 0] * (d @ facing) / np.where(drawn, pdf, 1), 0.0)
    assert abs(weighed.mean() - exact) < 5 * weighed.std() / np.sqrt(SAMPLES) + 2e-4 * exact


def spread_irradiance(light, p, half, n=1500):
    """Of a surface at p that faces the lamp's plane, in float64: a sum over its points."""
    grid = (np.arange(n) + 0.5) / n * 2 - 1
    a, b = np.meshgrid(grid, grid)
    inside = (a * a + b * b <= 1) | (light["kind"] == RECTANGLE)
    u, v, normal, position = (light[name].astype(float) for name in ("u", "v", "normal", "position"))
    points = position + (a * light["size_u"])[..., None] * u + (b * light["size_v"])[..., None] * v - p
    d2 = (points ** 2).sum(axis=-1)
    cosine = np.maximum(-(points @ normal) / np.sqrt(d2), 1e-9)
    passed = np.maximum(np.tan(half) - np.sqrt(np.maximum(1 - cosine ** 2, 0)) / cosine, 0) / (np.tan(half) - half)
    cells = 4 * float(light["size_u"]) * float(light["size_v"]) / n ** 2
    return float(light["radiance"][0]) * (inside * passed * cosine ** 2 / d2).sum() * cells


def solid_angle(corners):
    """Of a triangle seen from the origin, by its angles (Girard), float64."""
    a, b, c = corners / np.linalg.norm(corners, axis=1)[:, None]
    normals = [np.cross(a, b), np.cross(b, c), np.cross(c, a)]
    angles = [np.pi - np.arccos(np.clip(x @ y / np.linalg.norm(x) / np.linalg.norm(y), -1, 1))
              for x, y in zip(normals, normals[1:] + normals[:1], strict=True)]
    return sum(angles) - np.pi


CORNERS = np.array(((0, 0, 1), (2, 0.5, 1.5), (0.3, 1.2, 2)))
INSIDE = CORNERS.mean(0)
NORMAL = np.cross(CORNERS[1] - CORNERS[0], CORNERS[2] - CORNERS[0]) / np.linalg.norm(
    np.cross(CORNERS[1] - CORNERS[0], CORNERS[2] - CORNERS[0]))
VIEWS = {"in front": np.array((0.5, 0.2, 0.1)), "behind": np.array((0.5, 0.2, 4.0)), "far": np.array((9.0, -7, 12)),
         "grazing": INSIDE + 1.5 * (CORNERS[0] - INSIDE) + 0.02 * NORMAL, "close": INSIDE + 0.03 * NORMAL,
         "as good as in it": INSIDE + 1e-4 * NORMAL, "very far": np.array((60.0, -30, 40))}


def triangle_light(corners=CORNERS):
    b = Builder()
    b.add((corners, np.array([[0, 1, 2]])), emission(1.0))
    return ready(b.make()).buffers["lights"]


@pytest.mark.parametrize("view", VIEWS)
def test_triangles_are_sampled_by_solid_angle(kernel, view):
    """All directions meet the triangle; their density is 1 / solid angle, and by area where that is tiny or huge."""
    light, p = triangle_light(), VIEWS[view]
    rng = np.random.default_rng(zlib.crc32(view.encode()))
    d, _, pdf, distance = (a.astype(float) for a in kernel.sample(light, p, rng.random((SAMPLES, 2), np.float32)))
    points = p + d * distance[:, None]
    weights = np.linalg.solve(np.stack([CORNERS[1] - CORNERS[0], CORNERS[2] - CORNERS[0], NORMAL], axis=1),
                              (points - CORNERS[0]).T)
    size = np.linalg.norm(CORNERS - p, axis=1).max()
    assert np.abs(weights[2]).max() < 1e-5 * size
    assert weights[:2].min() > -2e-5 * size and weights[:2].sum(0).max() < 1 + 2e-5 * size
    exact = solid_angle(CORNERS - p.astype(np.float32).astype(float))
    if 3e-4 < exact < 6.2:
        np.testing.assert_allclose(pdf, 1 / exact, rtol=2e-5)
    else:
        area = np.linalg.norm(np.cross(CORNERS[1] - CORNERS[0], CORNERS[2] - CORNERS[0])) / 2
        np.testing.assert_allclose(pdf, distance ** 2 / (np.abs(d @ NORMAL) * area), rtol=2e-3)
    # The medians cut the triangle into 6: each gets its part of the solid angle, or by area the same.
    three = np.stack([1 - weights[:2].sum(0), *weights[:2]])
    ranks = np.argsort(three, axis=0)
    parts, shares = [], []
    for first in range(3):
        for second in range(3):
            if first == second:
                continue
            parts.append(((ranks[2] == first) & (ranks[1] == second)).sum())
            piece = np.stack([CORNERS[first], (CORNERS[first] + CORNERS[second]) / 2, INSIDE])
            shares.append(solid_angle(piece - p) if 3e-4 < exact < 6.2 else 1.0)
    expected = np.array(shares) / sum(shares) * SAMPLES
    assert stats.chisquare(parts, expected).pvalue > SIGNIFICANCE


def test_small_and_slim_triangles_keep_their_digits(kernel):
    """Down to where sampling goes over to area: directions meet the triangle, solid angles are those of float64."""
    rng = np.random.default_rng(5)
    u = rng.random((2000, 2), np.float32)
    for size, slim in ((0.03, 1.0), (0.3, 0.01), (3.0, 0.001), (3.0, 0.1)):
        shape = np.array(((0, 0, 0), (1, 0, 0.2), (0.3, slim, 0)))
        corners = (np.array((0.1, 0.2, 1.0)) + size * shape).astype(np.float32)
        light = triangle_light(corners.astype(float))
        exact = solid_angle(corners.astype(float))
        d, _, pdf, distance = (a.astype(float) for a in kernel.sample(light, (0, 0, 0), u))
        if exact > 3.1e-4:
            np.testing.assert_allclose(pdf, 1 / exact, rtol=1e-4)
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        edges = np.stack([corners[1] - corners[0], corners[2] - corners[0], normal], axis=1).astype(float)
        weights = np.linalg.solve(edges, (d * distance[:, None] - corners[0]).T)
        assert weights[:2].min() > -1e-3 and weights[:2].sum(0).max() < 1 + 1e-3


def test_lamps_are_one_sided_and_nothing_from_inside(kernel):
    u = np.random.default_rng(4).random((1000, 2))
    behind = (0.3, -0.2, 5.0)
    for lamp in ("rectangle", "ellipse"):
        light = record(*LAMPS[lamp])
        d, _, pdf, _ = kernel.sample(light, behind, u)
        assert not pdf.any() and not kernel.hit(light, behind, d)[2].any()
    light = record(*LAMPS["point"])
    d, _, pdf, _ = kernel.sample(light, DOWN[:, 3] + 0.1, u)
    assert not pdf.any() and not kernel.hit(light, DOWN[:, 3] + 0.1, d)[2].any()
