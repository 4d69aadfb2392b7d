# SPDX-License-Identifier: GPL-3.0-or-later
"""Attributes of evaluated meshes that materials ask for: UV maps, generated coordinates, attributes by name."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .. import compat

MESH, VERTEX, TRIANGLE, CORNER = 1, 2, 3, 4  # DOMAIN_ numbers of kernels/scene_records.h
# Types of attributes -> name and number of what they store.
STORED = {"FLOAT": ("value", 1), "INT": ("value", 1), "INT8": ("value", 1), "BOOLEAN": ("value", 1),
          "FLOAT2": ("vector", 2), "FLOAT_VECTOR": ("vector", 3), "FLOAT_COLOR": ("color", 4),
          "BYTE_COLOR": ("color", 4), "QUATERNION": ("value", 4)}


@dataclass
class Attribute:
    """Values of one attribute of a mesh, f4 (elements, components); `domain` is a DOMAIN_ number."""

    domain: int
    values: np.ndarray


def read_attribute(mesh, kind: str, name: str, split: bool) -> Attribute | None:
    """An attribute of a triangulated mesh (kinds: Lookups.attribute), None where the mesh has none such.

    `split`: its vertices were split, so that what goes by vertices goes by corners.
    """
    domain, values = READERS[kind](mesh, name) or (None, None)
    if domain is None:
        return None
    count = len(mesh.loop_triangles)
    if domain == "POINT" and not split:
        return Attribute(VERTEX, values)
    if domain == "FACE":
        return Attribute(TRIANGLE, values[compat.triangle_polygons(mesh, count)])
    corners = compat.triangle_corners(mesh, count)
    if domain == "POINT":
        corners = compat.corner_vertices(mesh)[corners]
    elif domain == "EDGE":
        corners = compat.read_all(mesh.loops, "edge_index", 1, np.int32)[corners]
    return Attribute(CORNER, values[corners])


def uv_map(mesh, name: str):
    layer = mesh.uv_layers.get(name) if name else next((each for each in mesh.uv_layers if each.active_render), None)
    return None if layer is None else ("CORNER", compat.uv_of(layer))


def named(mesh, name: str):
    attribute = mesh.attributes.get(name)
    if attribute is None or attribute.data_type not in STORED:
        return uv_map(mesh, name) if name else None
    stored, components = STORED[attribute.data_type]
    values = compat.read_all(attribute.data, stored, components, np.float32)
    return attribute.domain, values.reshape(-1, components)


def generated(mesh, _):
    """The place in the box of the texture space, without deforming modifiers, as in Cycles' attr_create_generated."""
    places = compat.read_all(mesh.vertices, "undeformed_co", 3, np.float32).reshape(-1, 3)
    low = np.array(mesh.texspace_location, np.float32) - np.array(mesh.texspace_size, np.float32)
    sizes = 2.0 * np.array(mesh.texspace_size, np.float32)
    return "POINT", (places - low) / np.where(sizes != 0.0, sizes, np.float32(1.0))


READERS = {"uv": uv_map, "named": named, "generated": generated}


def join_attributes(keys: list[tuple[str, str]], meshes: list[dict]) -> dict[str, np.ndarray]:
    """The scene's arrays of the attributes `keys`, given those of each mesh by key."""
    rows, values, length = np.zeros((len(meshes), len(keys), 3), np.uint32), [], 0
    for mesh, attributes in enumerate(meshes):
        for number, key in enumerate(keys):
            attribute = attributes.get(key)
            if attribute is not None:
                rows[mesh, number] = length, attribute.domain, attribute.values.shape[1]
                values.append(attribute.values.ravel())
                length += attribute.values.size
    values.append(np.zeros(0, np.float32))
    return {"mesh_attributes": rows, "attribute_values": np.concatenate(values)}
