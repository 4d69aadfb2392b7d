# SPDX-License-Identifier: GPL-3.0-or-later
"""A render that would take hours gets Ctrl-C after a second; the picture must stay."""

import os
import signal
import sys
import threading
import time
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from common import FOLDER, exr_output, report, small_scene  # noqa: E402

scene = small_scene(640, 480, samples=1 << 24)
exr_output(scene)
pressed = []


def press():
    time.sleep(1.5)
    pressed.append(time.perf_counter())
    os.kill(os.getpid(), signal.SIGINT)


threading.Thread(target=press).start()
bpy.ops.render.render()
stopped = time.perf_counter()
bpy.data.images["Render Result"].save_render(str(FOLDER / "cancelled.exr"), scene=scene)
report(seconds=stopped - pressed[0])
