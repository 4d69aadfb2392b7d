"""The native module built by g++ gives the bits of the one that is installed (clang's, where there is a choice)."""

import os
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from bench.parity import EVERY_PASS, differing_floats, opened, render_in_parts
from isophote import _native
from isophote.settings import Settings
from tests.conftest import missing
from tests.parity.scenes import SCENES, SETTINGS
from tests.scenes import full_frame, ready

ROOT = Path(__file__).parents[2]
BUILD = ROOT / "build" / "gxx"
VARIANT = "strict_v3" if any(v[0] == "strict_v3" and v[3] for v in _native.variants) else "strict_v2"


def sums_of(name) -> np.ndarray:
    """All sums of a small render of a scene, through the module that is loaded."""
    settings = Settings(samples=32, threads=2, passes=EVERY_PASS, **SETTINGS[name])
    scene = SCENES[name]()
    device = opened("openmp", settings, ready(scene))
    try:
        film = render_in_parts(device, full_frame(scene), settings)
    finally:
        device.close()
    return np.stack([film.sum(plane) for plane in range(film.planes.sums)])


@cache
def gxx_module() -> Path:
    """Where g++'s module lies; cmake and ninja build it when a source has changed."""
    compiler = os.environ.get("ISOPHOTE_GXX") or shutil.which("g++")
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    tools = [shutil.which(tool, path=path) for tool in ("cmake", "ninja")]
    if not compiler or not all(tools):
        missing("g++, cmake or ninja is not installed")
    configure = [tools[0], "-S", str(ROOT), "-B", str(BUILD), "-G", "Ninja", f"-DCMAKE_CXX_COMPILER={compiler}",
                 f"-DISOPHOTE_VARIANTS={VARIANT}", f"-DPython_EXECUTABLE={sys.executable}"]
    for command in (configure, [tools[0], "--build", str(BUILD), "--target", "_native"]):
        done = subprocess.run(command, env=dict(os.environ, PATH=path), text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT)
        assert done.returncode == 0, done.stdout[-3000:]
    return next(BUILD.glob("_native*.so"))


LOADER = """
import importlib.util, sys
import numpy as np
spec = importlib.util.spec_from_file_location("isophote._native", sys.argv[1])
sys.modules["isophote._native"] = module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)
import isophote
isophote._native = module
assert module.compiler.startswith("g++"), module.compiler
from tests.parity.test_compilers import SCENES, sums_of
np.savez(sys.argv[2], **{name: sums_of(name) for name in SCENES})
"""


@pytest.fixture(scope="module")
def from_gxx(tmp_path_factory):
    """name -> sums, rendered in a process of its own that has g++'s module for isophote._native."""
    out = tmp_path_factory.mktemp("gxx") / "sums.npz"
    path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    environment = dict(os.environ, PYTHONPATH=path, ISOPHOTE_ISA=VARIANT.partition("_")[2])
    done = subprocess.run([sys.executable, "-c", LOADER, str(gxx_module()), str(out)], cwd=ROOT, env=environment,
                          text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    assert done.returncode == 0, done.stdout[-3000:]
    return np.load(out)


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_gxx_gives_the_same_bits(from_gxx, name):
    assert differing_floats(sums_of(name), from_gxx[name]) == 0
