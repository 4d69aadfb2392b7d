"""The study: variants refuse what cannot be, trees keep their promises, rows are resumable and can be drawn."""

import json
from dataclasses import replace

import numpy as np
import pytest

from bench.study import trees
from bench.study.experiments import EXPERIMENTS, cpu_scale, gpu_scale
from bench.study.measure import Case, run_experiment
from bench.study.scenes import make_room, ready_with_leaves
from bench.study.variant import Variant
from isophote.records import numbers


@pytest.fixture(scope="module")
def room():
    return ready_with_leaves(make_room(2000), 1)


@pytest.mark.parametrize("wrong", [dict(traversal="octree"), dict(schedule="later"), dict(group=48),
                                   dict(sort="ray"), dict(traversal="list_local"), dict(ordered=False),
                                   dict(traversal="wide4", schedule="breadth_first")])
def test_variants_that_cannot_be(wrong):
    with pytest.raises(ValueError):
        Variant(**wrong)


def test_rooms_have_as_many_triangles_as_asked_for():
    for count in (32, 1000, 30000):
        assert abs(len(make_room(count).triangles) / count - 1) < 0.15


@pytest.mark.parametrize("size", [1, 4, 32])
def test_leaves_of_any_size(room, size):
    made = trees.with_leaves(room, size)
    leaves = trees.leaves_below(made, trees.roots(made)[-1])
    lengths = trees.run_lengths(made.buffers["triangles"])[trees.index_of(leaves)]
    assert lengths.max() <= size and lengths.sum() == len(room.buffers["triangles"])
    assert size == 1 or lengths.mean() > size / 3


def test_a_list_is_one_run(room):
    made = trees.as_list(room)
    assert trees.run_lengths(made.buffers["triangles"])[0] == len(room.buffers["triangles"])


def test_parents_lead_back_to_the_root(room):
    made = trees.with_parents(room)
    root, at = trees.roots(made)[-1], np.flatnonzero(made.buffers["nodes"]["unused"][:, 0] != numbers()["NONE"])
    for _ in range(64):
        parent = made.buffers["nodes"]["unused"][at, 0]
        at = np.where(parent == numbers()["NONE"], at, parent >> 1)
    assert (at == root).all()


@pytest.mark.parametrize("width", [4, 8])
def test_quantised_boxes_enclose_what_is_below(room, width):
    """Planes as kernels decode them, in float64, lie outside the corners of every triangle below."""
    made = trees.as_wide(room, width, True)
    nodes, none = made.buffers["nodes"], numbers()["NONE"]
    triangles = made.buffers["triangles"]
    corners = np.stack([triangles[f"v{k}"] for k in range(3)], axis=1).astype(float)
    below_lo, below_hi = (np.full((len(nodes), 3), fill) for fill in (np.inf, -np.inf))
    checked = 0
    for at in range(len(nodes) - 1, -1, -1):  # children follow their parents
        for place, ref in enumerate(nodes["child"][at]):
            if ref == none:
                continue
            index = trees.index_of(int(ref))
            lo, hi = ((below_lo[index], below_hi[index]) if trees.is_node(ref) else
                      (corners[index].min(0), corners[index].max(0)))
            below_lo[at], below_hi[at] = np.minimum(below_lo[at], lo), np.maximum(below_hi[at], hi)
            for axis, name in enumerate("xyz"):
                step = 2.0 ** ((int(nodes["exponents"][at]) >> 8 * axis & 255) - 127)
                words = [np.atleast_1d(nodes[f"{bound}_{name}"][at])[place // 4] for bound in ("lo", "hi")]
                planes = [nodes["corner"][at, axis] + step * (int(word) >> 8 * (place % 4) & 255) for word in words]
                assert planes[0] <= lo[axis] and planes[1] >= hi[axis]
                checked += 1
    assert checked > 3 * len(triangles)


def test_a_stack_that_is_too_small_is_refused(room):
    with pytest.raises(ValueError, match="needs a stack of"):
        trees.adapt(room, Variant("stack", stack=4))


def test_every_experiment_can_be_told_apart_by_its_keys():
    for scale in (gpu_scale((1, 4)), cpu_scale((1, 2))):
        for experiment in EXPERIMENTS.values():
            keys = [case.key for group in experiment(scale) for case in group]
            assert keys and len(keys) == len(set(keys))


def test_rows_are_kept_and_drawn(tmp_path, capsys):
    """A tiny experiment is measured once, goes on where it stopped, and becomes a figure and a table."""
    case = Case("pixels", "room:100", "openmp", size=8, samples=64, threads=1, x=1)
    cases = [case, replace(case, label="samples", over="samples")]
    for part in (cases[:1], cases, cases):
        run_experiment("threads", [part], tmp_path, tmp_path, "opencl:0", 0.01, 60)
    rows = [json.loads(line) for line in (tmp_path / "threads.jsonl").read_text().splitlines()]
    assert [row["label"] for row in rows] == ["pixels", "samples"]
    assert all(row["msamples_per_second"] > 0 for row in rows)
    pytest.importorskip("matplotlib")
    from bench.study.draw import draw_all

    draw_all(tmp_path, tmp_path / "drawn")
    assert (tmp_path / "drawn" / "threads.png").stat().st_size > 1000
    assert "| 1 | " in (tmp_path / "drawn" / "tables.md").read_text()
