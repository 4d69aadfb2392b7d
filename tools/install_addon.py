# SPDX-License-Identifier: Apache-2.0
"""Installs what `make extension` built into the Blender that is installed here, and switches it on.

    python tools/install_addon.py [BLENDER]      (a program, or a Python with the bpy wheel)
"""

from __future__ import annotations

import subprocess
import sys

from blender_run import ROOT, find_program, program

DIST = ROOT / "dist"
DONE = "Isophote is installed as"


def newest(pattern: str) -> str:
    found = sorted(DIST.glob(pattern), key=lambda path: path.stat().st_mtime)
    if not found:
        sys.exit(f"dist/ holds no {pattern}: make extension builds it")
    return str(found[-1])


def main() -> int:
    command = program(sys.argv[1]) if len(sys.argv) > 1 else find_program()
    if command is None:
        print("No Blender on PATH, ISOPHOTE_BLENDER is not set and there is no bpy wheel here", file=sys.stderr)
        return 1
    script = ROOT / "addon" / "scripts" / "install_inside_blender.py"
    zips = newest("isophote-*-linux-x64.zip"), newest("isophote-*-blender-3.4.zip")
    done = subprocess.run([*command, "-b", "--python", str(script), "--", *zips], text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT)
    if DONE not in done.stdout:  # Blender exits 0 after errors in scripts
        print(done.stdout, file=sys.stderr)
        return 1
    print(next(line for line in done.stdout.splitlines() if DONE in line))
    return 0


if __name__ == "__main__":
    sys.exit(main())
