"""Subsurface scattering against Cycles: a ball of each kind (blend_scenes/nodes/make_subsurface.py)."""

import pytest

from bench.shaders import MAKER, compare_shaders
from tests.images.agreement import rows_off

# Cycles drops what is left after 256 flights, of light colours in dense media some per cent. There (tests/analytic has
# what theory gives) the channel may be brighter by so much.
BRIGHTER = {"node, nearly white": 0.04, "skin": 0.015, "skin, anisotropy 0.8": 0.045, "two of them": 0.045}


@pytest.mark.slow
def test_balls_agree():
    rows, bits = compare_shaders("", samples=32, replicates=8, maker=MAKER.with_name("make_subsurface.py"))
    assert len(rows) > 20 and bits.get("differing", 0) == 0
    off = rows_off(rows, BRIGHTER)
    assert not off, off
