# SPDX-License-Identifier: GPL-3.0-or-later
"""Opens Blender's own panels to the engine.

Some 300 panels work for any engine and say so by listing BLENDER_RENDER; of those that only EEVEE
lists, the ones for materials' and the world's nodes are as good for this engine.
"""

from __future__ import annotations

from collections.abc import Iterator

import bpy

ALSO = {
    "EEVEE_MATERIAL_PT_context_material",
    "EEVEE_MATERIAL_PT_surface",
    "EEVEE_WORLD_PT_surface",
    "MATERIAL_PT_preview",
}
# Panels of things that this engine does not have, and those that ui.py has its own of.
NOT = {"DATA_PT_light", "DATA_PT_falloff_curve", "EEVEE_MATERIAL_PT_viewport_settings", "RENDER_PT_stereoscopy",
       "RENDER_PT_output_views", "VIEWLAYER_PT_layer_passes", "VIEWLAYER_PT_filter"}
NOT_ABOUT = ("freestyle", "lightprobe", "gpencil", "grease_pencil", "greasepencil")


def compatible_panels() -> Iterator[type]:
    """Blender's panels that make sense for this engine."""
    todo = bpy.types.Panel.__subclasses__()
    while todo:
        panel = todo.pop()
        todo += panel.__subclasses__()
        name = panel.__name__
        if name in NOT or any(word in name.lower() for word in NOT_ABOUT):
            continue
        if name in ALSO or "BLENDER_RENDER" in getattr(panel, "COMPAT_ENGINES", ()):
            yield panel


def open_panels(engine: str) -> None:
    for panel in compatible_panels():
        panel.COMPAT_ENGINES.add(engine)


def close_panels(engine: str) -> None:
    for panel in compatible_panels():
        panel.COMPAT_ENGINES.discard(engine)
