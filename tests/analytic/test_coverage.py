"""Renders know their error: a small form of bench/coverage.py, in which nothing may be claimed that does not hold."""

import pytest

from bench.coverage import coverage_rows, looks_of
from isophote.scene import resized
from isophote.settings import Settings
from tests.parity.scenes import cornell_like, lamps
from tests.rare_scenes import SCENES

COUNTS, SEEDS = (16, 64, 256), 6
SCENES = SCENES | {name: lambda make=make: resized(make(), (60, 48))
                   for name, make in (("cornell_like", cornell_like), ("lamps", lamps))}


@pytest.mark.parametrize("name", SCENES)
def test_what_is_claimed_holds(name):
    looks = looks_of(SCENES[name](), Settings(samples=COUNTS[-1]), COUNTS, range(1, SEEDS + 1))
    rows = list(coverage_rows(looks, COUNTS))
    sure = sum(row["sure"] for row in rows)
    wrong = sum(row["sure"] * row["wrong"] for row in rows if row["sure"])
    assert wrong <= 0.07 * sure + 3.0 * (0.07 * sure) ** 0.5, rows
    assert all(row["claimed"] > 0.85 or row["error"] > 1.0 for row in rows), "a smaller error was claimed than there is"
    if rows[-1]["error"] < 0.3:
        assert rows[-1]["claimed"] < 1.2 and rows[-1]["unsure"] < 0.3 and 0.91 < rows[-1]["tiles"] < 0.99
