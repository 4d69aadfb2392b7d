# SPDX-License-Identifier: GPL-3.0-or-later
"""What settings cost, for the panel: as the last render of each scene said, or as measured by another Blender in the
background. Gone with Blender."""

from __future__ import annotations

import bpy

from isophote.ledger import ledger_lines

from . import background, log
from .log import taken

_sentences: dict[str, list[str]] = {}  # by name of the scene
current: background.Task | None = None
measured = ""  # the scene of `current`


def keep(scene: str, result: dict) -> None:
    """Keep the ledger of a render; `result` is Session.result()."""
    _sentences[scene] = ledger_lines(taken(result))


def sentences(scene: str) -> list[str]:
    """Of the scene's last render or measurement, none before it."""
    return _sentences.get(scene, [])


def ended(task: background.Task) -> None:
    if task.error:
        log.line(f"error: what settings cost: {task.error}")
        return
    keep(measured, task.made)
    width, height = task.made["size"]
    _sentences[measured].append(f"Measured on pictures of {width} x {height} pixels")
    for sentence in sentences(measured):
        log.line(f"ledger: {sentence}")


def tick() -> float | None:
    """Blender's timer."""
    return background.look(current, "What settings cost", ended) if current else None


class ISOPHOTE_OT_measure_ledger(bpy.types.Operator):
    """Measure how much light each setting takes from this scene, by pairs of small pictures, in the background"""

    bl_idname = "isophote.measure_ledger"
    bl_label = "Measure"

    @classmethod
    def poll(cls, context):
        return context.scene.camera is not None and not (current and current.running)

    def execute(self, context):
        global current, measured
        try:
            current, measured = background.start("run_ledger", [context.scene.name]), context.scene.name
        except (OSError, RuntimeError) as error:
            self.report({"ERROR"}, f"Isophote: what settings cost cannot be measured: {error}")
            return {"CANCELLED"}
        bpy.app.timers.register(tick, first_interval=background.POLL, persistent=True)
        return {"FINISHED"}


CLASSES = (ISOPHOTE_OT_measure_ledger,)


def detach() -> None:
    """Stop measuring and forget it, as the add-on goes."""
    global current
    background.forget(current, tick)
    current = None
