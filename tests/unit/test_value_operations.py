"""Operations on values against independent formulas in float64, with extremes: the reference build, which folds
constants, closely, and float32 within bounds."""

import colorsys
import math

import numpy as np
import pytest

from isophote.values import call1, fold, operations
from tests.kernel_lib import ValueKernels

EXTREMES = (0.0, 1.0, -1.0, 0.5, -0.5, 2.0, 3.0, 1e-12, -1e-12, 1e6, -1e6)


@pytest.fixture(scope="module")
def kernels():
    return ValueKernels()


def samples(inputs: int, count: int = 3000) -> np.ndarray:
    """Inputs (count, inputs), float32 numbers in float64: some of all sizes, some extremes, some alike."""
    random = np.random.default_rng(inputs)
    x = random.normal(size=(count, inputs)) * 10.0 ** random.integers(-3, 3, (count, inputs))
    extreme = random.random((count, inputs)) < 0.2
    x[extreme] = random.choice(EXTREMES, extreme.sum())
    return x.astype(np.float32).astype(np.float64)


def colours(count: int = 3000) -> np.ndarray:
    """In [0, 1], some with equal parts, some black or white."""
    random = np.random.default_rng(7)
    x = random.random((count, 3))
    x[::5] = x[::5, :1]
    x[1::5, 1] = x[1::5, 2]
    x[2::5] = np.round(x[2::5])
    return x.astype(np.float32).astype(np.float64)


def power(x, y):
    if x < 0.0:
        return x ** y if y == math.floor(y) else 0.0
    return x ** y if x or y >= 0.0 else None


def logarithm(x, base):
    if x <= 0.0 or base <= 0.0:
        return 0.0
    return math.log(x) / math.log(base) if math.log(base) else 0.0


def wrap(x, high, low):
    return (x - low) - math.floor((x - low) / (high - low)) * (high - low) + low if high != low else low


def pingpong(x, scale):
    """The distance to the nearest multiple of twice the scale."""
    return abs(x - 2.0 * scale * math.floor(x / (2.0 * scale) + 0.5)) if scale else 0.0


def smooth_minimum(a, b, width):
    h = max(width - abs(a - b), 0.0) / width if width else 0.0
    return min(a, b) - h ** 3 * width / 6.0


def overlay(a, b, t):
    whole = 2.0 * a * b if a < 0.5 else 1.0 - 2.0 * (1.0 - a) * (1.0 - b)
    return (1.0 - t) * a + t * whole


def dodge(a, b, t):
    return 0.0 if a == 0.0 else 1.0 if 1.0 - t * b <= 0.0 else min(a / (1.0 - t * b), 1.0)


def burn(a, b, t):
    room = 1.0 - t + t * b
    return 0.0 if room <= 0.0 else min(max(1.0 - (1.0 - a) / room, 0.0), 1.0)


def turn(x, y, sine, cosine):
    turned = complex(x, y) * complex(cosine, sine)
    return turned.real, turned.imag


def rotate_about(*n):
    """By the matrix 1 + K sine + K K (1 - cosine) of the axis' cross product."""
    v, (x, y, z), sine, cosine = np.array(n[:3]), n[3:6], n[6], n[7]
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return v + k @ v * sine + k @ (k @ v) * (1.0 - cosine)


def refract(*n):
    """From the tangential part: it grows by the ratio."""
    incident, normal, ratio = np.array(n[:3]), np.array(n[3:6]), n[6]
    along = incident @ normal
    tangent = ratio * (incident - along * normal)
    square = 1.0 - ratio ** 2 * (1.0 - along ** 2)
    return (0.0, 0.0, 0.0) if square < 0.0 else tangent - math.sqrt(square) * normal


def normalize(*v):
    length = math.sqrt(sum(x * x for x in v))
    return [x / length for x in v] if length else v


def hsl(*color):
    hue, lightness, saturation = colorsys.rgb_to_hls(*color)
    return hue, saturation, lightness


def smaller(limit):
    """A filter of rows: those of numbers within a limit."""
    return lambda x: (np.abs(x) <= limit).all(axis=1)


# Name -> formula of its inputs; None: has no value there.
FORMULAS = {
    "add": lambda a, b: a + b, "subtract": lambda a, b: a - b, "multiply": lambda a, b: a * b,
    "divide": lambda a, b: a / b if b else 0.0, "minimum": min, "maximum": max,
    "square_root": lambda a: math.sqrt(a) if a > 0.0 else 0.0, "mix": lambda a, b, t: a + t * (b - a),
    "less_than": lambda a, b: float(a < b), "select": lambda c, a, b: a if c else b, "absolute": abs,
    "floor": math.floor, "truncate": math.trunc, "modulo": lambda a, b: math.fmod(a, b) if b else 0.0, "wrap": wrap,
    "pingpong": pingpong, "power": power, "logarithm": logarithm, "sine": math.sin, "cosine": math.cos,
    "tangent": math.tan, "arcsine": lambda a: math.asin(min(max(a, -1.0), 1.0)),
    "arccosine": lambda a: math.acos(min(max(a, -1.0), 1.0)), "arctangent": lambda a, b: math.atan2(a + 0.0, b + 0.0),
    "sinh": math.sinh, "cosh": math.cosh, "tanh": math.tanh, "exponent": math.exp,
    "compare": lambda a, b, c: float(abs(a - b) <= max(c, 2.0 ** -23)), "smooth_minimum": smooth_minimum,
    "clamp": lambda x, low, high: min(max(x, low), high),
    "dot": lambda *n: np.dot(n[:3], n[3:]), "cross": lambda *n: np.cross(n[:3], n[3:]),
    "length": lambda *v: math.hypot(*v), "normalize": normalize, "refract": refract, "turn": turn,
    "rotate_about": rotate_about, "overlay": overlay, "dodge": dodge, "burn": burn,
    "gamma": lambda x, y: 1.0 if y == 0.0 else x ** y if x > 0.0 else x,
    "rgb_to_hsv": colorsys.rgb_to_hsv, "hsv_to_rgb": colorsys.hsv_to_rgb, "rgb_to_hsl": hsl,
    "hsl_to_rgb": lambda h, s, v: colorsys.hls_to_rgb(h, v, s),
}
WITHIN = {"power": smaller(30.0), "gamma": smaller(30.0), "exponent": smaller(80.0), "sinh": smaller(80.0),
          "cosh": smaller(80.0), "smooth_minimum": smaller(1e3), "refract": smaller(30.0),
          "rotate_about": smaller(30.0), "wrap": lambda x: smaller(30.0)(x) & (np.abs(x[:, 1] - x[:, 2]) > 1e-2)}
UNIT = {"refract": slice(3, 6), "rotate_about": slice(3, 6)}  # inputs that are unit vectors
COLOURS = {"rgb_to_hsv", "hsv_to_rgb", "rgb_to_hsl", "hsl_to_rgb", "overlay", "dodge", "burn"}
# Where float32 may fall on the other side of a step: their float32 is compared with a rest of one part in 500.
STEPS = {"wrap", "pingpong", "compare", "overlay", "refract", "rgb_to_hsv", "hsv_to_rgb", "rgb_to_hsl"}


def inputs_of(name: str) -> np.ndarray:
    x = colours() if name in COLOURS else samples(operations()[name].inputs)
    if name in UNIT:
        v = x[:, UNIT[name]] + 1e-3
        x[:, UNIT[name]] = v / np.linalg.norm(v, axis=1, keepdims=True)
    return x[WITHIN[name](x)] if name in WITHIN else x


def expected(name: str, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(inputs that have a value that float32 holds, their outputs)."""
    found = [FORMULAS[name](*row) for row in inputs.tolist()]
    there = [k for k, each in enumerate(found) if each is not None and np.abs(each).max() < 1e30]
    return inputs[there], np.array([np.ravel(found[k]) for k in there])


def scale_of(name: str, inputs: np.ndarray, outputs: np.ndarray) -> np.ndarray:
    """What errors are relative to: outputs, but where large inputs cancel, these; colours are near 1."""
    if name in COLOURS:
        return np.ones_like(outputs)
    largest = np.minimum(np.abs(inputs).max(axis=1, keepdims=True), 1e3)
    return np.maximum.reduce([np.abs(outputs), largest + 0.0 * outputs, largest ** 2 + 0.0 * outputs])


def test_every_operation_has_a_formula():
    listed = {name for name, each in operations().items() if each.number // 32 in (1, 2, 3)}
    assert listed - set(FORMULAS) == {"vector", "blackbody", "dipole_length"}


@pytest.mark.parametrize("ior", [1.01, 1.4, 3.8])
def test_dipole_length_inverts_the_dipole(ior):
    """The reduced albedo that it stands for reflects the colour, to what twelve halvings tell apart."""
    for colour in (0.01, 0.2, 0.5, 0.8, 0.95):
        root = call1("dipole_length", colour, ior, repeat=12)  # sqrt(3 (1 - albedo))
        back = -1.44 / ior**2 + 0.71 / ior + 0.668 + 0.0636 * ior
        internal = 4 / 3 * (1 + back) / (1 - back)
        ends = []
        for near in (-1, 1):
            albedo = min(max(1 - root**2 / 3 + near * 2.0**-12, 0.0), 1.0)
            s = np.sqrt(3 * (1 - albedo))
            ends.append(0.5 * albedo * (1 + np.exp(-internal * s)) * np.exp(-s))
        assert ends[0] <= colour <= ends[1]
    assert call1("dipole_length", 0.0, ior, repeat=12) == np.sqrt(3)
    assert 0 < call1("dipole_length", 1.0, ior, repeat=12) < 0.002


@pytest.mark.parametrize("name", FORMULAS)
def test_reference_follows_the_formula(name):
    inputs, exact = expected(name, inputs_of(name))
    assert len(inputs) > 500
    found = np.array([fold(name, tuple(row)) for row in inputs.tolist()])
    off = np.abs(found - exact) / np.maximum(scale_of(name, inputs, exact), 1e-300)
    assert off.max() <= 1e-13, (inputs[off.max(axis=1).argmax()], found[off.max(axis=1).argmax()])


@pytest.mark.parametrize("name", FORMULAS)
def test_float32_is_near_the_formula(kernels, name):
    inputs, exact = expected(name, inputs_of(name))
    found = kernels.run(name, inputs).astype(np.float64)
    off = (np.abs(found - exact) / np.maximum(scale_of(name, inputs, exact), 1e-300)).max(axis=1)
    assert np.isfinite(found).all()
    assert (off > 2e-5).mean() <= (1 / 500 if name in STEPS else 0), (inputs[off.argmax()], found[off.argmax()])


def test_blackbodies_have_their_colours(kernels):
    """Known: white near 6500 K, red below, blue beyond; the fit's ends hold beyond them; luminance 1."""
    found = kernels.run("blackbody", np.float32([500, 800, 1000, 2000, 6500, 12000, 40000]))
    np.testing.assert_array_equal(found[[0, 6]], found[[1, 5]])
    np.testing.assert_allclose(found[4], 1.0, atol=0.06)
    assert (np.diff(found[1:6, 0]) < 0).all() and (np.diff(found[2:6, 2]) > 0).all() and (found >= 0).all()
    np.testing.assert_allclose(found[2:] @ [0.2126, 0.7152, 0.0722], 1.0, atol=0.02)


def smooth(values, angles, x, before, after):
    """Catmull-Rom between the angles on both sides of x, float64; `before` and `after` stand beyond the ends."""
    k = int(np.clip(np.searchsorted(angles, x) - 1, 0, len(angles) - 2))
    a, b, c, d = [before, *values, after][k:k + 4]
    t = (x - angles[k]) / (angles[k + 1] - angles[k])
    basis = np.array([[0, 2, 0, 0], [-1, 0, 1, 0], [2, -5, 4, -1], [-1, 3, -3, 1]]) / 2
    return np.array([1, t, t * t, t ** 3]) @ basis @ np.array([a, b, c, d])


@pytest.mark.parametrize("round_", [True, False])
def test_photometry(kernels, round_):
    rng = np.random.default_rng(7)
    across = np.float32(np.sort(rng.uniform(0.2, 6.0, 7)))
    if round_:
        across = np.float32([0, *across, 2 * np.pi])
    down = np.float32([0, 0.3, 0.7, 1.3, 2.2, np.pi] if round_ else [0.4, 0.9, 1.3, 2.5])
    watts = np.float32(rng.uniform(0.5, 3.0, (len(across), len(down))))
    watts[-1] = watts[0] if round_ else watts[-1]
    table = np.concatenate([[len(across), len(down)], across, down, watts.ravel()])
    places = np.float32(rng.uniform((0, 0), (2 * np.pi, np.pi), (2000, 2)))
    found = kernels.run("photometry", places, tables=table)[:, 0]
    expected = []
    for h, v in places.astype(float):
        rows = [smooth(row, down.astype(float), v, row[1] if round_ else 0, row[-2] if round_ else 0)
                for row in watts.astype(float)]
        value = smooth(rows, across.astype(float), h, rows[-2] if round_ else 0, rows[1] if round_ else 0)
        inside = across[0] <= h < across[-1] and down[0] <= v < down[-1]
        expected.append(max(value, 0) if inside else 0)
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-5)
    assert (np.array(expected) > 0).mean() > 0.3


def test_tables(kernels):
    entries = np.float32([0.0, 1.0, 4.0, 9.0])
    x = np.float32([-np.inf, -1.0, 0.0, 0.5, 0.9, 1.0, 2.0, np.nan])

    def run(name, x):
        return kernels.run(name, x, 4.0, entries)[:, 0]

    np.testing.assert_allclose(run("table", x), [0, 0, 0, 2.5, 7.5, 9, 9, 0], rtol=1e-6)
    np.testing.assert_allclose(run("table_stepped", x), [0, 0, 0, 1, 4, 9, 9, 0])
    np.testing.assert_allclose(run("table_extended", x[1:-1]), [-3, 0, 2.5, 7.5, 9, 24], rtol=1e-6)
