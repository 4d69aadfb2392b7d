# SPDX-License-Identifier: GPL-3.0-or-later
"""Registers everything with Blender, and takes it back in the opposite order."""

from __future__ import annotations

import bpy

from . import engine, kept, ledger, operators, panels, properties, trade, ui

MODULES = (properties, operators, trade, ledger, engine, ui)


def register() -> None:
    for module in MODULES:
        for cls in module.CLASSES:
            bpy.utils.register_class(cls)
    properties.attach()
    kept.attach()
    panels.open_panels(engine.IsophoteRenderEngine.bl_idname)


def unregister() -> None:
    panels.close_panels(engine.IsophoteRenderEngine.bl_idname)
    trade.detach()
    ledger.detach()
    kept.detach()
    properties.detach()
    for module in reversed(MODULES):
        for cls in reversed(module.CLASSES):
            bpy.utils.unregister_class(cls)
