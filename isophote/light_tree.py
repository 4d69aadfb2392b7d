"""The light tree that kernels/light_tree.h walks: pairs of clusters, from Light records."""

from __future__ import annotations

import numpy as np

from isophote.records import make_records, numbers
from isophote.statistics import LUMINANCE


def make_light_tree(lights: np.ndarray, lit: np.ndarray | None = None) -> tuple[np.ndarray, int, np.ndarray]:
    """(LightCluster records, steps from the root to the deepest light, parts of the clusters' intensity that light sets
    of receivers, f8 [clusters, sets]); fills in the lights' trails. `lit`: whether lights light sets, [N, sets].

    All lights must shine. Each level halves every cluster's lights at the median along the longest
    side of their centres' box, suns first parted from the others; so the depth is ceil(log2(n)) or one more.
    Built a level at a time over all clusters.
    """
    n = numbers()
    leaves = leaf_clusters(lights)
    lit = np.zeros((len(lights), 0)) if lit is None else lit
    order = np.arange(len(lights))
    if len(order) < 2:
        return make_records("LightCluster", 0), 0, np.zeros((0, lit.shape[1]))
    tree = make_records("LightCluster", 2 * (len(order) - 1))
    shares = np.zeros((len(tree), lit.shape[1]))
    starts, counts, pairs = np.array([0]), np.array([len(order)]), np.array([0])
    trails, made, depth = np.zeros(len(lights), np.uint32), 1, 0
    while len(starts):
        places = np.repeat(starts - np.concatenate([[0], counts.cumsum()[:-1]]), counts) + np.arange(counts.sum())
        members, firsts = order[places], np.concatenate([[0], counts.cumsum()[:-1]])
        cluster = np.repeat(np.arange(len(starts)), counts)
        key, parted = split_keys(leaves[members], cluster, firsts)
        order[places] = members[np.lexsort((key, cluster))]
        left = np.where(parted > 0, parted, counts // 2)

        starts = np.stack([starts, starts + left], axis=1).ravel()
        counts = np.stack([left, counts - left], axis=1).ravel()
        rows = np.stack([2 * pairs, 2 * pairs + 1], axis=1).ravel()
        of_side = np.repeat(np.arange(len(starts)) % 2, counts)
        places = np.repeat(starts - np.concatenate([[0], counts.cumsum()[:-1]]), counts) + np.arange(counts.sum())
        trails[order[places]] |= (of_side << depth).astype(np.uint32)
        firsts = np.concatenate([[0], counts.cumsum()[:-1]])
        tree[rows] = merge(leaves[order[places]], firsts)
        each = leaves["intensity"][order[places]]
        shares[rows] = (np.add.reduceat(each[:, None] * lit[order[places]], firsts)
                        / np.add.reduceat(each, firsts)[:, None])
        inner = counts > 1
        tree["child"][rows[~inner]] = n["CLUSTER_LIGHT"] | order[starts[~inner]].astype(np.uint32)
        pairs = made + np.arange(inner.sum())
        tree["child"][rows[inner]] = pairs
        made += len(pairs)
        starts, counts, depth = starts[inner], counts[inner], depth + 1
    lights["trail"] = trails
    return tree, depth, shares


def shining(lights: np.ndarray) -> np.ndarray:
    """Which Light records send something, int64: those without strength or area do not."""
    return np.flatnonzero(leaf_clusters(lights)["intensity"] > 0)


def beam_angles(lights: np.ndarray) -> np.ndarray:
    """How far from their axes spots and area lamps shine, radians, f8 [N]; no matter for others."""
    cone = lights["cone"].astype(np.float64)
    u, v = (np.linalg.norm(lights[axis].astype(np.float64), axis=1) for axis in ("u", "v"))
    spot = np.arctan2(np.sqrt(np.maximum(1 - cone ** 2, 0)), cone * np.minimum(u, v))  # a stretched cone is wider
    area = np.where(lights["cone_scale"] > 0, np.arctan(cone), np.pi / 2)
    return np.where(lights["kind"] == numbers()["LIGHT_SPOT"], spot, area)


def leaf_clusters(lights: np.ndarray) -> np.ndarray:
    """A LightCluster of each light, as structured float64; `child` is not filled."""
    n = numbers()
    kind, radiance = lights["kind"], np.abs(lights["radiance"].astype(np.float64)) @ LUMINANCE
    is_sun, is_triangle = kind == n["LIGHT_SUN"], kind == n["LIGHT_TRIANGLE"]
    is_world = kind == n["LIGHT_WORLD"]
    is_ball = (kind == n["LIGHT_POINT"]) | (kind == n["LIGHT_SPOT"])
    size_u, size_v = lights["size_u"].astype(np.float64), lights["size_v"].astype(np.float64)
    u, v = (lights[name].astype(np.float64) for name in ("u", "v"))
    position = lights["position"].astype(np.float64)
    corners = np.stack([position, position + u, position + v], axis=1)
    box = (corners.min(axis=1) + corners.max(axis=1)) / 2
    leaves = np.zeros(len(lights), CLUSTER)
    leaves["center"] = np.where(is_triangle[:, None], box, position)
    farthest = np.linalg.norm(corners - box[:, None], axis=2).max(axis=1)
    flat = np.hypot(size_u, size_v)
    leaves["radius"] = np.where(is_triangle, farthest, np.where(is_ball, size_u, np.where(is_sun, 0.0, flat)))
    leaves["axis"] = lights["normal"]
    spot = np.where(kind == n["LIGHT_SPOT"], beam_angles(lights), 0.0)
    angle = np.where(kind == n["LIGHT_POINT"], np.pi, spot)
    leaves["angle"] = np.where(is_world, np.pi, np.where(is_sun, size_u, angle))
    is_area = (kind == n["LIGHT_RECTANGLE"]) | (kind == n["LIGHT_ELLIPSE"])
    spreads = is_area & (lights["cone_scale"] > 0)
    edge = np.where(is_area, beam_angles(lights), np.pi / 2)
    leaves["edge"] = np.where(is_ball | is_sun | is_world, 0.0, edge)
    # Of a ball: radiance times the disk that it shows; of a point or a sharp sun, what `radiance` holds already.
    disk = np.pi * size_u ** 2
    ball = np.where(size_u > 0, disk, 1.0)
    sun = np.where(size_u > 0, np.pi * np.sin(size_u) ** 2, 1.0)
    distant = np.where(is_world, np.pi, sun)
    # Along the axis of a lamp with a spread; no more than what two diagonals in front of it looks all bright.
    peak = lights["cone"].astype(np.float64) * lights["cone_scale"]
    most = 4 * np.pi * (2 * flat) ** 2 / np.where(spreads, lights["area"], 1)
    area = lights["area"] * np.where(spreads, np.minimum(peak, most), 1.0)
    leaves["intensity"] = radiance * np.where(is_ball, ball, np.where(is_sun | is_world, distant, area))
    leaves["two_sided"], leaves["distant"] = is_triangle, is_sun | is_world
    return leaves


CLUSTER = np.dtype([("center", "f8", 3), ("radius", "f8"), ("axis", "f8", 3), ("angle", "f8"), ("edge", "f8"),
                    ("intensity", "f8"), ("two_sided", "?"), ("distant", "?")])


def split_keys(members: np.ndarray, cluster: np.ndarray, firsts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What each member is sorted by within its cluster, and how many go left where suns part from others, else 0."""
    low, high = (f.reduceat(members["center"], firsts, axis=0) for f in (np.minimum, np.maximum))
    axis = (high - low).argmax(axis=1)
    key = members["center"][np.arange(len(members)), axis[cluster]]
    suns = np.add.reduceat(members["distant"].astype(int), firsts)
    counts = np.diff(np.concatenate([firsts, [len(members)]]))
    mixed = (suns > 0) & (suns < counts)
    key = np.where(mixed[cluster], ~members["distant"], key)
    all_suns = (suns == counts)[cluster]
    key = np.where(all_suns, members["axis"][:, 0], key)
    return key, np.where(mixed, suns, 0)


def merge(members: np.ndarray, firsts: np.ndarray) -> np.ndarray:
    """Records of the clusters that begin at `firsts`: sphere, cone of axes, sum of intensities.

    The axis is the mean of the members' axes by intensity; those of two-sided lights may point either way
    and are turned to the first one's side.
    """
    n = numbers()
    counts = np.diff(np.concatenate([firsts, [len(members)]]))
    cluster = np.repeat(np.arange(len(firsts)), counts)
    reach = members["radius"][:, None]
    low = np.minimum.reduceat(members["center"] - reach, firsts, axis=0)
    high = np.maximum.reduceat(members["center"] + reach, firsts, axis=0)
    center = (low + high) / 2
    radius = np.maximum.reduceat(np.linalg.norm(members["center"] - center[cluster], axis=1) + reach[:, 0], firsts)
    two_sided = np.logical_or.reduceat(members["two_sided"], firsts)
    side = np.where(two_sided[cluster] & (np.einsum("ij,ij->i", members["axis"], members["axis"][firsts][cluster]) < 0),
                    -1.0, 1.0)
    axes = members["axis"] * side[:, None]
    mean = np.add.reduceat(axes * members["intensity"][:, None], firsts, axis=0)
    length = np.linalg.norm(mean, axis=1)
    clear = length > 1e-6 * np.add.reduceat(members["intensity"], firsts)
    axis = np.where(clear[:, None], mean / np.where(clear, length, 1.0)[:, None], axes[firsts])
    off = np.arccos(np.clip(np.einsum("ij,ij->i", axes, axis[cluster]), -1, 1))
    angle = np.minimum(np.maximum.reduceat(off + members["angle"], firsts), np.pi)
    # Rounding to float32 must not let a light out of its cluster.
    return make_records(
        "LightCluster", len(firsts), center=center, radius=radius * (1 + 1e-6), axis=axis,
        cos_axes=np.where(angle > 3.14, -1.0, np.cos(np.minimum(angle + 1e-3, np.pi))),
        cos_edge=np.cos(np.minimum(np.maximum.reduceat(members["edge"], firsts) + 1e-3, np.pi)),
        intensity=np.add.reduceat(members["intensity"], firsts),
        flags=two_sided * n["CLUSTER_TWO_SIDED"] | np.logical_and.reduceat(members["distant"], firsts)
        * n["CLUSTER_DISTANT"])
