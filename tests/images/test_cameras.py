"""Cameras against Cycles: blend_scenes/make_cameras.py, pixel by pixel, through a filter 1/100 of a pixel wide."""

from pathlib import Path

import numpy as np
import pytest

from bench.cycles_compare import render_both, same_bits
from bench.replicates import compare_replicates
from tests.images.agreement import made

PANORAMAS = ("equirectangular", "part", "equidistant", "equisolid", "polynomial", "mirror_ball", "cube_face",
             "cylinder", "portrait", "clipped")
SURFACES = ("place", "window", "view", "distances")
SAMPLES, REPLICATES = 8, 2
CLOSE = 1e-4  # nine pixels out of ten; filters of two pixels with other random numbers explain the rest


def room(folder: Path, camera: str, surface: str) -> Path:
    return made("make_cameras.py", folder / f"{camera}.blend", camera, surface)


@pytest.mark.slow
@pytest.mark.parametrize("camera,surface", [(camera, "place") for camera in PANORAMAS]
                         + [(camera, surface) for surface in SURFACES[1:] for camera in PANORAMAS[:8]])
def test_pixels_agree(camera, surface, tmp_path):
    both = render_both(room(tmp_path, camera, surface), 0, SAMPLES, REPLICATES)
    assert not both["scene"].notes, both["scene"].notes
    ours, theirs = (both[engine].mean(axis=0) for engine in ("isophote", "cycles"))
    off = np.abs(ours - theirs).max(axis=-1)
    assert np.quantile(off, 0.9) < CLOSE
    assert ours.mean() == pytest.approx(theirs.mean(), rel=1e-3)
    unseen = theirs.max(axis=-1) == 0.0
    assert np.count_nonzero(unseen != (ours.max(axis=-1) == 0.0)) <= 8  # of 6,912: those that the circle just touches
    if surface == "place":
        bits = same_bits(both["scene"], both["settings"])
        assert bits.get("differing", 0) == 0, bits


@pytest.mark.slow
@pytest.mark.parametrize("camera", ["perspective", *PANORAMAS[:8]])
def test_wires_are_pixels_wide(camera, tmp_path):
    """How wide pixels are where they look; the rims of fisheyes, whose neighbours see nothing, are left out."""
    both = render_both(room(tmp_path, camera, "wires"), 0, SAMPLES, REPLICATES)
    ours, theirs = (both[engine].mean(axis=0)[..., 0] for engine in ("isophote", "cycles"))
    y, x = (np.mgrid[:ours.shape[0], :ours.shape[1]] + 0.5) / np.array(ours.shape)[:, None, None] * 2 - 1
    inner = np.hypot(x, y) < 0.8
    assert ours[inner].mean() == pytest.approx(theirs[inner].mean(), rel=0.05)
    assert np.count_nonzero(np.abs(ours - theirs)[inner] > 0.5) < 0.03 * np.count_nonzero(theirs[inner] > 0.5)


@pytest.mark.slow
def test_lens_of_a_fisheye(tmp_path):
    both = render_both(room(tmp_path, "focused", "marks"), 0, 32, 8)
    found = compare_replicates(both["isophote"], both["cycles"])
    for mean in found["means"]:
        assert abs(mean["ratio"] - 1.0) <= 1.5 * mean["half_interval"] + 2e-4, found
    assert found["tiles"]["passed"] and found["pixels"]["passed"], found
