# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that compute numbers from numbers: Math, Clamp, Map Range."""

from __future__ import annotations

import math

from isophote.values import Number, add, call1, clamp, divide, maximum, minimum, multiply, select, square_root, subtract

from ..values import each


def floor(x: Number) -> Number:
    return call1("floor", x)


def fraction(x: Number) -> Number:
    return x - floor(x)


def less(a: Number, b: Number) -> Number:
    """1 where a < b, else 0."""
    return call1("less_than", a, b)


# Math's operations of (a, b, c); formulas as in Cycles (src/kernel/svm/math_util.h).
MATHS = {
    "ADD": lambda a, b, c: add(a, b),
    "SUBTRACT": lambda a, b, c: subtract(a, b),
    "MULTIPLY": lambda a, b, c: multiply(a, b),
    "DIVIDE": lambda a, b, c: divide(a, b),
    "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "POWER": lambda a, b, c: call1("power", a, b),
    "LOGARITHM": lambda a, b, c: call1("logarithm", a, b),
    "SQRT": lambda a, b, c: square_root(a),
    "INVERSE_SQRT": lambda a, b, c: divide(1.0, square_root(a)),
    "ABSOLUTE": lambda a, b, c: call1("absolute", a),
    "EXPONENT": lambda a, b, c: call1("exponent", a),
    "MINIMUM": lambda a, b, c: minimum(a, b),
    "MAXIMUM": lambda a, b, c: maximum(a, b),
    "LESS_THAN": lambda a, b, c: less(a, b),
    "GREATER_THAN": lambda a, b, c: less(b, a),
    "SIGN": lambda a, b, c: less(0.0, a) - less(a, 0.0),
    "COMPARE": lambda a, b, c: call1("compare", a, b, c),
    "SMOOTH_MIN": lambda a, b, c: call1("smooth_minimum", a, b, c),
    "SMOOTH_MAX": lambda a, b, c: -call1("smooth_minimum", -a, -b, c),
    "ROUND": lambda a, b, c: floor(a + 0.5),
    "FLOOR": lambda a, b, c: floor(a),
    "CEIL": lambda a, b, c: -floor(-a),
    "TRUNC": lambda a, b, c: call1("truncate", a),
    "FRACT": lambda a, b, c: fraction(a),
    "MODULO": lambda a, b, c: call1("modulo", a, b),
    "FLOORED_MODULO": lambda a, b, c: call1("wrap", a, b, 0.0),
    "WRAP": lambda a, b, c: call1("wrap", a, b, c),
    "SNAP": lambda a, b, c: floor(divide(a, b)) * b,
    "PINGPONG": lambda a, b, c: call1("pingpong", a, b),
    "SINE": lambda a, b, c: call1("sine", a),
    "COSINE": lambda a, b, c: call1("cosine", a),
    "TANGENT": lambda a, b, c: call1("tangent", a),
    "ARCSINE": lambda a, b, c: call1("arcsine", a),
    "ARCCOSINE": lambda a, b, c: call1("arccosine", a),
    "ARCTANGENT": lambda a, b, c: call1("arctangent", a, 1.0),
    "ARCTAN2": lambda a, b, c: call1("arctangent", a, b),
    "SINH": lambda a, b, c: call1("sinh", a),
    "COSH": lambda a, b, c: call1("cosh", a),
    "TANH": lambda a, b, c: call1("tanh", a),
    "RADIANS": lambda a, b, c: a * (math.pi / 180.0),
    "DEGREES": lambda a, b, c: a * (180.0 / math.pi),
}


def math_node(values, node, socket, stack):
    operation = MATHS.get(node.operation)
    if operation is None:
        return None
    result = operation(*(values.number(node, stack, s.identifier) for s in node.inputs))
    return clamp(result) if node.use_clamp else result


def clamp_node(values, node, socket, stack):
    x, low, high = (values.number(node, stack, name) for name in ("Value", "Min", "Max"))
    return clamp_between(x, low, high) if node.clamp_type == "RANGE" else call1("clamp", x, low, high)


def clamp_between(x: Number, one: Number, other: Number) -> Number:
    """x within two limits, whichever is the lower."""
    return call1("clamp", x, minimum(one, other), maximum(one, other))


# How far a value is between two limits -> how far its result is, given the number of steps.
INTERPOLATIONS = {
    "LINEAR": lambda t, steps: t,
    "STEPPED": lambda t, steps: select(less(0.0, steps), divide(floor(t * (steps + 1.0)), steps), 0.0),
    "SMOOTHSTEP": lambda t, steps: smooth(clamp(t)),
    "SMOOTHERSTEP": lambda t, steps: smoother(clamp(t)),
}


def smooth(t: Number) -> Number:
    return t * t * (3.0 - 2.0 * t)


def smoother(t: Number) -> Number:
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0)


def map_range(values, node, socket, stack):
    """Where the first range is empty, numbers become 0 and vectors To Min, as in Cycles."""
    interpolation = INTERPOLATIONS[node.interpolation_type]
    if node.data_type == "FLOAT":
        names = ("Value", "From Min", "From Max", "To Min", "To Max", "Steps")
        x, low, high, to_low, to_high, steps = (values.number(node, stack, name) for name in names)
        mapped = interpolation(divide(x - low, high - low), steps) * (to_high - to_low) + to_low
        mapped = select(high - low, mapped, 0.0)
        return clamp_between(mapped, to_low, to_high) if node.clamp else mapped
    names = ("Vector", "From_Min_FLOAT3", "From_Max_FLOAT3", "To_Min_FLOAT3", "To_Max_FLOAT3", "Steps_FLOAT3")
    x, low, high, to_low, to_high, steps = (values.vector(node, stack, name) for name in names)
    mapped = each(interpolation, each(divide, x - low, high - low), steps) * (to_high - to_low) + to_low
    return each(clamp_between, mapped, to_low, to_high) if node.clamp else mapped


NODES = {
    "ShaderNodeMath": math_node,
    "ShaderNodeClamp": clamp_node,
    "ShaderNodeMapRange": map_range,
}
