# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes without inputs: constants, the shaded point, attributes."""

from __future__ import annotations

from isophote.values import Number, Value, call1

from ..values import default_value, triple


def source(name: str, **data):
    """The three outputs of an operation as a vector."""
    call = call1(name, **data).call
    return triple(*(Value(call, k) for k in range(3)))


def constant(values, node, socket, stack):
    return default_value(socket, None)


def geometry(values, node, socket, stack):
    """Geometry: Position, Normal, True Normal, Incoming, Backfacing."""
    operation = {"Position": "position", "Normal": "shading_normal", "True Normal": "true_normal",
                 "Incoming": "incoming"}.get(socket.name)
    if operation:
        return place(values) if operation == "position" else source(operation)
    return call1("backfacing") if socket.name == "Backfacing" else None


def place(values):
    """Where the shaded point is in Blender's world; in a world, the direction in which one looks."""
    return source("object_point" if values.kind == "world" else "position")


def uv_of(values, name: str = ""):
    return source("attribute", data=values.lookups.attribute("uv", name)) if values.lookups else None


def texture_coordinate(values, node, socket, stack):
    if values.lookups is None:
        return None
    if socket.name == "UV":
        return uv_of(values)
    if socket.name == "Generated" and values.kind == "world":
        return place(values)
    if socket.name == "Generated":
        return source("attribute", data=values.lookups.attribute("generated"))
    if socket.name == "Normal":
        return source("shading_normal")
    if socket.name == "Object" and node.object is None:
        return source("object_point")
    return None


def uv_map(values, node, socket, stack):
    return uv_of(values, node.uv_map)


def attribute(values, node, socket, stack) -> Number | None:
    """An attribute of the mesh by its name; those of objects and view layers are not there."""
    if values.lookups is None or node.attribute_type != "GEOMETRY":
        return None
    data = values.lookups.attribute("named", node.attribute_name)
    if socket.name == "Fac":
        x, y, z = source("attribute", data=data)
        return (x + y + z) * (1.0 / 3.0)
    if socket.name == "Alpha":
        return Value(call1("attribute", data=data).call, 3)
    return source("attribute", data=data)


NODES = {
    "ShaderNodeRGB": constant,
    "ShaderNodeValue": constant,
    "ShaderNodeNewGeometry": geometry,
    "ShaderNodeTexCoord": texture_coordinate,
    "ShaderNodeUVMap": uv_map,
    "ShaderNodeAttribute": attribute,
}
