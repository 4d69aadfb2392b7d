"""bench.rounding and bench.fast_bias in small: what float32 and fast precision do to pictures."""

import pytest

from bench.fast_bias import bias_row
from bench.rounding import rounding_row
from isophote.settings import Settings
from tests.parity.scenes import SCENES

SAMPLES = 64


@pytest.mark.parametrize("name", ["cornell_like", "closures"])
def test_rounding_is_far_below_the_noise(name):
    """A thousand times below that of 1,024 samples, and samples that turned at an edge favour no side."""
    row = rounding_row(SCENES[name](), SAMPLES)
    assert row["ratio"] * SAMPLES / 1024 > 1000
    assert row["turned"] < 2e-3 and abs(row["bias"]) <= max(2 * row["bias_95"], 1e-3)


def test_fast_precision_takes_the_same_paths():
    row = bias_row(SCENES["cornell_like"](), Settings(samples=SAMPLES), 4)
    assert row["image"] == "within" and row["tiles"] == 1.0 and row["rel_mse"] < 1e-6 * row["noise"]
