"""Isophote's pictures against those of Cycles, as statistics: bench.cycles_compare at a size for CI.

ISOPHOTE_BPY_PYTHONS names Pythons with a bpy wheel, separated by colons; else this one has to have it.
Without one the tests are skipped, with CI=true they fail. Seeds are fixed: a test that passes passes again.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from bench.cycles_compare import render_both
from bench.replicates import CLOSE, compare_replicates, render_replicates
from bench.scenes import ignis_box, made_scenes, own_scenes
from isophote.materials import OPERATIONS

SIZE, REPLICATES = 64, 16
# Samples of a replicate; those with glass are noisy.
SAMPLES = {"cornell_box": 48, "sphere_box": 48, "torus_box": 40, "monkey_box": 40, "box": 32, "glassbox": 48}


@pytest.fixture(scope="module")
def scenes(tmp_path_factory) -> dict:
    """Paths by name; those of ../shared/scenes only where that is."""
    made = made_scenes(tmp_path_factory.mktemp("made"), ("glassbox",))
    return {path.stem: path for path in [*own_scenes(), *ignis_box(), *made]}


@cache
def both(path):
    """Both engines' replicates: the negative control compares with those of another test."""
    return render_both(path, SIZE, SAMPLES[path.stem], REPLICATES)


@pytest.mark.slow
@pytest.mark.parametrize("name", SAMPLES)
def test_pictures_agree(scenes, name):
    if name not in scenes:
        pytest.skip("../shared/scenes is not here")
    renders = both(scenes[name])
    found = compare_replicates(renders["isophote"], renders["cycles"])
    for mean in found["means"]:
        off = abs(mean["ratio"] - 1.0)
        assert off <= CLOSE, found
        assert off <= 1.5 * mean["half_interval"] + 2e-4, found  # 99.5 %; below 2e-4 float32 sums count
    assert found["tiles"]["passed"] and found["pixels"]["passed"], found
    assert found["agrees"], found


@pytest.mark.slow
def test_albedo_off_by_two_percent_is_found(scenes):
    renders = both(scenes["cornell_box"])
    scene = renders["scene"]
    weight = scene.instruction_weight.copy()
    weight[scene.instruction_op == OPERATIONS["diffuse"][0]] *= np.float32(0.98)
    darker = replace(scene, arrays=scene.arrays | {"instruction_weight": weight})
    pictures = render_replicates(darker, renders["settings"], range(REPLICATES))
    found = compare_replicates(pictures, renders["cycles"])
    assert not found["tiles"]["passed"], found
    assert all(mean["verdict"] == "beyond" for mean in found["means"]), found
    assert not found["agrees"], found
