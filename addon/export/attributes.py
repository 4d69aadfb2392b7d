# SPDX-License-Identifier: GPL-3.0-or-later
"""Attributes of evaluated meshes that materials ask for: UV maps and tangents, generated coordinates, those by name."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .. import compat
from .hashes import hash_words, to_unit
from .pointiness import pointiness_of
from .tangents import corner_tangents

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
    if domain == "TRIANGLE_CORNER":
        return Attribute(CORNER, values)
    if domain == "MESH":
        return Attribute(MESH, values)
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
    return "POINT", (places - box_low(mesh, "")[1]) / box_sizes(mesh, "")[1]


def box_low(mesh, _):
    """The lowest corner of the box of the texture space."""
    return "MESH", np.array([mesh.texspace_location], np.float32) - np.array([mesh.texspace_size], np.float32)


def box_sizes(mesh, _):
    sizes = 2.0 * np.array([mesh.texspace_size], np.float32)
    return "MESH", np.where(sizes != 0.0, sizes, np.float32(1.0))


def color(mesh, name: str):
    """A colour attribute; the one that is active for rendering where none is named."""
    colors = mesh.color_attributes
    if not name and 0 <= colors.render_color_index < len(colors):
        name = colors[colors.render_color_index].name
    return named(mesh, name)


def tangent(mesh, name: str):
    """Tangents along a UV map, and signs of their bitangents."""
    found = uv_map(mesh, name)
    if found is None:
        return None
    count = len(mesh.loop_triangles)
    corners, vertices = compat.triangle_corners(mesh, count).reshape(-1, 3), compat.corner_vertices(mesh)
    places = compat.vertex_positions(mesh).reshape(-1, 3)[vertices[corners]]
    normals = compat.corner_normals(mesh, vertices, corners)
    made = corner_tangents(places, found[1][corners], None if normals is None else normals[corners])
    return "TRIANGLE_CORNER", made.reshape(-1, 4)


def strand(mesh, _):
    """What only hair has."""
    return None


def island(mesh, _):
    """A random number for each part that edges hold together, as in Cycles (attr_create_random_per_island)."""
    edges = compat.read_all(mesh.edges, "vertices", 2, np.int32)
    roots = roots_of_islands(len(mesh.vertices), edges.tolist())
    starts = compat.read_all(mesh.polygons, "loop_start", 1, np.int32).reshape(-1)
    return "FACE", to_unit(hash_words(roots[compat.corner_vertices(mesh)[starts]]))[:, None]


def pointiness(mesh, _):
    edges = compat.read_all(mesh.edges, "vertices", 2, np.int32)
    normals = compat.read_all(mesh.vertex_normals, "vector", 3, np.float32)
    return "POINT", pointiness_of(compat.vertex_positions(mesh).reshape(-1, 3), normals, edges)[:, None]


def place(mesh, _):
    """In the object's space, before any displacement."""
    return "POINT", compat.vertex_positions(mesh).reshape(-1, 3)


def vertex_normal(mesh, _):
    """Of vertices that a flat mesh's displacement moves."""
    return "POINT", compat.read_all(mesh.vertex_normals, "vector", 3, np.float32).reshape(-1, 3)


def roots_of_islands(count: int, edges: list) -> np.ndarray:
    """The vertex that stands for each vertex's island, i8 (count): which one follows from the order of edges (Galler
    and Fischer 1964, "An Improved Equivalence Algorithm", by rank), and the random number from it."""
    parents, ranks = list(range(count)), [0] * count

    def find(x):
        while parents[x] != x:
            parents[x] = x = parents[parents[x]]
        return x

    for edge in edges:
        high, low = find(edge[0]), find(edge[1])
        if high == low:
            continue
        if ranks[high] < ranks[low]:
            high, low = low, high
        parents[low] = high
        ranks[high] += ranks[high] == ranks[low]
    return np.array([find(x) for x in range(count)], np.int64)


READERS = {"uv": uv_map, "named": named, "generated": generated, "color": color, "tangent": tangent, "island": island,
           "pointiness": pointiness, "place": place, "normal": vertex_normal, "box_low": box_low,
           "box_sizes": box_sizes, "strand": strand}


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
