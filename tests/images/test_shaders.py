"""Every shader's ball against Cycles: bench.shaders at a size for CI."""

import pytest

from bench.shaders import compare_shaders

CLOSE = 0.01  # relative, of a channel's mean over a ball


@pytest.mark.slow
def test_shaders_agree():
    rows, bits = compare_shaders("", samples=32, replicates=8)
    assert len(rows) > 50 and bits.get("differing", 0) == 0
    off = {row["shader"]: row for row in rows
           if row["notes"] or any(abs(ratio - 1) > CLOSE + 2 * half
                                  for ratio, half in zip(row["ratios"], row["half_intervals"], strict=True))}
    assert not off, off
