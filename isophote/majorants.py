"""How dense the volumes of a scene get: null collisions fill them up to that (kernels/tracking.h)."""

from __future__ import annotations

import os

import numpy as np

from isophote import _native
from isophote.emission import arrays_of
from isophote.records import numbers
from isophote.scene import Scene
from isophote.volumes import Filled

THREADS = os.cpu_count() or 1
POINTS = 32  # along each side of the box around a volume that differs from point to point
MARGIN = 1.25  # of the majorant over the densest of these points
COLLISIONS = 8.0  # of a way through all of a box that emits: less would be noisy
WORLD_SIZES = (1.0, 10.0, 100.0, 1000.0)  # half sides of boxes around the origin where the world's volume is asked for


def find_majorants(scene: Scene, buffers: dict[str, np.ndarray], filled: list[Filled]) -> np.ndarray:
    """Of each material, f8 [P], as kernels/scene_records.h has them: for volumes with steps the densest channel of many
    points, and some more. `buffers` are what it takes to compute it, `filled` the scene's filled_objects."""
    materials = buffers["materials"]
    made = np.zeros(len(materials))
    boxes = list(filled)
    if scene.world_volume:
        world = np.array([int(scene.world_volume) - 1])
        boxes += [Filled(np.full(3, -size), np.full(3, size), numbers()["NONE"], world) for size in WORLD_SIZES]
    for box in boxes:
        for material in box.materials[materials["steps"][box.materials] > 0]:
            most = MARGIN * densest(buffers, box, int(material))
            if materials["flags"][material] & numbers()["MATERIAL_EMITS"]:
                most = max(most, COLLISIONS / max(float(np.linalg.norm(box.high - box.low)), 1e-30))
            made[material] = max(made[material], most, 1e-30)
    return made


# The additive recurrence of Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences", in 3D.
GOLDEN = 1.22074408460576 ** -np.arange(1.0, 4.0)


def densest(buffers: dict[str, np.ndarray], box: Filled, material: int) -> float:
    """The largest extinction of a channel at points all over a box, one in each cell, at a place of its own there."""
    cells = np.stack(np.meshgrid(*[np.arange(POINTS)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = (0.5 + np.arange(1, len(cells) + 1)[:, None] * GOLDEN) % 1.0
    places = box.low + (box.high - box.low) * (cells + inside) / POINTS
    made = np.empty((len(places), 3), np.float32)
    ids = np.broadcast_to(np.array([material, box.around], np.uint32), (len(places), 2))
    _native.evaluate_volumes(arrays_of(buffers), np.ascontiguousarray(ids), np.ascontiguousarray(places, np.float32),
                             THREADS, made)
    return float(np.where(np.isfinite(made), made, 0.0).max(initial=0.0))
