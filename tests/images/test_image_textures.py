"""Image and Environment Textures against Cycles: the picture of blend_scenes/nodes/make_images.py, without noise."""

import numpy as np
import pytest

from bench.cycles_compare import render_both, same_bits
from tests.conftest import missing
from tests.images.agreement import made

PATCH = 16


@pytest.fixture(scope="module")
def renders(tmp_path_factory):
    blend = made("nodes/make_images.py", tmp_path_factory.mktemp("made") / "images.blend")
    return render_both(blend, 0, 16, 1)


def patches(picture):
    """(patch, pixel, channel) of (h, w, c), without the pixels at the patches' edges."""
    height, width, channels = picture.shape
    cut = picture.reshape(height // PATCH, PATCH, width // PATCH, PATCH, channels)[:, 1:-1, :, 1:-1]
    return cut.transpose(0, 2, 1, 3, 4).reshape(-1, (PATCH - 2) ** 2, channels)


def test_patches_are_those_of_cycles(renders):
    """Within what the pixel filter, a hundredth of a pixel wide, leaves of noise; 0.06 at edges of closest texels."""
    ours, theirs = patches(renders["isophote"][0]), patches(renders["cycles"][0])
    bright = np.maximum(theirs.mean(axis=1), 0.01)
    assert np.abs(ours.mean(axis=1) - theirs.mean(axis=1)).max() < 2e-3, np.abs(ours - theirs).mean(axis=(1, 2))
    assert (np.median(np.abs(ours - theirs), axis=1) / bright).max() < 2e-3
    assert (theirs.max(axis=(1, 2)) > 0.1).sum() >= 40


def test_bits_are_the_same_on_opencl(renders):
    found = same_bits(renders["scene"], renders["settings"])
    if "why_not" in found:
        missing(found["why_not"])
    assert found["differing"] == 0, found
