# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether the native module is there and fits this add-on."""

from __future__ import annotations

import importlib
import sys


def problem() -> str:
    """What keeps the native module from being used, in words for the user; "" where it can be."""
    from . import VERSION

    wanted = ".".join(str(n) for n in VERSION)
    try:
        module = importlib.import_module("isophote._native")
    except ImportError as error:
        python = ".".join(str(n) for n in sys.version_info[:2])
        return (
            f"the native module of Isophote {wanted} cannot be loaded in Blender's Python {python} ({error}). "
            "Install the zip that is made for this version of Blender and this platform"
        )
    found = getattr(module, "version", "of unknown version")
    if found != wanted:
        return (
            f"the native module is {found}, the add-on {wanted}: they must be of one version. Remove the add-on, "
            f"restart Blender and install it again (module: {module.__file__})"
        )
    return ""
