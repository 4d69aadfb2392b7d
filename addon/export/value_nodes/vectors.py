# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that compute vectors: Vector Math, Mapping, Vector Rotate and Transform, Normal, Combine and Separate XYZ."""

from __future__ import annotations

import numpy as np

from isophote.values import ARITHMETIC, Number, call1, divide, is_number, select

from ..values import call3, each, triple
from .arithmetic import MATHS, less

# Operations of Vector Math that treat each part as Math does.
PARTWISE = {name: MATHS[name] for name in (
    "ADD", "SUBTRACT", "MULTIPLY", "DIVIDE", "MULTIPLY_ADD", "ABSOLUTE", "POWER", "SIGN", "MINIMUM", "MAXIMUM", "FLOOR",
    "CEIL", "MODULO", "WRAP", "SNAP", "SINE", "COSINE", "TANGENT")} | {"FRACTION": MATHS["FRACT"]}


def dot(a, b) -> Number:
    return call1("dot", *a, *b)


def length(v) -> Number:
    return call1("length", *v)


def normalize(v) -> np.ndarray:
    """0 stays 0."""
    return call3("normalize", *v)


def project(a, b, c, scale):
    return b * divide(dot(a, b), dot(b, b))


def reflect(a, b, c, scale):
    normal = normalize(b)
    return a - normal * (2.0 * dot(a, normal))


def face_forward(a, b, c, scale):
    forward = less(dot(c, b), 0.0)
    return each(lambda x: select(forward, x, -x), a)


# Those of whole vectors (a, b, c) and the number Scale, which make vectors, or numbers.
WHOLE = {
    "CROSS_PRODUCT": lambda a, b, c, scale: call3("cross", *a, *b),
    "PROJECT": project,
    "REFLECT": reflect,
    "REFRACT": lambda a, b, c, scale: call3("refract", *a, *normalize(b), scale),
    "FACEFORWARD": face_forward,
    "SCALE": lambda a, b, c, scale: a * scale,
    "NORMALIZE": lambda a, b, c, scale: normalize(a),
}
TO_NUMBER = {
    "DOT_PRODUCT": lambda a, b, c, scale: dot(a, b),
    "DISTANCE": lambda a, b, c, scale: length(a - b),
    "LENGTH": lambda a, b, c, scale: length(a),
}


def vector_math(values, node, socket, stack):
    vectors = [values.vector(node, stack, name) for name in ("Vector", "Vector_001", "Vector_002")]
    if node.operation in PARTWISE:
        return each(PARTWISE[node.operation], *vectors)
    whole = WHOLE.get(node.operation) or TO_NUMBER.get(node.operation)
    return whole and whole(*vectors, values.number(node, stack, "Scale"))


# ------------------------------------------------------------------ turning


def turn(v, axis: int, angle: Number) -> np.ndarray:
    """About the x, y or z axis."""
    if is_number(angle, 0.0):
        return v
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turned = v.copy()
    turned[i], turned[j] = ARITHMETIC.call("turn", (v[i], v[j], call1("sine", angle), call1("cosine", angle)))
    return turned


def turn_euler(v, angles) -> np.ndarray:
    """About x, then y, then z."""
    for axis in range(3):
        v = turn(v, axis, angles[axis])
    return v


def turn_back(v, angles) -> np.ndarray:
    """The inverse of turn_euler."""
    for axis in (2, 1, 0):
        v = turn(v, axis, -angles[axis])
    return v


def turn_about(v, axis, angle: Number) -> np.ndarray:
    """About any axis; not at all where that has no length."""
    turned = call3("rotate_about", *v, *normalize(axis), call1("sine", angle), call1("cosine", angle))
    return each(lambda x, unturned: select(length(axis), x, unturned), turned, v)


def vector_rotate(values, node, socket, stack):
    center = values.vector(node, stack, "Center")
    v = values.vector(node, stack, "Vector") - center
    if node.rotation_type == "EULER_XYZ":
        angles = values.vector(node, stack, "Rotation")
        return (turn_back if node.invert else turn_euler)(v, angles) + center
    angle = values.number(node, stack, "Angle")
    angle = -angle if node.invert else angle
    if node.rotation_type == "AXIS_ANGLE":
        return turn_about(v, values.vector(node, stack, "Axis"), angle) + center
    return turn(v, "XYZ".index(node.rotation_type[0]), angle) + center


def mapping(values, node, socket, stack):
    v, rotation, scale = (values.vector(node, stack, name) for name in ("Vector", "Rotation", "Scale"))
    location = values.vector(node, stack, "Location") if node.vector_type in ("POINT", "TEXTURE") else None
    return mapped(node.vector_type, v, location, rotation, scale)


def mapped(kind: str, v, location, rotation, scale) -> np.ndarray:
    """A vector as a Mapping node of a kind has it; `location` is that of points and textures."""
    if kind == "NORMAL":
        return normalize(turn_euler(each(divide, v, scale), rotation))
    if kind == "VECTOR":
        return turn_euler(v * scale, rotation)
    if kind == "TEXTURE":
        return each(divide, turn_back(v - location, rotation), scale)
    return turn_euler(v * scale, rotation) + location


def texture_mapped(v, m) -> np.ndarray:
    """A vector through the mapping that each texture node holds, whose limits Cycles does not know."""
    parts = {"NONE": 0.0, **dict(zip("XYZ", v, strict=True))}
    chosen = triple(parts[m.mapping_x], parts[m.mapping_y], parts[m.mapping_z])
    return mapped(m.vector_type, chosen, triple(*m.translation), triple(*m.rotation), triple(*m.scale))


# ------------------------------------------------------------------ spaces

KINDS = {"POINT": 0, "VECTOR": 1, "NORMAL": 2}  # KIND_ numbers of kernels/values/space.h
TO_WORLD = {"OBJECT": "from_object", "CAMERA": "from_camera"}
FROM_WORLD = {"OBJECT": "to_object", "CAMERA": "to_camera"}


def vector_transform(values, node, socket, stack):
    v, kind = values.vector(node, stack, "Vector"), KINDS[node.vector_type]
    if node.convert_from == node.convert_to:
        return v
    if values.lamp and "OBJECT" in (node.convert_from, node.convert_to):
        return through_lamp(values, v, node)
    for name in (TO_WORLD.get(node.convert_from), FROM_WORLD.get(node.convert_to)):
        v = v if name is None else call3(name, *v, data=kind)
    return v


def through_lamp(values, v, node):
    """Between the space of a lamp and another."""
    if node.convert_from == "CAMERA":
        v = call3("from_camera", *v, data=KINDS[node.vector_type])
    v = values.lamp.moved(node.vector_type, v, to_world=node.convert_from == "OBJECT")
    return call3("to_camera", *v, data=KINDS[node.vector_type]) if node.convert_to == "CAMERA" else v


def normal(values, node, socket, stack):
    direction = normalize(triple(*node.outputs["Normal"].default_value))
    return direction if socket.name == "Normal" else dot(direction, normalize(values.vector(node, stack, "Normal")))


def combine(values, node, socket, stack):
    return triple(*(values.number(node, stack, name) for name in "XYZ"))


def separate(values, node, socket, stack):
    return values.vector(node, stack, "Vector")["XYZ".index(socket.name)]


NODES = {
    "ShaderNodeVectorMath": vector_math,
    "ShaderNodeVectorRotate": vector_rotate,
    "ShaderNodeMapping": mapping,
    "ShaderNodeVectorTransform": vector_transform,
    "ShaderNodeNormal": normal,
    "ShaderNodeCombineXYZ": combine,
    "ShaderNodeSeparateXYZ": separate,
}
