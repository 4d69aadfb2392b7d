"""A scene by both engines: the statistical test that several files here ask of theirs."""

from __future__ import annotations

from pathlib import Path

from bench.common import ROOT
from bench.cycles_compare import render_both, same_bits
from bench.cycles_process import run_script
from bench.replicates import compare_replicates

SIZE = 48  # pixels, of the longer side
CLOSE = 0.01  # relative, of a channel's mean over a shader's ball


def made(script: str, blend: Path, *arguments: str) -> Path:
    """The scene that a script of blend_scenes makes."""
    run_script(ROOT / "blend_scenes" / script, "--", blend, *arguments, makes=blend)
    return blend


def assert_agrees(blend: Path, samples: int, replicates: int, noise: float, slack: float = 2e-4, over=None) -> dict:
    """Means, tiles and pixels, `noise` times Cycles' variance at most, and the same bits from OpenCL.

    Means may differ by half as much again as their interval and by `slack`; `over` as in render_both. Gives
    compare_replicates' findings.
    """
    renders = render_both(blend, SIZE, samples, replicates, over)
    assert not renders["scene"].notes, renders["scene"].notes
    found = compare_replicates(renders["isophote"], renders["cycles"])
    for mean in found["means"]:
        assert abs(mean["ratio"] - 1.0) <= 1.5 * mean["half_interval"] + slack, found
    assert found["tiles"]["passed"] and found["pixels"]["passed"], found
    assert found["noise"]["median"] <= noise, found
    bits = same_bits(renders["scene"], renders["settings"])
    assert bits.get("differing", 0) == 0, bits
    return found


def rows_off(rows: list[dict], brighter: dict[str, float] | None = None) -> dict[str, dict]:
    """Rows of compare_shaders with notes, or with a mean beyond CLOSE; `brighter`: how much more some may have."""
    def is_off(row) -> bool:
        most = (brighter or {}).get(row["shader"], CLOSE)
        pairs = zip(row["ratios"], row["half_intervals"], strict=True)
        return row["notes"] or any(not -CLOSE - 2 * half <= ratio - 1 <= most + 2 * half for ratio, half in pairs)
    return {row["shader"]: row for row in rows if is_off(row)}
