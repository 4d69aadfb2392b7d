# SPDX-License-Identifier: GPL-3.0-or-later
"""Walking a node tree: through reroutes, muted nodes and groups, and folding what is constant.

A place in the tree is a socket and the stack of group nodes that were entered to reach it. Constant
nodes are folded by a table; a node that is not in it names itself in a note, and the socket's own
default value stands in.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Source:
    """What feeds an input: an output socket of a node, or (node None) the value of `socket` itself."""

    node: object
    socket: object
    stack: tuple


def source_of(socket, stack: tuple = ()) -> Source:
    """Follow an input's link to the node that makes its value; reroutes, groups and muting are seen through."""
    for _ in range(1000):  # a bound against cycles in broken files
        link = live_link(socket)
        if link is None:
            return Source(None, socket, stack)
        node, output = link.from_node, link.from_socket
        if node.mute:
            inner = next((i for i in node.internal_links if i.to_socket == output), None)
            if inner is None:
                return Source(None, None, stack)
            socket = inner.from_socket
        elif node.type == "REROUTE":
            socket = node.inputs[0]
        elif node.type == "GROUP" and node.node_tree:
            end = next((n for n in node.node_tree.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output), None)
            if end is None:
                return Source(None, None, stack)
            socket, stack = by_identifier(end.inputs, output.identifier), (*stack, node)
        elif node.type == "GROUP_INPUT" and stack:
            socket, stack = by_identifier(stack[-1].inputs, output.identifier), stack[:-1]
        else:
            return Source(node, output, stack)
        if socket is None:
            return Source(None, None, stack)
    return Source(None, None, stack)


def live_link(socket):
    """The link into an input, or None where there is none that counts."""
    if not socket.is_linked:
        return None
    return next((link for link in socket.links if link.is_valid and not link.is_muted), None)


def by_identifier(sockets, identifier):
    return next((s for s in sockets if s.identifier == identifier), None)


def find_input(node, *names):
    """The first of a node's inputs with one of these identifiers or names; None where it has none."""
    for name in names:
        for socket in node.inputs:
            if socket.identifier == name:
                return socket
    for name in names:
        for socket in node.inputs:
            if socket.name == name and socket.enabled:
                return socket
    return None


class Values:
    """Folds constant inputs of one material, light or world; notes what is not constant."""

    def __init__(self, kind: str, name: str, notes):
        self.kind, self.name, self.notes = kind, name, notes

    def note(self, what: str) -> None:
        self.notes.add(self.kind, self.name, what)

    def color(self, node, stack, *names) -> np.ndarray:
        """RGB of an input, f8 [3]."""
        return as_color(self.input(node, stack, names))

    def number(self, node, stack, *names) -> float:
        """A scalar input; colours count with their luminance."""
        return as_number(self.input(node, stack, names))

    def input(self, node, stack, names):
        """The constant at a node's input. Raises KeyError where it has no such input."""
        socket = find_input(node, *names)
        if socket is None:
            raise KeyError(f"node {node.name} has no input {' or '.join(names)}")
        source = source_of(socket, stack)
        if source.node is None:
            return default_value(source.socket, socket)
        fold = FOLDS.get(source.node.bl_idname)
        value = fold(self, source.node, source.socket, source.stack) if fold else None
        if value is None:
            self.note(f"{source.node.name} ({source.node.bl_idname}) into {node.name}, {socket.name}: "
                      "not supported, the socket's own value is used")
            return default_value(None, socket)
        return value


def default_value(socket, fallback):
    """The value that an unlinked socket holds; `fallback` is asked where `socket` has none."""
    for candidate in (socket, fallback):
        value = getattr(candidate, "default_value", None)
        if value is not None:
            return value if isinstance(value, (int, float)) else np.array(value[:], dtype=np.float64)
    return 0.0


def as_color(value) -> np.ndarray:
    return np.full(3, float(value)) if np.ndim(value) == 0 else np.asarray(value, dtype=np.float64)[:3]


def as_number(value) -> float:
    return float(value) if np.ndim(value) == 0 else float(np.dot(np.asarray(value)[:3], (0.2126, 0.7152, 0.0722)))


# --- constant nodes ------------------------------------------------------------------------------
# Each takes (values, node, output socket, stack) and returns the constant, or None where it cannot.

BLENDS = {
    "MIX": lambda a, b: b,
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "MULTIPLY": lambda a, b: a * b,
    "SCREEN": lambda a, b: 1.0 - (1.0 - a) * (1.0 - b),
    "DARKEN": np.minimum,
    "LIGHTEN": np.maximum,
    "DIFFERENCE": lambda a, b: np.abs(a - b),
}

MATHS = {
    "ADD": lambda a, b, c: a + b,
    "SUBTRACT": lambda a, b, c: a - b,
    "MULTIPLY": lambda a, b, c: a * b,
    "DIVIDE": lambda a, b, c: a / b if b else 0.0,
    "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "POWER": lambda a, b, c: a ** b if a >= 0.0 or b == int(b) else 0.0,
    "SQRT": lambda a, b, c: math.sqrt(a) if a > 0.0 else 0.0,
    "ABSOLUTE": lambda a, b, c: abs(a),
    "MINIMUM": lambda a, b, c: min(a, b),
    "MAXIMUM": lambda a, b, c: max(a, b),
    "LESS_THAN": lambda a, b, c: float(a < b),
    "GREATER_THAN": lambda a, b, c: float(a > b),
}


def fold_output(values, node, socket, stack):
    return default_value(socket, None)


def fold_mix_rgb(values, node, socket, stack):
    return blend(values, node, stack, node.blend_type, node.use_clamp, "Fac", "Color1", "Color2")


def fold_mix(values, node, socket, stack):
    names = {"RGBA": "Color", "FLOAT": "Float", "VECTOR": "Vector"}
    kind = names.get(node.data_type)
    if kind is None or node.factor_mode != "UNIFORM":
        return None
    mode = node.blend_type if kind == "Color" else "MIX"
    clamp = node.clamp_result and kind == "Color"
    mixed = blend(values, node, stack, mode, clamp, "Factor_Float", f"A_{kind}", f"B_{kind}", node.clamp_factor)
    return float(mixed[0]) if kind == "Float" and mixed is not None else mixed


def blend(values, node, stack, mode, clamp, factor, a, b, clamp_factor=True):
    if mode not in BLENDS:
        return None
    t = values.number(node, stack, factor)
    t = min(max(t, 0.0), 1.0) if clamp_factor else t
    a, b = values.color(node, stack, a), values.color(node, stack, b)
    mixed = a * (1.0 - t) + BLENDS[mode](a, b) * t
    return np.clip(mixed, 0.0, 1.0) if clamp else mixed


def fold_math(values, node, socket, stack):
    operation = MATHS.get(node.operation)
    if operation is None:
        return None
    numbers = [as_number(values.input(node, stack, (s.identifier,))) for s in node.inputs]
    result = operation(*numbers, *[0.0] * (3 - len(numbers)))
    return min(max(result, 0.0), 1.0) if node.use_clamp else result


def fold_invert(values, node, socket, stack):
    t, color = values.number(node, stack, "Fac"), values.color(node, stack, "Color")
    return color * (1.0 - t) + (1.0 - color) * t


def fold_gamma(values, node, socket, stack):
    return np.maximum(values.color(node, stack, "Color"), 0.0) ** values.number(node, stack, "Gamma")


def fold_ramp(values, node, socket, stack):
    color = node.color_ramp.evaluate(values.number(node, stack, "Fac"))
    return float(color[3]) if socket.name == "Alpha" else np.array(color[:3], dtype=np.float64)


def fold_combine(values, node, socket, stack):
    if getattr(node, "mode", "RGB") != "RGB":
        return None
    return np.array([as_number(values.input(node, stack, (s.identifier,))) for s in list(node.inputs)[:3]])


def fold_separate(values, node, socket, stack):
    if getattr(node, "mode", "RGB") != "RGB":
        return None
    return float(as_color(values.input(node, stack, (node.inputs[0].identifier,)))[list(node.outputs).index(socket)])


FOLDS = {
    "ShaderNodeRGB": fold_output,
    "ShaderNodeValue": fold_output,
    "ShaderNodeMixRGB": fold_mix_rgb,
    "ShaderNodeMix": fold_mix,
    "ShaderNodeMath": fold_math,
    "ShaderNodeInvert": fold_invert,
    "ShaderNodeGamma": fold_gamma,
    "ShaderNodeValToRGB": fold_ramp,
    "ShaderNodeCombineColor": fold_combine,
    "ShaderNodeCombineRGB": fold_combine,
    "ShaderNodeCombineXYZ": fold_combine,
    "ShaderNodeSeparateColor": fold_separate,
    "ShaderNodeSeparateRGB": fold_separate,
    "ShaderNodeSeparateXYZ": fold_separate,
}
