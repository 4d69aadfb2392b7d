"""What moves while the shutter is open, against Cycles: blend_scenes/make_motion.py."""

import numpy as np
import pytest

from bench.cycles_process import exported
from tests.images.agreement import assert_agrees, made

# Keys of instances and shapes of meshes, by scene.
KEYS = {"objects": ([0, 3, 9, 3, 3, 0], []), "before": ([0, 3, 9, 3, 3, 0], []), "after": ([0, 3, 9, 3, 3, 0], []),
        "deforming": ([0, 0, 3, 0, 0], [0, 3, 3, 0, 3]), "lights": ([0, 3, 0, 0], [0, 0, 3, 0]),
        "instances": ([0, 0, 3, 3, 3, 5, 5], [])}


@pytest.mark.slow
@pytest.mark.parametrize("kind", KEYS)
def test_what_moves(kind, tmp_path):
    blend = made("make_motion.py", tmp_path / f"{kind}.blend", kind)
    assert_agrees(blend, 64, 4, noise=1.5, slack=2e-3 if kind == "lights" else 2e-4)  # lights are noisy in Cycles
    scene = exported(blend, (8, 6))
    instances, meshes = KEYS[kind]
    assert scene.instance_keys.tolist() == instances
    assert scene.mesh_keys.tolist() == (meshes or [0] * len(scene.mesh_keys))
    assert len(scene.key_to_world) == sum(instances) and np.isfinite(scene.key_to_world).all()
