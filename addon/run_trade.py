# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a trade report in a Blender of its own, for the add-on's button (trade.py starts it).

Arguments: the report's FOLDER, its SECONDS, the LONGEST side in pixels, the scene's name, the report's name, and
whether to begin `anew` or to `continue`. Makes {"page", "partial"}.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy

from isophote.device import list_devices
from isophote.passes import with_catchers
from isophote.scene import resized
from isophote.trade.job import Job
from isophote.trade.plan import reduced
from isophote.trade.report import make_report

from . import background_job
from .exporter import render_to_scene


def make_job(folder: str, seconds: str, longest: str, scene_name: str, name: str, begin: str) -> Job:
    blender_scene = bpy.data.scenes[scene_name]
    base = background_job.settings_of(blender_scene)
    background_job.say_doing("exporting", 0.0)
    scene, _ = render_to_scene(blender_scene)
    base = with_catchers(base, scene)
    full = tuple(int(n) for n in scene.resolution)
    others = tuple(device.id for device in list_devices() if device.usable and device.id != base.device)
    Path(folder).mkdir(parents=True, exist_ok=True)
    return Job(resized(scene, reduced(full, int(longest))), name, full, base, Path(folder), float(seconds), others,
               anew=begin == "anew")


def report(arguments: list[str], stopped: Callable[[], bool]) -> dict:
    job = make_job(*arguments)
    result = make_report(job, lambda now: background_job.say_doing(now.doing, now.spent / now.seconds), stopped)
    return {"page": str(result["page"]), "partial": result["partial"]}


def main() -> None:
    background_job.run(report)
