"""What materials emit where it differs from point to point: asked of the kernels, for choosing lights."""

from __future__ import annotations

import os

import numpy as np

from isophote import _native
from isophote.light_tree import beam_angles
from isophote.records import numbers, scene_buffers
from isophote.statistics import LUMINANCE

THREADS = os.cpu_count() or 1
POINTS, FEWEST_POINTS, MOST_POINTS = 1 << 20, 4, 64  # of all triangles together, and of one


def radiance_from(buffers: dict[str, np.ndarray], directions: np.ndarray) -> np.ndarray:
    """Radiance of the world, f4 [N, 3], seen along unit vectors, f4 [N, 3]."""
    ids = np.full((len(directions), 2), numbers()["NONE"], np.uint32)
    return evaluate(buffers, ids, np.zeros((len(directions), 2), np.float32), directions)


def mean_radiance(buffers: dict[str, np.ndarray], instance: np.ndarray, primitive: np.ndarray,
                  normal: np.ndarray) -> np.ndarray:
    """Mean over points of triangles, half of them seen from each side, f8 [N, 3]; numbers that are none count as 0.

    `normal` is unit, f8 [N, 3].
    """
    count = int(np.clip(POINTS // max(len(instance), 1), FEWEST_POINTS, MOST_POINTS))
    total = np.zeros((len(instance), 3))
    ids = np.stack([instance, primitive], axis=1).astype(np.uint32)
    for k, place in enumerate(points_of_triangle(count)):
        side = -normal if k % 2 else normal
        total += evaluate(buffers, ids, np.broadcast_to(place, (len(ids), 2)), side)
    return total / count


LOOKS, DIMMEST = 256, 1.0 / 256  # at each lamp; an estimate is never less: what is bright may lie between


def lamp_luminance(buffers: dict[str, np.ndarray], numbers_of: np.ndarray, lights: np.ndarray,
                   viewer: np.ndarray) -> np.ndarray:
    """The largest luminance that materials of lamps emit, f8 [N], which is what the light tree has of all lights: with
    means the beam of a luminaire would be noisy.

    `lights`: their records, by their numbers; seen from as far as `viewer`, f8 [3].
    """
    n = numbers()
    along, across = looks_at_lamps(LOOKS)
    position, normal, u, v = (lights[name].astype(np.float64)[:, None] for name in ("position", "normal", "u", "v"))
    half = np.stack([lights["size_u"], lights["size_v"]], axis=1).astype(np.float64)
    kind = lights["kind"][:, None, None]
    is_flat, is_spot, is_sun = kind >= n["LIGHT_RECTANGLE"], kind == n["LIGHT_SPOT"], kind == n["LIGHT_SUN"]
    beam = np.where((is_spot | is_flat)[:, 0, 0], np.cos(beam_angles(lights)), -1.0)
    cone = np.where(is_sun[:, 0, 0], 1 - lights["size_v"], beam)
    cosine = 1 - along[:, 0] * (1 - cone[:, None])
    sine, phi = np.sqrt(np.maximum(1 - cosine ** 2, 0)), 2 * np.pi * along[:, 1]
    side = np.cross(normal, np.where(np.abs(normal[..., :1]) < 0.5, [1.0, 0, 0], [0, 1.0, 0]))
    side /= np.linalg.norm(side, axis=-1, keepdims=True)
    up = np.cross(normal, side)
    leaving = cosine[..., None] * normal + sine[..., None] * (np.cos(phi)[:, None] * side + np.sin(phi)[:, None] * up)
    on_lamp = np.where(is_flat, across[:, :1] * half[:, None, :1] * u + across[:, 1:] * half[:, None, 1:] * v, 0.0)
    far = np.linalg.norm(position - viewer, axis=-1, keepdims=True)
    far = np.maximum(far, 2 * half.max(axis=1)[:, None, None]) + 1e-6
    made = np.empty((len(lights) * LOOKS, 3), np.float32)
    _native.evaluate_lamps(arrays_of(buffers), np.repeat(numbers_of, LOOKS).astype(np.uint32),
                           np.ascontiguousarray((position + on_lamp + leaving * far).reshape(-1, 3), np.float32),
                           np.ascontiguousarray(-leaving.reshape(-1, 3), np.float32), THREADS, made)
    seen = (np.where(np.isfinite(made), np.maximum(made, 0.0), 0.0) @ LUMINANCE).reshape(len(lights), LOOKS)
    return np.maximum(seen.max(axis=1), DIMMEST)


def looks_at_lamps(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of numbers from 0 to 1 for directions, and from -1 to 1 for places, f8 [count, 2] each: a recurrence as of
    points_of_triangle, in four dimensions."""
    root = 1.16730397826142
    u = (0.5 + np.arange(1, count + 1)[:, None] / root ** np.arange(1, 5)) % 1.0
    return u[:, :2], 2 * u[:, 2:] - 1


def points_of_triangle(count: int) -> np.ndarray:
    """Weights of the second and third corner of points spread evenly, f4 [count, 2]: an additive recurrence (Roberts
    2018, "The Unreasonable Effectiveness of Quasirandom Sequences"), folded at the diagonal."""
    golden = 1.32471795724474602596
    u = (0.5 + np.arange(1, count + 1)[:, None] / np.array([golden, golden ** 2])) % 1.0
    return np.where(u.sum(axis=1, keepdims=True) > 1.0, 1.0 - u, u).astype(np.float32)


def arrays_of(buffers: dict[str, np.ndarray]) -> list[np.ndarray]:
    """Bytes of the scene's arrays in the order of kernels/scene_buffers.h."""
    nothing = np.zeros(0, np.uint8)
    return [np.ascontiguousarray(buffers[name]).reshape(-1).view(np.uint8) if name in buffers else nothing
            for name in scene_buffers()]


def evaluate(buffers: dict[str, np.ndarray], ids: np.ndarray, places: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """As `emitted`; not finite or negative parts are 0."""
    made = emitted(buffers, ids, places, directions)
    return np.where(np.isfinite(made), np.maximum(made, 0.0), 0.0)


def emitted(buffers: dict[str, np.ndarray], ids: np.ndarray, places: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """What programs compute, f4 [N, 3], as native/emission.h has it."""
    made = np.empty((len(ids), 3), np.float32)
    _native.evaluate_emission(arrays_of(buffers), ids, np.ascontiguousarray(places, np.float32),
                              np.ascontiguousarray(directions, np.float32), THREADS, made)
    return made
