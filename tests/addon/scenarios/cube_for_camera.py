# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets up a render that cannot be; the command line starts it."""

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from common import small_scene  # noqa: E402

small_scene().camera = bpy.data.objects["Cube"]
