# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender: installs and enables the extension (4.2 and newer) or the legacy add-on, and saves that.

    blender -b --python install_inside_blender.py -- EXTENSION.zip LEGACY.zip
"""

import sys

import addon_utils
import bpy

extension, legacy = sys.argv[sys.argv.index("--") + 1:][:2]
if bpy.app.version >= (4, 2, 0):
    addon_utils.enable("bl_pkg", default_set=True)
    bpy.ops.extensions.package_install_files(filepath=extension, repo="user_default", enable_on_install=True)
    name = "bl_ext.user_default.isophote"
else:
    bpy.ops.preferences.addon_install(filepath=legacy, overwrite=True)
    name = "isophote_addon"
    bpy.ops.preferences.addon_enable(module=name)
bpy.ops.wm.save_userpref()
bpy.context.scene.render.engine = "ISOPHOTE"  # raises where it is not registered
print(f"Isophote is installed as {name} in Blender {bpy.app.version_string}", flush=True)
