# SPDX-License-Identifier: GPL-3.0-or-later
"""What the render of a view layer leaves for its next frame: the geometry, of which only what changed is made anew,
and an OpenCL device with its kernels and the scene, of which it takes only what is new.

Blender makes an engine for each frame, so this lives in the module. It goes when the render or the animation
ends, is cancelled, or another file is loaded; where the scene's Persistent Data is on, it stays for the next
render, as that switch promises. All geometry together never takes more than SHARE of the machine's memory, and
one device is kept, with one scene. Pictures do not depend on it: geometry that is used again is compared byte by
byte with what was exported, or is the same array (export/changes.py).
"""

from __future__ import annotations

import os
from contextlib import suppress
from typing import TYPE_CHECKING

import bpy
from bpy.app.handlers import persistent

from isophote.device import Device, DeviceError
from isophote.session import Session
from isophote.settings import Settings

if TYPE_CHECKING:  # it needs the native module, and the add-on says what is wrong where that is missing
    from isophote.geometry import Geometry

SHARE = 0.125
UNKNOWN_MEMORY = 8 << 30  # bytes, of a machine that does not tell how many it has

_geometries: dict[tuple[str, str], Geometry] = {}  # by names of scene and view layer
_devices: list[Device] = []  # never more than one: they might share a GPU's memory


def take(scene: str, layer: str, settings: Settings) -> tuple[Geometry | None, Device | None]:
    """What the last render of a view layer has left, and a device for these settings; they are kept no longer."""
    device = _devices.pop() if _devices and _devices[0].take_up(settings) else None
    close_device()
    return _geometries.pop((scene, layer), None), device


def keep(scene: str, layer: str, session: Session) -> bool:
    """Leave a session's geometry and device for the next frame, if there is room; False where there is not."""
    geometry = session.prepared.geometry
    if sum(sum(each.bytes.values()) for each in (geometry, *_geometries.values())) > SHARE * memory_of_machine():
        return False
    _geometries[scene, layer] = geometry
    close_device()
    device = session.leave()
    if device:
        _devices.append(device)
    return True


def close_device() -> None:
    while _devices:
        with suppress(DeviceError):  # it has done its work
            _devices.pop().close()


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
        close_device()


@persistent
def file_loads(*_) -> None:
    _geometries.clear()
    close_device()


HANDLERS = (("render_complete", render_ended), ("render_cancel", render_ended), ("load_pre", file_loads))


def attach() -> None:
    for name, handler in HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def detach() -> None:
    for name, handler in HANDLERS:
        getattr(bpy.app.handlers, name).remove(handler)
    file_loads()
