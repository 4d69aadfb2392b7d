# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that make values of values: arithmetic, mixing, ramps, taking apart and putting together."""

from __future__ import annotations

import numpy as np

from isophote.values import call1, clamp, maximum, minimum, mix, square_root, varies

from ..values import as_number, each, triple

BLENDS = {
    "MIX": lambda a, b: b,
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "MULTIPLY": lambda a, b: a * b,
    "SCREEN": lambda a, b: 1.0 - (1.0 - a) * (1.0 - b),
    "DARKEN": minimum,
    "LIGHTEN": maximum,
    "DIFFERENCE": lambda a, b: maximum(a - b, b - a),
}

MATHS = {
    "ADD": lambda a, b, c: a + b,
    "SUBTRACT": lambda a, b, c: a - b,
    "MULTIPLY": lambda a, b, c: a * b,
    "DIVIDE": lambda a, b, c: call1("divide", a, b),
    "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "SQRT": lambda a, b, c: square_root(a),
    "ABSOLUTE": lambda a, b, c: maximum(a, -a),
    "MINIMUM": lambda a, b, c: minimum(a, b),
    "MAXIMUM": lambda a, b, c: maximum(a, b),
}


def mix_rgb(values, node, socket, stack):
    return blend(values, node, stack, node.blend_type, node.use_clamp, "Fac", "Color1", "Color2")


def mix_node(values, node, socket, stack):
    names = {"RGBA": "Color", "FLOAT": "Float", "VECTOR": "Vector"}
    kind = names.get(node.data_type)
    if kind is None or node.factor_mode != "UNIFORM":
        return None
    mode = node.blend_type if kind == "Color" else "MIX"
    limited = node.clamp_result and kind == "Color"
    mixed = blend(values, node, stack, mode, limited, "Factor_Float", f"A_{kind}", f"B_{kind}", node.clamp_factor)
    return mixed[0] if kind == "Float" and mixed is not None else mixed


def blend(values, node, stack, mode, limited, factor, a, b, clamp_factor=True):
    if mode not in BLENDS:
        return None
    t = values.number(node, stack, factor)
    t = clamp(t) if clamp_factor else t
    a, b = values.color(node, stack, a), values.color(node, stack, b)
    mixed = each(lambda x, y: mix(x, BLENDS[mode](x, y), t), a, b)
    return each(clamp, mixed) if limited else mixed


def math(values, node, socket, stack):
    operation = MATHS.get(node.operation)
    if operation is None:
        return None
    numbers = [as_number(*values.input(node, stack, (s.identifier,))) for s in node.inputs]
    result = operation(*numbers, *[0.0] * (3 - len(numbers)))
    return clamp(result) if node.use_clamp else result


def invert(values, node, socket, stack):
    t, color = values.number(node, stack, "Fac"), values.color(node, stack, "Color")
    return each(lambda x: mix(x, 1.0 - x, t), color)


def gamma(values, node, socket, stack):
    color, exponent = values.color(node, stack, "Color"), values.number(node, stack, "Gamma")
    if varies(color, exponent):
        return None
    return each(lambda x: max(x, 0.0) ** exponent, color)


def ramp(values, node, socket, stack):
    factor = values.number(node, stack, "Fac")
    if varies(factor):
        return None
    color = node.color_ramp.evaluate(factor)
    return float(color[3]) if socket.name == "Alpha" else triple(*color[:3])


def combine(values, node, socket, stack):
    if getattr(node, "mode", "RGB") != "RGB":
        return None
    return triple(*(values.number(node, stack, s.identifier) for s in list(node.inputs)[:3]))


def separate(values, node, socket, stack) -> object:
    if getattr(node, "mode", "RGB") != "RGB":
        return None
    parts: np.ndarray = values.color(node, stack, node.inputs[0].identifier)
    return parts[list(node.outputs).index(socket)]


NODES = {
    "ShaderNodeMixRGB": mix_rgb,
    "ShaderNodeMix": mix_node,
    "ShaderNodeMath": math,
    "ShaderNodeInvert": invert,
    "ShaderNodeGamma": gamma,
    "ShaderNodeValToRGB": ramp,
    "ShaderNodeCombineColor": combine,
    "ShaderNodeCombineRGB": combine,
    "ShaderNodeCombineXYZ": combine,
    "ShaderNodeSeparateColor": separate,
    "ShaderNodeSeparateRGB": separate,
    "ShaderNodeSeparateXYZ": separate,
}
