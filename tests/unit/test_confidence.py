"""Claims hold on synthetic films with a known answer, and are not made where light comes in rare hits."""

import math

import numpy as np
import pytest
from scipy import stats

from isophote.confidence import Claim, claim_of, error_of_most, relative_errors, student95, tiles_of
from isophote.film import COMBINED_PLANES, Film
from isophote.statistics import luminance_of, sums_over_tiles

rng = np.random.default_rng(19)
SIDE = 256


def grey_film(halves, samples=64, origin=(0, 0)):
    """A film of `samples` whose two replicates have these means (h, w), the same in R, G and B."""
    height, width = halves[0].shape
    film = Film((*origin, origin[0] + width, origin[1] + height), COMBINED_PLANES)
    film.end = samples
    for replicate, count in enumerate(film.replicate_samples):
        for channel in range(3):
            film.totals[4 * replicate + channel].add(halves[replicate] * count)
    return film


def normal_film(mean=2.0, sigma=0.1, side=SIDE, **options):
    """Pixels off by `sigma` each, (side, side) or numbers."""
    return grey_film([mean + math.sqrt(2.0) * sigma * rng.standard_normal((side, side)) for _ in range(2)], **options)


def film_of_hits(rate, height=1.0, background=0.0, side=SIDE):
    """Poisson hits, `rate` a tile, each of which adds `height` to a pixel, on a background without noise."""
    hits = [rng.poisson(rate / 64 / 2 * np.ones((side, side))) for _ in range(2)]
    return grey_film([background + 2.0 * height * k for k in hits])


def wrong(film, truth):
    """(unsure, wrong among the sure): shares of tiles whose mean should be `truth`."""
    tiles = tiles_of(luminance_of(film))
    low, high = tiles.interval()
    missed = (truth < low) | (truth > high)
    return tiles.unsure.mean(), (missed & ~tiles.unsure).sum() / max(1, (~tiles.unsure).sum())


def test_intervals_of_normal_noise_hold():
    unsure, share = wrong(normal_film(), 2.0)
    assert unsure == 0.0 and 0.03 < share < 0.07
    assert wrong(normal_film(), 2.0 + 0.1 / 8)[1] > 0.1, "the test would not see a shift of one standard deviation"


@pytest.mark.parametrize("rate", [0.03, 0.3, 1.0, 3.0])
def test_few_hits_are_flagged(rate):
    unsure, share = wrong(film_of_hits(rate), rate / 64)
    assert unsure > 0.9 and (1.0 - unsure) * share < 0.005


@pytest.mark.parametrize("rate", [15.0, 30.0, 100.0])
def test_enough_hits_are_claimed_and_hold(rate):
    unsure, share = wrong(film_of_hits(rate), rate / 64)
    assert unsure < 0.1 and share < 0.07


def test_a_noisy_edge_is_not_few_hits():
    """One column of each tile is noisy, half bright and half dark: 64 samples, 8 pixels of some 30 hits."""
    edge = np.arange(SIDE) % 8 == 3
    halves = [np.where(edge, rng.binomial(32, 0.5, (SIDE, SIDE)) / 32, (np.arange(SIDE) % 8 > 3) * 1.0) for _ in "ab"]
    unsure, share = wrong(grey_film(halves), 4.5 / 8)
    assert unsure < 0.02 and share < 0.07


def test_light_that_quiet_tiles_may_have_missed_flags_them():
    noise = normal_film(0.5, 0.001)
    hits = film_of_hits(0.5, height=0.5)
    both = grey_film([noise.sum(4 * r) / 32 + hits.sum(4 * r) / 32 for r in (0, 1)])
    assert wrong(both, 0.5 + 0.5 * 0.5 / 64) == (1.0, 0.0)
    assert wrong(noise, 0.5)[0] == 0.0


def test_black_is_unsure_near_rare_light_and_a_background_is_not():
    halves = [np.zeros((64, 64)), np.zeros((64, 64))]
    halves[0][20, 20] = halves[1][40, 50] = 5.0
    black = tiles_of(luminance_of(grey_film(halves)))
    assert black.unsure.all() and (black.unseen > 0.0).all()
    bright = tiles_of(luminance_of(grey_film([half + (half == 0.0) for half in halves])))
    assert bright.unsure.sum() == 2 * 9 and not bright.unseen[bright.sigma == 0.0].any(), "those and around them"
    assert not tiles_of(luminance_of(grey_film([np.zeros((64, 64))] * 2))).unsure.any()


def test_tiles_follow_the_full_frame():
    film = normal_film(side=40, origin=(5, 3))
    tiles = tiles_of(luminance_of(film))
    assert tiles.mean.shape == tiles.unsure.shape == tiles.unseen.shape == (6, 6)
    counts = sums_over_tiles(np.ones((40, 40)), (5, 3))
    assert (tiles.mean * counts).sum() == pytest.approx(luminance_of(film).mean.sum())


def test_the_error_of_most_pixels_is_1_96_sigma():
    claim = claim_of(normal_film(2.0, 0.02))
    assert claim.most.value == pytest.approx(1.96 * 0.01, rel=0.03)
    assert claim.most.low < claim.most.value < claim.most.high < 1.05 * claim.most.low
    assert claim.unsure == 0.0 and claim.mean.value == pytest.approx(0.01, rel=0.03)


def test_dark_pixels_are_measured_by_a_tenth_of_the_mean():
    mean = np.where(np.arange(SIDE) < SIDE // 2, 2.0, 1e-4)[None, :]  # the picture's mean is 1
    seen = luminance_of(normal_film(mean, 0.01))
    errors = relative_errors(seen, tiles_of(seen))
    assert error_of_most(errors[:, SIDE // 2 + 1:]).value == pytest.approx(1.96 * 0.1, rel=0.03)


def test_unseen_light_keeps_the_error_of_most_pixels_large():
    noise, hits = normal_film(0.001, 1e-6), film_of_hits(0.5)
    claim = claim_of(grey_film([(noise.sum(4 * r) + hits.sum(4 * r)) / 32 for r in (0, 1)]))
    assert claim.unsure == 1.0 and claim.most.value > 1.0, "half the tiles look perfect"


def test_nothing_is_claimed_of_nothing():
    film = Film((0, 0, 8, 8), COMBINED_PLANES)
    film.add_samples(1)
    assert claim_of(film) == Claim(None, None, None)
    assert claim_of(grey_film([np.zeros((8, 8))] * 2)).most is None


def test_student_s_quantile():
    freedom = np.array([3, 4, 6, 10, 20, 64, 1000])
    assert np.allclose(student95(freedom), stats.t.ppf(0.975, freedom), rtol=0.01)
