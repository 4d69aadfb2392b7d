"""Noise, patterns and cells against float64 formulas written from their definitions, and far from the origin."""

import itertools
import math
import struct
from functools import reduce

import numpy as np
import pytest

from isophote.values import fold
from tests.scenes import Builder, pixels, program, quad, render
from tests.unit.test_values import position

POINTS = np.random.default_rng(5).uniform(-20.0, 20.0, (12, 4)).tolist()


def rotated(x: int, k: int) -> int:
    return (x << k | x >> 32 - k) & 0xFFFFFFFF


def jenkins(*words: int) -> int:
    """hashword of lookup3.c with 13 to start from."""
    a = b = c = (0xDEADBEEF + 4 * len(words) + 13) & 0xFFFFFFFF
    left = list(words)
    while len(left) > 3:
        a, b, c = ((x + y) & 0xFFFFFFFF for x, y in zip((a, b, c), left, strict=False))
        for turns in (4, 6, 8, 16, 19, 4):  # a, b and c take turns
            a = (a - c & 0xFFFFFFFF) ^ rotated(c, turns)
            c = c + b & 0xFFFFFFFF
            a, b, c = b, c, a
        del left[:3]
    a, b, c = ((x + y) & 0xFFFFFFFF for x, y in zip((a, b, c), [*left, 0, 0], strict=False))
    for turns in (14, 11, 25, 16, 4, 14, 24):  # c by b, a by c, b by a, c by b, ...
        c = (c ^ b) - rotated(b, turns) & 0xFFFFFFFF
        a, b, c = b, c, a
    return b  # it was c when it was made


def random_of(*numbers: float) -> float:
    return jenkins(*(struct.unpack("<I", struct.pack("<f", x))[0] for x in numbers)) / 2.0**32


def gradients(dimensions: int) -> list[tuple]:
    """By the last bits of a corner's hash; in three dimensions those of Perlin 2002."""
    signs = [1.0, -1.0]
    if dimensions == 1:
        return [(sign * size,) for sign in signs for size in range(1, 9)]
    if dimensions == 2:
        return [(a, 2 * b) for b in signs for a in signs] + [(2 * b, a) for b in signs for a in signs]
    if dimensions == 3:
        pairs = [(a, b) for b in signs for a in signs]
        edges = [(a, b, 0) for a, b in pairs] + [(a, 0, b) for a, b in pairs] + [(0, a, b) for a, b in pairs]
        return [*edges, (1, 1, 0), (0, -1, 1), (-1, 1, 0), (0, -1, -1)]
    threes = [(a, b, c) for c in signs for b in signs for a in signs]
    return [(*t[:zero], 0, *t[zero:]) for zero in (3, 2, 1, 0) for t in threes]


SCALES = (0.25, 0.6616, 0.982, 0.8344)


def perlin(*point: float) -> float:
    """Gradient noise: at each corner a slope, blended by Perlin's polynomial of degree five."""
    table, total = gradients(len(point)), 0.0
    for corner in itertools.product((0, 1), repeat=len(point)):
        cell = [math.floor(x) + c for x, c in zip(point, corner, strict=True)]
        way = [x - c for x, c in zip(point, cell, strict=True)]
        slope = table[jenkins(*(c & 0xFFFFFFFF for c in cell)) % len(table)]
        weight = math.prod(1 - abs(t)**3 * (10 - 15 * abs(t) + 6 * t * t) for t in way)
        total += weight * sum(g * t for g, t in zip(slope, way, strict=True))
    return SCALES[len(point) - 1] * total


def octave(point, k, lacunarity):
    return perlin(*(x * lacunarity**k for x in point))


def fbm(point, detail, roughness, lacunarity, offset, gain):
    whole = int(detail)
    parts = [octave(point, k, lacunarity) * roughness**k for k in range(whole + 2)]
    return sum(parts[:whole + 1]) + (detail - whole) * parts[whole + 1]


def normalized(point, detail, roughness, lacunarity, offset, gain):
    def scaled(whole):
        shape = (float(whole), roughness, lacunarity, offset, gain)
        return 0.5 + 0.5 * fbm(point, *shape) / sum(roughness**k for k in range(whole + 1))
    whole = int(detail)
    return (1 - detail + whole) * scaled(whole) + (detail - whole) * scaled(whole + 1)


def multifractal(point, detail, roughness, lacunarity, offset, gain):
    parts = [min(max(detail + 1 - k, 0), 1) for k in range(int(detail) + 2)]
    return math.prod(1 + part * roughness**k * octave(point, k, lacunarity) for k, part in enumerate(parts))


def hybrid(point, detail, roughness, lacunarity, offset, gain):
    value, weight = 0.0, 1.0
    for k in range(int(detail) + 2):
        if weight <= 0.001:
            break
        signal = (octave(point, k, lacunarity) + offset) * roughness**k
        value += min(max(detail + 1 - k, 0), 1) * min(weight, 1) * signal
        weight = min(weight, 1) * gain * signal
    return value


def ridged(point, detail, roughness, lacunarity, offset, gain):
    value, signal = 0.0, math.inf
    for k in range(int(detail) + 1):
        signal = (offset - abs(octave(point, k, lacunarity)))**2 * (min(max(signal * gain, 0), 1) if k else 1)
        value += signal * roughness**k
    return value


def terrain(point, detail, roughness, lacunarity, offset, gain):
    value = octave(point, 0, lacunarity) + offset
    for k in range(1, int(detail) + 2):
        part = min(max(detail + 1 - k, 0), 1)
        value += part * (octave(point, k, lacunarity) + offset) * roughness**k * value
    return value


KINDS = {0: fbm, 1: multifractal, 2: hybrid, 3: ridged, 4: terrain, 8: normalized}


def test_hash_of_numbers():
    for dimensions in range(1, 5):
        for point in POINTS:
            assert fold(f"random_{dimensions}d", tuple(point[:dimensions]))[0] == random_of(*point[:dimensions])


def test_gradient_noise():
    for dimensions in range(1, 5):
        for point in POINTS:
            made = fold(f"perlin_{dimensions}d", tuple(point[:dimensions]))[0]
            assert made == pytest.approx(perlin(*point[:dimensions]), abs=1e-12)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("detail", [0.0, 2.0, 3.4])
def test_octaves(kind, detail):
    """More repeats than there are octaves change nothing."""
    for dimensions in range(1, 5):
        for point in POINTS[:4]:
            shape = (detail, 0.6, 2.25, 0.4, 1.7)
            for repeat in (math.ceil(detail) + 1, 16):
                made = fold(f"noise_{dimensions}d", (*point[:dimensions], *shape), repeat, float(kind))[0]
                assert made == pytest.approx(KINDS[kind](point[:dimensions], *shape), abs=1e-11)


# ------------------------------------------------------------------ cells


LENGTHS = {0: lambda v: math.hypot(*v), 1: lambda v: sum(map(abs, v)), 2: lambda v: max(map(abs, v))}


def place_in(cell) -> list[float]:
    """Where the point of a cell is in it."""
    if len(cell) < 4:
        return [random_of(*cell), random_of(*cell, 1.0), random_of(*cell, 2.0)][:len(cell)]
    return [random_of(*cell[-k:], *cell[:-k]) for k in range(4)]


def cells_around(point, width=3):
    """(cell, place of its point) for the cells of a grid around a point, x first."""
    half = width // 2
    for turned in itertools.product(range(-half, half + 1), repeat=len(point)):
        cell = [float(math.floor(x) + step) for x, step in zip(point, reversed(turned), strict=True)]
        yield cell, [c + 0.8 * r for c, r in zip(cell, place_in(cell), strict=True)]


def away(a, b) -> list[float]:
    return [y - x for x, y in zip(a, b, strict=True)]


@pytest.mark.parametrize("dimensions", [1, 2, 3, 4])
@pytest.mark.parametrize("metric", LENGTHS)
def test_nearest_cells(dimensions, metric):
    for point in (p[:dimensions] for p in POINTS[:4]):
        found = sorted((LENGTHS[metric](away(point, place)), cell) for cell, place in cells_around(point))
        for name, (length, cell) in zip(("f1", "f2"), found, strict=False):
            out = fold(f"voronoi_{name}_{dimensions}d", (*point, 0.8), 3**dimensions, float(metric))
            assert list(out[1:dimensions + 1]) == cell
            measured = out[0] if metric else math.sqrt(out[0])
            assert measured == pytest.approx(length, abs=1e-12)


@pytest.mark.parametrize("dimensions", [2, 3, 4])
def test_minkowski(dimensions):
    for point in (p[:dimensions] for p in POINTS[:4]):
        found = sorted(sum(abs(t)**1.7 for t in away(point, place)) for _, place in cells_around(point))
        for name, measure in zip(("f1", "f2"), found, strict=False):
            out = fold(f"minkowski_{name}_{dimensions}d", (*point, 0.8, 1.7), 3**dimensions)
            assert out[0] == pytest.approx(measure, rel=1e-12)


@pytest.mark.parametrize("dimensions", [1, 2, 3, 4])
def test_edge_and_radius(dimensions):
    for point in (p[:dimensions] for p in POINTS[:4]):
        others = sorted((math.dist(point, place), place) for _, place in cells_around(point))
        nearest = others[0][1]
        edges = [sum(t * (a + b - 2 * p) / 2 for t, a, b, p in zip(away(nearest, o), nearest, o, point, strict=True))
                 / math.dist(nearest, o) for _, o in others[1:]]
        edge = fold(f"voronoi_edge_{dimensions}d", (*point, 0.8), 2 * 3**dimensions)[0]
        if dimensions == 1:  # of the cell that the point lies in, even where another's point is nearer
            middle = [(a + b) / 2 for a, b in itertools.pairwise(place[0] for _, place in cells_around(point))]
            assert edge == pytest.approx(min(abs(point[0] - m) for m in middle), abs=1e-12)
        else:
            assert edge == pytest.approx(min(edges), abs=1e-12)
        home = next(cell for cell, place in cells_around(point) if place == nearest)
        around = [c + 0.5 for c in home]  # a point in the nearest point's cell
        radius = min(math.dist(nearest, place) for cell, place in cells_around(around) if cell != home)
        out = fold(f"voronoi_radius_{dimensions}d", (*point, 0.8), 2 * 3**dimensions)[0]
        assert math.sqrt(out) == pytest.approx(radius, abs=1e-12)


@pytest.mark.parametrize("dimensions", [1, 2])
def test_smooth_cells(dimensions):
    """The blend that Cycles documents: each cell takes over by a smooth step of what it is nearer."""
    smoothness = 0.3
    for point in (p[:dimensions] for p in POINTS[:6]):
        def blend(before, cell, point=point):
            distance, place = math.dist(point, cell[1]), np.array(cell[1])
            t = min(max(0.5 + 0.5 * (before[0] - distance) / smoothness, 0.0), 1.0) if before else 1.0
            h = t * t * (3 - 2 * t)
            less = smoothness * h * (1 - h)
            first, second = before or (0.0, place)
            return (first + h * (distance - first) - less, second + h * (place - second) - less / (1 + 3 * smoothness))
        distance, place = reduce(blend, cells_around(point, 5), None)
        out = fold(f"voronoi_smooth_{dimensions}d", (*point, 0.8, smoothness), 5**dimensions)
        assert out[0] == pytest.approx(distance, abs=1e-12)
        np.testing.assert_allclose(out[4:4 + dimensions], place, atol=1e-12)


# ------------------------------------------------------------------ patterns


def test_checker_and_gradients():
    for x, y, z, _ in POINTS:
        assert fold("checker", (x, y, z))[0] == (math.floor(x) + math.floor(y) + math.floor(z)) % 2
        assert fold("gradient", (x, y, z), 1, 4.0)[0] == pytest.approx(math.atan2(y, x) / (2 * math.pi) + 0.5)
    assert fold("gradient", (0.3, 0.4, 0.0), 1, 6.0)[0] == pytest.approx(0.499999)


def test_waves():
    for x, *_ in POINTS:
        turns = x / (2 * math.pi)
        assert fold("wave_profile", (x,), 1, 0.0)[0] == pytest.approx(0.5 + 0.5 * math.sin(x - math.pi / 2))
        assert fold("wave_profile", (x,), 1, 1.0)[0] == pytest.approx(turns % 1.0)
        assert fold("wave_profile", (x,), 1, 2.0)[0] == pytest.approx(2 * abs(turns - round(turns)))


def test_bricks_are_where_rows_and_columns_say():
    """Bricks of 0.5 by 0.25 with mortar of 0.02; every other row is moved by half a brick."""
    def share(x, y):
        return fold("brick", (x, y, 0.02, 0.0, 0.0, 0.5, 0.25, 0.5, 2.0, 1.0, 2.0))[1]
    assert share(0.25, 0.375) == 0.0 and share(0.01, 0.375) == 1.0 and share(0.25, 0.26) == 1.0
    assert share(0.25, 0.125) == 1.0 and share(0.01, 0.125) == 0.0  # row 0 is one of the moved ones


FAR = (0.0, -0.0, 1e5, -1e6, 123456789.0, 3e9, -1e20, 3e38, math.inf, -math.inf, math.nan)


def test_numbers_stay_defined_far_away():
    """In float32, in a picture: every texture of coordinates out of all range."""
    x, y, _ = position()
    builder = Builder(size=(8, 8))
    builder.look((0, 0, 3), (0, 0, 0), tangent=1.0, orthographic=True, up=(0, 1, 0))
    builder.add(quad((0, 0, 0), (1, 0, 0), (0, 1, 0)), program(("emission", [far_sum(x, y)] * 3)))
    assert np.isfinite(pixels(render(builder.make(), 1))[..., :3]).all()


def far_sum(x, y):
    """A sum of textures, each bounded, of coordinates that grow by 2^16 from one to the next."""
    from isophote.values import ARITHMETIC, minimum

    total, size = 0.0, 1.0
    for number in range(8):
        p = (x * size, y * size, x * -size)
        size *= 2.0**16
        names = {"noise_3d": (*p, 2.0, 0.5, 2.0, 0.0, 1.0), "voronoi_f1_3d": (*p, 1.0), "checker": p,
                 "magic": (*p, 1.0, 1.0), "brick": (*p[:2], 0.1, 0.1, 0.0, 0.5, 0.25, 0.5, 2.0, 1.0, 2.0),
                 "random_3d": p, "pcg_3d": p}
        for name, inputs in names.items():
            total = total + minimum(ARITHMETIC.call(name, inputs, repeat=3, number=float(number % 5))[0], 1.0)
    return total


@pytest.mark.parametrize("name", ["noise_1d", "perlin_3d", "magic", "brick", "wave_profile", "checker", "pcg_3d"])
def test_folding_far_away_ends(name):
    from isophote.values import operations

    for far in FAR:
        fold(name, (far,) * operations()[name].inputs, 3)
