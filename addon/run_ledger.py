# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures what settings cost in a Blender of its own, for the add-on's button (ledger.py starts it).

Argument: the scene's name. Makes {"ledger", "size"}.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import bpy

from isophote.bias import PAIRS, SAMPLES, checked_ledger, small
from isophote.passes import with_catchers

from . import background_job
from .exporter import render_to_scene


def ledger(arguments: list[str], stopped: Callable[[], bool]) -> dict:
    blender_scene = bpy.data.scenes[arguments[0]]
    settings = replace(background_job.settings_of(blender_scene), samples=SAMPLES, passes=("combined",))
    background_job.say_doing("exporting", 0.0)
    scene, _ = render_to_scene(blender_scene)
    settings = with_catchers(settings, scene)

    def progress(what: str) -> None:
        if stopped():
            raise ValueError("stopped")
        background_job.say_doing(what, 0.0)

    scene = small(scene)
    return {"ledger": checked_ledger(scene, settings, PAIRS, progress), "size": [int(n) for n in scene.resolution]}


def main() -> None:
    background_job.run(ledger)
