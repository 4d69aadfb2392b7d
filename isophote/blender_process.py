"""Starts Blender, or Python with the bpy wheel, to turn a .blend file into a scene file.

Blender exits 0 after many failures, and goes on with its start-up scene where a file cannot be read.
So success is not the exit status, but a line `ISOPHOTE-EXPORT {json}` that names the file which was
exported, and a scene file that is there.
"""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from isophote.files import replacing

MARK = "ISOPHOTE-EXPORT "
# A .blend is plain, gzip (before 3.0) or Zstandard (3.0 and newer).
BLEND_MAGIC = (b"BLENDER", b"\x1f\x8b", b"\x28\xb5\x2f\xfd")
LOG_TAIL = 15  # lines of the log that an error message shows


class BlenderError(RuntimeError):
    """No Blender, or an export that failed; the message names the file and where the log lies."""


@dataclass(frozen=True)
class Blender:
    """What runs the export: `program` is Blender, or a Python that has the bpy wheel."""

    program: str
    is_wheel: bool

    def command(self, script: Path, blend: Path, arguments: list[str]) -> list[str]:
        if self.is_wheel:
            return [self.program, str(script), str(blend), *arguments]
        return [self.program, "-b", str(blend), "--python-exit-code", "1", "--python", str(script), "--", *arguments]


def find_blender(program: str | None = None) -> Blender:
    """The Blender named, else that of ISOPHOTE_BLENDER, else `blender` on PATH, else the bpy wheel of this Python.

    A name that ends in python, python3 or the like is taken for a Python with the wheel. Raises BlenderError.
    """
    for name, source in ((program, "--blender"), (os.environ.get("ISOPHOTE_BLENDER"), "ISOPHOTE_BLENDER")):
        if name:
            found = shutil.which(name)
            if found is None:
                raise BlenderError(f"{source}: no program {name}")
            return Blender(found, Path(found).name.startswith("python"))
    found = shutil.which("blender")
    if found:
        return Blender(found, False)
    if importlib.util.find_spec("bpy"):
        return Blender(sys.executable, True)
    raise BlenderError("no Blender: a .blend file needs --blender PROGRAM, ISOPHOTE_BLENDER, `blender` on the PATH "
                       "or the bpy wheel (pip install bpy)")


def export_script() -> Path:
    """addon/run_export.py: beside this package, or in the folder that ISOPHOTE_ADDON names. Raises BlenderError."""
    folder = Path(os.environ.get("ISOPHOTE_ADDON") or Path(__file__).resolve().parents[1] / "addon")
    script = folder / "run_export.py"
    if not script.is_file():
        raise BlenderError(f"{script}: no such file; ISOPHOTE_ADDON names the folder of the add-on")
    return script


def check_blend(path: Path) -> None:
    """Raise BlenderError where `path` is no readable .blend file by its first bytes."""
    try:
        with open(path, "rb") as file:
            head = file.read(8)
    except OSError as error:
        raise BlenderError(f"{path}: {error.strerror}") from error
    if not head.startswith(BLEND_MAGIC):
        raise BlenderError(f"{path}: not a .blend file")


def export_blend(path: str | Path, out_npz: str | Path, frame: int | None = None, size: tuple[int, int] | None = None,
                 blender: str | None = None, on_line: Callable[[str], None] | None = None) -> dict:
    """Export a frame of a .blend file into a scene file, and return the exporter's report (its JSON line).

    `frame` and `size` (pixels) default to the file's own; `on_line` gets Blender's output as it comes.
    The scene file appears whole or not at all. Raises BlenderError.
    """
    path, out_npz = Path(path), Path(out_npz)
    check_blend(path)
    runner, script = find_blender(blender), export_script()
    try:
        with replacing(out_npz) as temporary:
            arguments = [str(temporary.absolute())]
            if frame is not None:
                arguments += ["--frame", str(frame)]
            if size is not None:
                arguments += ["--size", f"{size[0]}x{size[1]}"]
            status, lines = run(runner.command(script, path.absolute(), arguments), on_line)
            report, why = judge(status, lines, path, temporary)
            if why:
                raise BlenderError(f"{path}: export failed: {why}\n{kept_log(lines)}")
            return report
    except OSError as error:
        raise BlenderError(f"{path}: export failed: {error}") from error


def run(command: list[str], on_line: Callable[[str], None] | None) -> tuple[int, list[str]]:
    """Exit status and lines of a process. It does not outlive this call, whatever interrupts it."""
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                               text=True, encoding="utf-8", errors="replace")
    lines = []
    try:
        for line in process.stdout:
            lines.append(line.rstrip("\n"))
            if on_line:
                on_line(lines[-1])
        return process.wait(), lines
    finally:
        if process.poll() is None:
            process.terminate()
            process.wait()


def judge(status: int, lines: list[str], blend: Path, scene: Path) -> tuple[dict, str]:
    """The exporter's report, and why the export failed ("" where it did not)."""
    marked = [line[len(MARK):] for line in lines if line.startswith(MARK)]
    try:
        report = json.loads(marked[-1]) if marked else {}
    except ValueError as error:
        return {}, f"its report cannot be read ({error})"
    if not isinstance(report, dict):
        return {}, "its report is no object"
    if report.get("error"):
        return report, str(report["error"])
    if status != 0:
        return report, f"Blender ended with status {status}" if status > 0 else f"Blender was ended by signal {-status}"
    if not marked:
        return report, "Blender ended without a report"
    if not scene.is_file() or scene.stat().st_size == 0:  # it was there before, empty
        return report, "Blender wrote no scene"
    exported = report.get("file")
    if exported and Path(exported).resolve() != blend.resolve():
        return report, f"Blender exported {exported} instead"
    return report, ""


def kept_log(lines: list[str]) -> str:
    """Write the log to a file that stays; its place and last lines for the error message."""
    with tempfile.NamedTemporaryFile("w", prefix="isophote_export_", suffix=".log", delete=False,
                                     encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")
    return "\n".join([*(f"  | {line}" for line in lines[-LOG_TAIL:]), f"  log: {file.name}"])
