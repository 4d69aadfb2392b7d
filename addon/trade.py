# SPDX-License-Identifier: GPL-3.0-or-later
"""The trade report's button: a report of the open scene, made by another Blender in the background.

A copy of the file is saved and opened there: the interface waits for the saving only, what is unsaved counts, the
scene is evaluated as for a render (a viewport's dependency graph has other levels and hides other things), and a report
that runs out of memory takes no work with it. What the other one says comes through its stdout (run_trade.py).
"""

from __future__ import annotations

import json
import queue
import subprocess
import sys
import tempfile
import threading
from dataclasses import dataclass, field
from pathlib import Path

import bpy
from bpy.props import BoolProperty, FloatProperty, IntProperty, StringProperty

from . import log
from .run_trade import TRADE_MARK

POLL = 0.5  # seconds between looks at what the other Blender says
TAIL = 8  # lines of its log that an error shows


@dataclass
class Report:
    """A report under way or done. `doing`, `page` and `error` are what the panel shows."""

    process: subprocess.Popen
    copy: tempfile.TemporaryDirectory
    lines: queue.Queue = field(default_factory=queue.Queue)
    log: list[str] = field(default_factory=list)
    doing: str = "starting"
    share: float = 0.0
    page: str = ""
    partial: bool = False
    error: str = ""

    @property
    def running(self) -> bool:
        return not (self.page or self.error)


current: Report | None = None


def command(blend: Path, arguments: list[str]) -> list[str]:
    """This Blender without a window and without the user's add-ons but this one; its modules are found as here."""
    name = __package__
    code = (f"import sys, importlib, addon_utils; sys.path += [p for p in {sys.path!r} if p not in sys.path]; "
            f"addon_utils.enable({name!r}); importlib.import_module({name + '.run_trade'!r}).main()")
    program = [bpy.app.binary_path] if bpy.app.binary_path else [
        sys.executable, str(Path(__file__).parent / "scripts" / "blender_bpy.py")]  # the bpy module is no program
    return [*program, "-b", "--factory-startup", str(blend), "--python-expr", code, "--", *arguments]


def start(scene, folder: Path, seconds: float, longest: int, anew: bool) -> Report:
    """Save a copy of the file and let another Blender make the report. Raises OSError, RuntimeError."""
    copy = tempfile.TemporaryDirectory(prefix="isophote_trade_")
    name = Path(bpy.data.filepath).stem or "untitled"
    blend = Path(copy.name) / f"{name}.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend), copy=True, check_existing=False)
    arguments = [str(folder), str(seconds), str(longest), scene.name, name, "anew" if anew else "continue"]
    process = subprocess.Popen(command(blend, arguments), stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT, text=True, encoding="utf-8", errors="replace")
    report = Report(process, copy)
    threading.Thread(target=read, args=(report,), daemon=True).start()
    return report


def read(report: Report) -> None:
    """Pass on every line of the process, and None when it has ended."""
    for line in report.process.stdout:
        report.lines.put(line.rstrip("\n"))
    report.process.wait()
    report.lines.put(None)


def update(report: Report) -> None:
    """Take in what was said since the last look."""
    while report.running:
        try:
            line = report.lines.get_nowait()
        except queue.Empty:
            return
        if line is None:
            report.error = f"Blender ended with status {report.process.returncode}: " + " | ".join(report.log[-TAIL:])
        elif not line.startswith(TRADE_MARK):
            report.log.append(line)
        else:
            said = json.loads(line[len(TRADE_MARK):])
            report.page, report.partial = said.get("page", ""), said.get("partial", False)
            report.error = said.get("error", "")
            if "doing" in said:
                report.doing, report.share = said["doing"], min(1.0, said["spent"] / said["seconds"])


def stop(report: Report) -> None:
    """Ask the other Blender to write what it has."""
    try:
        report.process.stdin.close()
    except OSError:
        pass  # it has gone by itself


def tick() -> float | None:
    """Blender's timer: look, show, and open the page when it is there."""
    report = current
    if report is None:
        return None
    update(report)
    redraw(f"Trade report: {report.doing} ({100 * report.share:.0f} %)" if report.running else None)
    if report.running:
        return POLL
    report.copy.cleanup()
    if report.error:
        log.line(f"error: trade report: {report.error}")
    else:
        log.line(f"trade report: {report.page}")
        if not bpy.app.background:
            bpy.ops.wm.url_open(url=Path(report.page).as_uri())
    return None


def redraw(status: str | None) -> None:
    """Show a line in the status bar (None: Blender's own) and draw the panels anew."""
    for window in bpy.context.window_manager.windows:
        window.workspace.status_text_set(status)
        for area in window.screen.areas:
            if area.type == "PROPERTIES":
                area.tag_redraw()


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
            current = start(context.scene, folder, 60.0 * self.minutes, self.longest, self.anew)
        except (OSError, RuntimeError) as error:
            self.report({"ERROR"}, f"Isophote: the trade report cannot begin: {error}")
            return {"CANCELLED"}
        bpy.app.timers.register(tick, first_interval=POLL, persistent=True)
        return {"FINISHED"}


class ISOPHOTE_OT_stop_trade_report(bpy.types.Operator):
    """Write the report of what is done so far; the next one with the same settings goes on from there"""

    bl_idname = "isophote.stop_trade_report"
    bl_label = "Stop"

    @classmethod
    def poll(cls, context):
        return current is not None and current.running

    def execute(self, context):
        stop(current)
        current.doing = "stopping"
        return {"FINISHED"}


CLASSES = (ISOPHOTE_OT_trade_report, ISOPHOTE_OT_stop_trade_report)


def detach() -> None:
    """Stop a report and forget it, as the add-on goes."""
    global current
    if current is not None:
        stop(current)
        if bpy.app.timers.is_registered(tick):
            bpy.app.timers.unregister(tick)
        current = None
