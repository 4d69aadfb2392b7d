# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes without inputs: constants, the shaded point, the ray that met it, attributes, what is known of the object."""

from __future__ import annotations

import numpy as np

from isophote.records import numbers
from isophote.values import Number, call1, square_root

from ..values import default_value, dot, grey, mean, outputs, source, triple
from .normals import default_tangent


def constant(values, node, socket, stack):
    return default_value(socket, None)


def zero(values, node, socket, stack):
    """Of points and volumes, which surfaces of meshes and strands are not."""
    return grey(0.0) if socket.type in ("VECTOR", "RGBA") else 0.0


# ------------------------------------------------------------------ the point


def geometry(values, node, socket, stack):
    if socket.name == "Position":
        return place(values)
    if socket.name == "Normal":
        return values.surface_normal
    if socket.name == "Tangent":
        return default_tangent(values)
    if socket.name == "True Normal":
        return source("true_normal")
    if socket.name == "Incoming":
        return source("incoming")
    if socket.name == "Parametric":
        if values.lamp:
            return values.lamp.parametric()
        u, v = outputs("barycentric")
        return triple(1.0 - u - v, u, 0.0)
    if socket.name == "Backfacing":
        return call1("backfacing")
    kind = {"Pointiness": "pointiness", "Random Per Island": "island"}.get(socket.name)
    return call1("attribute", data=values.lookups.attribute(kind)) if kind and values.lookups else None


def place(values):
    """Where the shaded point is in Blender's world; in a world, the direction in which one looks."""
    if values.lamp:
        return values.lamp.place()
    return source("object_point" if values.kind == "world" and not values.fills else "position")


def uv_of(values, name: str = "", from_instancer: bool = False):
    if values.lookups is None:
        return None
    if from_instancer:
        return triple(*instance_columns(values, "uv", 2), 0.0)
    if values.lamp and not name:
        return values.lamp.parametric()
    return source("attribute", data=values.lookups.attribute("uv", name))


def generated(values, from_instancer: bool = False):
    """The place in the box of a mesh's texture space; in a world, the direction in which one looks."""
    if values.lookups is None:
        return None
    if values.kind == "world":
        return place(values)
    if from_instancer:
        return triple(*instance_columns(values, "generated", 3))
    if values.lamp:
        return values.lamp.point()
    if values.fills:
        low, sizes = (source("attribute", data=values.lookups.attribute(kind)) for kind in ("box_low", "box_sizes"))
        return (source("object_point") - low) / sizes
    return source("attribute", data=values.lookups.attribute("generated"))


def texture_coordinate(values, node, socket, stack):
    if values.lookups is None:
        return None
    if socket.name == "UV":
        return uv_of(values, "", node.from_instancer)
    if socket.name == "Generated":
        return generated(values, node.from_instancer)
    if socket.name == "Normal":
        return to_object_normal(values, values.surface_normal)
    if socket.name == "Object":
        return object_point(values) if node.object is None else in_space_of(values, node.object)
    if socket.name == "Camera":
        return source("camera_point")
    if socket.name == "Window":
        return source("window_point", *source("camera_point"))
    return source("mirrored_view") if socket.name == "Reflection" else None


def object_point(values):
    """The point in the space of its object."""
    if values.fills and values.kind == "world":
        return place(values)
    return values.lamp.point() if values.lamp else source("object_point")


def to_object_normal(values, normal):
    """A normal, unit, in the space of the shaded object."""
    return values.lamp.moved("NORMAL", normal, to_world=False) if values.lamp else source("to_object_normal", *normal)


def in_space_of(values, ob):
    """The point in the space of another object."""
    matrix = np.array(ob.matrix_world.inverted_safe(), np.float64)
    center = np.array(ob.matrix_world, np.float64)[:3, 3]
    place = values.lamp.place() if values.lamp else source("position")
    relative = place - center  # in this order differences of large numbers are small ones
    return triple(*(sum(m * x for m, x in zip(row[:3], relative, strict=True)) for row in matrix[:3]))


def uv_map(values, node, socket, stack):
    return uv_of(values, node.uv_map, node.from_instancer)


def camera_data(values, node, socket, stack):
    x, y, z = source("camera_point")
    if socket.name == "View Z Depth":
        return z
    distance = square_root(x * x + y * y + z * z)
    return distance if socket.name == "View Distance" else triple(x / distance, y / distance, z / distance)


def wireframe(values, node, socket, stack):
    return call1("wireframe", values.number(node, stack, "Size"), data=int(node.use_pixel_size))


# ------------------------------------------------------------------ attributes


def attribute(values, node, socket, stack) -> Number | None:
    """An attribute of the mesh by its name, or a property of the object, of what made an instance of it, or of the view
    layer, the scene or the world."""
    if values.lookups is None:
        return None
    kind, name = node.attribute_type, node.attribute_name
    if kind == "GEOMETRY":
        found = outputs("attribute", data=values.lookups.attribute("named", name))
    elif kind in ("OBJECT", "INSTANCER"):
        found = instance_columns(values, kind.lower(), 4, name)
    else:
        found = values.lookups.view_layer_value(name)
    return {"Fac": mean(found[:3]), "Alpha": found[3]}.get(socket.name, triple(*found[:3]))


def vertex_color(values, node, socket, stack):
    """A colour attribute; the one that is active for rendering where none is named."""
    if values.lookups is None:
        return None
    found = outputs("attribute", data=values.lookups.attribute("color", node.layer_name))
    return found[3] if socket.name == "Alpha" else triple(*found[:3])


# ------------------------------------------------------------------ objects


def instance_columns(values, kind: str, count: int, name: str = "") -> tuple[Number, ...]:
    if values.lamp:
        return tuple(float(part) for part in values.lamp.known(kind, name)[:count])
    return tuple(call1("instance_value", data=values.lookups.instance(kind, name, k)) for k in range(count))


def object_info(values, node, socket, stack):
    if socket.name == "Location":
        return triple(*values.lamp.matrix[:3, 3]) if values.lamp else source("object_location")
    if socket.name == "Material Index":
        return float(values.material_index)
    if values.lookups is None:
        return None
    color = {"Color": slice(0, 3), "Alpha": 3}.get(socket.name)
    if color is None:
        return instance_columns(values, {"Object Index": "index", "Random": "random"}[socket.name], 1)[0]
    found = instance_columns(values, "color", 4)[color]
    return triple(*found) if socket.name == "Color" else found


def particle_info(values, node, socket, stack):
    if values.lookups is None:
        return None
    found = instance_columns(values, "particle", 3 if socket.type == "VECTOR" else 1, socket.name)
    return triple(*found) if socket.type == "VECTOR" else found[0]


def hair_info(values, node, socket, stack):
    """All is 0 on what is no strand."""
    if values.lookups is None:
        return zero(values, node, socket, stack)
    if socket.name == "Tangent Normal":
        return tangent_normal(values)
    name = {"Is Strand": "is_strand"}.get(socket.name, socket.name.lower())
    return call1("attribute", data=values.lookups.attribute("strand", name))


def strand_tangent(values):
    """Unit, along the strand in the world; 0 elsewhere."""
    along = outputs("attribute", data=values.lookups.attribute("strand", "tangent"))[:3]
    return source("normalize", *source("to_world_vector", *along))


def tangent_normal(values):
    """What of the way to the viewer is across the strand, unit: Cycles' curve_tangent_normal."""
    tangent, incoming = strand_tangent(values), source("incoming")
    across = source("normalize", *(incoming - tangent * dot(tangent, incoming)))
    return across * call1("attribute", data=values.lookups.attribute("strand", "is_strand"))


# ------------------------------------------------------------------ the ray


def light_path(values, node, socket, stack):
    n = numbers()
    kinds = {
        "Is Camera Ray": n["RAY_CAMERA"], "Is Shadow Ray": n["RAY_SHADOW"],
        "Is Singular Ray": n["RAY_SINGULAR"], "Is Reflection Ray": n["RAY_DIFFUSE"] | n["RAY_GLOSSY"],
        "Is Transmission Ray": n["RAY_TRANSMISSION"], "Is Diffuse Ray": n["RAY_DIFFUSE"] | n["RAY_SOFT"],
    }
    if socket.name in kinds:
        return call1("ray_is", data=kinds[socket.name])
    if socket.name == "Is Glossy Ray":  # refraction's too, but for what diffuse transmission sends on
        soft = call1("ray_is", data=n["RAY_SOFT"])
        return call1("ray_is", data=n["RAY_GLOSSY"] | n["RAY_TRANSMISSION"]) - soft
    shifts = {"Ray Depth": 0, "Diffuse Depth": 8, "Glossy Depth": 16, "Transmission Depth": 24}
    if socket.name in shifts:
        return call1("ray_bounces", data=shifts[socket.name])
    if socket.name == "Transparent Depth":
        return call1("ray_passed")
    return call1("ray_length") if socket.name == "Ray Length" else 0.0  # volumes, portals


NODES = {
    "ShaderNodeRGB": constant,
    "ShaderNodeValue": constant,
    "ShaderNodeNewGeometry": geometry,
    "ShaderNodeTexCoord": texture_coordinate,
    "ShaderNodeUVMap": uv_map,
    "ShaderNodeAttribute": attribute,
    "ShaderNodeVertexColor": vertex_color,
    "ShaderNodeCameraData": camera_data,
    "ShaderNodeWireframe": wireframe,
    "ShaderNodeObjectInfo": object_info,
    "ShaderNodeParticleInfo": particle_info,
    "ShaderNodeLightPath": light_path,
    "ShaderNodeHairInfo": hair_info,
    "ShaderNodePointInfo": zero,
    "ShaderNodeVolumeInfo": zero,
}
