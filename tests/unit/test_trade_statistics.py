"""The trade report's statistics against Student's law and synthetic renders of known bias and noise."""

import math

import numpy as np
import pytest
from scipy import stats

from isophote.settings import Settings
from isophote.trade.advice import ERRORS, Curve, advise, curve_of, for_error, for_time, front_of, pareto
from isophote.trade.analysis import Replicates, make_reference, measure, offset, spread
from isophote.trade.grid import BASE, TRUTH, Choice
from isophote.trade.intervals import corrected_level, interval_of, log_jackknife, student_quantile

SHAPE = (24, 32, 3)
COUNTS = np.array([4.0, 16.0])


@pytest.mark.parametrize("freedom", [1, 2, 3, 4, 7, 8, 31])
@pytest.mark.parametrize("level", [0.95, corrected_level(30)])
def test_quantiles_are_students(freedom, level):
    assert student_quantile(level, freedom) == pytest.approx(stats.t.ppf(0.5 + level / 2, freedom), rel=1e-8)


def test_intervals_of_means_hold_as_often_as_they_say():
    rng = np.random.default_rng(1)
    held = [interval_of(rng.normal(3.0, 2.0, 5)) for _ in range(4000)]
    assert np.mean([i.low <= 3.0 <= i.high for i in held]) == pytest.approx(0.95, abs=0.012)
    assert interval_of([1.0]).high == math.inf


def test_jackknifed_ratios_hold_about_as_often_as_they_say():
    """The ratio of two noises over shared seeds, as noise_ratio is made."""
    rng = np.random.default_rng(2)
    below, held = np.ones((8, 8, 3)), 0
    for _ in range(400):
        common = rng.normal(0.0, 1.0, (8, 8, 8, 3))
        one = spread(0.5 * (0.8 * common + 0.6 * rng.normal(0.0, 1.0, common.shape)), below)
        other = spread(common, below)
        interval = log_jackknife(one[0] / other[0], one[1] / other[1])
        held += interval.low <= 0.25 <= interval.high
    assert 0.91 <= held / 400 <= 0.985


def test_parts_of_the_jackknife_are_estimates_without_one_replicate():
    rng = np.random.default_rng(3)
    pictures, below = rng.normal(1.0, 0.3, (5, 6, 7, 3)), rng.uniform(0.5, 2.0, (6, 7, 3))
    for estimate in (spread, offset):
        whole, parts = estimate(pictures, below)
        for left_out, part in enumerate(parts):
            assert estimate(np.delete(pictures, left_out, axis=0), below)[0] == pytest.approx(part, rel=1e-9)
        assert whole == pytest.approx(parts.mean(), rel=0.2)


def synthetic(key, truth, seeds, bias=0.0, noise=1.0, own=0.0, seconds=0.1, seed=0):
    """Renders with shared noise of `noise` / sqrt(samples), noise of their own, and a relative bias."""
    pictures = []
    for k in seeds:
        shared, mine = np.random.default_rng(k), np.random.default_rng([seed, k])
        pictures.append([truth * (1.0 + bias) + truth / math.sqrt(count)
                         * (noise * shared.normal(size=SHAPE) + own * mine.normal(size=SHAPE)) for count in COUNTS])
    choice = Choice(key, "Clamping", key.title(), Settings())
    times = np.array([[seconds * count for count in COUNTS] for _ in seeds])
    return Replicates(choice, list(seeds), np.array(pictures, np.float32), COUNTS, times, 0.01, {"device": "numpy"})


def measured_set(seeds=range(1, 9), **changes):
    truth = np.random.default_rng(7).uniform(0.2, 1.5, SHAPE)
    pieces = truth * (1.0 + 0.02 * np.random.default_rng(8).normal(size=(6, *SHAPE)))
    base = synthetic(BASE, truth, seeds)
    biased = synthetic("biased", truth, seeds, **({"bias": -0.03, "noise": 0.6, "own": 0.1, "seconds": 0.05, "seed": 1}
                                                  | changes))
    return measure(base, [biased], synthetic(TRUTH, truth, seeds, seconds=0.3), make_reference(pieces, 64), 4)


def test_known_bias_noise_and_time_are_found():
    base, biased, truth = measured_set()
    assert not base.bias_found and base.same_bits and base.light.value == 0.0
    assert biased.bias_found and biased.light_found
    assert biased.light_bias.low <= -0.03 <= biased.light_bias.high
    assert biased.light_bias.high - biased.light_bias.low < 0.01, "shared noise cancels"
    assert biased.noise_ratio.low <= math.hypot(0.6, 0.1) <= biased.noise_ratio.high
    assert biased.time.value == pytest.approx(0.5) and truth.time.value == pytest.approx(3.0)
    assert biased.effort.value == pytest.approx(0.5 * 0.37, rel=0.05)
    below = make_reference(np.random.default_rng(7).uniform(0.2, 1.5, SHAPE)[None], 1)
    relative = below.picture ** 2 / below.below
    assert biased.bias == pytest.approx(0.03 * math.sqrt(relative.mean()), rel=0.1)
    for s, count in enumerate(COUNTS):
        assert base.noise[s].value == pytest.approx(math.sqrt(relative.mean() / count), rel=0.03)
        assert biased.error[s].value == pytest.approx(math.hypot(biased.noise[s].value, biased.bias), rel=1e-6)
    assert biased.tile_bias == pytest.approx(0.03, rel=0.2) and biased.tiles_off > 0.2


def test_intervals_of_light_hold_as_often_as_they_say():
    held = missed = 0
    for trial in range(60):
        seeds = range(100 * trial, 100 * trial + 5)
        _, biased, _ = measured_set(seeds, bias=0.004, noise=1.0, own=0.3, seed=trial)
        held += biased.light_bias.low <= 0.004 <= biased.light_bias.high
        _, unbiased, _ = measured_set(seeds, bias=0.0, noise=1.0, own=0.3, seed=trial + 1000)
        missed += unbiased.light_found or unbiased.bias_found
    assert held / 60 == pytest.approx(0.95, abs=0.07)
    assert missed / 60 <= 0.12, "5 % for all comparisons together"


def test_curves_interpolate_extrapolate_and_keep_the_bias():
    curve = Curve("a", "A", np.array([1.0, 4.0]), np.array([16.0, 64.0]), np.array([0.2, 0.1]), 0.03)
    assert curve.power == pytest.approx(1.0)
    assert curve.error_at(4.0) == pytest.approx(math.hypot(0.1, 0.03))
    assert curve.error_at(16.0) == pytest.approx(math.hypot(0.05, 0.03))
    assert curve.seconds_for(curve.error_at(9.0)) == pytest.approx(9.0, rel=1e-6)
    assert curve.seconds_for(0.03) is None and curve.error_at(0.01) is None


def test_advice_takes_the_soonest_and_names_what_is_out_of_reach():
    fast = Curve("fast", "Fast", np.array([0.5, 2.0]), np.array([16.0, 64.0]), np.array([0.2, 0.1]), 0.04)
    base = Curve(BASE, "Base", np.array([1.0, 4.0]), np.array([16.0, 64.0]), np.array([0.2, 0.1]), 0.0)
    assert for_error([base, fast], 0.15).choice == "fast" and not for_error([base, fast], 0.15).extrapolated
    near = for_error([base, fast], 0.04)
    assert near.choice == BASE and near.extrapolated and near.seconds == pytest.approx(25.0)
    assert for_error([fast, Curve(BASE, "Base", base.seconds, base.counts, base.noise, 0.5)], 0.01).choice is None
    assert for_time([base, fast], 1.0).choice == "fast" and for_time([base, fast], 600.0).choice == BASE
    nearly = Curve("nearly", "Nearly", 0.95 * base.seconds, base.counts, base.noise, 0.0)
    assert for_error([base, nearly], 0.1).choice == BASE, "5 % are not worth a change"


def test_the_front_holds_what_nothing_beats():
    assert pareto([(1.0, 5.0), (2.0, 3.0), (3.0, 4.0), (4.0, 1.0), (2.0, 6.0), (5.0, 0.999)]) == [0, 1, 3]
    assert front_of(measured_set()) == [(1, 0), (1, 1)], "half the time and less noise, but for a small bias"
    assert front_of(measured_set(bias=-0.9)) == [(1, 0), (0, 0), (0, 1)]


def test_advice_of_measured_choices():
    made = measured_set()
    assert len(advise(made)) == len(ERRORS) + 3
    assert curve_of(made[0]).error_at(made[0].seconds[-1]) == pytest.approx(made[0].error[-1].value, rel=1e-3)
