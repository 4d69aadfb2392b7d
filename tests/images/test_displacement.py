"""Displaced meshes against Cycles: blend_scenes/nodes/make_displacement.py, patch by patch."""

import numpy as np
import pytest

from bench.cycles_compare import render_both
from tests.images.patches import make_blends, patches_of

PATCH = 32  # pixels
CLOSE, STEEP = 0.002, 0.015  # difference of nine pixels out of ten: usually, and where normals turn within a pixel


@pytest.mark.slow
def test_normals_of_displaced_meshes_agree(tmp_path):
    make_blends("make_displacement.py", tmp_path)
    both = render_both(tmp_path / "displacement.blend", 0, 1, 2)
    assert not both["scene"].notes
    ours, theirs = (patches_of(both[engine], PATCH).mean(axis=0) for engine in ("isophote", "cycles"))
    off = np.quantile(np.abs(ours - theirs).max(axis=-1), 0.9, axis=1)
    assert len(off) > 50 and not np.flatnonzero(off > STEEP).tolist() and np.median(off) < CLOSE
    assert ours.mean() == pytest.approx(theirs.mean(), rel=2e-3)
