# SPDX-License-Identifier: GPL-3.0-or-later
"""Buttons: copy the settings of Cycles, look for devices."""

import bpy

from isophote.device import DeviceInfo, list_devices

from .settings import FROM_CYCLES


class ISOPHOTE_OT_copy_cycles_settings(bpy.types.Operator):
    """Copy samples, bounces, clamps, filter, device and passes from Cycles' settings of this scene"""

    bl_idname = "isophote.copy_cycles_settings"
    bl_label = "Copy Settings from Cycles"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return hasattr(context.scene, "cycles")  # missing where the Cycles add-on is off

    def execute(self, context):
        cycles, own = context.scene.cycles, context.scene.isophote
        for theirs, ours in FROM_CYCLES.items():
            setattr(own, ours, getattr(cycles, theirs))
        own.device = "opencl" if cycles.device == "GPU" else "openmp"
        for layer in context.scene.view_layers:
            layer.isophote.sample_count = layer.cycles.pass_debug_sample_count
            layer.isophote.albedo = layer.cycles.denoising_store_passes or layer.isophote.albedo
        self.say_what_differs(cycles)
        return {"FINISHED"}

    def say_what_differs(self, cycles) -> None:
        """What Cycles is asked to do and this engine does otherwise."""
        differing = []
        if cycles.use_adaptive_sampling:
            differing.append("the noise threshold is not taken over: Sampling > Error is measured otherwise")
        if cycles.use_denoising:
            differing.append("denoising is left to the compositor")
        if cycles.pixel_filter_type != "BLACKMAN_HARRIS":
            differing.append("the pixel filter is Blackman-Harris")
        if differing:
            self.report({"WARNING"}, "Isophote: " + "; ".join(differing))


class ISOPHOTE_OT_find_devices(bpy.types.Operator):
    """Look for devices that can render; drivers that are loaded for the first time take a moment"""

    bl_idname = "isophote.find_devices"
    bl_label = "Find Devices"

    # None before the first look; kept so that drawing a panel never waits for a driver.
    found: list[DeviceInfo] | None = None

    def execute(self, context):
        ISOPHOTE_OT_find_devices.found = list_devices()
        for device in self.found:
            self.report({"INFO"}, f"{device.id}: {device.name} {device.driver} {device.why_not}")
        return {"FINISHED"}


CLASSES = (ISOPHOTE_OT_copy_cycles_settings, ISOPHOTE_OT_find_devices)
