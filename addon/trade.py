# SPDX-License-Identifier: GPL-3.0-or-later
"""The trade report's button: a report of the open scene, made by another Blender in the background."""

from __future__ import annotations

import tempfile
from pathlib import Path

import bpy
from bpy.props import BoolProperty, FloatProperty, IntProperty, StringProperty

from . import background, log

current: background.Task | None = None


def ended(report: background.Task) -> None:
    """Say where the page is, and open it."""
    if report.error:
        log.line(f"error: trade report: {report.error}")
        return
    log.line(f"trade report: {report.made['page']}")
    if not bpy.app.background:
        bpy.ops.wm.url_open(url=Path(report.made["page"]).as_uri())


def tick() -> float | None:
    """Blender's timer."""
    return background.look(current, "Trade report", ended) if current else None


def default_folder() -> str:
    """Beside the file; for one that was never saved, in the folder for temporary files."""
    if bpy.data.filepath:
        return f"//trade_{Path(bpy.data.filepath).stem}"
    return str(Path(tempfile.gettempdir()) / "isophote_trade_untitled")


class ISOPHOTE_OT_trade_report(bpy.types.Operator):
    """Measure what samples, bounces, clamping and precision buy and cost in this scene, in the background"""

    bl_idname = "isophote.trade_report"
    bl_label = "Make Trade Report"

    minutes: FloatProperty(name="Minutes", description="Time that the report may take", default=10.0, min=0.1,
                           soft_max=120.0)
    longest: IntProperty(name="Size", description="Longer side of the report's pictures", default=256, min=16,
                         soft_max=1024, subtype="PIXEL")
    folder: StringProperty(name="Folder", description="Where the report goes; empty for a folder beside the file",
                           subtype="DIR_PATH")
    anew: BoolProperty(name="Begin Anew", description="Forget a report of another state of the scene that lies there")

    @classmethod
    def poll(cls, context):
        return context.scene.camera is not None and not (current and current.running)

    def invoke(self, context, event):
        self.folder = default_folder()
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context):
        global current
        folder = Path(bpy.path.abspath(self.folder or default_folder()))
        try:
            current = background.start("run_trade", [
                str(folder), str(60.0 * self.minutes), str(self.longest), context.scene.name, background.file_name(),
                "anew" if self.anew else "continue"])
        except (OSError, RuntimeError) as error:
            self.report({"ERROR"}, f"Isophote: the trade report cannot begin: {error}")
            return {"CANCELLED"}
        bpy.app.timers.register(tick, first_interval=background.POLL, persistent=True)
        return {"FINISHED"}


class ISOPHOTE_OT_stop_trade_report(bpy.types.Operator):
    """Write the report of what is done so far; the next one with the same settings goes on from there"""

    bl_idname = "isophote.stop_trade_report"
    bl_label = "Stop"

    @classmethod
    def poll(cls, context):
        return current is not None and current.running

    def execute(self, context):
        background.stop(current)
        current.doing = "stopping"
        return {"FINISHED"}


CLASSES = (ISOPHOTE_OT_trade_report, ISOPHOTE_OT_stop_trade_report)


def detach() -> None:
    """Stop a report and forget it, as the add-on goes."""
    global current
    background.forget(current, tick)
    current = None
