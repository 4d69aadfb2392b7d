"""Objects that not all see, against Cycles: blend_scenes/nodes/make_visibility.py."""

import pytest

from tests.images.agreement import assert_agrees, made

SAMPLES = 128
BACKGROUND = (0.2, 0.5, 0.8)  # under what has an alpha
NOISE = {"held_out": 1.5, "held_out_opaque": 1.5, "indirect_only": 1.5}  # variance over Cycles', at most


@pytest.mark.slow
@pytest.mark.parametrize("case", NOISE)
def test_pictures_agree(case, tmp_path):
    blend = made("nodes/make_visibility.py", tmp_path / "visibility.blend", case)
    found = assert_agrees(blend, SAMPLES, 8, NOISE[case], over=BACKGROUND)
    assert all(mean["half_interval"] < 0.01 for mean in found["means"]), found
