"""Smooth shapes of few faces under grazing light against Cycles: blend_scenes/nodes/make_terminator.py."""

from dataclasses import replace

import numpy as np
import pytest

from bench.cycles_compare import render_both, same_bits
from bench.replicates import compare_replicates, render_replicates
from tests.images.agreement import made

SAMPLES, REPLICATES = 32, 6


@pytest.mark.slow
def test_rays_are_lifted_as_in_cycles(tmp_path):
    both = render_both(made("nodes/make_terminator.py", tmp_path / "terminator.blend"), 0, SAMPLES, REPLICATES)
    scene = both["scene"]
    assert not scene.notes and np.unique(scene.instance_terminator).tolist() == pytest.approx([0.0, 0.1, 0.2, 0.4])
    lifted = compare_replicates(both["isophote"], both["cycles"])
    for mean in lifted["means"]:
        assert abs(mean["ratio"] - 1.0) <= 1.5 * mean["half_interval"] + 5e-4, lifted
    flat = replace(scene, arrays=scene.arrays | {"instance_terminator": np.zeros_like(scene.instance_terminator)})
    flat = compare_replicates(render_replicates(flat, both["settings"], range(REPLICATES)), both["cycles"])
    assert 4 * lifted["tiles"]["rejected"] < flat["tiles"]["rejected"], (lifted, flat)
    assert same_bits(scene, both["settings"]).get("differing", 0) == 0
