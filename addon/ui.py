# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine's panels."""

from __future__ import annotations

import textwrap
from pathlib import Path

import bpy

from . import ledger, left_out, native, trade
from .compat import shadow_switch
from .operators import ISOPHOTE_OT_copy_cycles_settings as CopyCycles
from .operators import ISOPHOTE_OT_find_devices as FindDevices
from .result import KINDS

UNTIL_THEN = "Rendering the scene will tell"
SHOWN = 20  # notes of a panel
LETTER, MARGIN = 7.0, 60.0  # pixels of a letter and around a panel's text, where Blender's scale is 1


def say(column, context, text: str, icon: str = "NONE") -> None:
    """A text in as many lines as the width of the editor needs."""
    width = context.region.width / context.preferences.system.ui_scale
    for number, part in enumerate(textwrap.wrap(text, max(12, int((width - MARGIN) / LETTER)))):
        column.label(text=part, icon="BLANK1" if number and icon != "NONE" else icon)


class PanelBase:
    """A panel of the properties editor that belongs to this engine."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {"ISOPHOTE"}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES

    def column(self):
        """Labels left, values right, as in Blender's own panels."""
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        return self.layout.column()


class ISOPHOTE_PT_sampling(PanelBase, bpy.types.Panel):
    bl_label = "Sampling"

    def draw(self, context):
        column, own = self.column(), context.scene.isophote
        problem = native.problem()
        if problem:
            say(column, context, f"This render engine cannot be used: {problem}", "ERROR")
        column.prop(own, "samples")
        column.prop(own, "time_limit")
        column.prop(own, "error_percent")
        adaptive = column.row()
        adaptive.active = own.error_percent > 0.0
        adaptive.prop(own, "adaptive")
        column.prop(own, "seed")
        column.operator(CopyCycles.bl_idname)


class ISOPHOTE_PT_device(PanelBase, bpy.types.Panel):
    bl_label = "Device and Precision"

    def draw(self, context):
        column, own = self.column(), context.scene.isophote
        column.prop(own, "device")
        if own.device == "opencl":
            column.prop(own, "opencl_device")
            column.prop(own, "wait_for_kernels")
            self.draw_found(column)
        column.prop(own, "precision")
        if own.precision == "reference" and own.device != "openmp":
            column.label(text="Reference is for the CPU only", icon="ERROR")

    def draw_found(self, column):
        """The devices that were found, with the reason where one cannot be used."""
        column.operator(FindDevices.bl_idname)
        for device in FindDevices.found or ():
            icon = "CHECKMARK" if device.usable else "ERROR"
            column.label(text=f"{device.id}: {device.name} {device.driver} {device.why_not}", icon=icon)


class ISOPHOTE_PT_bounces(PanelBase, bpy.types.Panel):
    bl_label = "Bounces"

    def draw(self, context):
        column, own = self.column(), context.scene.isophote
        column.prop(own, "max_bounces")
        column = self.layout.column(align=True)
        for kind in ("diffuse", "glossy", "transmission", "transparent"):
            column.prop(own, f"{kind}_bounces")


class ISOPHOTE_PT_clamping(PanelBase, bpy.types.Panel):
    bl_label = "Clamping"
    bl_parent_id = "ISOPHOTE_PT_bounces"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        column, own = self.column(), context.scene.isophote
        column.prop(own, "clamp_direct")
        column.prop(own, "clamp_indirect")


class ISOPHOTE_PT_ledger(PanelBase, bpy.types.Panel):
    bl_label = "What Settings Cost"
    bl_parent_id = "ISOPHOTE_PT_bounces"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        column = self.layout.column(align=True)
        for sentence in ledger.sentences(context.scene.name) or [UNTIL_THEN]:
            say(column, context, sentence)
        task = ledger.current
        if task and task.running:
            column.label(text=f"Measuring: {task.doing}")
            return
        if task and task.error:
            say(column, context, task.error, "ERROR")
        column.operator(ledger.ISOPHOTE_OT_measure_ledger.bl_idname)


class ISOPHOTE_PT_left_out(PanelBase, bpy.types.Panel):
    bl_label = "Left Out"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context):
        notes = left_out.lines(context.scene.name, context.view_layer.name)
        if notes:
            self.layout.label(text=str(len(notes)), icon="ERROR")

    def draw(self, context):
        column = self.layout.column(align=True)
        notes = left_out.lines(context.scene.name, context.view_layer.name)
        for note in ([UNTIL_THEN] if notes is None else notes or ["Nothing"])[:SHOWN]:
            say(column, context, note, "DOT" if notes else "NONE")
        if notes and len(notes) > SHOWN:
            column.label(text=f"and {len(notes) - SHOWN} more, which are in the log", icon="BLANK1")


class ISOPHOTE_PT_film(PanelBase, bpy.types.Panel):
    bl_label = "Film"

    def draw(self, context):
        column = self.column()
        column.prop(context.scene.isophote, "filter_width")
        column.prop(context.scene.render, "film_transparent", text="Transparent")


class ISOPHOTE_PT_performance(PanelBase, bpy.types.Panel):
    bl_label = "Performance"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        column, render = self.column(), context.scene.render
        column.prop(render, "threads_mode")
        sub = column.column()
        sub.enabled = render.threads_mode == "FIXED"
        sub.prop(render, "threads")
        column.prop(render, "use_persistent_data")


class ISOPHOTE_PT_trade(PanelBase, bpy.types.Panel):
    bl_label = "Trade Report"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        column, report = self.layout.column(), trade.current
        if report is None or not report.running:
            column.label(text="What do samples, bounces and clamping buy here?")
            column.operator(trade.ISOPHOTE_OT_trade_report.bl_idname)
        if report is None:
            return
        if report.running:
            column.label(text=f"{100 * report.share:.0f} %: {report.doing}", icon="TIME")
            column.operator(trade.ISOPHOTE_OT_stop_trade_report.bl_idname, icon="CANCEL")
        elif report.error:
            say(column, context, report.error, "ERROR")
        else:
            text = "Open Report (stopped early)" if report.made["partial"] else "Open Report"
            column.operator("wm.url_open", text=text, icon="URL").url = Path(report.made["page"]).as_uri()


class ISOPHOTE_PT_passes(PanelBase, bpy.types.Panel):
    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context):
        layer = context.view_layer
        column = self.column()
        column.prop(layer, "use_pass_z")
        column.prop(layer, "use_pass_normal")
        column.prop(layer, "use_pass_position")
        column.prop(layer, "use_pass_uv")
        column.prop(layer, "use_pass_mist")
        column.prop(layer, "use_pass_object_index")
        column.prop(layer, "use_pass_material_index")
        column = self.layout.column(align=True)
        if hasattr(layer, "cycles"):
            column.prop(layer.cycles, "denoising_store_passes", text="Denoising Data")
            column.prop(layer.cycles, "use_pass_shadow_catcher")
        column.prop(layer.isophote, "albedo")
        column.prop(layer.isophote, "sample_count")
        column.prop(layer.isophote, "invalid")
        column.prop(layer.isophote, "error")


class ISOPHOTE_PT_light_passes(PanelBase, bpy.types.Panel):
    bl_label = "Light"
    bl_context = "view_layer"
    bl_parent_id = "ISOPHOTE_PT_passes"

    def draw(self, context):
        layer, column = context.view_layer, self.column()
        for kind in KINDS:
            row = column.row(heading=kind.title(), align=True)
            for of in ("direct", "indirect", "color"):
                row.prop(layer, f"use_pass_{kind}_{of}", text=of.title(), toggle=True)
        column.prop(layer, "use_pass_emit")
        column.prop(layer, "use_pass_environment")
        column.prop(layer, "use_pass_ambient_occlusion", text="Ambient Occlusion")


class ISOPHOTE_PT_cryptomatte(PanelBase, bpy.types.Panel):
    bl_label = "Cryptomatte"
    bl_context = "view_layer"
    bl_parent_id = "ISOPHOTE_PT_passes"

    def draw(self, context):
        layer, column = context.view_layer, self.column()
        for kind in ("object", "material", "asset"):
            column.prop(layer, f"use_pass_cryptomatte_{kind}", text=kind.title())
        column.prop(layer, "pass_cryptomatte_depth", text="Levels")


class ListOfLayer(PanelBase):
    """Things that a view layer lists, to add to and to remove from: shown by a UIList, `items` of an `item`."""

    bl_context = "view_layer"
    bl_parent_id = "ISOPHOTE_PT_passes"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layer, row = context.view_layer, self.layout.row()
        row.template_list(self.shown_by, self.items, layer, self.items, layer, f"active_{self.item}_index", rows=2)
        column = row.column(align=True)
        column.operator(f"scene.view_layer_add_{self.item}", icon="ADD", text="")
        column.operator(f"scene.view_layer_remove_{self.item}", icon="REMOVE", text="")


class ISOPHOTE_PT_aovs(ListOfLayer, bpy.types.Panel):
    bl_label = "Shader AOV"
    shown_by, items, item = "VIEWLAYER_UL_aov", "aovs", "aov"


class ISOPHOTE_PT_light_groups(ListOfLayer, bpy.types.Panel):
    bl_label = "Light Groups"
    shown_by, items, item = "UI_UL_list", "lightgroups", "lightgroup"


class LightGroupOf(PanelBase):
    """The group of a thing that gives light."""

    bl_label = "Light Group"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and getattr(context, cls.bl_context) is not None

    def draw(self, context):
        thing = getattr(context, self.bl_context)
        self.column().prop_search(thing, "lightgroup", context.view_layer, "lightgroups", text="Light Group")


class ISOPHOTE_PT_object_light_group(LightGroupOf, bpy.types.Panel):
    bl_context = "object"


class ISOPHOTE_PT_world_light_group(LightGroupOf, bpy.types.Panel):
    bl_context = "world"


class ISOPHOTE_PT_object(PanelBase, bpy.types.Panel):
    bl_label = "Isophote"
    bl_context = "object"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.object is not None and context.object.type == "MESH"

    def draw(self, context):
        self.column().prop(context.object.isophote, "as_sphere")


class ISOPHOTE_PT_light(PanelBase, bpy.types.Panel):
    bl_label = "Light"
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.light is not None

    def draw(self, context):
        light = context.light
        column = self.column()
        self.layout.row().prop(light, "type", expand=True)
        column = self.layout.column()
        column.prop(light, "color")
        column.prop(light, "energy")
        if light.type == "SUN":
            column.prop(light, "angle")
        elif light.type == "AREA":
            column.prop(light, "shape")
            oblong = light.shape in {"RECTANGLE", "ELLIPSE"}
            column.prop(light, "size", text="Size X" if oblong else "Size")
            if oblong:
                column.prop(light, "size_y", text="Y")
        else:
            column.prop(light, "shadow_soft_size", text="Radius")
        switch = shadow_switch(light)
        if switch:
            column.prop(*switch, text="Shadow")


CLASSES = (
    ISOPHOTE_PT_sampling,
    ISOPHOTE_PT_device,
    ISOPHOTE_PT_bounces,
    ISOPHOTE_PT_clamping,
    ISOPHOTE_PT_ledger,
    ISOPHOTE_PT_left_out,
    ISOPHOTE_PT_film,
    ISOPHOTE_PT_performance,
    ISOPHOTE_PT_trade,
    ISOPHOTE_PT_passes,
    ISOPHOTE_PT_light_passes,
    ISOPHOTE_PT_cryptomatte,
    ISOPHOTE_PT_aovs,
    ISOPHOTE_PT_light_groups,
    ISOPHOTE_PT_object_light_group,
    ISOPHOTE_PT_world_light_group,
    ISOPHOTE_PT_object,
    ISOPHOTE_PT_light,
)
