"""Every shader's ball against Cycles: bench.shaders at a size for CI."""

import pytest

from bench.shaders import compare_shaders
from tests.images.agreement import rows_off


@pytest.mark.slow
def test_shaders_agree():
    rows, bits = compare_shaders("", samples=32, replicates=8)
    assert len(rows) > 50 and bits.get("differing", 0) == 0
    off = rows_off(rows)
    assert not off, off
