# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that make normals and tangents, and those that look at the angle between a normal and the viewer."""

from __future__ import annotations

from isophote.values import ARITHMETIC, Number, Value, call1, is_number, maximum, rewritten, select, square_root

from ... import compat
from ..values import dot, outputs, source, triple

DISPLACEMENT_FILTER = 0.1  # footprints, of displacement that is rendered as bump: Cycles' default
HELD = 1.0  # the number of an attribute's step that bump leaves where it is


def normal_input(values, node, stack):
    """The Normal of a node: the surface's own where nothing is linked."""
    if values.is_linked(node, stack, "Normal"):
        return values.vector(node, stack, "Normal")
    return values.surface_normal


def held(values, kind: str, name: str = "") -> tuple:
    """An attribute of which frames are made: as in Cycles these do not turn while bump looks to the side."""
    return outputs("attribute", data=values.lookups.attribute(kind, name), number=HELD)


# ------------------------------------------------------------------ angles to the viewer


def fresnel(values, node, socket, stack):
    return call1("fresnel", values.number(node, stack, "IOR"), *normal_input(values, node, stack))


def layer_weight(values, node, socket, stack):
    blend, normal = values.number(node, stack, "Blend"), normal_input(values, node, stack)
    if socket.name == "Facing":
        return call1("facing", blend, *normal)
    return call1("fresnel", 1.0 / maximum(1.0 - blend, 1e-5), *normal)


# ------------------------------------------------------------------ normals


def normal_map(values, node, socket, stack):
    if values.lookups is None:
        return None
    color, strength = values.color(node, stack, "Color"), values.number(node, stack, "Strength")
    x, y, z = color * 2.0 - 1.0
    if node.space == "TANGENT":
        z = 1.0 + (z - 1.0) * call1("minimum", maximum(strength, 0.0), 1.0)
        tangent = held(values, "tangent", node.uv_map)
        return source("tangent_space", x * strength, y * strength, z, *tangent, *source("smooth_normal"))
    if node.space.startswith("BLENDER"):
        y, z = -y, -z
    normal = triple(x, y, z)
    if node.space.endswith("OBJECT"):
        normal = source("to_world_normal", *normal)
    return source("blended_normal", *normal, strength)


def bump(values, node, socket, stack):
    if values.lookups is None:
        return None
    distance = values.number(node, stack, "Distance")
    return bent(normal_input(values, node, stack), values.number(node, stack, "Height"),
                values.number(node, stack, "Strength"), -distance if node.invert else distance,
                compat.bump_filter(node))


def bent(normal, height, strength, distance, filter_width: float):
    """A normal bent by the slope of a height."""
    if is_number(distance, 0.0) or is_number(strength, 0.0):
        return normal
    beside = [after_step(height, axis, filter_width) for axis in (0, 1)]
    if beside == [height] * 2:
        return normal
    return source("bump", *normal, height, *beside, strength, distance, number=filter_width)


def after_step(number, axis: int, length: float, stretch: Number = 1.0):
    """The number at a place on the surface `length` footprints away, along one of two axes; on the way there places
    change `stretch` times as much as attributes."""
    footprint = [x * length for x in outputs("footprint")]
    step, weights = footprint[3 * axis:3 * axis + 3], footprint[6 + 2 * axis:8 + 2 * axis]
    step = [x * stretch for x in step]

    def change(call, inputs):
        here = tuple(Value(call, k) for k in range(3))
        if call.name == "position":
            return tuple(x + d for x, d in zip(here, step, strict=True))
        if call.name in ("object_point", "camera_point"):
            turned = source({"object_point": "to_object_vector", "camera_point": "to_camera_vector"}[call.name], *step)
            return tuple(x + d for x, d in zip(here, turned, strict=True))
        if call.name == "barycentric":
            return tuple(x + d for x, d in zip(here, weights, strict=False))
        if call.name == "attribute" and call.number != HELD:
            u, v = (x + d for x, d in zip(outputs("barycentric"), weights, strict=True))
            return ARITHMETIC.call("attribute_at", (u, v), data=call.data)
        return None

    return rewritten(number, change)


# ------------------------------------------------------------------ displacement


def displacement(values, node, socket, stack):
    """Along the normal, in the world."""
    amount = values.number(node, stack, "Height") - values.number(node, stack, "Midlevel")
    amount = amount * values.number(node, stack, "Scale")
    normal = normal_input(values, node, stack)
    if node.space == "OBJECT":
        normal = source("to_world_vector", *source("to_object_normal", *normal))
    return normal * amount


def vector_displacement(values, node, socket, stack):
    if values.lookups is None:
        return None
    vector = values.vector(node, stack, "Vector") - values.number(node, stack, "Midlevel")
    vector = vector * values.number(node, stack, "Scale")
    if node.space == "TANGENT":
        x, y, z = vector
        *tangent, sign = held(values, "tangent")
        tangent, normal = triple(*tangent), source("to_object_normal", *values.surface_normal)
        across = cross(normal, tangent)
        vector = tangent * x + normal * y + across * (sign * z / square_root(dot(across, across)))
    return vector if node.space == "WORLD" else source("to_world_vector", *vector)


def cross(a, b):
    return triple(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def displaced_normal(values, vector):
    """The surface's normal where a displacement is rendered as bump."""
    normal = values.surface_normal
    beside = [dot([after_step(x, axis, DISPLACEMENT_FILTER) for x in vector], normal) for axis in (0, 1)]
    height = dot(vector, normal)
    if beside == [height] * 2:
        return normal
    return source("bump", *normal, height, *beside, 1.0, 1.0, number=DISPLACEMENT_FILTER)


def moved_normal(values, vector):
    """The surface's normal where a displacement both moves and bends it.

    As in Cycles (kernel/svm/bump.h, displace.h) vertices keep their normals, and bump looks at the surface as it was,
    in the space of its object; but the places that it steps to lie in the plane of the surface as it is.
    """
    number = values.lookups.attribute("place")
    place = triple(*outputs("attribute", data=number)[:3])
    corner, second, third = (source("attribute_at", u, v, data=number) for u, v in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)))
    here = source("to_world_vector", *place) + source("object_location")
    footprint = outputs("footprint")
    width = call1("length", *footprint[:3])
    sides = [(second - corner) * (footprint[k] / width) + (third - corner) * (footprint[k + 1] / width) for k in (6, 8)]
    stretch = sum(call1("length", *source("to_world_vector", *side)) for side in sides) * 0.5

    def before(call, inputs):
        if call.name == "camera_point":
            way = source("to_camera_vector", *(here - source("position")))
            return tuple(Value(call, k) + way[k] for k in range(3))
        return {"position": tuple(here), "object_point": tuple(place)}.get(call.name)

    def height(at):
        return dot([rewritten(x, before) for x in at], values.surface_normal)

    high = height(vector)
    rises = [(height([after_step(x, axis, DISPLACEMENT_FILTER, stretch) for x in vector]) - high) / width
             for axis in (0, 1)]
    upright = source("to_object_normal", *values.surface_normal)
    slopes = cross(sides[1], upright), cross(upright, sides[0])
    det = dot(sides[0], slopes[0])
    bent = upright * (det * DISPLACEMENT_FILTER) - slopes[0] * rises[0] - slopes[1] * rises[1]
    side = select(call1("less_than", det, 0.0), -1.0, 1.0)
    return source("unit_normal", *source("to_world_normal", *(bent * side)))


# ------------------------------------------------------------------ tangents


def tangent(values, node, socket, stack):
    if values.lookups is None:
        return None
    if node.direction_type == "UV_MAP":
        *direction, _ = held(values, "tangent", node.uv_map)
    else:
        direction = around(values, node.axis)
    return source("frame_tangent", *direction)


def around(values, axis: str):
    """The direction around an axis through the middle of the generated coordinates."""
    x, y, z = (c - 0.5 for c in held(values, "generated")[:3])
    return {"X": (0.0, -z, y), "Y": (-z, 0.0, x), "Z": (-y, x, 0.0)}[axis]


def default_tangent(values):
    """Of a surface where no node makes one, as in Cycles (kernel/geom/primitive.h, primitive_tangent)."""
    return source("frame_tangent", *around(values, "Z")) if values.lookups else None


# ------------------------------------------------------------------ what needs rays of its own


def bevel(values, node, socket, stack):
    values.note(f"{node.name} ({node.bl_idname}): not supported, its normal is left as it is")
    return normal_input(values, node, stack)


def ambient_occlusion(values, node, socket, stack):
    values.note(f"{node.name} ({node.bl_idname}): not supported, nothing is occluded")
    return values.color(node, stack, "Color") if socket.name == "Color" else 1.0


NODES = {
    "ShaderNodeFresnel": fresnel,
    "ShaderNodeLayerWeight": layer_weight,
    "ShaderNodeNormalMap": normal_map,
    "ShaderNodeBump": bump,
    "ShaderNodeDisplacement": displacement,
    "ShaderNodeVectorDisplacement": vector_displacement,
    "ShaderNodeTangent": tangent,
    "ShaderNodeBevel": bevel,
    "ShaderNodeAmbientOcclusion": ambient_occlusion,
}
