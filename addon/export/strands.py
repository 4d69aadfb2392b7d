# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair, of particle systems and of Curves objects, as strands of segments (kernels/strand.h).

What Cycles makes of it (intern/cycles/blender/curves.cpp): points of a strand lie on Catmull-Rom curves, radii as well.
Between two points there are as many segments as the curves are bent, at most MOST_PARTS.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .. import compat
from .attributes import MESH, STORED, TRIANGLE, VERTEX, Attribute, box_low, box_sizes
from .hashes import hash_pair, to_unit
from .mesh import MeshArrays, evaluated_mesh

MOST_PARTS = 8  # of a curve between two points
BENT = 0.25  # of a radius that segments may lie off the curve
DEFAULT_RADIUS = 0.005  # of Curves without one, metres


@dataclass
class Strands:
    """Points of strands in the object's space, one strand after the other: f4 [n, 3], their radii, and where each
    strand begins, with the end behind the last. `numbers`: Blender's of each strand; `counted`: those of all strands of
    an object, counted through its systems."""

    name: str
    points: np.ndarray
    radii: np.ndarray
    first: np.ndarray
    numbers: np.ndarray
    counted: np.ndarray


@dataclass
class Refined:
    """Strands as they are traced. `place`: of each vertex among the points of `strands`, with a fraction where it is
    between two; `share`: how far along its strand it is, 0 to 1; `length` of each strand; `owner`: the strand of each
    segment."""

    arrays: MeshArrays
    place: np.ndarray
    share: np.ndarray
    length: np.ndarray
    owner: np.ndarray
    strands: Strands


# ------------------------------------------------------------------ where they come from


def hair_systems(ob, depsgraph) -> list:
    """The particle modifiers of an evaluated object whose hair is to be rendered as strands."""
    shown = "show_render" if depsgraph.mode == "RENDER" else "show_viewport"
    return [m for m in ob.modifiers if m.type == "PARTICLE_SYSTEM" and getattr(m, shown) and m.particle_system
            and m.particle_system.settings.type == "HAIR" and m.particle_system.settings.render_type == "PATH"]


def hair_material(modifier, slots: int) -> int:
    """The slot, of so many, that a system's hair has."""
    return min(max(modifier.particle_system.settings.material, 1), max(slots, 1)) - 1


def strand_numbers(system) -> tuple[int, int]:
    """First number and end of a system's strands: parents, or where there are some their children."""
    parents, children = len(system.particles), len(system.child_particles)
    return (parents, parents + children) if system.settings.child_type != "NONE" and children else (0, parents)


def read_hair(ob, modifier, depsgraph) -> Strands | None:
    """Of a particle system."""
    system = modifier.particle_system
    settings, (begin, end) = system.settings, strand_numbers(system)
    rendered = depsgraph.mode == "RENDER"
    steps = 2 ** (settings.render_step if rendered else settings.display_step)
    if settings.kink == "SPIRAL":
        steps += settings.kink_extra_steps
    matrix = np.array(ob.matrix_world, np.float64)
    if end == begin or np.linalg.matrix_rank(matrix[:3, :3]) < 3:
        return None
    read = system.co_hair
    places = np.array([read(ob, particle_no=strand, step=step)[:] for strand in range(begin, end)
                       for step in range(steps + 1)], np.float64).reshape(end - begin, steps + 1, 3)
    for step in range(1, steps + 1):  # beyond the end of a strand that is shorter Blender says 0
        over = ~places[:, step].any(axis=1)
        places[over, step] = places[over, step - 1]
    inverse = np.linalg.inv(matrix)
    points = places @ inverse[:3, :3].T + inverse[:3, 3]
    points, first, kept = without_repeats(points)
    if not len(kept):
        return None
    share, _ = shares(points, first)
    half = 0.5 * settings.radius_scale
    radii = tapered(share, half * settings.root_radius, half * settings.tip_radius, settings.shape)
    if settings.use_close_tip:
        radii[first[1:] - 1] = 0.0
    systems = hair_systems(ob, depsgraph)
    before = systems[:[each.name for each in systems].index(modifier.name)]
    counts = [end - begin for begin, end in (strand_numbers(each.particle_system) for each in before)]
    return Strands(f"{ob.name} {system.name}", points.astype(np.float32), radii.astype(np.float32), first,
                   begin + kept, sum(counts) + kept)


def without_repeats(points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of strands f8 [strands, n, 3]: the points that are not where the one before is, where each strand begins, and
    the strands' numbers. Those of one point alone are left out."""
    moved = np.ones(points.shape[:2], bool)
    moved[:, 1:] = (points[:, 1:] != points[:, :-1]).any(axis=2)
    counts = moved.sum(axis=1)
    moved[counts < 2] = False
    kept = np.flatnonzero(counts >= 2)
    return points[moved], np.concatenate([[0], np.cumsum(counts[kept])]), kept


def tapered(share: np.ndarray, root: float, tip: float, shape: float) -> np.ndarray:
    """Radii along strands, as Cycles' shaperadius: `shape` from -1 to 1 makes the taper round or hollow."""
    rest = (1.0 - share) ** (1.0 + shape if shape < 0.0 else 1.0 / max(1.0 - shape, 1e-6))
    return rest * (root - tip) + tip


def read_curves(ob) -> Strands | None:
    """Of a Curves object."""
    data = ob.data
    if not len(data.curves):
        return None
    points = compat.read_all(data.points, "position", 3, np.float32).reshape(-1, 3)
    sizes = compat.read_all(data.curves, "points_length", 1, np.int32).reshape(-1)
    radius = data.attributes.get("radius")
    radii = np.full(len(points), DEFAULT_RADIUS, np.float32) if radius is None else compat.read_all(
        radius.data, "value", 1, np.float32).reshape(-1)
    return Strands(data.name, points, radii, np.concatenate([[0], np.cumsum(sizes)]), np.arange(len(sizes)),
                   np.arange(len(sizes)))


# ------------------------------------------------------------------ curves to segments


def shares(points: np.ndarray, first: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far along its strand each point is, 0 to 1, f8 [n], and the strands' lengths."""
    steps = np.zeros(len(points))
    steps[1:] = np.linalg.norm(np.diff(points.astype(np.float64), axis=0), axis=1)
    steps[first[:-1]] = 0.0
    along = np.cumsum(steps)
    counts = np.diff(first)
    begin, lengths = along[first[:-1]], along[first[1:] - 1] - along[first[:-1]]
    return (along - np.repeat(begin, counts)) / np.repeat(np.where(lengths > 0.0, lengths, 1.0), counts), lengths


def refine(strands: Strands) -> Refined:
    """Segments along the curves."""
    first, counts = strands.first, np.diff(strands.first)
    values = np.concatenate([strands.points, strands.radii[:, None]], axis=1).astype(np.float64)
    is_last = np.zeros(len(values), bool)
    is_last[first[1:] - 1] = True
    begin = np.flatnonzero(~is_last)
    strand = np.repeat(np.arange(len(counts)), counts)
    before = np.maximum(begin - 1, first[strand[begin]])
    after = np.minimum(begin + 2, first[strand[begin] + 1] - 1)
    a, b, c, d = values[before], values[begin], values[begin + 1], values[after]
    parts = parts_of(a, b, c, d)
    rows = [b]
    for k in range(1, parts):
        t = k / parts
        rows.append(0.5 * ((2.0 * b) + (c - a) * t + (2.0 * a - 5.0 * b + 4.0 * c - d) * t ** 2
                           + (3.0 * (b - c) + d - a) * t ** 3))
    made = np.empty((len(values) + len(begin) * (parts - 1), 4))
    place = np.empty(len(made))
    at = np.arange(len(values)) + (np.cumsum(~is_last) - ~is_last) * (parts - 1)  # of the points themselves
    made[at[is_last]], place[at[is_last]] = values[is_last], np.flatnonzero(is_last)
    for k, row in enumerate(rows):
        made[at[begin] + k], place[at[begin] + k] = row, begin + k / parts
    ends = np.zeros(len(made), bool)
    ends[at[is_last]] = True
    start = np.flatnonzero(~ends).astype(np.uint32)
    new_first = np.concatenate([[0], np.flatnonzero(ends) + 1])
    share, length = shares(made[:, :3], new_first)
    arrays = MeshArrays(strands.name, made[:, :3].astype(np.float32), np.stack([start, start + 1, start], axis=1), None,
                        None, np.maximum(made[:, 3], 0.0).astype(np.float32))
    owner = np.repeat(np.arange(len(counts)), np.diff(new_first) - 1)
    return Refined(arrays, place, share, length, owner, strands)


def parts_of(a, b, c, d) -> int:
    """Segments of each curve, so that none lies off it by more than BENT of its radius: by its middle, and a segment
    among n of them by n^2 less. How fast the curve goes along its chord does not count."""
    off, chord = (b + c - a - d)[:, :3] / 16.0, (c - b)[:, :3]
    square = np.maximum((chord ** 2).sum(axis=1), 1e-60)
    off = np.linalg.norm(off - chord * ((off * chord).sum(axis=1) / square)[:, None], axis=1)
    width = np.maximum(0.5 * (b + c)[:, 3], 1e-30)
    return int(np.clip(np.ceil(np.sqrt((off / (BENT * width)).max(initial=0.0))), 1, MOST_PARTS))


# ------------------------------------------------------------------ what materials ask of them


def strand_attributes(ob, modifier, refined: Refined, keys) -> dict[tuple, Attribute | None]:
    """By key (Lookups.attribute), None for those that strands do not have."""
    made = {}
    for kind, name in keys:
        if kind == "strand":
            made[kind, name] = OF_STRANDS[name](refined)
        elif kind == "generated" and modifier is not None:
            made[kind, name] = roots_in_box(ob, refined)
        elif modifier is not None and (kind == "uv" or (kind == "named" and name)):
            made[kind, name] = emitter_uv(ob, modifier, refined, name)
        elif modifier is None:
            made[kind, name] = curve_attribute(ob.data, refined, kind, name)
        else:
            made[kind, name] = None
    return made


def by_strand(refined: Refined, values: np.ndarray) -> Attribute:
    return Attribute(TRIANGLE, values.reshape(len(refined.length), -1)[refined.owner].astype(np.float32))


def by_vertex(refined: Refined, values: np.ndarray) -> Attribute:
    return Attribute(VERTEX, values.reshape(-1, 1).astype(np.float32))


def tangents(refined: Refined) -> Attribute:
    ends = refined.arrays.vertices[refined.arrays.triangles[:, :2]].astype(np.float64)
    along = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(along, axis=1, keepdims=True)
    return Attribute(TRIANGLE, (along / np.where(length > 0.0, length, 1.0)).astype(np.float32))


# Outputs of Hair Info, by what they are called here, and the direction in the object's space.
OF_STRANDS = {
    "is_strand": lambda refined: Attribute(MESH, np.ones((1, 1), np.float32)),
    "intercept": lambda refined: by_vertex(refined, refined.share),
    "length": lambda refined: by_strand(refined, refined.length),
    "thickness": lambda refined: by_vertex(refined, 2.0 * refined.arrays.radii),
    "random": lambda refined: by_strand(refined, to_unit(hash_pair(refined.strands.counted, 0))),  # as Cycles
    "tangent": tangents,
}


def roots_in_box(ob, refined: Refined) -> Attribute | None:
    """Generated coordinates of where strands begin."""
    mesh, is_copy = evaluated_mesh(ob)
    if mesh is None:
        return None
    try:
        roots = refined.arrays.vertices[refined.arrays.triangles[np.searchsorted(refined.owner, np.arange(
            len(refined.length))), 0]]
        return by_strand(refined, (roots - box_low(mesh, "")[1]) / box_sizes(mesh, "")[1])
    finally:
        if is_copy:
            ob.to_mesh_clear()


def emitter_uv(ob, modifier, refined: Refined, name: str) -> Attribute | None:
    """Where strands begin on a UV map of what they grow from."""
    layers = ob.data.uv_layers
    layer = layers.find(name) if name else next((k for k, each in enumerate(layers) if each.active_render), -1)
    if layer < 0:
        return None
    system = modifier.particle_system
    parents = len(system.particles)
    found = [system.uv_on_emitter(modifier, particle=system.particles[number if number < parents else 0],
                                  particle_no=number, uv_no=layer)[:] for number in refined.strands.numbers.tolist()]
    return by_strand(refined, np.array(found, np.float32))


def curve_attribute(data, refined: Refined, kind: str, name: str) -> Attribute | None:
    """A Curves object's attribute of that name, of curves or points; its UV map is where it is on a surface."""
    found = data.attributes.get(name or {"uv": "surface_uv_coordinate"}.get(kind, ""))
    if kind not in ("uv", "named", "color") or found is None or found.data_type not in STORED:
        return None
    stored, components = STORED[found.data_type]
    values = compat.read_all(found.data, stored, components, np.float32).reshape(-1, components)
    if found.domain != "POINT":
        return by_strand(refined, values)
    before, part = refined.place.astype(np.int64), (refined.place % 1.0)[:, None]
    after = np.minimum(before + 1, len(values) - 1)
    return Attribute(VERTEX, (values[before] * (1.0 - part) + values[after] * part).astype(np.float32))
