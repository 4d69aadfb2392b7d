# SPDX-License-Identifier: GPL-3.0-or-later
"""Switches the add-on off and on again."""

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
import addon_utils  # noqa: E402
from common import report  # noqa: E402


def panels():
    found, todo = 0, list(bpy.types.Panel.__subclasses__())
    while todo:
        panel = todo.pop()
        todo += panel.__subclasses__()
        found += panel.is_registered and "ISOPHOTE" in getattr(panel, "COMPAT_ENGINES", ())
    return found


def engines():
    engines = bpy.types.RenderEngine.__subclasses__()
    return [getattr(cls, "bl_idname", "") for cls in engines if cls.is_registered]


def state():
    scene = bpy.context.scene
    return {"engine": "ISOPHOTE" in engines(), "scene": hasattr(scene, "isophote"), "panels": panels(),
            "object": hasattr(bpy.data.objects["Cube"], "isophote"),
            "layer": hasattr(bpy.context.view_layer, "isophote")}


name = "isophote_addon"
on = state()
addon_utils.disable(name)
off = state()
addon_utils.enable(name)
report(on=on, off=off, again=state())
