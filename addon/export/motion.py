# SPDX-License-Identifier: GPL-3.0-or-later
"""A camera that moves while its shutter is open: its poses, for which Blender evaluates the scene at other times.

As Cycles has it (intern/cycles/blender/sync.cpp): the shutter is open for a time around the frame, from it on or until
it, and a camera has 2^n + 1 poses, between which it turns and moves evenly.
"""

from __future__ import annotations

import numpy as np
from mathutils import Matrix

from isophote.scene import Scene

from .. import compat
from .camera import View, camera_of, export_camera, make_rigid, view_of
from .notes import Notes

SHUTTER_STEPS = 256  # values of the shutter's curve
MOVED = 1e-6  # relative change of a matrix from which on an object counts as moving


def with_motion(scene: Scene, engine, depsgraph, view: str, notes: Notes) -> dict[str, np.ndarray]:
    """The scene's arrays of the camera in the middle of the shutter's time and of its motion; none where there is to be
    no motion blur.

    Blender's scene is as before when this returns, but evaluated anew.
    """
    blender_scene = depsgraph.scene_eval
    render = blender_scene.render
    if not render.use_motion_blur:
        return {}
    note_rolling_shutter(blender_scene, notes)
    camera = camera_of(engine, depsgraph)
    frame, subframe, shutter = blender_scene.frame_current, blender_scene.frame_subframe, render.motion_blur_shutter
    center = frame + subframe + {"START": 0.5, "END": -0.5}.get(compat.shutter_position(blender_scene), 0.0) * shutter
    settings = getattr(camera, "cycles", None)
    times = center + np.linspace(-0.5, 0.5, 2 ** getattr(settings, "motion_steps", 1) + 1) * shutter
    lens, places, shapes = camera.data.lens, [], []
    views: list[View] = []
    try:
        for number, time in enumerate(times):
            set_time(engine, time)
            camera = camera_of(engine, depsgraph)
            views.append(view_of(engine, camera, view))
            places.append(matrices_of(depsgraph))
            shapes.append(shapes_of(depsgraph))
            if number == len(times) // 2:
                middle = export_camera(blender_scene, camera, scene.resolution, Notes(), views[-1], scene.origin)
            if camera.data.lens != lens:
                what = "a lens that changes while the shutter is open is not supported: it stays"
                notes.add("camera", camera.name, what)
    finally:
        engine.frame_set(frame, subframe)
    note_moving_objects(places, notes)
    note_deforming_meshes(shapes, notes)
    poses = np.array([pose_of(seen, views[len(views) // 2], scene.origin) for seen in views])
    if not getattr(settings, "use_motion_blur", True) or (poses == poses[0]).all():
        return middle
    return middle | {"camera_poses": poses, "shutter_curve": shutter_curve(render)}


def set_time(engine, time: float) -> None:
    frame = int(np.floor(time))
    engine.frame_set(frame, min(time - frame, 1.0))


def pose_of(view: View, middle: View, origin: np.ndarray) -> np.ndarray:
    """Place, and turn from the middle as a quaternion x, y, z, w, f8 [7]."""
    axes, base = (make_rigid(each.matrix, "camera", Notes()) for each in (view, middle))
    turn = Matrix((axes[:, None, :] * base[None, :, :]).sum(axis=-1).tolist()).to_quaternion()
    return np.array([*(view.matrix[:3, 3] - origin), turn.x, turn.y, turn.z, turn.w])


def shutter_curve(render) -> np.ndarray:
    """How open the shutter is over its time; nothing where it is open at once."""
    mapping = render.motion_blur_shutter_curve
    mapping.initialize()
    values = np.array([mapping.evaluate(mapping.curves[0], x) for x in np.linspace(0.0, 1.0, SHUTTER_STEPS)])
    return np.zeros(0) if np.ptp(values) == 0.0 else np.maximum(values, 0.0)


def matrices_of(depsgraph) -> dict[str, np.ndarray]:
    """Of objects that may be seen, by name."""
    return {ob.name: np.array(ob.matrix_world) for ob in depsgraph.objects if ob.type != "CAMERA"}


def note_moving_objects(places: list[dict], notes: Notes) -> None:
    first = places[0]
    for name, matrix in first.items():
        limit = MOVED * np.abs(matrix).max()
        if any(name in other and np.abs(other[name] - matrix).max() > limit for other in places[1:]):
            notes.add("object", name, "it moves while the shutter is open, which is not supported: it stays")


def shapes_of(depsgraph) -> dict[str, int]:
    """Of objects that are meshes, by name: a hash of where the vertices of the evaluated mesh are."""
    found = {}
    for ob in depsgraph.objects:
        if ob.type == "MESH":
            places = np.empty(3 * len(ob.data.vertices), np.float32)
            ob.data.vertices.foreach_get("co", places)
            found[ob.name] = hash(places.tobytes())
    return found


def note_deforming_meshes(shapes: list[dict], notes: Notes) -> None:
    for name, shape in shapes[0].items():
        if any(other.get(name, shape) != shape for other in shapes[1:]):
            notes.add("object", name, "its mesh changes while the shutter is open, which is not supported: it stays")


def note_rolling_shutter(scene, notes: Notes) -> None:
    if getattr(getattr(scene, "cycles", None), "rolling_shutter_type", "NONE") != "NONE":
        notes.add("scene", scene.name, "a rolling shutter is not supported: all rows are exposed at once")
