# SPDX-License-Identifier: Apache-2.0
"""Renders blend_scenes/cornell_box.blend in Blender with the add-on of this tree, and says where it is.

    python tools/demo.py [FILE.blend]
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

from blender_run import ADDON, ROOT, environment, find_program
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

OUT = ROOT / "out"
LOG_LINES = 15


def main() -> int:
    blend = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "blend_scenes" / "cornell_box.blend"
    command = find_program()
    if command is None:
        print("No Blender on PATH, and no bpy wheel for this Python: the demo needs one of them", file=sys.stderr)
        return 1
    OUT.mkdir(exist_ok=True)
    console = Console(highlight=False, soft_wrap=True)
    console.print(f"Rendering {blend} with {command[0]}", markup=False)
    script = ROOT / "addon" / "scripts" / "demo_inside_blender.py"
    command += ["-b", str(blend), "--addons", ADDON, "--python", str(script),
                "--", str(OUT / blend.stem)]
    status, lines = run(command, console)
    missing = [f"{OUT / blend.stem}{suffix}" for suffix in (".png", ".exr")
               if f"Demo: wrote {OUT / blend.stem}{suffix}" not in lines]
    if status != 0 or missing or any(line.startswith("Isophote: error") for line in lines):
        print("\n".join(lines[-LOG_LINES:]), file=sys.stderr)
        print(f"The demo failed (status {status}); not written: {', '.join(missing) or 'nothing'}", file=sys.stderr)
        return 1
    for suffix in (".png", ".exr"):
        console.print(f"{suffix[1:].upper()}  {OUT / blend.stem}{suffix}", markup=False)
    return 0


def run(command: list[str], console: Console) -> tuple[int, list[str]]:
    """Status and lines of Blender; its progress as a bar, what Isophote says as it comes."""
    lines = []
    with Progress(TextColumn("{task.description}", markup=False), BarColumn(), console=console,
                  disable=not console.is_terminal) as bar:
        task = bar.add_task("starting Blender", total=None)
        process = subprocess.Popen(command, env=environment(), text=True, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        for line in process.stdout:
            lines.append(line.rstrip("\n"))
            progress = re.search(r"Sample (\d+)/(\d+).*", lines[-1])
            if progress:
                bar.update(task, completed=int(progress[1]), total=int(progress[2]), description=progress[0])
                if not console.is_terminal:
                    console.print(progress[0], markup=False)
            elif lines[-1].startswith("Isophote:"):
                console.print(lines[-1], markup=False)
    return process.wait(), lines


if __name__ == "__main__":
    sys.exit(main())
