"""Lamps against Cycles: blend_scenes/nodes/make_lamps.py."""

import pytest

from tests.images.agreement import assert_agrees, made

SAMPLES = {"spread": 768}  # else 256: a lamp with a spread is noisier
REPLICATES = 10
# How noisy a picture may be at equal samples, as variance over Cycles'.
# The tree of lights knows the brightest that a program may be, not where, nor which of two lamps in a cluster lights a
# place: what one lamp alone lights is noisier then.
NOISE = {"spread": 1.5, "narrow": 1.5, "stretched": 1.5, "hidden": 1.5, "hidden_mixed": 1.5, "bounces": 1.5,
         "object": 1.2, "normal": 1.2, "uv": 1.2, "position": 1.2, "incoming": 1.2, "parametric": 1.2, "picture": 1.8,
         "graphs": 3.5, "photometric": 4.5, "falloff": 1.2}


@pytest.mark.slow
@pytest.mark.parametrize("case", NOISE)
def test_pictures_agree(case, tmp_path):
    blend = made("nodes/make_lamps.py", tmp_path / "lamps.blend", case)
    found = assert_agrees(blend, SAMPLES.get(case, 256), REPLICATES, NOISE[case])
    assert all(mean["half_interval"] < 0.01 for mean in found["means"]), found
