# SPDX-License-Identifier: GPL-3.0-or-later
"""What settings cost, measured by the panel's button: of a cube on a floor, of other settings, stopped."""

import sys
import time
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))

from common import report, small_scene  # noqa: E402
from isophote_addon import ledger  # noqa: E402

scene = small_scene(48, 32)
bpy.ops.mesh.primitive_plane_add(size=20, location=(0, 0, -1))


def measured(stops=False):
    """What the panel would show at the end; there is no timer in the background, so it is called here."""
    bpy.ops.isophote.measure_ledger()
    if stops:
        ledger.detach()
        return ledger.current is None
    begin = time.perf_counter()
    while ledger.current.running and time.perf_counter() - begin < 100:
        time.sleep(0.05)
        ledger.tick()
    return {"sentences": ledger.sentences(scene.name), "error": ledger.current.error}


scene.isophote.max_bounces = 0
limited = measured()
scene.isophote.max_bounces = 12
scene.isophote.diffuse_bounces = 12
scene.isophote.clamp_indirect = 0.01
clamped = measured()
report(limited=limited, clamped=clamped, stopped=measured(stops=True), engine=scene.render.engine)
