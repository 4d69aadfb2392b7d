# SPDX-License-Identifier: GPL-3.0-or-later
"""A final render of one view layer: export, prepare, step, show, finish.

Everything that touches bpy happens in the thread that Blender calls; preparing and rendering happen
in a worker, so that a cancel is seen within POLL seconds whatever the device is doing.
"""

from __future__ import annotations

import time
import traceback
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import replace

import bpy

from isophote.device import DeviceError
from isophote.film import FilmError
from isophote.passes import make_named, make_passes, with_catchers
from isophote.scene import SceneError
from isophote.session import Progress, Session

from . import kept, ledger, left_out, log, native
from .compat import catch_interrupts, frame_border, interrupted
from .export import export_scene, follows_motion, middle_of_shutter, seen_from
from .export.changes import Changes
from .result import OpenResult, mark_failed, missing_passes, stamp, view_names
from .settings import make_settings

POLL = 0.05  # seconds between looks at Blender's Esc key
SHOW_SHARE = 0.1  # of the render's time that may go into showing it
EXPECTED = (SceneError, DeviceError, FilmError, ValueError, MemoryError)


class Cancelled(Exception):
    """The user stopped the render before there was a picture."""


def render(engine, depsgraph) -> None:
    """What Blender calls for each view layer. Errors end in a message and a picture that is no picture."""
    layer = depsgraph.view_layer_eval.name
    try:
        with catch_interrupts():
            render_layer(engine, depsgraph)
    except Cancelled:
        log.line("cancelled before the first sample")
    except Exception as error:
        if not isinstance(error, EXPECTED):
            traceback.print_exc()
        message = str(error) or type(error).__name__
        if isinstance(error, MemoryError):
            message = f"out of memory: {message}"
        log.line(f"error: {message}")
        engine.report({"ERROR"}, f"Isophote: {message}")
        if not bpy.app.background:  # there the report is printed already
            engine.error_set(f"Isophote: {message}")
        mark_failed(engine, depsgraph.scene_eval, layer)


def render_layer(engine, depsgraph) -> None:
    """Render the depsgraph's view layer into the engine's result, each of its views. Raises one of EXPECTED, or
    Cancelled."""
    # It goes on only after a render that saw all that Blender told, and if there is room for what it holds.
    changes, engine.changes = engine.changes or Changes(), None
    problem = native.problem()
    if problem:
        raise DeviceError(problem)
    blender_scene, view_layer = depsgraph.scene_eval, depsgraph.view_layer_eval
    engine.update_stats("", "Isophote: exporting")
    started = time.perf_counter()
    frame = blender_scene.frame_current
    with middle_of_shutter(engine, depsgraph):
        scene = export_scene(depsgraph, changes=changes, frame=frame)
    scene.notes += missing_passes(blender_scene, view_layer)
    export_seconds = time.perf_counter() - started
    region = frame_border(blender_scene.render, scene.resolution)
    settings = make_settings(blender_scene, view_layer, region, engine.is_preview)
    if not engine.is_preview:
        settings = replace(settings, named=scene.named)
    settings = with_catchers(settings, scene)
    if not blender_scene.render.use_multiview:
        only = [seen_from(scene, engine, depsgraph)]
        del scene
        if render_view(engine, only, settings, blender_scene.name, view_layer.name, export_seconds, []):
            engine.changes = None if follows_motion(depsgraph) else changes  # other frames were evaluated
        return
    told: list[str] = []
    for view in view_names(engine):
        log.line(f"view {view}")
        engine.active_view_set(view)
        seen = [seen_from(scene, engine, depsgraph, view)]
        render_view(engine, seen, settings, blender_scene.name, view_layer.name, export_seconds, told, view)


def render_view(engine, scenes: list, settings, scene_name: str, layer: str, export_seconds: float,
                told: list[str], view: str = "") -> bool:
    """Render an exported scene into one view of the engine's result. Whether its geometry is kept for the next one.

    The scene is taken out of `scenes`: a caller's name for it would keep what the session lets go of. `told` are the
    notes that the log has of the views before.
    """
    scene, holds = scenes.pop(), False
    with ThreadPoolExecutor(1, "isophote") as worker:
        engine.update_stats("", "Isophote: preparing")
        geometry, device = (None, None) if engine.is_preview else kept.take(scene_name, layer, settings)
        future = worker.submit(Session, scene, settings, device, kept=geometry)
        del scene, geometry  # the session lets go of what it does not render
        session = prepared(engine, future)
        with session:
            if not engine.is_preview:
                log.notes(session.notes, told)
            finish = render_session(engine, worker, session, layer, view)
            if not engine.is_preview:
                log.notes(session.notes, told)
                left_out.keep(scene_name, layer, told)
                result = session.result()
                log.finished(result, export_seconds)
                ledger.keep(scene_name, result)
                holds = kept.keep(scene_name, layer, session)
        if finish:
            raise finish
    return holds


def prepared(engine, future: Future) -> Session:
    """The session when it is ready. After a cancel it is closed as soon as it is, and nobody waits."""
    if not waited(engine, future):
        future.add_done_callback(lambda done: None if done.exception() else done.result().close())
        raise Cancelled
    return future.result()


def waited(engine, future: Future) -> bool:
    """Wait for the worker; False as soon as the user wants to stop."""
    while not future.done():
        if engine.test_break() or interrupted():
            return False
        wait([future], timeout=POLL)
    return True


def render_session(engine, worker, session: Session, layer: str, view: str) -> Exception | None:
    """Step to the end and show what comes. An error of the device is returned after what was rendered is kept."""
    x0, y0, x1, y1 = session.region
    width, height = x1 - x0, y1 - y0
    settings = session.settings
    with OpenResult(engine, width, height, layer, view, settings.passes, settings.named,
                    settings.matte_levels) as result:
        failure, due, stopped = None, 0.0, False
        while not stopped:
            future = worker.submit(session.step)
            if not waited(engine, future):
                session.cancel()
            try:
                progress = future.result()
            except EXPECTED as error:
                failure = error
                break
            stopped = bool(progress.why_stopped)
            now = time.perf_counter()
            # Nobody watches in the background; elsewhere showing shall cost little of the time.
            if not stopped and now >= due:
                if not bpy.app.background:
                    result.show(make_passes(session.film, ("combined",)))
                report(engine, progress, settings.time_limit)
                cost = time.perf_counter() - now
                due = now + cost + max(cost / SHOW_SHARE, 1.0 if bpy.app.background else 0.0)
        if session.film.samples:
            result.show(make_passes(session.film, settings.passes) | make_named(session.film))
    if session.film.samples and not engine.is_preview:
        stamp(engine, log.stamp_fields(session.result(), layer, partial=bool(failure)) | session.matte_metadata(layer))
    if failure and session.film.samples:
        message = f"{failure}; the {session.film.samples} samples that were done are kept"
        log.line(f"error: {message}")
        engine.report({"ERROR"}, f"Isophote: {message}")
        return None
    if not failure and not session.film.samples:
        return Cancelled()
    return failure


def report(engine, progress: Progress, time_limit: float) -> None:
    """Tell Blender how far it is."""
    done = progress.samples_done / progress.samples_total
    if time_limit > 0.0:
        done = max(done, progress.seconds / time_limit)
    if progress.error_target and progress.remaining is not None and progress.seconds > 0.0:
        done = max(done, progress.seconds / (progress.seconds + progress.remaining))
    engine.update_progress(min(done, 1.0))
    engine.update_stats("", log.progress_line(progress))
