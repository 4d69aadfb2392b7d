# SPDX-License-Identifier: GPL-3.0-or-later
"""The render engine as Blender sees it. It only delegates."""

from __future__ import annotations

import bpy

from . import final, result


class IsophoteRenderEngine(bpy.types.RenderEngine):
    """A path tracer on OpenMP and OpenCL."""

    bl_idname = "ISOPHOTE"
    bl_label = "Isophote"
    bl_use_preview = True
    bl_use_eevee_viewport = True  # for the material preview
    bl_use_shading_nodes_custom = False  # the nodes are those of Cycles and EEVEE

    changes = None  # export.changes.Changes, where the engine lives on after a frame (Persistent Data)

    def update_render_passes(self, scene, renderlayer):
        result.register_passes(self, scene, renderlayer)

    def render(self, depsgraph):
        final.render(self, depsgraph)


CLASSES = (IsophoteRenderEngine,)
