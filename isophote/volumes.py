"""Volumes of a scene: whether it has some, and whether the camera may be within one of an object."""

from __future__ import annotations

import numpy as np

from isophote.lights import slots_of
from isophote.records import numbers
from isophote.scene import Scene


def has_volumes(scene: Scene) -> bool:
    return bool(scene.material_volume.any() or scene.world_volume)


def is_camera_enclosed(scene: Scene) -> bool:
    """Whether paths may begin in the box around an object that has a volume: then kernels look where they are."""
    if not scene.material_volume.any():
        return False
    places = np.concatenate([scene.camera_to_world[None, :, 3], scene.camera_poses[:, :3]]).astype(np.float64)
    reach = camera_reach(scene)
    return any(((places >= low - reach) & (places <= high + reach)).all(axis=1).any()
               for low, high in volume_boxes(scene))


def camera_reach(scene: Scene) -> float:
    """No path begins farther from the camera's place than that, metres."""
    wide = float(np.abs(scene.camera_window).max()) * 2.0 ** 0.5
    near, lens, eye = (abs(float(x)) for x in (scene.camera_clip[0], scene.camera_lens[0], scene.camera_stereo[0]))
    return near * (1.0 + wide) + wide * bool(scene.camera_kind == numbers()["CAMERA_ORTHOGRAPHIC"]) + lens + eye


def volume_boxes(scene: Scene):
    """(lowest, highest corner), f8 [3] each, of the box in the world around each object that has a volume."""
    filled = scene.material_volume > 0
    for instance, mesh in enumerate(scene.instance_mesh):
        first = int(scene.instance_slots[instance])
        if not filled[scene.slot_materials[first + np.unique(slots_of(scene, mesh))]].any():
            continue
        matrix = scene.instance_to_world[instance]
        vertices = scene.vertices[scene.mesh_vertices[mesh]:scene.mesh_vertices[mesh + 1]].astype(np.float64)
        placed = vertices @ matrix[:, :3].T + matrix[:, 3]
        yield placed.min(axis=0), placed.max(axis=0)
    for center, radius, material in zip(scene.sphere_center, scene.sphere_radius, scene.sphere_material, strict=True):
        if filled[material]:
            yield center - radius, center + radius


def is_deeply_nested(scene: Scene) -> bool:
    """Whether the boxes of so many volumes overlap that paths cannot remember all that they are in."""
    boxes = np.array(list(volume_boxes(scene))).reshape(-1, 2, 3)
    room = numbers()["MOST_VOLUMES"] - bool(scene.world_volume)
    return any(((low <= boxes[:, 1]) & (high >= boxes[:, 0])).all(axis=1).sum() > room for low, high in boxes)
