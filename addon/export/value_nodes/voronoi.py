# SPDX-License-Identifier: GPL-3.0-or-later
"""Voronoi Textures: octaves of what kernels/values/voronoi.h makes of the cells around a point."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from isophote.values import ARITHMETIC, Number, Value, call1, clamp, divide, minimum, mix, square_root

from ... import compat
from ..values import each, triple
from .textures import MOST_DETAIL, number_or, point_of, random_color

METRICS = {"EUCLIDEAN": 0, "MANHATTAN": 1, "CHEBYCHEV": 2, "MINKOWSKI": 0}  # of the kernels' steps, which those of
CELLS_ARE_WHOLE = 4  # Minkowski's metric do not ask


@dataclass
class Cells:
    """How the cells around a point are looked at; `number` is that of the kernels' steps, `exponent` Minkowski's."""

    feature: str
    number: float
    randomness: Number
    smoothness: Number
    exponent: Number | None

    def steps(self, feature: str, point, *inputs: Number, width: int = 3, rounds: int = 1) -> tuple[Number, ...]:
        """What steps have made that see all cells of a grid `width` wide."""
        dimensions, measure = len(point), ()
        name = f"voronoi_{feature}_{dimensions}d"
        if self.exponent is not None and dimensions > 1 and feature in ("f1", "f2", "smooth"):
            name, measure = f"minkowski_{feature}_{dimensions}d", (self.exponent,)
        return ARITHMETIC.call(name, (*point, self.randomness, *measure, *inputs), number=self.number,
                               repeat=rounds * width**dimensions)

    def length(self, measure: Number, dimensions: int) -> Number:
        """The length that a step has measured."""
        if dimensions > 1 and self.exponent is not None:
            return call1("positive_power", measure, divide(1.0, self.exponent))
        return measure if int(self.number) % CELLS_ARE_WHOLE else square_root(measure)

    def largest(self, dimensions: int) -> Number:
        """The largest length that there can be, as Cycles estimates it for Normalize."""
        half = 0.5 + 0.5 * self.randomness
        if dimensions > 1 and self.exponent is not None:
            longest = half * call1("positive_power", float(dimensions), divide(1.0, self.exponent))
        else:
            longest = half * {0: math.sqrt(dimensions), 1: dimensions, 2: 1}[int(self.number) % CELLS_ARE_WHOLE]
        return longest * 2.0 if self.feature == "F2" else longest

    def distance(self, point) -> Number:
        if self.feature == "SMOOTH_F1":
            return self.steps("smooth", point, self.smoothness, width=5)[0]
        return self.length(self.steps(self.feature.lower(), point)[0], len(point))

    def cell(self, point) -> tuple[Number, ...]:
        """The cell of the nearest or second nearest point."""
        return self.steps(self.feature.lower(), point)[1:len(point) + 1]

    def color(self, point) -> np.ndarray:
        if self.feature == "SMOOTH_F1":
            return triple(*self.steps("smooth", point, self.smoothness, width=5)[1:4])
        cell = self.cell(point)
        if not self.cells_are_whole(cell):
            return random_color(cell)
        return triple(*self.randoms(cell if len(cell) > 2 else (*cell, 0.0))[:3])

    def place(self, point) -> tuple[Number, ...]:
        """Where the nearest or second nearest point is."""
        if self.feature == "SMOOTH_F1":
            return self.steps("smooth", point, self.smoothness, width=5)[4:]
        cell = self.cell(point)
        return tuple(x + offset * self.randomness for x, offset in zip(cell, self.randoms(cell), strict=True))

    def cells_are_whole(self, cell) -> bool:
        return len(cell) > 1 and int(self.number) >= CELLS_ARE_WHOLE

    def randoms(self, cell) -> tuple[Number, ...]:
        """As many random numbers of a cell as it has coordinates (Cycles: hash_float3_to_float3 and its like)."""
        if self.cells_are_whole(cell):
            return ARITHMETIC.call(f"pcg_{len(cell)}d", cell)
        if len(cell) < 4:
            return tuple(random_color(cell)[:len(cell)])
        x, y, z, w = cell
        return tuple(call1("random_4d", *turned) for turned in ((x, y, z, w), (w, x, y, z), (z, w, x, y), (y, z, w, x)))

    def edge(self, point) -> Number:
        """The distance to the nearest cell's edge."""
        if len(point) == 1:
            return call1("voronoi_edge_1d", *point, self.randomness)
        return self.steps("edge", point, rounds=2)[0]

    def radius(self, point) -> Number:
        return square_root(self.steps("radius", point, rounds=2)[0]) * 0.5


@dataclass
class Octave:
    """One of those that a texture is a sum of; `part` of it counts."""

    point: tuple
    scale: Number
    amplitude: Number
    part: Number


def octaves(point, detail: Number, roughness: Number, lacunarity: Number):
    """The octaves up to `detail`: whole ones, and a fraction of the last."""
    count = int(MOST_DETAIL) + 1 if isinstance(detail, Value) else math.ceil(detail) + 1
    scale, amplitude = 1.0, 1.0
    for number in range(count):
        part = clamp(detail - (number - 1.0)) if number else 1.0
        yield Octave(tuple(x * scale for x in point), scale, amplitude, part)
        scale, amplitude = scale * lacunarity, amplitude * roughness


def summed(found, start, values):
    """The sum of what octaves have, by amplitude, and the sum of amplitudes."""
    total, amplitudes = start, 0.0
    for octave in found:
        total = each(lambda t, v: mix(t, t + v * octave.amplitude, octave.part), total, values(octave.point))  # noqa: B023
        amplitudes = mix(amplitudes, amplitudes + octave.amplitude, octave.part)
    return total, amplitudes


def blended(found, place) -> tuple[Number, ...]:
    """Places, of which each octave's replaces those before by its amplitude."""
    total = None
    for octave in found:
        own = tuple(divide(x, octave.scale) for x in place(octave.point))
        total = own if total is None else tuple(
            mix(t, mix(t, x, octave.amplitude), octave.part) for t, x in zip(total, own, strict=True))
    return total


def edges(found, cells: Cells) -> tuple[Number, Number]:
    """Distance to the nearest edge of all octaves, and how large that can be."""
    largest = 0.5 + 0.5 * cells.randomness
    distance, bound = 8.0, largest
    for octave in found:
        nearer = minimum(distance, divide(cells.edge(octave.point), octave.scale))
        distance = mix(distance, mix(distance, nearer, octave.amplitude), octave.part)
        bound = mix(bound, mix(bound, divide(largest, octave.scale), octave.amplitude), octave.part)
    return distance, bound


def read_cells(values, node, stack) -> Cells:
    feature, smoothness = node.feature, clamp(values.number(node, stack, "Smoothness") * 0.5, 0.0, 0.5)
    if feature == "SMOOTH_F1" and not isinstance(smoothness, Value) and smoothness == 0.0:
        feature = "F1"
    number = METRICS[node.distance] + CELLS_ARE_WHOLE * compat.voronoi_cells_are_whole()
    exponent = values.number(node, stack, "Exponent") if node.distance == "MINKOWSKI" else None
    return Cells(feature, float(number), clamp(values.number(node, stack, "Randomness")), smoothness, exponent)


def voronoi(values, node, socket, stack):
    point = point_of(values, node, stack, node.voronoi_dimensions)
    if point is None:
        return None
    cells = read_cells(values, node, stack)
    detail = clamp(number_or(0.0, values, node, stack, "Detail"), 0.0, MOST_DETAIL)
    roughness = clamp(number_or(0.0, values, node, stack, "Roughness"))
    lacunarity, normalize = number_or(1.0, values, node, stack, "Lacunarity"), getattr(node, "normalize", False)
    found = octaves(point, detail, roughness, lacunarity)
    if cells.feature == "N_SPHERE_RADIUS":
        return cells.radius(point) if socket.identifier == "Radius" else zero_of(socket)
    if cells.feature == "DISTANCE_TO_EDGE":
        if socket.identifier != "Distance":
            return zero_of(socket)
        distance, bound = edges(found, cells)
        return divide(distance, bound) if normalize else distance
    if socket.identifier == "Distance":
        (distance, *_), amplitudes = summed(found, triple(0.0, 0.0, 0.0), cells.distance)
        return divide(distance, amplitudes * cells.largest(len(point))) if normalize else distance
    if socket.identifier == "Color":
        color, amplitudes = summed(found, triple(0.0, 0.0, 0.0), cells.color)
        return each(lambda x: divide(x, amplitudes), color) if normalize else color
    if socket.identifier in ("Position", "W"):
        return place_of(socket, blended(found, cells.place), values.number(node, stack, "Scale"))
    return zero_of(socket)


def place_of(socket, place, scale: Number):
    """Position or W of a place in the texture's one to four coordinates."""
    place = tuple(divide(x, scale) for x in place)
    w = place[-1] if len(place) in (1, 4) else 0.0
    x, y, z = (*place, 0.0)[:3] if len(place) > 1 else (0.0, 0.0, 0.0)
    return w if socket.identifier == "W" else triple(x, y, z)


def zero_of(socket):
    """What an output holds that the chosen feature does not make."""
    return triple(0.0, 0.0, 0.0) if socket.type in ("RGBA", "VECTOR") else 0.0


NODES = {"ShaderNodeTexVoronoi": voronoi}
