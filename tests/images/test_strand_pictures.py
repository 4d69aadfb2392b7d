"""Hair against Cycles: blend_scenes/nodes/make_strands.py."""

import numpy as np
import pytest

from bench.cycles_compare import render_both, same_bits
from bench.cycles_process import exported
from bench.replicates import compare_replicates
from tests.images.agreement import SIZE, assert_agrees, made

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("kind", ["fur", "info"])
def test_3d_curves_agree(kind, tmp_path):
    blend = made("nodes/make_strands.py", tmp_path / f"{kind}.blend", kind)
    assert_agrees(blend, 48, 4, noise=1.4, slack=5e-4)
    scene = exported(blend, (8, 6))
    assert (scene.mesh_radii > 0).sum() == {"fur": 2, "info": 4}[kind]


@pytest.mark.parametrize("kind", ["children", "shaders", "curves"])
def test_ribbons_and_open_ends_have_the_same_means(kind, tmp_path):
    """Tubes here, in Cycles ribbons that face each ray; of Curves as thick as these one sees the ends."""
    blend = made("nodes/make_strands.py", tmp_path / f"{kind}.blend", kind)
    renders = render_both(blend, SIZE, 48, 4)
    assert not renders["scene"].notes, renders["scene"].notes
    for mean in compare_replicates(renders["isophote"], renders["cycles"])["means"]:
        assert abs(mean["ratio"] - 1.0) <= 1.5 * mean["half_interval"] + 3e-3, mean
    bits = same_bits(renders["scene"], renders["settings"])
    assert bits.get("differing", 0) == 0, bits


def test_shares_and_radii_are_those_of_blender(tmp_path):
    """In the object's space, tapered from root to tip."""
    scene = exported(made("nodes/make_strands.py", tmp_path / "info.blend", "info"), (8, 6))
    mesh = int(np.flatnonzero(scene.mesh_radii)[0])
    own = slice(*scene.mesh_triangles[mesh:mesh + 2].tolist())
    segments = scene.triangles[own].astype(int)
    assert (segments == segments[:, :1] + (0, 1, 0)).all()
    radii = scene.radii[int(scene.mesh_radii[mesh]) - 1:][segments[:, 0] - int(scene.mesh_vertices[mesh])]
    roots = np.flatnonzero(np.diff(segments[:, 0], prepend=-9) != 1)
    assert len(roots) == 30
    np.testing.assert_allclose(radii[roots], 0.03, rtol=1e-6)
    lengths = np.linalg.norm(np.diff(scene.vertices[segments[:, :2]], axis=1)[:, 0], axis=1)
    total = np.add.reduceat(lengths, roots)
    along = np.concatenate([np.cumsum(part) - part for part in np.split(lengths, roots[1:])]) / np.repeat(
        total, np.diff([*roots, len(lengths)]))
    np.testing.assert_allclose(radii, 0.03 * (1.0 - along), atol=1e-4)  # between points by Catmull and Rom, too
