# SPDX-License-Identifier: GPL-3.0-or-later
"""A trade report of the default cube by the button's operator: stopped, continued, and one of a changed scene."""

import os
import sys
import time
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))

from common import FOLDER, report, small_scene  # noqa: E402
from isophote_addon import trade  # noqa: E402

scene = small_scene(48, 32)
scene.isophote.clamp_indirect = 2.0
os.environ["OCL_ICD_VENDORS"] = str(FOLDER)  # no OpenCL: its compiler would take most of the time


def made(stop_at=None, **options):
    """What the panel would show at the end; there is no timer in the background, so it is called here."""
    bpy.ops.isophote.trade_report("EXEC_DEFAULT", folder=str(FOLDER / "report"), longest=32, **options)
    begin = time.perf_counter()
    while trade.current.running and time.perf_counter() - begin < 100:
        time.sleep(0.05)
        trade.tick()
        if stop_at and trade.current.share > stop_at:
            bpy.ops.isophote.stop_trade_report()
            stop_at = None
    seconds = time.perf_counter() - begin
    return {"page": "", "partial": False, **trade.current.made, "error": trade.current.error, "seconds": seconds}


stopped = made(minutes=0.5, stop_at=0.15)
whole = made(minutes=0.1)
scene.isophote.clamp_indirect = 3.0
refused = made(minutes=0.1)
report(whole=whole, refused=refused, stopped=stopped, file=bpy.data.filepath, engine=scene.render.engine)
