"""Procedural textures against Cycles, in all of their modes, pixel by pixel."""

import numpy as np
import pytest

from tests.images.patches import differences, make_blends

# What is left of the pixel filter moves a sample by some 1/1000 of a pixel; where a value jumps, across the jump.
USUAL, JUMP, JUMPS = 5e-4, 0.02, 0.02  # median difference, what counts as a jump, share of pixels that may show one


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("textures")


@pytest.mark.parametrize("name, fewest", [("noise", 60), ("cells", 100)])
def test_patches_agree(folder, name, fewest):
    make_blends(f"make_{name}.py", folder)
    found, notes = differences(folder / f"{name}.blend", 10, 12)
    assert not notes and len(found) > fewest
    wrong = {patch: (float(np.median(off)), float((off > JUMP).mean())) for patch, off in found.items()
             if np.median(off) > USUAL or (off > JUMP).mean() > JUMPS}
    assert not wrong
    assert np.median(list(found.values())) < 5e-5
