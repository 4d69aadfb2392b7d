# SPDX-License-Identifier: GPL-3.0-or-later
"""What moves while the shutter is open, for which Blender evaluates the scene at other times.

As Cycles has it (intern/cycles/blender/sync.cpp): the shutter is open for a time around the frame, from it on or until
it; everything is exported in the middle of that time. A camera has 2^n + 1 poses, between which it turns and moves
evenly; moving.py follows the objects.
"""

from __future__ import annotations

from contextlib import contextmanager

import numpy as np
from mathutils import Matrix

from isophote.scene import Scene

from .. import compat
from .camera import View, camera_of, export_camera, make_rigid, view_of
from .moving import Moving, parts_of
from .notes import Notes

SHUTTER_STEPS = 256  # values of the shutter's curve


@contextmanager
def middle_of_shutter(engine, depsgraph):
    """Blender's scene as it is in the middle of the shutter's time, where there is to be motion blur; as before, but
    evaluated anew, when this ends."""
    scene = depsgraph.scene_eval
    frame, subframe, middle = scene.frame_current, scene.frame_subframe, middle_time(scene)
    if not scene.render.use_motion_blur or middle == frame + subframe:
        yield
        return
    try:
        set_time(engine, middle)
        yield
    finally:
        engine.frame_set(frame, subframe)


def middle_time(scene) -> float:
    shift = {"START": 0.5, "END": -0.5}.get(compat.shutter_position(scene), 0.0) * scene.render.motion_blur_shutter
    return scene.frame_current + scene.frame_subframe + shift


def with_motion(scene: Scene, engine, depsgraph, view: str, notes: Notes) -> dict[str, np.ndarray]:
    """The scene's arrays of the camera in the middle of the shutter's time, of its motion and of that of objects; or of
    the frames around, where that is for the Vector pass; none where there is to be neither.

    Blender's scene is as before when this returns, but evaluated anew.
    """
    blender_scene = depsgraph.scene_eval
    render = blender_scene.render
    if not follows_motion(depsgraph):
        return {}
    blurs = render.use_motion_blur
    if blurs:
        note_rolling_shutter(blender_scene, notes)
    length = render.motion_blur_shutter if blurs else 2.0
    frame, subframe = blender_scene.frame_current, blender_scene.frame_subframe
    middle = middle_time(blender_scene) if blurs else frame + subframe
    moving = Moving(scene, notes, all_move=not blurs)
    views: dict[float, View] = {}
    try:
        set_time(engine, middle)
        moving.prepare(depsgraph)
        camera = camera_of(engine, depsgraph)
        settings, lens = getattr(camera, "cycles", None), camera.data.lens
        times = parts_of(getattr(settings, "motion_steps", 1) if blurs else 1)
        views[0.5] = view_of(engine, camera, view)
        arrays = {}
        if blurs:
            arrays = export_camera(blender_scene, camera, scene.resolution, Notes(), views[0.5], scene.origin)
        for time in sorted({*times, *moving.times()} - {0.5}):
            set_time(engine, middle + (time - 0.5) * length)
            moving.look(depsgraph, time)
            camera = camera_of(engine, depsgraph)
            views[time] = view_of(engine, camera, view)
            if camera.data.lens != lens:
                what = "a lens that changes while the shutter is open is not supported: it stays"
                notes.add("camera", camera.name, what if blurs else "the Vector pass knows of no change of its lens")
        set_time(engine, middle)
        arrays |= moving.finish(depsgraph)
    finally:
        engine.frame_set(frame, subframe)
    poses = np.array([pose_of(views[time], views[0.5], scene.origin) for time in times])
    if not blurs:
        return arrays | {"vectors": 1, "camera_poses": poses}
    if getattr(settings, "use_motion_blur", True) and not (poses == poses[0]).all():
        arrays["camera_poses"] = poses
    if arrays.keys() & {"camera_poses", "key_to_world", "key_vertices"}:
        arrays["shutter_curve"] = shutter_curve(render)
    return arrays


def follows_motion(depsgraph) -> bool:
    """Whether Blender's scene is evaluated at other times, too."""
    return depsgraph.scene_eval.render.use_motion_blur or depsgraph.view_layer_eval.use_pass_vector


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


def note_rolling_shutter(scene, notes: Notes) -> None:
    if getattr(getattr(scene, "cycles", None), "rolling_shutter_type", "NONE") != "NONE":
        notes.add("scene", scene.name, "a rolling shutter is not supported: all rows are exposed at once")
