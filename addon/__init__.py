# SPDX-License-Identifier: GPL-3.0-or-later
"""Isophote, a path tracer for Blender: what Blender calls to switch the add-on on and off.

Nothing is imported here before `register`, so that scripts may import addon.export on its own.
"""

import sys
from pathlib import Path

VERSION = (0, 1, 0)

bl_info = {
    "name": "Isophote",
    "author": "The Isophote developers",
    "description": "A path tracer on OpenMP and OpenCL that knows how accurate its pictures are",
    "version": VERSION,
    "blender": (3, 4, 0),
    "location": "Properties > Render > Render Engine",
    "category": "Render",
}

# Where the zip for Blender 3.4 to 4.1 keeps what wheels bring to newer versions.
VENDOR = Path(__file__).resolve().parent / "vendor"


def register():
    if VENDOR.is_dir() and str(VENDOR) not in sys.path:
        sys.path.append(str(VENDOR))
    from . import native, registration

    problem = native.problem()
    if problem:
        print(f"Isophote: error: {problem}", file=sys.stderr, flush=True)
    registration.register()


def unregister():
    from . import registration

    registration.unregister()
    if str(VENDOR) in sys.path:
        sys.path.remove(str(VENDOR))
