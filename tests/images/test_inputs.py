"""Input nodes, normals and Light Path against Cycles: scenes of blend_scenes/nodes/make_inputs.py, patch by patch."""

import os
import subprocess

import numpy as np
import pytest

from bench.common import ROOT
from bench.cycles_compare import render_both
from bench.cycles_process import find_python

PATCH = 32  # pixels
# Samples of a replicate and replicates; what the means of a patch may be apart, of 1 and beyond what noise explains.
RENDERED = {"inputs": (4, 2, 4e-3), "normals": (32, 4, 0.01), "paths": (32, 4, 4e-3)}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    python = find_python()
    if python is None:
        why = "no Python with a bpy module: set ISOPHOTE_BPY_PYTHONS"
        pytest.fail(why) if os.environ.get("CI") == "true" else pytest.skip(why)
    made = tmp_path_factory.mktemp("inputs")
    script = ROOT / "blend_scenes" / "nodes" / "make_inputs.py"
    subprocess.run([python, str(script), "--", str(made)], check=True, capture_output=True)
    return made


def patches_of(pictures: np.ndarray) -> np.ndarray:
    """Means of patches (replicates, patches, 3) of pictures (replicates, h, w, 3)."""
    count, height, width, _ = pictures.shape
    rows, columns = height // PATCH, width // PATCH
    return pictures.reshape(count, rows, PATCH, columns, PATCH, 3).mean(axis=(2, 4)).reshape(count, -1, 3)


@pytest.mark.slow
@pytest.mark.parametrize("name", RENDERED)
def test_patches_agree(folder, name):
    samples, replicates, apart = RENDERED[name]
    both = render_both(folder / f"{name}.blend", 0, samples, replicates)
    assert not both["scene"].notes
    ours, theirs = (patches_of(both[engine]) for engine in ("isophote", "cycles"))
    off = np.abs(ours.mean(axis=0) - theirs.mean(axis=0))
    noise = np.sqrt((ours.var(axis=0, ddof=1) + theirs.var(axis=0, ddof=1)) / replicates)
    allowed = apart * np.maximum(theirs.mean(axis=0), 0.1) + 4.0 * noise
    assert not {int(k): off[k].tolist() for k in np.flatnonzero((off > allowed).any(axis=1))}
    assert ours.mean() == pytest.approx(theirs.mean(), rel=3e-3)
