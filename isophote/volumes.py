"""Volumes of a scene: where they are, how dense they get, and whether the camera may be within one of an object."""

from __future__ import annotations

import os
from typing import NamedTuple

import numpy as np

from isophote import _native
from isophote.emission import arrays_of
from isophote.geometry import mesh_boxes
from isophote.lights import slots_of
from isophote.motion import box_of_shapes, deforming, moving, swept_boxes
from isophote.records import numbers
from isophote.scene import Scene
from isophote.values import operations

THREADS = os.cpu_count() or 1
AROUND_SPHERE = 0x80000000  # kernels/volume.h
POINTS = 32  # along each side of the box around a volume that differs from point to point
MARGIN = 1.25  # of the majorant over the densest of these points
COLLISIONS = 8.0  # of a way through all of a box that emits: less would be noisy
WORLD_SIZES = (1.0, 10.0, 100.0, 1000.0)  # half sides of boxes around the origin where the world's volume is asked for
# Operations on values that ask for the triangle at which a point lies; in a volume there is none.
OF_SURFACES = ("shading_normal", "smooth_normal", "wireframe", "attribute_at", "footprint")


class Filled(NamedTuple):
    """A box in the world around what volumes fill: its corners f8 [3], what tells it apart (volume_key of
    kernels/volume.h), the numbers of the volumes' materials."""

    low: np.ndarray
    high: np.ndarray
    around: int
    materials: np.ndarray


def has_volumes(scene: Scene) -> bool:
    return bool(scene.material_volume.any() or scene.world_volume)


def is_camera_enclosed(scene: Scene, filled: list[Filled]) -> bool:
    """Whether paths may begin in the box around an object that has a volume: then kernels look where they are."""
    places = np.concatenate([scene.camera_to_world[None, :, 3], scene.camera_poses[:, :3]]).astype(np.float64)
    reach = camera_reach(scene)
    return any(((places >= box.low - reach) & (places <= box.high + reach)).all(axis=1).any()
               for box in filled)


def camera_reach(scene: Scene) -> float:
    """No path begins farther from the camera's place than that, metres."""
    wide = float(np.abs(scene.camera_window).max()) * 2.0 ** 0.5
    near, lens, eye = (abs(float(x)) for x in (scene.camera_clip[0], scene.camera_lens[0], scene.camera_stereo[0]))
    return near * (1.0 + wide) + wide * bool(scene.camera_kind == numbers()["CAMERA_ORTHOGRAPHIC"]) + lens + eye


def filled_objects(scene: Scene) -> list[Filled]:
    """The boxes around all objects with volumes, at every time of the shutter; of a scene that was cleaned."""
    volume, moves, deforms = scene.material_volume.astype(np.int64), moving(scene), deforming(scene)
    if not volume.any():
        return []
    boxes, used, made = mesh_boxes(scene), {}, []
    for instance, mesh in enumerate(scene.instance_mesh.tolist()):
        if mesh not in used:
            used[mesh] = np.unique(slots_of(scene, mesh))
        found = np.unique(volume[scene.slot_materials[int(scene.instance_slots[instance]) + used[mesh]]])
        if found.any():
            box = box_of_shapes(scene, mesh) if deforms[mesh] else boxes[mesh]
            low, high = world_box(scene, instance, box.astype(np.float64), moves[instance])
            made.append(Filled(low, high, instance, found[found > 0] - 1))
    for sphere, (center, radius, material) in enumerate(zip(scene.sphere_center, scene.sphere_radius,
                                                            scene.sphere_material, strict=True)):
        if volume[material]:
            made.append(Filled(center - radius, center + radius, AROUND_SPHERE | sphere, volume[[material]] - 1))
    return made


def world_box(scene: Scene, instance: int, box: np.ndarray, moves: bool) -> tuple[np.ndarray, np.ndarray]:
    """Corners f8 [3] of a box around an instance, of which `box`, f8 [2, 3], is in its own space."""
    if moves:
        low, high = swept_boxes(scene, np.array([instance]), box[None])
        return low[0], high[0]
    matrix = scene.instance_to_world[instance]
    corners = np.stack([np.where([c & 1, c & 2, c & 4], box[1], box[0]) for c in range(8)])
    placed = corners @ matrix[:, :3].T + matrix[:, 3]
    return placed.min(axis=0), placed.max(axis=0)


def is_deeply_nested(scene: Scene) -> bool:
    """Whether the boxes of so many volumes overlap that paths cannot remember all that they are in."""
    boxes = np.array([(box.low, box.high) for box in filled_objects(scene)]).reshape(-1, 2, 3)
    room = numbers()["MOST_VOLUMES"] - bool(scene.world_volume)
    return any(((low <= boxes[:, 1]) & (high >= boxes[:, 0])).all(axis=1).sum() > room for low, high in boxes)


def asks_for_surfaces(scene: Scene) -> np.ndarray:
    """Numbers of volumes' materials whose steps ask for what only a surface has."""
    of_surfaces = [operations()[name].number for name in OF_SURFACES]
    domains, mesh = scene.mesh_attributes[:, :, 1], numbers()["DOMAIN_MESH"]
    by_element = (domains > mesh).any(axis=0)
    reads = scene.step_op == operations()["attribute"].number
    wrong = np.isin(scene.step_op, of_surfaces)
    wrong[reads] = by_element[scene.step_data[reads]]
    owner = np.searchsorted(scene.material_steps, np.flatnonzero(wrong), side="right") - 1
    volumes = {*scene.material_volume.tolist(), int(scene.world_volume)} - {0}
    return np.intersect1d(owner, np.array([number - 1 for number in volumes], np.int64))


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
