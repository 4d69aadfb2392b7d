"""Textures far from where they begin, and normals that lean far away from the surface's own."""

from fractions import Fraction

import numpy as np
import pytest

from isophote.materials import make_instruction
from isophote.records import numbers
from isophote.values import ARITHMETIC, Value, call1
from tests.conftest import missing
from tests.extremes.probe import run_cpp, run_opencl
from tests.extremes.table import Row, step
from tests.extremes.variants import film, rgb, spaces
from tests.scenes import SUN, Builder, ball, look_at, mean_and_error, program, quad
from tests.unit.test_textures import far_sum

N = numbers()
EXTENSIONS = {"repeat": 0, "mirror": N["IMAGE_SPECIAL"], "extend": N["IMAGE_ENDS"],
              "clip": N["IMAGE_ENDS"] | N["IMAGE_SPECIAL"]}
SIZES = (1, 3, 256, 1000, 8192)
TAPS = """
  for (uint k = 0u; k < 2u; k++) {
    Tap t = make_tap(in[0], int_of(in[1]), IMAGE_LINEAR, uint_of(in[2]), k);
    out[2u * k] = real_of(t.texel);
    out[2u * k + 1u] = t.weight;
  }
"""


def taps(values: np.ndarray) -> np.ndarray:
    """Texel and weight of both taps (n, 4), of rows of coordinate, texels, extension; the same bits on both devices."""
    made = run_cpp("values/values.h", TAPS, values, 4)
    try:
        other = run_opencl("values/values.h", TAPS, values, 4)
    except LookupError as error:
        missing(str(error))
    assert made.tobytes() == other.tobytes()
    return made.astype(float)


def brought_near(u: float, extension: str) -> Fraction:
    """Where a picture's width of 1 has the coordinate u, which is exact; None beyond its ends."""
    exact = Fraction(u)
    if extension in ("extend", "clip"):
        return exact
    folded = exact % (2 if extension == "mirror" else 1)
    return min(folded, 2 - folded) if extension == "mirror" else folded


@pytest.mark.parametrize("extension", EXTENSIONS)
def test_pictures_far_from_their_first_texel(extension):
    """A tap's texel and weight say where on the picture the coordinate lies: by exact fractions of the float."""
    rng = np.random.default_rng(2)
    far = (rng.uniform(-1, 1, step(200, 5000)) * 10.0 ** rng.uniform(0, 9, step(200, 5000))).astype(np.float32)
    sizes = ", ".join(map(str, SIZES))
    with Row("texture coordinates", f"up to 1e9, negative, {extension}; pictures of {sizes} texels",
             "place off the exact one, in pictures' widths", 2e-7) as row:
        for size in SIZES:
            made = taps(np.stack([far, np.full_like(far, size), np.full_like(far, EXTENSIONS[extension])], axis=-1))
            for u, (low, low_weight, high, high_weight) in zip(far.tolist(), made, strict=True):
                x = float(brought_near(u, extension) * size - Fraction(1, 2))
                if extension in ("extend", "clip") and not -1 < x < size:  # beyond its ends
                    end = 0 if x < 0 else size - 1
                    seen = low_weight + high_weight if extension == "clip" else abs(low - end) + abs(high - end)
                    row.see(seen, f"{u}, {size}")
                    continue
                if extension == "repeat":  # behind the last texel follows the first
                    row.see(((low + high_weight - x + size / 2) % size - size / 2) / size, f"{u}, {size}")
                    continue
                at = low * low_weight + high * high_weight
                clamped = min(max(x, 0.0), size - 1.0)
                wanted = x if extension == "clip" else clamped
                if extension == "clip" and not 0 <= x <= size - 1:  # only one of the two is there
                    at, wanted = low_weight + high_weight, 1 - abs(x - clamped)
                row.see((at - wanted) / size, f"{u}, {size}")


def test_coordinates_that_are_no_numbers():
    far = np.float32([np.nan, np.inf, -np.inf, 3e38, -3e38, 1e30, 1e-45])
    with Row("texture coordinates", "NaN, infinity, 3e38; all extensions",
             "weights not in 0 ... 1, texels not there") as row:
        for extension, size in ((e, s) for e in EXTENSIONS.values() for s in SIZES):
            made = taps(np.stack([far, np.full_like(far, size), np.full_like(far, extension)], axis=-1))
            weights, texels = made[:, 1::2], made[:, ::2]
            row.see(np.sum(~((weights >= 0) & (weights <= 1))) + np.sum(~((texels >= 0) & (texels < size))))


def glowing(values) -> Builder:
    """A square from -1 to 1 that fills the picture and shines with the values."""
    b = Builder((16, 16))
    b.look((0, 0, 3), (0, 0, 0), 1.0, orthographic=True, up=(0, 1, 0))
    b.add(quad((0, 0, 0), (1, 0, 0), (0, 1, 0)), program(("emission", values)))
    return b


def test_textures_far_away():
    """Noise, cells, checkers, bricks, magic: of coordinates that grow beyond all range, and of NaN."""
    x, y = (Value(call1("position").call, axis) for axis in (0, 1))
    infinite = (x + 2.0) * 3e38 * 3e38
    with Row("texture coordinates", "noise, cells, checker, brick, magic at 1 ... 2^112, infinity and NaN",
             "pixels that are no numbers, or not counted") as row:
        for u, v in ((x, y), (infinite, y), (infinite - infinite, x)):
            made = film(glowing([far_sum(u, v)] * 3).make(), 4, filter_width=0.001)
            row.see(np.sum(~np.isfinite(rgb(made))) + made.sum(N["PLANE_INVALID"]).sum(), "a texture")


# ------------------------------------------------------------------ normals


LEANS = 128  # pixels, from -89 to 89 degrees


def leaning(closures) -> Builder:
    """A square whose normals lean from -89 to 89 degrees towards x from its left end to its right."""
    x = Value(call1("position").call, 0)
    lean = x * np.radians(89.0)
    normal = ARITHMETIC.call("blended_normal", (call1("sine", lean), 0.0, call1("cosine", lean), 1.0))
    b = Builder((LEANS, 1))
    b.look((0, 0, 3), (0, 0, 0), 1.0, orthographic=True, up=(0, 1, 0))
    b.add(quad((0, 0, 0), (1.1, 0, 0), (0, 1.1, 0)),
          [make_instruction(name, (1.0, 1.0, 1.0), normal=normal, **constants) for name, constants in closures])
    return b


DIFFUSE = (("diffuse", {}),)
GLOSSY = (("glossy", dict(roughness=0.3, multiscatter=0)),)


def lit_from(builder: Builder, elevation: float) -> Builder:
    """Under a sharp sun of pi W/m^2 that stands so many degrees above the square's right end."""
    e = np.radians(elevation)
    builder.lamp(SUN, np.pi, look_at((np.cos(e), 0, np.sin(e)), (0, 0, 0)), (0, 0))
    return builder


def test_leaning_normals_make_no_light():
    with Row("shadow terminator", "normals that lean up to 89 degrees, diffuse and glossy, albedo 1, in a white world",
             "mean above 1, beyond 3 standard errors", 1e-5) as row:
        for name, closures in (("diffuse", DIFFUSE), ("glossy", GLOSSY)):
            builder = leaning(closures)
            builder.world = 1.0
            for space, scene in spaces(builder.make()).items():
                mean, error = mean_and_error(film(scene, step(64, 1024)))
                row.see(np.maximum(0, mean - 1 - 3 * error), f"{name}, {space}")


def test_leaning_normals_see_no_light_from_behind():
    with Row("shadow terminator", "normals that lean up to 89 degrees, a sun 1 ... 80 degrees behind the surface",
             "light") as row:
        for closures in (DIFFUSE, GLOSSY):
            for elevation in (-1.0, -10.0, -80.0):
                for space, scene in spaces(lit_from(leaning(closures), elevation).make()).items():
                    row.see(rgb(film(scene, 4)), f"{elevation} degrees, {space}")


def test_leaning_normals_have_no_bands():
    """A sun 2 ... 60 degrees high: from one normal to the next, 1.4 degrees away, light changes by little. Lambert's
    cosine by 0.025 at most, times the softened edge."""
    with Row("shadow terminator", "normals that lean up to 89 degrees, diffuse, a sun 2 ... 60 degrees high",
             "step of the radiance from 1.4 degrees to the next", 0.06) as row:
        for elevation in (2.0, 10.0, 30.0, 60.0):
            for space, scene in spaces(lit_from(leaning(DIFFUSE), elevation).make()).items():
                made = rgb(film(scene, 4, filter_width=0.001))[0, :, 0]
                assert made.max() > 0.1
                row.see(np.diff(made), f"{elevation} degrees, {space}")


def test_bands_of_few_facets_are_no_wider_than_their_angle():
    """A smooth ball of few facets, the sun at its side. Facets that look away from the sun are black, which is seen
    where their normals still look towards it: by no more than the angle between a facet and its corners."""
    with Row("shadow terminator", "smooth balls of 6 ... 24 rings, the sun at the side",
             "height of the sun over black pixels, less the facets' own angle; sines", 0.02) as row:
        for rings in (6, 12, 24):
            vertices, triangles = ball(rings=rings)
            corners = vertices[triangles]
            flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            flat /= np.linalg.norm(flat, axis=-1, keepdims=True)
            widest = np.sqrt(1 - np.einsum("tk,tck->tc", flat, corners).min() ** 2)  # the sine
            b = Builder((96, 96))
            b.look((0, -3, 0), (0, 0, 0), 1.0, orthographic=True)
            b.add((vertices, triangles), program(("diffuse", 1.0)), normals=vertices)
            b.lamp(SUN, np.pi, look_at((1, 0, 0), (0, 0, 0)), (0, 0))
            x, z = np.meshgrid(*2 * [(np.arange(96) + 0.5) / 48 - 1])
            inside = x * x + z * z < 0.8  # within the outline of the facets
            for space, scene in spaces(b.make()).items():
                made = rgb(film(scene, 4, filter_width=0.001))[..., 0]
                assert made.max() > 0.8
                black = inside & (made == 0)
                row.see(np.maximum(0, x[black].max() - widest), f"{rings} rings, {space}")
