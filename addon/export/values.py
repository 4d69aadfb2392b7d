# SPDX-License-Identifier: GPL-3.0-or-later
"""Inputs of nodes as numbers, or as expressions (isophote.values) where they differ from point to point.

Node types are dispatched by the table of value_nodes; a node that is not in it names itself in a note, and the socket's
own value stands in. Colours and vectors are arrays of three, of objects: each is a number or an expression.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isophote.values import ARITHMETIC, Number, Value, clamp, maximum, varies

from .lookups import Lookups
from .nodes import find_input, source_of

LUMINANCE = (0.2126729, 0.7151522, 0.0721750)  # of Rec. 709, as Cycles takes it from Blender's colour management


@dataclass(frozen=True)
class Sun:
    """A disc that shines: unit direction of its middle and half its angle, where the direction `seen`, an array of
    expressions, is what a sky is asked for."""

    direction: np.ndarray
    half: float
    seen: np.ndarray


class Values:
    """The inputs of one material's, light's or world's nodes; notes what it cannot express.

    Without `lookups` what differs from point to point is none of it: the socket's own value stands in.
    `surface_normal` is what nodes and closures without a normal of their own have, `lamp` the space of a lamp
    (lamp_space.LampSpace) whose nodes these are.
    """

    material_index = 0
    fills = False  # the nodes are those of a volume

    def __init__(self, kind: str, name: str, notes, lookups: Lookups | None = None):
        self.kind, self.name, self.notes, self.lookups = kind, name, notes, lookups
        self.surface_normal = source("shading_normal")
        self.suns: list[Sun] = []  # met on the way
        self.lamp = None
        self._made: dict[tuple, object] = {}

    def note(self, what: str) -> None:
        self.notes.add(self.kind, self.name, what)

    def number(self, node, stack, *names) -> Number:
        """A scalar input: colours count with their luminance, vectors with their mean, as in Cycles."""
        return as_number(*self.input(node, stack, names))

    def color(self, node, stack, *names) -> np.ndarray:
        """RGB of an input, objects [3]."""
        return as_triple(self.input(node, stack, names)[0])

    vector = color

    def is_linked(self, node, stack, *names) -> bool:
        """Whether another node feeds an input."""
        socket = find_input(node, *names)
        return socket is not None and source_of(socket, stack).node is not None

    def input(self, node, stack, names) -> tuple[object, str]:
        """(value, type of the socket that it comes from). Raises KeyError where the node has no such input."""
        socket = find_input(node, *names)
        if socket is None:
            raise KeyError(f"node {node.name} has no input {' or '.join(names)}")
        source = source_of(socket, stack)
        if source.node is None:
            return default_value(source.socket, socket), (source.socket or socket).type
        key = (source.node.as_pointer(), source.socket.identifier, *(group.as_pointer() for group in source.stack))
        if key not in self._made:
            self._made[key] = self.output(source)
        value = self._made[key]
        if value is None or (self.lookups is None and varies(value)):
            self.note(f"{source.node.name} ({source.node.bl_idname}) into {node.name}, {socket.name}: "
                      "not supported, the socket's own value is used")
            return default_value(None, socket), socket.type
        return value, source.socket.type

    def output(self, source):
        """What a node's output is; None where that is not supported."""
        from .value_nodes import NODES  # they ask for inputs in turn

        make = NODES.get(source.node.bl_idname)
        return make(self, source.node, source.socket, source.stack) if make else None


def outputs(name: str, *inputs: Number, **data) -> tuple[Number, ...]:
    """All outputs of an operation."""
    return ARITHMETIC.call(name, inputs, **data)


def source(name: str, *inputs: Number, **data) -> np.ndarray:
    """Three of them as a vector."""
    return triple(*outputs(name, *inputs, **data)[:3])


def default_value(socket, fallback):
    """The value that an unlinked socket holds; `fallback` is asked where `socket` has none."""
    for candidate in (socket, fallback):
        value = getattr(candidate, "default_value", None)
        if isinstance(value, (int, float)):
            return float(value)
        if value is not None and not isinstance(value, str):
            return triple(*value[:3])
    return 0.0


def triple(x: Number, y: Number, z: Number) -> np.ndarray:
    """A colour or a vector, objects [3]."""
    made = np.empty(3, object)
    made[:] = [each if isinstance(each, Value) else float(each) for each in (x, y, z)]
    return made


def call3(name: str, *inputs: Number, **data) -> np.ndarray:
    """The three outputs of an operation."""
    return triple(*ARITHMETIC.call(name, inputs, **data))


def grey(x: Number) -> np.ndarray:
    return triple(x, x, x)


def as_triple(value) -> np.ndarray:
    return value if isinstance(value, np.ndarray) else grey(value)


def as_number(value, kind: str) -> Number:
    """Blender's implicit conversion from a socket of a type."""
    if not isinstance(value, np.ndarray):
        return value
    if kind == "RGBA":
        return sum(part * weight for part, weight in zip(value, LUMINANCE, strict=True))
    return mean(value)


def mean(three) -> Number:
    return (three[0] + three[1] + three[2]) * (1.0 / 3.0)


def dot(a, b) -> Number:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def each(function, *triples):
    """A triple of a function of numbers, part by part."""
    return triple(*(function(*parts) for parts in zip(*map(as_triple, triples), strict=True)))


def not_negative(color) -> np.ndarray:
    return each(lambda x: maximum(x, 0.0), color)


def saturate(color) -> np.ndarray:
    return each(clamp, color)
