"""The error bars hold what they claim, on synthetic films with a known answer.

Bounds on coverage: one pixel a tile is looked at, so the tests are independent; a share of N tests
lies within 4.9 binomial standard deviations of its expectation with probability 1 - 1e-6.
"""

import math

import numpy as np
import pytest
from scipy import stats

from isophote.film import COMBINED_PLANES, Film
from isophote.passes import combined
from isophote.statistics import (
    LUMINANCE,
    image_error,
    mean_and_error,
    pixel_error,
    pixels_of_tiles,
    pool,
    spread_over_tiles,
    sums_over_tiles,
)

rng = np.random.default_rng(20240607)


def normal_film(height, width, samples, mean, sigma, origin=(0, 0)):
    """A film whose samples are normal: RGB independent, of `mean` and `sigma` (numbers or (h, w))."""
    film = Film((*origin, origin[0] + width, origin[1] + height), COMBINED_PLANES)
    film.add_samples(samples)  # an open block: at most 63
    for replicate, count in enumerate(film.replicate_samples):
        for channel in range(3):
            noise = sigma * math.sqrt(count) * rng.standard_normal((height, width))
            film.open[4 * replicate + channel] = count * mean + noise
        film.open[4 * replicate + 3] = count
    return film


def coverage_bound(expected, tests):
    return 4.9 * math.sqrt(expected * (1.0 - expected) / tests)


@pytest.mark.parametrize("samples", [2, 3, 5, 32, 63])
def test_error_bars_cover(samples):
    film = normal_film(384, 384, samples, mean=2.0, sigma=1.0)
    z = ((combined(film)[..., :3] - 2.0) / pixel_error(film))[3::8, 3::8]
    expected = 1.0 - 2.0 * stats.t.sf(1.96, 64)
    inside = (np.abs(z) < 1.96).mean()
    bound = coverage_bound(expected, z.size)
    assert abs(inside - expected) < bound
    assert abs((np.abs(z) < 1.96 * 0.85).mean() - expected) > bound, "the test would not see bars 15 % too short"


def test_error_bars_cover_where_tiles_differ_from_each_other():
    sigma = np.kron(np.geomspace(0.01, 10.0, 48 * 48).reshape(48, 48), np.ones((8, 8)))
    film = normal_film(384, 384, 16, mean=5.0, sigma=sigma)
    z = ((combined(film)[..., :3] - 5.0) / pixel_error(film))[4::8, 4::8]
    expected = 1.0 - 2.0 * stats.t.sf(1.96, 64)
    assert abs((np.abs(z) < 1.96).mean() - expected) < coverage_bound(expected, z.size)


def test_pixel_error_by_hand():
    film = Film((0, 0, 1, 1), COMBINED_PLANES)
    film.open[0], film.open[4] = 6.0, 1.0  # replicate 0: three samples of mean 2; replicate 1: two of mean 0.5
    film.add_samples(5)
    assert pixel_error(film)[0, 0, 0] == pytest.approx(math.sqrt(1.5**2 * 6 / 25))


def test_even_counts_are_half_the_difference():
    film = Film((0, 0, 1, 1), COMBINED_PLANES)
    film.open[0], film.open[4] = 8.0, 4.0
    film.add_samples(8)
    assert pixel_error(film)[0, 0, 0] == pytest.approx(0.5)


def test_one_sample_has_no_error():
    film = normal_film(8, 8, 1, 1.0, 1.0)
    assert np.isnan(pixel_error(film)).all()
    assert image_error(film) is None


def test_black_pictures_have_no_relative_error():
    film = Film((0, 0, 4, 4), COMBINED_PLANES)
    film.add_samples(4)
    assert image_error(film) is None


def test_image_error_is_the_relative_rms_error():
    film = normal_film(256, 256, 32, mean=2.0, sigma=0.5)
    truth = 0.5 / math.sqrt(32) * math.sqrt((LUMINANCE**2).sum()) / 2.0
    estimate = image_error(film)
    assert estimate.value == pytest.approx(truth, rel=0.03)
    picture = combined(film)[..., :3].astype(float) @ LUMINANCE
    assert estimate.value == pytest.approx(math.sqrt(((picture - 2.0) ** 2).mean()) / 2.0, rel=0.03)


def test_the_interval_of_the_image_error_covers():
    truth = math.sqrt((LUMINANCE**2).sum()) / math.sqrt(16) / 3.0
    trials = 600
    inside = 0
    for _ in range(trials):
        estimate = image_error(normal_film(48, 48, 16, mean=3.0, sigma=1.0))
        inside += estimate.low <= truth <= estimate.high
    assert abs(inside / trials - 0.95) < coverage_bound(0.95, trials)


def test_tiles_follow_the_full_frame():
    ones = sums_over_tiles(np.ones((10, 13)), origin=(5, 14))
    assert (pixels_of_tiles((10, 13), (5, 14)) == ones).all()
    assert ones.tolist() == [[3 * 2, 8 * 2, 2 * 2], [3 * 8, 8 * 8, 2 * 8]]


@pytest.mark.parametrize("origin", [(0, 0), (5, 14), (8, 7), (31, 1)])
@pytest.mark.parametrize("shape,tile", [((1, 1), 8), ((10, 13), 8), ((16, 7), 4), ((33, 20), 16), ((5, 90), 64)])
def test_tiles_have_the_pixels_that_lie_in_them(origin, shape, tile):
    x, y = (np.arange(size) + first for size, first in zip(shape[::-1], origin, strict=True))
    names = 1000 * (y // tile - y[0] // tile)[:, None] + (x // tile - x[0] // tile)
    tiles = 1000.0 * np.arange(names[-1, 0] // 1000 + 1)[:, None] + np.arange(names[0, -1] + 1)
    counts = np.unique(names, return_counts=True)[1].reshape(tiles.shape)
    assert (spread_over_tiles(tiles, shape, origin, tile) == names).all()
    assert (pixels_of_tiles(shape, origin, tile) == counts).all()
    assert (sums_over_tiles(names, origin, tile) == counts * tiles).all()


def test_a_region_pools_over_the_tiles_of_the_full_frame():
    whole = normal_film(24, 24, 8, mean=1.0, sigma=np.linspace(0.1, 2.0, 24))
    part = Film((5, 3, 24, 24), COMBINED_PLANES)
    part.add_samples(8)
    part.open[:] = whole.open[:, 3:, 5:]
    assert np.allclose(pixel_error(part)[5:, 3:], pixel_error(whole)[8:, 8:], rtol=1e-6)


def test_the_interval_of_a_region_uses_the_tiles_of_the_full_frame():
    sigma = np.kron(np.arange(64).reshape(8, 8) % 2 * 3.0 + 0.01, np.ones((8, 8)))[3:, 5:]
    film = normal_film(61, 59, 8, mean=1.0, sigma=sigma, origin=(5, 3))
    aligned = image_error(film)
    film.region = (0, 0, 59, 61)  # tiles now mix quiet and loud pixels: the interval must be wider
    misaligned = image_error(film)
    assert misaligned.value == aligned.value
    assert misaligned.high - misaligned.low > 1.05 * (aligned.high - aligned.low)


def test_pool_equals_means_of_slices():
    values = rng.random((11, 9))
    pooled = pool(values, origin=(3, 6))
    assert np.allclose(pooled[:2, :5], values[:2, :5].mean())
    assert np.allclose(pooled[2:10, 5:9], values[2:10, 5:9].mean())
    assert np.allclose(pooled[10:, 5:], values[10:, 5:].mean())


def test_mean_and_error_of_renders():
    renders = 1.0 + 0.2 * rng.standard_normal((4, 64, 64, 3))
    mean, error = mean_and_error(renders)
    assert mean.shape == (64, 64, 3)
    assert np.sqrt((error**2).mean()) == pytest.approx(0.1, rel=0.05)
    with pytest.raises(ValueError, match="at least 2"):
        mean_and_error(renders[:1])
