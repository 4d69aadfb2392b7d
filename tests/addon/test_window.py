# SPDX-License-Identifier: Apache-2.0
"""The add-on in Blender's window under Xvfb: panels, F12, Esc. Screenshots stay in build/window."""

import json
import os
import shutil
import subprocess

import blender_run
import numpy as np
import OpenImageIO as oiio
import pytest
from conftest import MARK, SCENARIOS, missing

SHOTS = blender_run.ROOT / "build" / "window"


@pytest.fixture
def display():
    """An X server of our own; its number is whatever is free."""
    for name in ("Xvfb", "import", "xdotool"):
        if shutil.which(name) is None:
            missing(f"no {name}")
    reading, writing = os.pipe()
    server = subprocess.Popen(["Xvfb", "-displayfd", str(writing), "-screen", "0", "1280x800x24"],
                              pass_fds=[writing], stderr=subprocess.DEVNULL)
    os.close(writing)
    with os.fdopen(reading) as numbers:
        number = numbers.readline().strip()
    yield f":{number}"
    server.terminate()
    server.wait()


@pytest.mark.timed
def test_f12_and_escape(program, display):
    SHOTS.mkdir(parents=True, exist_ok=True)
    env = blender_run.environment(program.scripts, DISPLAY=display, LIBGL_ALWAYS_SOFTWARE="1")
    done = subprocess.run([program.path, "--factory-startup", "-p", "0", "0", "1280", "800",
                           "--addons", blender_run.ADDON, "--python", str(SCENARIOS / "window.py"), "--", str(SHOTS)],
                          env=env, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=200)
    lines = [line[len(MARK):] for line in done.stdout.splitlines() if line.startswith(MARK)]
    assert lines, done.stdout
    assert json.loads(lines[-1])["seconds"] < 0.5
    assert np.ptp(oiio.ImageBuf(str(SHOTS / "cancelled.exr")).get_pixels()[..., 0]) > 0.2, "the picture was kept"
    assert "Traceback" not in done.stdout and "Isophote: error" not in done.stdout
