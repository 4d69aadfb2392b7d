"""The nodes of the Converter, Color and Vector menus against Cycles, in all of their modes, pixel by pixel."""

import numpy as np
import pytest

from tests.images.patches import differences, make_blends

# What is left of the pixel filter moves a sample by some 1/1000 of a pixel; where a value jumps, across the jump.
USUAL, JUMP, JUMPS = 5e-4, 0.02, 0.02  # median difference, what counts as a jump, share of pixels that may show one
CONSTANT = 1e-4  # what Blender itself says of a curve, where Cycles has a table


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("conversions")
    make_blends("make_conversions.py", made)
    return made


@pytest.mark.parametrize("name, columns, fewest", [("numbers", 12, 120), ("vectors", 12, 130), ("colours", 14, 150)])
def test_patches_agree(folder, name, columns, fewest):
    found, notes = differences(folder / f"{name}.blend", columns, 12)
    assert not notes and len(found) > fewest
    wrong = {patch: float(off.max()) for patch, off in found.items()
             if (off.max() > CONSTANT if patch.endswith("constant") else not agrees(off))}
    assert not wrong


def test_spaces_agree(folder):
    """Through a perspective camera squares are anywhere: the whole picture, cut like the others."""
    found, notes = differences(folder / "spaces.blend", 6, 24)
    assert not notes and len(found) == 18
    assert agrees(np.stack(list(found.values())))


def agrees(off: np.ndarray) -> bool:
    return np.median(off) <= USUAL and (off > JUMP).mean() <= JUMPS
