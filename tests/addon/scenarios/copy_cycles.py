# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies the settings from Cycles' panel."""

import sys
from pathlib import Path

import addon_utils
import bpy

sys.path.insert(0, str(Path(__file__).parent))
from common import report, small_scene  # noqa: E402

addon_utils.enable("cycles")
scene = small_scene()
cycles = scene.cycles
cycles.samples, cycles.time_limit, cycles.seed = 77, 12.5, 5
cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces = 11, 3, 2
cycles.transmission_bounces, cycles.transparent_max_bounces = 9, 6
cycles.sample_clamp_direct, cycles.sample_clamp_indirect, cycles.filter_width = 1.5, 10.0, 2.5
result = bpy.ops.isophote.copy_cycles_settings()
own = scene.isophote
names = ("samples", "time_limit", "seed", "max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces",
         "transparent_bounces", "clamp_direct", "clamp_indirect", "filter_width", "device")
report(result=list(result), **{name: getattr(own, name) for name in names})
