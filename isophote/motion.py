"""What moves while the shutter is open, as kernels read it (kernels/motion.h), and boxes around all of its ways."""

from __future__ import annotations

import numpy as np

from isophote.records import make_records
from isophote.scene import Scene

TURN_EACH = 0.1  # radians between the moments at which boxes are looked at
NEAR_COSINE = 0.9995  # of quaternions, from which on kernels interpolate them linearly
POSE_MARGIN = 2.0**-16  # of what is computed of a pose in float32, relative to coordinates
SHAPE_MARGIN = 2.0**-21  # of what lies between two shapes


def moving(scene: Scene) -> np.ndarray:
    """Mask (I) of instances that move while the shutter is open."""
    return (scene.instance_keys > 0) & (scene.vectors == 0)


def deforming(scene: Scene) -> np.ndarray:
    """Mask (M) of meshes that deform while it is."""
    return (scene.mesh_keys > 0) & (scene.vectors == 0)


def starts(counts: np.ndarray) -> np.ndarray:
    """Where each of several runs of these lengths begins, int64."""
    return np.cumsum(np.concatenate([[0], counts]), dtype=np.int64)[:-1]


def motion_buffers(scene: Scene) -> dict[str, np.ndarray]:
    """Buffers `motions`, `poses` and `shapes`; all are empty where nothing moves, from frame to frame either."""
    if not (scene.instance_keys.any() or scene.mesh_keys.any()):
        return {"motions": make_records("Motion", 0), "poses": make_records("Pose", 0),
                "shapes": np.zeros((0, 3), np.float32)}
    turn, place, stretch = decomposed(scene.key_to_world)
    poses = make_records("Pose", len(turn), turn=turn, place=place, diagonal=stretch[:, [0, 1, 2], [0, 1, 2]],
                         mixed=stretch[:, [0, 0, 1], [1, 2, 2]])
    vertices = np.diff(scene.mesh_vertices.astype(np.int64))
    rows = scene.mesh_keys * vertices
    smooth = scene.mesh_normals >= 0
    first = starts(rows) - scene.mesh_vertices[:-1]
    first_normal = len(scene.key_vertices) + starts(rows * smooth) - scene.mesh_vertices[:-1]
    mesh, still = scene.instance_mesh, scene.instance_keys == 0
    motions = make_records(
        "Motion", len(mesh), first_pose=np.where(still, 0, starts(scene.instance_keys)), poses=scene.instance_keys,
        first_shape=(first % 2**32)[mesh], shapes=scene.mesh_keys[mesh], first_normal=(first_normal % 2**32)[mesh],
        vertices=vertices[mesh])
    return {"motions": motions, "poses": poses, "shapes": np.concatenate([scene.key_vertices, scene.key_normals])}


def decomposed(matrices: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Turn (a quaternion x, y, z, w; f8 [n, 4]), place (f8 [n, 3]) and symmetric stretch (f8 [n, 3, 3]) of matrices,
    f8 [n, 3, 4].

    The polar decomposition (Shoemake and Duff 1992); of a mirroring matrix the stretch mirrors. Where a stretch is flat
    the turn about what is left is one of several.
    """
    u, sizes, v = np.linalg.svd(matrices[:, :, :3])
    mirrored = np.linalg.det(u @ v) < 0
    flat = sizes[:, 2] <= 1e-12 * sizes[:, 0]
    u[mirrored & flat, :, 2] *= -1
    u[mirrored & ~flat] *= -1
    turn = u @ v
    stretch = turn.transpose(0, 2, 1) @ matrices[:, :, :3]
    return quaternions(turn), matrices[:, :, 3], (stretch + stretch.transpose(0, 2, 1)) / 2


def quaternions(turns: np.ndarray) -> np.ndarray:
    """x, y, z, w of rotations f8 [n, 3, 3]: each from the largest of the four (Shepperd 1978)."""
    m = turns
    trace = np.trace(m, axis1=1, axis2=2)
    squares = np.stack([*(1 + 2 * m[:, k, k] - trace for k in range(3)), 1 + trace], axis=1)
    made = np.empty((len(m), 4))
    largest = squares.argmax(axis=1)
    for k in range(4):
        at = largest == k
        double = 2 * np.sqrt(squares[at, k])
        if k == 3:
            pairs = [m[at, (i + 2) % 3, (i + 1) % 3] - m[at, (i + 1) % 3, (i + 2) % 3] for i in range(3)]
            made[at] = np.stack([*pairs, squares[at, 3]], axis=1) / double[:, None]
        else:
            i, j = (k + 1) % 3, (k + 2) % 3
            made[at, k] = squares[at, k] / double
            made[at, i] = (m[at, k, i] + m[at, i, k]) / double
            made[at, j] = (m[at, k, j] + m[at, j, k]) / double
            made[at, 3] = (m[at, j, i] - m[at, i, j]) / double
    return made


def rotations(q: np.ndarray) -> np.ndarray:
    """Matrices f8 [n, 3, 3] of unit quaternions."""
    x, y, z, w = q.T
    return np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),
                     2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
                     2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], axis=1).reshape(-1, 3, 3)


def slerp(a: np.ndarray, b: np.ndarray, t: float) -> tuple[np.ndarray, np.ndarray]:
    """Quaternions on the shorter arcs from a to b, as kernels have them, and half of the angles of these arcs."""
    cosine = np.einsum("ni,ni->n", a, b)
    b = np.where(cosine < 0, -1.0, 1.0)[:, None] * b
    cosine = np.minimum(np.abs(cosine), 1.0)
    angle, near = np.arccos(cosine), cosine > NEAR_COSINE
    sine = np.where(near, 1.0, np.sin(angle))
    before = np.where(near, 1 - t, np.sin((1 - t) * angle) / sine)
    made = before[:, None] * a + np.where(near, t, np.sin(t * angle) / sine)[:, None] * b
    return made / np.linalg.norm(made, axis=1, keepdims=True), angle


def swept_boxes(scene: Scene, instances: np.ndarray, boxes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """World boxes f8 [n, 3] that hold, at every time of the shutter, what lies in object boxes f8 [n, 2, 3] of the
    instances with these numbers, all of which move.

    What is in a box is a mean of its corners, at any time. Between two moments a corner's way f leaves its chord by no
    more than h^2 / 8 max |f''|, h being the time between them. Where the turn goes evenly, with speed w, and stretch
    and place change linearly, f = R q + p and |f''| <= w^2 |q| + 2 w |q'|. A turn that is interpolated linearly is at
    any time less than the third power of its angle away from the even one.
    """
    corners = np.stack([np.where([c & 1, c & 2, c & 4], boxes[:, 1], boxes[:, 0]) for c in range(8)], axis=1)
    low, high = np.full((len(instances), 3), np.inf), np.full((len(instances), 3), -np.inf)
    reach = np.zeros(len(instances))
    first, counts = starts(scene.instance_keys)[instances], scene.instance_keys[instances].astype(np.int64)
    turn, place, stretch = decomposed(scene.key_to_world)
    for step in range(int(counts.max(initial=1)) - 1):
        rows = np.flatnonzero(step < counts - 1)
        a = first[rows] + step
        ends = [np.einsum("nij,ncj->nci", stretch[k], corners[rows]) for k in (a, a + 1)]
        length = np.maximum(*(np.linalg.norm(end, axis=2).max(axis=1) for end in ends))
        change = np.linalg.norm(ends[1] - ends[0], axis=2).max(axis=1)
        angle = 2 * slerp(turn[a], turn[a + 1], 0.0)[1]
        parts = int(np.ceil(angle.max(initial=0.0) / TURN_EACH)) + 1
        bulge = (angle ** 2 * length + 2 * angle * change) / (8 * parts ** 2) + length * np.minimum(angle, 0.1) ** 3
        for k in range(parts + 1):
            t = k / parts
            turned = rotations(slerp(turn[a], turn[a + 1], t)[0])
            at = np.einsum("nij,ncj->nci", turned, (1 - t) * ends[0] + t * ends[1])
            at += ((1 - t) * place[a] + t * place[a + 1])[:, None]
            low[rows] = np.minimum(low[rows], at.min(axis=1) - bulge[:, None])
            high[rows] = np.maximum(high[rows], at.max(axis=1) + bulge[:, None])
        far = np.maximum(np.abs(place[a]).max(axis=1), np.abs(place[a + 1]).max(axis=1))
        reach[rows] = np.maximum(reach[rows], length + far)
    margin = POSE_MARGIN * reach[:, None]
    return low - margin, high + margin


def shape_range(scene: Scene, mesh: int) -> np.ndarray:
    """The shapes of a mesh that deforms, f4 [keys, vertices, 3]."""
    count = int(scene.mesh_vertices[mesh + 1] - scene.mesh_vertices[mesh])
    first = int(starts(scene.mesh_keys * np.diff(scene.mesh_vertices.astype(np.int64)))[mesh])
    keys = int(scene.mesh_keys[mesh])
    return scene.key_vertices[first:first + keys * count].reshape(keys, count, 3)


def shape_boxes(scene: Scene, mesh: int) -> tuple[np.ndarray, np.ndarray]:
    """Boxes f4 [T, 3] of the triangles of a mesh that deforms, which hold them at every time."""
    own = scene.triangles[scene.mesh_triangles[mesh]:scene.mesh_triangles[mesh + 1]] - scene.mesh_vertices[mesh]
    corners = shape_range(scene, mesh)[:, own]
    low, high = corners.min(axis=(0, 2)), corners.max(axis=(0, 2))
    margin = SHAPE_MARGIN * np.maximum(np.abs(low), np.abs(high)).max(axis=1, keepdims=True)
    return low - margin, high + margin


def box_of_shapes(scene: Scene, mesh: int) -> np.ndarray:
    """Lowest and highest corner of all shapes, f4 [2, 3]."""
    low, high = shape_boxes(scene, mesh)
    return np.stack([low.min(axis=0), high.max(axis=0)]) if len(low) else np.zeros((2, 3), np.float32)
