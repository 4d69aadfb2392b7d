"""Worlds and textures that light a scene against Cycles: blend_scenes/nodes/make_worlds.py."""

import pytest

from tests.images.agreement import assert_agrees, made

SAMPLES, REPLICATES = 32, 8
# How noisy a picture may be at equal samples, as variance over Cycles'.
NOISE = {"sky": 1.5, "sunny": 1.5, "ball": 1.5, "light_path": 1.5, "lamps": 1.0, "screens": 1.6, "hidden": 1.6}


@pytest.mark.slow
@pytest.mark.parametrize("world", NOISE)
def test_pictures_agree(world, tmp_path):
    blend = made("nodes/make_worlds.py", tmp_path / "world.blend", world)
    assert_agrees(blend, SAMPLES, REPLICATES, NOISE[world])
