# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a trade report in a Blender of its own, for the add-on's button (trade.py starts it).

Arguments behind `--`: the report's FOLDER, its SECONDS, the LONGEST side in pixels, the scene's name, the report's
name, and whether to begin `anew` or to `continue`. Prints lines of TRADE_MARK and a JSON object: {"doing", "spent",
"seconds"} now and then, at the end {"page", "partial"} or {"error"}. A line on stdin, or its end, stops it in good
order: so nothing goes on when the Blender that asked has gone.
"""

from __future__ import annotations

import json
import os
import sys
import threading
from pathlib import Path

import bpy

from isophote.device import DeviceError, list_devices
from isophote.images import ImageError
from isophote.scene import SceneError, resized
from isophote.settings import Settings
from isophote.trade.job import Job
from isophote.trade.plan import reduced
from isophote.trade.report import make_report
from isophote.trade.runs import TradeError

from .exporter import render_to_scene
from .settings import device_of, own_values

TRADE_MARK = "ISOPHOTE-TRADE "
EXPECTED = (DeviceError, ImageError, SceneError, TradeError, MemoryError, OSError, ValueError)


def say(**values) -> None:
    print(TRADE_MARK + json.dumps(values), flush=True)


def make_job(folder: str, seconds: str, longest: str, scene_name: str, name: str, begin: str) -> Job:
    blender_scene = bpy.data.scenes[scene_name]
    base = Settings(**own_values(blender_scene.isophote), device=device_of(blender_scene.isophote),
                    threads=blender_scene.render.threads, film_transparent=blender_scene.render.film_transparent)
    say(doing="exporting", spent=0.0, seconds=float(seconds))
    scene, _ = render_to_scene(blender_scene)
    full = tuple(int(n) for n in scene.resolution)
    others = tuple(device.id for device in list_devices() if device.usable and device.id != base.device)
    Path(folder).mkdir(parents=True, exist_ok=True)
    return Job(resized(scene, reduced(full, int(longest))), name, full, base, Path(folder), float(seconds), others,
               anew=begin == "anew")


def main() -> None:
    """Make the report that the arguments ask for, and end the process."""
    stop = threading.Event()
    threading.Thread(target=lambda: (sys.stdin.readline(), stop.set()), daemon=True).start()
    status = 0
    try:
        job = make_job(*sys.argv[sys.argv.index("--") + 1:])
        result = make_report(job, lambda now: say(doing=now.doing, spent=now.spent, seconds=now.seconds), stop.is_set)
        say(page=result["page"], partial=result["partial"])
    except EXPECTED as error:
        say(error=str(error) or type(error).__name__)
        status = 1
    sys.stdout.flush()
    os._exit(status)  # Blender would wait for the thread that reads stdin
