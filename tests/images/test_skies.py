"""Sky Textures of all types against Cycles, pixel by pixel, and scenes that they light.

The script is blend_scenes/nodes/make_skies.py. ISOPHOTE_BPY_PYTHONS names Pythons with bpy wheels, separated by
colons; else this one has to have it.
"""

import os
import subprocess
import sys

import numpy as np
import pytest

from bench.common import ROOT
from bench.cycles_compare import render_both, same_bits
from bench.cycles_process import find_python
from bench.replicates import compare_replicates
from tests.conftest import missing
from tests.images.agreement import SIZE, assert_agrees
from tests.images.patches import differences

PYTHONS = [path for path in os.environ.get("ISOPHOTE_BPY_PYTHONS", "").split(":") if path] or [sys.executable]
COLUMNS, PIXELS = 10, 12
# As in test_procedural.py: median difference, what counts as a jump, share of pixels that may show one.
USUAL, JUMP, JUMPS = 5e-5, 0.02, 0.02
SAMPLES, REPLICATES = 32, 8
# How noisy a picture may be at equal samples, as variance over Cycles'.
NOISE = {"sun": 1.5, "low_sun": 1.6, "large_sun": 1.5, "dim_sun": 1.5, "turned": 1.5, "no_sun": 1.6, "preetham": 1.6,
         "hosek_wilkie": 1.6}


def made_by(python, folder):
    """The folder with the scenes that one Blender made; that one then renders them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ISOPHOTE_BPY_PYTHONS", python)
        if find_python() is None:
            missing("no Python with a bpy module: set ISOPHOTE_BPY_PYTHONS")
        subprocess.run([python, str(ROOT / "blend_scenes" / "nodes" / "make_skies.py"), "--", str(folder)],
                       check=True, capture_output=True, stdin=subprocess.DEVNULL)
        yield folder


@pytest.fixture(scope="module", params=PYTHONS)
def folder(request, tmp_path_factory):
    yield from made_by(request.param, tmp_path_factory.mktemp("patches"))


@pytest.fixture(scope="module")
def worlds(tmp_path_factory):
    yield from made_by(PYTHONS[0], tmp_path_factory.mktemp("worlds"))


def test_patches_agree(folder):
    found, notes = differences(folder / "skies.blend", COLUMNS, PIXELS)
    assert not notes and len(found) > 60
    wrong = {patch: (float(np.median(off)), float((off > JUMP).mean())) for patch, off in found.items()
             if np.median(off) > USUAL or (off > JUMP).mean() > JUMPS}
    assert not wrong


def test_patches_have_the_same_bits(folder):
    both = render_both(folder / "skies.blend", 0, 1, 1)
    bits = same_bits(both["scene"], both["settings"])
    assert bits.get("differing", 0) == 0, bits


@pytest.mark.slow
@pytest.mark.parametrize("world", NOISE)
def test_worlds_agree(worlds, world):
    assert_agrees(worlds / f"under_{world}.blend", SAMPLES, REPLICATES, NOISE[world])


@pytest.mark.slow
def test_two_suns_are_the_sum_of_each(worlds):
    """Cycles itself loses some 3 % of light from several suns (4.5.15), so each of them is asked for alone."""
    both = render_both(worlds / "under_two_suns.blend", SIZE, SAMPLES, REPLICATES)["isophote"]
    each = [render_both(worlds / f"under_{name}.blend", SIZE, SAMPLES, REPLICATES)["cycles"]
            for name in ("sun", "second_sun")]
    found = compare_replicates(both, each[0] + each[1])
    for mean in found["means"]:
        assert abs(mean["ratio"] - 1.0) <= 1.5 * mean["half_interval"] + 2e-3, found
