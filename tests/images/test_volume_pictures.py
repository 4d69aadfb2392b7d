"""Volumes against Cycles: a ball of each kind, scenes in fog, haze and clouds (blend_scenes/nodes/make_volume*.py)."""

import pytest

from bench.shaders import MAKER, compare_shaders
from tests.images.agreement import assert_agrees, made, rows_off

# How noisy a picture may be at equal samples, as variance over Cycles'.
NOISE = {"fog": 2.0, "inside": 1.8, "glow": 1.1, "clouds": 3.0}


@pytest.mark.slow
def test_balls_agree():
    rows, bits = compare_shaders("", samples=16, replicates=8, maker=MAKER.with_name("make_volumes.py"))
    assert len(rows) > 20 and bits.get("differing", 0) == 0
    off = rows_off(rows)
    assert not off, off


@pytest.mark.slow
@pytest.mark.parametrize("kind", NOISE)
def test_pictures_agree(kind, tmp_path):
    blend = made("nodes/make_volume_scenes.py", tmp_path / "volume.blend", kind)
    assert_agrees(blend, 16, 6, NOISE[kind])
