# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports a .blend file to Isophote's .npz, inside Blender or the bpy module.

    blender -b FILE --python addon/run_export.py -- OUT.npz [--frame N] [--size WxH]
    python addon/run_export.py FILE OUT.npz [--frame N] [--size WxH]

Prints one line, ISOPHOTE-EXPORT and a JSON object; exits with 1 after an error.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from addon import properties  # noqa: E402
from addon.exporter import render_to_scene  # noqa: E402
from addon.settings import file_settings  # noqa: E402
from isophote.scene import save_scene  # noqa: E402


def parse(arguments: list[str], with_file: bool) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="run_export.py", description="Export a .blend file to .npz.")
    if with_file:
        parser.add_argument("file")
    parser.add_argument("out")
    parser.add_argument("--frame", type=int)
    parser.add_argument("--size", help="WIDTHxHEIGHT in pixels")
    return parser.parse_args(arguments)


def run(options: argparse.Namespace) -> dict:
    """Set up the scene, export it and write OUT; what is printed comes back. Raises what goes wrong."""
    if getattr(options, "file", None):
        bpy.ops.wm.open_mainfile(filepath=options.file)
    scene = bpy.context.scene
    render = scene.render
    if options.size:
        render.resolution_x, render.resolution_y = (int(n) for n in options.size.lower().split("x"))
        render.resolution_percentage = 100
    if options.frame is not None:
        scene.frame_set(options.frame)
    if not hasattr(bpy.types.Scene, "isophote"):  # the add-on may be enabled already
        for cls in properties.CLASSES:
            bpy.utils.register_class(cls)
        properties.attach()
    wanted = file_settings(scene)
    exported, seconds = render_to_scene(scene)
    exported.settings = wanted
    save_scene(exported, options.out)
    return {
        "ok": True,
        "error": None,
        "seconds": round(seconds, 4),
        "triangles": len(exported.triangles),
        "instances": len(exported.instance_mesh),
        "notes": len(exported.notes),
        "file": bpy.data.filepath,
    }


def main() -> int:
    inside = "--" in sys.argv  # of the Blender program
    arguments = sys.argv[sys.argv.index("--") + 1:] if inside else sys.argv[1:]
    options = parse(arguments, with_file=not inside)
    try:
        result = run(options)
    except Exception as error:
        result = {"ok": False, "error": str(error).strip(), "seconds": 0.0, "triangles": 0, "instances": 0, "notes": 0}
    print("ISOPHOTE-EXPORT", json.dumps(result), flush=True)
    return 0 if result["ok"] else 1


if __name__ == "__main__":
    status = main()
    sys.stdout.flush()
    os._exit(status)  # the bpy module sometimes hangs while it is torn down after a render
