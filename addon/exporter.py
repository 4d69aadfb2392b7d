# SPDX-License-Identifier: GPL-3.0-or-later
"""A RenderEngine that only exports: asking it to render is the way to get Blender's dependency graph as evaluated for
rendering (render levels of modifiers, hide_render)."""

from __future__ import annotations

import time
import traceback

import bpy

from isophote.scene import SceneError

from .export import export_scene, middle_of_shutter, seen_from


class Exporter(bpy.types.RenderEngine):
    """Exports each view layer that is rendered; the first one counts."""

    bl_idname = "ISOPHOTE_EXPORT"
    bl_label = "Isophote export"
    scenes: list = []
    errors: list = []

    def render(self, depsgraph):
        try:
            start = time.perf_counter()
            frame = depsgraph.scene_eval.frame_current
            with middle_of_shutter(self, depsgraph):
                scene = export_scene(depsgraph, frame=frame)
            scene = seen_from(scene, self, depsgraph)
            self.scenes.append((scene, time.perf_counter() - start))
        except Exception as error:  # Blender would print it and go on
            traceback.print_exc()
            self.errors.append(str(error) or type(error).__name__)


def render_to_scene(scene):
    """(Scene, seconds) of a bpy scene: Blender renders it with the Exporter, without picture or compositor.

    Raises SceneError without a camera, RuntimeError with what went wrong inside.
    """
    if scene.camera is None:  # Blender would say so without the scene's name
        raise SceneError(f"no camera in scene '{scene.name}'")
    if not Exporter.is_registered:
        bpy.utils.register_class(Exporter)
    Exporter.scenes, Exporter.errors = [], []
    render = scene.render
    render.engine = Exporter.bl_idname
    render.use_compositing = render.use_sequencer = False
    views, render.use_border, render.use_multiview = render.use_multiview, False, False
    bpy.ops.render.render(scene=scene.name)
    if Exporter.errors:
        raise RuntimeError(Exporter.errors[0])
    if not Exporter.scenes:
        raise RuntimeError(f"scene '{scene.name}' was not exported: no view layer is on for rendering")
    exported, seconds = Exporter.scenes[0]
    if views:
        what = "of its views only the camera's own is exported"
        exported.notes.append({"kind": "scene", "name": scene.name, "what": what})
    return exported, seconds
