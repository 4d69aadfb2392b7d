# SPDX-License-Identifier: GPL-3.0-or-later
"""Inside Blender: renders a short animation with the add-on's engine, one sample a pixel, and times its stages.

    blender -b --factory-startup [FILE.blend] --addons isophote_addon --python bench/export_worker.py -- '{json}'

bench/export.py starts it and says what the object means. Prints lines `ISOPHOTE-EXPORT-BENCH {json}`, one a frame.
"""

from __future__ import annotations

import importlib
import json
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

import bpy
import numpy as np

ADDON = "isophote_addon"
MARK = "ISOPHOTE-EXPORT-BENCH "
# stage -> functions, by module and name, whose time counts for it; a function inside another counts for its own
# stage only, so that stages add up to the whole but for what is not named.
STAGES = {
    "total": [(f"{ADDON}.final", "render")],
    "meshes": [],
    "export": [(f"{ADDON}.final", "export_scene")],
    "validate": [("isophote.session", "check")],
    "hash": [("isophote.session", "Session.result")],
    "prepare": [("isophote.prepare", "prepare")],
    "bvh2": [("isophote._native", "make_tree"), ("isophote._native", "refit_tree")],
    "wide": [("isophote._native", "make_wide_tree"), ("isophote._native", "refit_wide_tree")],
    "sample": [("isophote.openmp", "OpenMPDevice.render")],
    "show": [(f"{ADDON}.result", "OpenResult.show")],
}


class Stopwatch:
    """Seconds of each stage, exclusive of stages inside it."""

    def __init__(self):
        self.seconds = dict.fromkeys(STAGES, 0.0)
        self.inside = []

    def watch(self, stage: str, module: str, name: str) -> None:
        owner = importlib.import_module(module)
        *outer, name = name.split(".")
        for part in outer:
            owner = getattr(owner, part)
        if not hasattr(owner, name):
            return
        function = getattr(owner, name)

        def timed(*arguments, **named):
            with self.timing(stage):
                return function(*arguments, **named)

        setattr(owner, name, timed)

    @contextmanager
    def timing(self, stage: str):
        started, inner = time.perf_counter(), sum(self.seconds.values())
        try:
            yield
        finally:
            now = time.perf_counter()
            self.seconds[stage] += now - started - (sum(self.seconds.values()) - inner)


def make_grid(triangles: int, smooth: bool):
    """A mesh of quads, `triangles` in all once they are cut, with hills."""
    side = round((triangles / 2) ** 0.5)
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=side, y_subdivisions=side, size=4)
    ob = bpy.context.object
    count = len(ob.data.vertices)
    places = np.empty(3 * count, np.float32)
    ob.data.vertices.foreach_get("co", places)
    x, y, z = places.reshape(-1, 3).T
    z[:] = 0.3 * np.sin(3 * x) * np.cos(4 * y) + 0.01 * np.sin(60 * x) * np.sin(70 * y)
    ob.data.vertices.foreach_set("co", places)
    ob.data.polygons.foreach_set("use_smooth", [smooth] * len(ob.data.polygons))
    ob.data.update()
    return ob


def make_scene(job: dict) -> None:
    """The scene that the job names; 'file' is the one that Blender was started with."""
    if job["scene"] == "file":
        return
    for ob in list(bpy.data.objects):
        if ob.type == "MESH" and job["scene"] != "cube":
            bpy.data.objects.remove(ob)
    if job["scene"] == "cube":
        return
    ob = make_grid(job["triangles"], job["scene"] != "flat")
    if job["scene"] == "shared":
        other = ob.copy()
        other.location.z = -1.0
        bpy.context.collection.objects.link(other)


def animate(job: dict) -> None:
    """Keys that change what the job says, and nothing else, from frame to frame."""
    scene = bpy.context.scene
    meshes = [ob for ob in scene.objects if ob.type == "MESH"]
    largest = max(meshes, key=lambda ob: len(ob.data.polygons))
    if job["change"] == "deform":
        largest.modifiers.new("wave", "WAVE").speed = 0.05
        return
    moved = {"camera": scene.camera, "object": largest}[job["change"]]
    place = moved.location.copy()
    for frame in range(1, job["frames"] + 1):
        moved.location = place + 0.01 * (frame - 1) * type(place)((1.0, 0.5, 0.25))
        moved.keyframe_insert("location", frame=frame)


def tell(frame: int, **row: float) -> None:
    print(MARK + json.dumps({"frame": frame} | {name: round(seconds, 4) for name, seconds in row.items()}), flush=True)


def follow_others(scene) -> None:
    """Print a row for each frame of an engine that tells no more than that it has ended."""
    ends = []
    bpy.app.handlers.render_init.append(lambda *_: ends.append(time.perf_counter()))

    def ended(*_):
        ends.append(time.perf_counter())
        tell(scene.frame_current, whole=ends[-1] - ends[-2])

    bpy.app.handlers.render_post.append(ended)


def follow(scene) -> None:
    """Print a row for each frame of ours, with the seconds of its stages."""
    watch, ends = Stopwatch(), [time.perf_counter()]
    bpy.app.handlers.render_init.append(lambda *_: ends.append(time.perf_counter()))
    for stage, functions in STAGES.items():
        for module, name in functions:
            watch.watch(stage, module, name)
    final = importlib.import_module(f"{ADDON}.final")
    inner = final.render

    def one_frame(engine, depsgraph):
        watch.seconds = dict.fromkeys(STAGES, 0.0)
        started = time.perf_counter()
        with watch.timing("meshes"):
            for ob in depsgraph.objects:
                ob.data  # noqa: B018 - newer Blenders subdivide when the mesh is asked for
        inner(engine, depsgraph)
        ended = time.perf_counter()
        stages = {name: seconds for name, seconds in watch.seconds.items() if name != "total"}
        tell(scene.frame_current, **stages, blender=started - ends[-1], total=ended - started,
             other=watch.seconds["total"], whole=ended - ends[-1])
        ends.append(ended)

    final.render = one_frame


def main() -> None:
    job = json.loads(sys.argv[sys.argv.index("--") + 1])
    scene, folder = bpy.context.scene, tempfile.TemporaryDirectory(prefix="isophote_bench_")
    make_scene(job)
    scene.frame_start, scene.frame_end = 1, job["frames"]
    animate(job)
    render = scene.render
    render.engine, scene.isophote.samples = job["engine"], 1
    if job["engine"] == "CYCLES":
        scene.cycles.samples, scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising = 1, False, False
    render.resolution_x, render.resolution_y, render.resolution_percentage = *job["size"], 100
    render.threads_mode, render.threads = "FIXED", job["threads"]
    render.use_persistent_data = job["persistent"]
    render.use_compositing = render.use_sequencer = False
    render.image_settings.file_format = "BMP"
    render.filepath = str(Path(folder.name) / "frame_")
    follow(scene) if job["engine"] == "ISOPHOTE" else follow_others(scene)
    for _ in range(job["rounds"]):
        bpy.ops.render.render(animation=True)
    folder.cleanup()


main()
