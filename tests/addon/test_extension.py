# SPDX-License-Identifier: Apache-2.0
"""The zips of `make extension`, installed in fresh user folders of real Blenders, with nothing else to import."""

import os
import subprocess
import sys

import blender_run
import numpy as np
import OpenImageIO as oiio
import pytest

pytestmark = pytest.mark.slow
CUBE = """
import bpy, sys, isophote._native as native
scene = bpy.context.scene
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 64, 48, 100
scene.isophote.samples = 4
print("MODULE", native.__file__)
import pyopencl
print("OPENCL", pyopencl.__file__)
"""


# A development environment finds the package of the tree first: take the tree off the path.
WITHOUT_TREE = """
import runpy, sys
sys.path[:] = [scripts] + [place for place in sys.path if place not in ("", root)]
sys.meta_path[:] = [finder for finder in sys.meta_path if not type(finder).__module__.startswith("_editable")]
runpy.run_path(scripts + "/blender_bpy.py", run_name="__main__")
"""


def program_without_tree(path: str) -> list[str]:
    """blender_run.program for an environment that may have this tree installed."""
    command = blender_run.program(path)
    if len(command) == 1:
        return command
    root = str(blender_run.ROOT)
    return [path, "-c", f"root, scripts = {root!r}, {root + '/addon/scripts'!r}\n{WITHOUT_TREE}"]


@pytest.fixture(scope="session")
def zips():
    """Built once; the build checks and validates them."""
    done = subprocess.run([sys.executable, str(blender_run.ROOT / "tools" / "build_extension.py")], text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    assert done.returncode == 0, done.stdout


def test_install_and_render(host, zips):
    """The user's folder is the test's own, so that only the zip can be what is found."""
    user = host.folder / "user"
    env = {name: value for name, value in os.environ.items() if not name.startswith(("BLENDER_", "PYTHONPATH"))}
    # Debian's Blender takes its site-packages from the first python3 on PATH, which may be a .venv.
    env["PATH"] = os.defpath
    env |= {"BLENDER_USER_RESOURCES": str(user), "HOME": str(user), "XDG_CONFIG_HOME": str(user / "config")}
    for folder in ("CONFIG", "SCRIPTS", "EXTENSIONS"):
        env[f"BLENDER_USER_{folder}"] = str(user / folder.lower())
        (user / folder.lower()).mkdir(parents=True)
    installed = subprocess.run([sys.executable, str(blender_run.ROOT / "tools" / "install_addon.py"), host.path],
                               env=env, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=120)
    assert installed.returncode == 0, installed.stdout
    # The bpy module does not load the user's preferences, in which the extension is switched on.
    enable = [] if host.path.endswith("blender") else ["--addons", "bl_ext.user_default.isophote"]
    done = subprocess.run([*program_without_tree(host.path), "-b", *enable, "--python-expr", CUBE, "-E", "ISOPHOTE",
                           "-o", str(host.folder / "cube_#"), "-F", "PNG", "-f", "1"],
                          env=env, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=120)
    log = done.stdout
    for mark in ("MODULE", "OPENCL"):
        path = next((line for line in log.splitlines() if line.startswith(mark)), log)
        assert str(user) in path, f"not from the zip: {path}"
    assert "Isophote: device" in log
    pixels = oiio.ImageBuf(str(host.folder / "cube_1.png")).get_pixels()
    assert np.ptp(pixels[..., 0]) > 0.2
