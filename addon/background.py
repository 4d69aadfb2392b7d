# SPDX-License-Identifier: GPL-3.0-or-later
"""Work on the open scene that another Blender does in the background: trade reports, measured ledgers.

A copy of the file is saved and opened there: the interface waits for the saving only, what is unsaved counts, the
scene is evaluated as for a render (a viewport's dependency graph has other levels and hides other things), and work
that runs out of memory takes nothing with it. What the other one says comes through its stdout (background_job.py).
"""

from __future__ import annotations

import json
import queue
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import bpy

from .background_job import MARK

POLL = 0.5  # seconds between looks at what the other Blender says
TAIL = 8  # lines of its log that an error shows


@dataclass
class Task:
    """Work under way or done. `doing` and `error` are what panels show, `made` is what came of it."""

    process: subprocess.Popen
    copy: tempfile.TemporaryDirectory
    lines: queue.Queue = field(default_factory=queue.Queue)
    log: list[str] = field(default_factory=list)
    doing: str = "starting"
    share: float = 0.0
    made: dict = field(default_factory=dict)
    error: str = ""

    @property
    def running(self) -> bool:
        return not (self.made or self.error)

    @property
    def percent(self) -> str:
        """How much is done, to stand behind `doing`."""
        return f" ({100 * self.share:.0f} %)" if self.share else ""


def file_name() -> str:
    """The open file's name without its ending."""
    return Path(bpy.data.filepath).stem or "untitled"


def command(module: str, blend: Path, arguments: list[str]) -> list[str]:
    """This Blender without a window and without the user's add-ons but this one; its modules are found as here."""
    name = __package__
    code = (f"import sys, importlib, addon_utils; sys.path += [p for p in {sys.path!r} if p not in sys.path]; "
            f"addon_utils.enable({name!r}); importlib.import_module({f'{name}.{module}'!r}).main()")
    program = [bpy.app.binary_path] if bpy.app.binary_path else [
        sys.executable, str(Path(__file__).parent / "scripts" / "blender_bpy.py")]  # the bpy module is no program
    return [*program, "-b", "--factory-startup", str(blend), "--python-expr", code, "--", *arguments]


def start(module: str, arguments: list[str]) -> Task:
    """Save a copy of the file and let another Blender run `main` of a module of this add-on on it.

    Raises OSError, RuntimeError.
    """
    copy = tempfile.TemporaryDirectory(prefix="isophote_")
    blend = Path(copy.name) / f"{file_name()}.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend), copy=True, check_existing=False)
    process = subprocess.Popen(command(module, blend, arguments), stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT, text=True, encoding="utf-8", errors="replace")
    task = Task(process, copy)
    threading.Thread(target=read, args=(task,), daemon=True).start()
    return task


def read(task: Task) -> None:
    """Pass on every line of the process, and None when it has ended."""
    for line in task.process.stdout:
        task.lines.put(line.rstrip("\n"))
    task.process.wait()
    task.lines.put(None)


def update(task: Task) -> None:
    """Take in what was said since the last look."""
    while task.running:
        try:
            line = task.lines.get_nowait()
        except queue.Empty:
            return
        if line is None:
            task.error = f"Blender ended with status {task.process.returncode}: " + " | ".join(task.log[-TAIL:])
        elif not line.startswith(MARK):
            task.log.append(line)
        else:
            said = json.loads(line[len(MARK):])
            task.error = said.get("error", "")
            if "doing" in said:
                task.doing, task.share = said["doing"], said["share"]
            elif not task.error:
                task.made = said


def stop(task: Task) -> None:
    """Ask the other Blender to end in good order."""
    try:
        task.process.stdin.close()
    except OSError:
        pass  # it has gone by itself


def look(task: Task, what: str, ended: Callable[[Task], None]) -> float | None:
    """For Blender's timers: show how far the task is; once it is done call `ended` and let the timer end."""
    update(task)
    redraw(f"{what}: {task.doing}{task.percent}" if task.running else None)
    if task.running:
        return POLL
    task.copy.cleanup()
    ended(task)
    return None


def forget(task: Task | None, tick: Callable[[], float | None]) -> None:
    """Stop a task and its timer, as the add-on goes."""
    if task is not None:
        stop(task)
        if bpy.app.timers.is_registered(tick):
            bpy.app.timers.unregister(tick)


def redraw(status: str | None) -> None:
    """Show a line in the status bar (None: Blender's own) and draw the panels anew."""
    for window in bpy.context.window_manager.windows:
        window.workspace.status_text_set(status)
        for area in window.screen.areas:
            if area.type == "PROPERTIES":
                area.tag_redraw()
