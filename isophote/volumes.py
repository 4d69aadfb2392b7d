"""Volumes of a scene: where they are, and whether the camera may be within one of an object."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.motion import box_of_shapes, deforming, moving, swept_boxes
from isophote.records import numbers
from isophote.scene import Scene, slots_of
from isophote.values import operations

AROUND_SPHERE = 0x80000000  # kernels/volume.h
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
    from isophote.geometry import mesh_boxes  # scenes can be told wrong without the native module

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
