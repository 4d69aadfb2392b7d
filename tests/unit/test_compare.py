import numpy as np
import pytest

from isophote.compare import CompareError, compare, corrected_p, z_test
from isophote.images import Image
from isophote.statistics import mean_and_error

rng = np.random.default_rng(11)


def picture(rgb):
    return Image({"Combined": np.concatenate([rgb, np.ones_like(rgb[..., :1])], axis=2).astype(np.float32)})


def test_known_answers():
    b = picture(np.full((16, 16, 3), 0.5))
    a = picture(np.full((16, 16, 3), [0.5, 0.55, 0.25]))
    result = compare(a, b)
    assert result["mean_ratio"] == pytest.approx([1.0, 1.1, 0.5])
    assert result["rmse"] == pytest.approx(np.sqrt((0.05**2 + 0.25**2) / 3))
    assert result["relmse"] == pytest.approx((0.05**2 + 0.25**2) / 3 / 0.26)
    assert (result["differing_floats"], result["compared_floats"]) == (2 * 256, 4 * 256)


def test_psnr_of_a_known_step():
    a, b = picture(np.zeros((8, 8, 3))), picture(np.ones((8, 8, 3)))
    assert compare(a, b)["psnr"] == pytest.approx(0.0, abs=1e-9)
    assert compare(a, a)["psnr"] is None
    assert compare(b, a)["mean_ratio"] == [None] * 3


def test_flip_is_0_for_equals_and_1_for_black_and_white():
    pytest.importorskip("flip_evaluator")
    a, b = picture(np.zeros((32, 32, 3))), picture(np.ones((32, 32, 3)))
    assert compare(a, a)["flip"] == pytest.approx(0.0, abs=1e-6)
    assert compare(a, b)["flip"] > 0.9


def test_missing_flip_says_so(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "flip_evaluator", None)
    result = compare(picture(np.ones((4, 4, 3))), picture(np.ones((4, 4, 3))))
    assert result["flip"] is None and "no FLIP" in result["notes"][0]


def test_bits_are_compared_not_values():
    a, b = picture(np.zeros((4, 4, 3))), picture(np.zeros((4, 4, 3)))
    b.planes["Combined"][0, 0, :2] = -0.0
    a.planes["Combined"][1, 1, 1] = b.planes["Combined"][1, 1, 1] = np.nan
    b.planes["Combined"][2, 2, 2] = np.float32(1e-45)
    assert compare(a, b)["differing_floats"] == 3


def test_passes_in_one_picture_only_are_noted():
    a, b = picture(np.ones((4, 4, 3))), picture(np.ones((4, 4, 3)))
    a.planes["Depth"] = np.ones((4, 4, 1), np.float32)
    assert any("Depth" in note for note in compare(a, b)["notes"])


def test_pictures_that_do_not_fit_are_refused():
    with pytest.raises(CompareError, match="4x4 and 5x4"):
        compare(picture(np.ones((4, 4, 3))), picture(np.ones((4, 5, 3))))
    with pytest.raises(CompareError, match="second picture has no pass Combined, only Depth"):
        compare(picture(np.ones((4, 4, 3))), Image({"Depth": np.ones((4, 4, 1), np.float32)}))


def pair(shape=(96, 96, 3), sigma=0.1, shift=0.0):
    truth = rng.uniform(0.2, 1.0, shape)
    s = np.full(shape, sigma)
    return truth + s * rng.standard_normal(shape), truth + s * rng.standard_normal(shape) + shift, s, s


def test_equal_renders_pass_as_often_as_stated():
    runs = [z_test(*pair((32, 32, 3))) for _ in range(300)]
    assert np.mean([run.share_outside for run in runs]) == pytest.approx(0.05, abs=0.002)
    # p is uniform: the share below 0.05 has a standard deviation of 0.0126 over 300 runs.
    assert np.mean([run.p_value < 0.05 for run in runs]) < 0.05 + 4 * 0.0126
    assert np.mean([run.p_value < 0.5 for run in runs]) == pytest.approx(0.5, abs=4 * 0.029)
    assert sum(not run.passed for run in runs) < 300 * 0.01 + 4 * np.sqrt(3)


def test_a_wrong_region_fails():
    a, b, sigma_a, sigma_b = pair()
    b[40:48, 40:48] += 1.5  # 64 of 9,216 pixels, 10 standard deviations
    result = z_test(a, b, sigma_a, sigma_b)
    assert not result.passed and result.rejected > 150 and result.p_value < 1e-6


def test_a_bias_below_the_noise_of_a_pixel_fails():
    a, b, sigma_a, sigma_b = pair(shift=0.01)  # a tenth of a pixel's error
    result = z_test(a, b, sigma_a, sigma_b)
    assert not result.passed and result.bias_z > 5 and result.rejected < 5


def test_tiles_show_what_pixels_hide():
    a, b, sigma_a, sigma_b = pair()
    b[:48] += 0.07
    b[48:] -= 0.07  # the means agree
    assert z_test(a, b, sigma_a, sigma_b).passed
    assert not z_test(a, b, sigma_a, sigma_b, tile=8).passed


def test_errors_claimed_too_small_fail():
    a, b, sigma_a, sigma_b = pair()
    assert not z_test(a, b, sigma_a / 2, sigma_b / 2).passed


def test_estimated_errors_from_renders_pass_and_see_a_difference():
    renders = 0.5 + 0.2 * rng.standard_normal((2, 4, 64, 64, 3))
    (a, sigma_a), (b, sigma_b) = mean_and_error(renders[0]), mean_and_error(renders[1])
    assert z_test(a, b, sigma_a, sigma_b, dof=192).passed
    b[:8, :8] += 1.0
    assert not z_test(a, b, sigma_a, sigma_b, dof=192).passed


def test_values_without_error_must_be_equal():
    a = np.ones((8, 8))
    zero = np.zeros((8, 8))
    assert z_test(a, a, zero, zero).passed
    b = a.copy()
    b[0, 0] += 1e-5
    assert not z_test(a, b, zero, zero).passed


def test_rounding_is_no_difference_however_many_pixels_share_it():
    a, zero = np.ones((256, 256)), np.zeros((256, 256))
    result = z_test(a, a * (1 + 2e-7), zero, zero, tile=8)
    assert result.passed and result.bias_z == 0.0 and result.p_value == 1.0
    assert not z_test(a, a * (1 + 2e-6), zero, zero, tile=8).passed


def test_unknown_errors_test_nothing():
    a = np.ones((8, 8))
    with pytest.raises(CompareError, match="not finite"):
        z_test(a, a, np.full((8, 8), np.nan), np.zeros((8, 8)))
    with pytest.raises(CompareError, match="shapes"):
        z_test(a, a[:4], a, a)


def test_corrected_p_by_hand():
    assert corrected_p(1.959963984540054, 1) == pytest.approx(0.05)
    assert corrected_p(4.0, 1000) == pytest.approx(1 - (1 - 6.334248366623996e-05) ** 1000)
