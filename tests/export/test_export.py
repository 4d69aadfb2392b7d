"""Runs the scripts of this folder inside real Blenders: the program, and the bpy modules.

ISOPHOTE_BLENDER names the program (else `blender` on the path), ISOPHOTE_BPY_PYTHONS the Pythons that
have a bpy module (tools/blender_run.py). What is missing is skipped, with CI=true it fails.
"""

import os
import shutil
import subprocess
from pathlib import Path

import blender_run
import pytest

from tests.conftest import missing

HERE = Path(__file__).parent
SCRIPTS = sorted(path.name for path in HERE.glob("inside_*.py"))
SECONDS = 240  # generous: the machine may be busy


def run(command):
    done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, stdin=subprocess.DEVNULL)
    output = done.stdout + done.stderr
    assert done.returncode == 0 and "ALL PASSED" in done.stdout, output[-8000:]


@pytest.mark.parametrize("script", SCRIPTS)
def test_in_blender(script):
    blender = os.environ.get("ISOPHOTE_BLENDER") or shutil.which("blender")
    if not blender or not shutil.which(blender):
        missing("no Blender: set ISOPHOTE_BLENDER or install Debian's blender and python3-numpy")
    run([blender, "-b", "--factory-startup", "--python-exit-code", "1", "--python", str(HERE / script)])


@pytest.mark.parametrize("script", SCRIPTS)
@pytest.mark.parametrize("python", blender_run.bpy_pythons(), ids=lambda path: Path(path).parts[-3])
def test_in_bpy_module(python, script):
    if not Path(python).exists():
        missing(f"{python}: no such Python with a bpy module")
    run([python, str(HERE / script)])
