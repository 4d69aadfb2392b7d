# SPDX-License-Identifier: GPL-3.0-or-later
"""What the render of a view layer leaves for its next frame: the geometry, of which only what changed is made anew.

Blender makes an engine for each frame, so this lives in the module. It goes when the render or the animation
ends, is cancelled, or another file is loaded; where the scene's Persistent Data is on, it stays for the next
render, as that switch promises. Together it never holds more than SHARE of the machine's memory. Pictures do
not depend on it: geometry that is used again is compared byte by byte with what was exported.
"""

from __future__ import annotations

import os

import bpy
from bpy.app.handlers import persistent

from isophote.geometry import Geometry

SHARE = 0.125
UNKNOWN_MEMORY = 8 << 30  # bytes, of a machine that does not tell how many it has

_geometries: dict[tuple[str, str], Geometry] = {}  # by names of scene and view layer


def take(scene: str, layer: str) -> Geometry | None:
    """What the last render of a view layer has left; it is kept no longer."""
    return _geometries.pop((scene, layer), None)


def keep(scene: str, layer: str, geometry: Geometry) -> None:
    """Leave it for the next frame, if there is room."""
    if sum(sum(each.bytes.values()) for each in (geometry, *_geometries.values())) <= SHARE * memory_of_machine():
        _geometries[scene, layer] = geometry


def memory_of_machine() -> int:
    """Bytes."""
    if hasattr(os, "sysconf") and "SC_PHYS_PAGES" in os.sysconf_names:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    return UNKNOWN_MEMORY


@persistent
def render_ended(scene, *_) -> None:
    if not scene.render.use_persistent_data:
        for key in [key for key in _geometries if key[0] == scene.name]:
            del _geometries[key]


@persistent
def file_loads(*_) -> None:
    _geometries.clear()


HANDLERS = (("render_complete", render_ended), ("render_cancel", render_ended), ("load_pre", file_loads))


def attach() -> None:
    for name, handler in HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def detach() -> None:
    for name, handler in HANDLERS:
        getattr(bpy.app.handlers, name).remove(handler)
    _geometries.clear()
