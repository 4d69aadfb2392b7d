# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on where its native module cannot be loaded, as with a zip for another Python."""

import sys
from pathlib import Path

import addon_utils
import bpy

sys.path.insert(0, str(Path(__file__).parent))
from common import exr_output, render_to, report, small_scene  # noqa: E402

addon_utils.disable("isophote_addon")
for name in [name for name in sys.modules if name.partition(".")[0] in ("isophote", "isophote_addon")]:
    del sys.modules[name]
sys.modules["isophote._native"] = None
addon_utils.enable("isophote_addon")
scene = small_scene()
exr_output(scene)
failed = ""
try:
    render_to(scene, "no_native.exr")
except RuntimeError as error:
    failed = str(error)
report(failed=failed, registered=hasattr(bpy.types.Scene, "isophote"))
