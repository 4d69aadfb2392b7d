# SPDX-License-Identifier: GPL-3.0-or-later
"""Procedural textures made of noise and of patterns; voronoi.py has those made of cells.

Each asks the kernels' operations for one number at a point of one to four coordinates; what nodes say beside (scale,
distortion, further channels of colours) is arithmetic around these. Limits of inputs are those of Cycles.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.values import ARITHMETIC, Number, Value, call1, clamp, maximum, minimum, mix, square_root, varies

from ... import compat
from ..nodes import find_input
from ..values import as_number, each, grey, triple
from .inputs import generated
from .vectors import texture_mapped

NOISE_KINDS = {"FBM": 0, "MULTIFRACTAL": 1, "HYBRID_MULTIFRACTAL": 2, "RIDGED_MULTIFRACTAL": 3, "HETERO_TERRAIN": 4}
NORMALIZED = 8
MOST_DETAIL = 15.0
GRADIENT_KINDS = ("LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "RADIAL", "QUADRATIC_SPHERE", "SPHERICAL")
WAVE_PROFILES = ("SIN", "SAW", "TRI")
BRICK_SHAPE = ("Mortar Size", "Mortar Smooth", "Bias", "Brick Width", "Row Height")


def coordinates(values, node, stack):
    """The vector that a texture is looked up at, generated coordinates where nothing is linked; None without those."""
    linked = values.is_linked(node, stack, "Vector")
    vector = values.vector(node, stack, "Vector") if linked else generated(values)
    return None if vector is None else texture_mapped(vector, node.texture_mapping)


def point_of(values, node, stack, dimensions: str) -> tuple | None:
    """The one to four scaled coordinates that a texture of "1D" to "4D" reads."""
    scale = values.number(node, stack, "Scale")
    if dimensions == "1D":
        return (values.number(node, stack, "W") * scale,)
    vector = coordinates(values, node, stack)
    if vector is None:
        return None
    scaled = tuple(each * scale for each in vector)
    return {"2D": scaled[:2], "3D": scaled}.get(dimensions) or (*scaled, values.number(node, stack, "W") * scale)


def number_or(default: float, values, node, stack, name: str) -> Number:
    """An input that nodes of older versions do not have."""
    return default if find_input(node, name) is None else values.number(node, stack, name)


# ------------------------------------------------------------------ noise


def octaves(detail: Number) -> int:
    """How often a step of noise has to run."""
    if isinstance(detail, Value):
        return int(MOST_DETAIL) + 1
    return math.ceil(detail) + 1 if detail >= 0.0 else 2


def limit_roughness(roughness: Number) -> Number:
    most = compat.most_noise_roughness()
    roughness = maximum(roughness, 0.0)
    return roughness if most == math.inf else minimum(roughness, most)


def noise_at(point, detail, roughness, lacunarity=2.0, offset=0.0, gain=1.0, mode=NORMALIZED) -> Number:
    return call1(f"noise_{len(point)}d", *point, detail, roughness, lacunarity, offset, gain, repeat=octaves(detail),
                 number=float(mode))


def moved(point, seed: int) -> tuple:
    """A point moved by 100 to 200 in each coordinate, as Cycles makes independent noises (svm/noisetex.h)."""
    if len(point) == 1:
        randoms = [call1("random_1d", float(seed))]
    else:
        randoms = [call1("random_2d", float(seed), float(k)) for k in range(len(point))]
    offsets = np.float32(100.0) + np.float32(randoms) * np.float32(100.0)
    return tuple(x + float(offset) for x, offset in zip(point, offsets, strict=True))


def distorted(point, strength: Number) -> tuple:
    """Each coordinate moved by a noise of its own."""
    if not varies(strength) and float(strength) == 0.0:
        return point
    return tuple(x + call1(f"perlin_{len(point)}d", *moved(point, k)) * strength for k, x in enumerate(point))


def noise(values, node, socket, stack):
    point = point_of(values, node, stack, node.noise_dimensions)
    if point is None:
        return None
    point = distorted(point, values.number(node, stack, "Distortion"))
    detail = clamp(values.number(node, stack, "Detail"), 0.0, MOST_DETAIL)
    kind, normalize = compat.noise_kind(node)
    defaults = {"Lacunarity": 2.0, "Offset": 0.0, "Gain": 1.0}
    shape = (limit_roughness(values.number(node, stack, "Roughness")),
             *(number_or(default, values, node, stack, name) for name, default in defaults.items()))
    mode = NOISE_KINDS[kind] + NORMALIZED * normalize
    value = noise_at(point, detail, *shape, mode=mode)
    if socket.type != "RGBA":
        return value
    first = 1 if len(point) == 1 else len(point)  # the seeds before are those of the distortion
    return triple(value, *(noise_at(moved(point, first + k), detail, *shape, mode=mode) for k in range(2)))


def musgrave(values, node, socket, stack):
    """Before 4.1: noise of which each octave is lacunarity^-dimension as strong as the one before, one octave less."""
    point = point_of(values, node, stack, node.musgrave_dimensions)
    if point is None:
        return None
    detail = clamp(values.number(node, stack, "Detail"), 0.0, MOST_DETAIL) - 1.0
    dimension = maximum(values.number(node, stack, "Dimension"), 1e-5)
    lacunarity = maximum(values.number(node, stack, "Lacunarity"), 1e-5)
    offset, gain = values.number(node, stack, "Offset"), values.number(node, stack, "Gain")
    return noise_at(point, detail, call1("positive_power", lacunarity, -dimension), lacunarity, offset, gain,
                    NOISE_KINDS[node.musgrave_type])


# ------------------------------------------------------------------ patterns


def white_noise(values, node, socket, stack):
    vector, w = values.vector(node, stack, "Vector"), values.number(node, stack, "W")
    point = {"1D": (w,), "2D": tuple(vector[:2]), "3D": tuple(vector), "4D": (*vector, w)}[node.noise_dimensions]
    return random_color(point) if socket.type == "RGBA" else random_at(point)


def random_at(point) -> Number:
    return call1(f"random_{len(point)}d", *point)


def random_color(point) -> np.ndarray:
    """Three random numbers of a point, as Cycles' hash_float_to_float3 and its like have them."""
    if len(point) < 4:
        return triple(random_at(point), random_at((*point, 1.0)), random_at((*point, 2.0)))
    x, y, z, w = point
    return triple(random_at(point), random_at((z, x, w, y)), random_at((w, z, y, x)))


def checker(values, node, socket, stack):
    point = point_of(values, node, stack, "3D")
    if point is None:
        return None
    first = call1("checker", *point)
    if socket.type != "RGBA":
        return first
    colors = (values.color(node, stack, name) for name in ("Color1", "Color2"))
    return each(lambda a, b: mix(b, a, first), *colors)


def gradient(values, node, socket, stack):
    vector = coordinates(values, node, stack)
    if vector is None:
        return None
    value = call1("gradient", *vector, number=float(GRADIENT_KINDS.index(node.gradient_type)))
    return grey(value) if socket.type == "RGBA" else value


def wave(values, node, socket, stack):
    point = point_of(values, node, stack, "3D")
    if point is None:
        return None
    point = tuple((x + 0.000001) * 0.999999 for x in point)  # off the edges of profiles, as Cycles has it
    strength, phase = values.number(node, stack, "Distortion"), values.number(node, stack, "Phase Offset")
    turns = bands(point, node.bands_direction) if node.wave_type == "BANDS" else rings(point, node.rings_direction)
    turns = turns + phase
    if varies(strength) or float(strength) != 0.0:
        detail = clamp(values.number(node, stack, "Detail"), 0.0, MOST_DETAIL)
        roughness, scale = values.number(node, stack, "Detail Roughness"), values.number(node, stack, "Detail Scale")
        own = noise_at([x * scale for x in point], detail, limit_roughness(roughness))
        turns = turns + strength * (own * 2.0 - 1.0)
    value = call1("wave_profile", turns, number=float(WAVE_PROFILES.index(node.wave_profile)))
    return grey(value) if socket.type == "RGBA" else value


def bands(point, direction: str) -> Number:
    if direction == "DIAGONAL":
        return (point[0] + point[1] + point[2]) * 10.0
    return point["XYZ".index(direction)] * 20.0


def rings(point, direction: str) -> Number:
    """The distance from an axis, or from the origin (SPHERICAL)."""
    across = [x for x, axis in zip(point, "XYZ", strict=True) if axis != direction]
    return square_root(sum(x * x for x in across)) * 20.0


def magic(values, node, socket, stack):
    vector = coordinates(values, node, stack)
    if vector is None:
        return None
    scale, strength = values.number(node, stack, "Scale"), values.number(node, stack, "Distortion")
    color = triple(*ARITHMETIC.call("magic", (*vector, scale, strength), repeat=node.turbulence_depth + 1))
    return color if socket.type == "RGBA" else as_number(color, "VECTOR")


def brick(values, node, socket, stack):
    point = point_of(values, node, stack, "2D")
    if point is None:
        return None
    shape = (values.number(node, stack, name) for name in BRICK_SHAPE)
    shifts = (0.0, 1.0, 1.0, 1.0)
    if node.offset_frequency and node.squash_frequency:
        shifts = (node.offset, node.offset_frequency, node.squash, node.squash_frequency)
    tint, share = ARITHMETIC.call("brick", (*point, *shape, *shifts))
    if socket.type != "RGBA":
        return share
    colors = (values.color(node, stack, name) for name in ("Color1", "Color2", "Mortar"))
    return each(lambda a, b, mortar: mix(mix(a, b, tint), mortar, share), *colors)


NODES = {
    "ShaderNodeTexNoise": noise,
    "ShaderNodeTexMusgrave": musgrave,
    "ShaderNodeTexWhiteNoise": white_noise,
    "ShaderNodeTexChecker": checker,
    "ShaderNodeTexGradient": gradient,
    "ShaderNodeTexWave": wave,
    "ShaderNodeTexMagic": magic,
    "ShaderNodeTexBrick": brick,
}
