"""Input nodes, normals and Light Path against Cycles: make_inputs.py and make_normals.py, patch by patch."""

import numpy as np
import pytest

from bench.cycles_compare import render_both
from tests.images.patches import make_blends, patches_of

PATCH = 32  # pixels
# Samples of a replicate and replicates; what means of a patch may be apart, in parts, beyond what noise explains.
RENDERED = {"inputs": (1, 2, 4e-3), "instances": (1, 2, 4e-3), "normals": (16, 3, 0.01), "steps": (1, 2, 4e-3),
            "paths": (16, 3, 4e-3)}
POINTWISE, SHOWN = 1e-3, ("inputs", "instances", "steps")  # difference of nine pixels out of ten, without noise


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("inputs")
    for script in ("make_inputs.py", "make_normals.py"):
        make_blends(script, made)
    return made


@pytest.mark.slow
@pytest.mark.parametrize("name", RENDERED)
def test_patches_agree(folder, name):
    samples, replicates, apart = RENDERED[name]
    both = render_both(folder / f"{name}.blend", 0, samples, replicates)
    assert not both["scene"].notes
    ours, theirs = (patches_of(both[engine], PATCH) for engine in ("isophote", "cycles"))
    if name in SHOWN:
        pixels = np.abs(ours.mean(axis=0) - theirs.mean(axis=0)).max(axis=-1)
        assert not np.flatnonzero(np.quantile(pixels, 0.9, axis=1) > POINTWISE).tolist()
    ours, theirs = ours.mean(axis=2), theirs.mean(axis=2)
    off = np.abs(ours.mean(axis=0) - theirs.mean(axis=0))
    noise = np.sqrt((ours.var(axis=0, ddof=1) + theirs.var(axis=0, ddof=1)) / replicates)
    allowed = apart * np.maximum(theirs.mean(axis=0), 0.1) + 4.0 * noise
    assert not {int(k): off[k].tolist() for k in np.flatnonzero((off > allowed).any(axis=1))}
    assert ours.mean() == pytest.approx(theirs.mean(), rel=3e-3)
