"""kernels/elementary.h against float64: the bounds stated at each function."""

import numpy as np
import pytest

from tests.kernel_lib import CppKernels


@pytest.fixture(scope="module")
def kernels():
    return CppKernels()


def ulps(values: np.ndarray, exact: np.ndarray) -> float:
    """Largest error in units in the last place of float32."""
    spacing = np.spacing(np.abs(exact).astype(np.float32)).astype(np.float64)
    return np.max(np.abs(values.astype(np.float64) - exact) / spacing)


def sweep(low: float, high: float, count: int = 1_000_001) -> np.ndarray:
    return np.linspace(low, high, count).astype(np.float32)


@pytest.mark.parametrize("name, exact", [("sin", np.sin), ("cos", np.cos)])
def test_sin_cos(kernels, name, exact):
    x = np.concatenate([sweep(-8192, 8192), sweep(-7, 7)])
    values = kernels.function(name, x)
    assert np.max(np.abs(values - exact(x.astype(np.float64)))) <= 2.0**-23
    assert np.max(np.abs(values)) <= 1


def test_exp(kernels):
    x = sweep(-87.33, 88.72)
    assert ulps(kernels.function("exp", x), np.exp(x.astype(np.float64))) <= 1.5


def test_exp_limits(kernels):
    values = kernels.function("exp", [-np.inf, -1e30, -87.4, 0, 88.8, 1e30, np.inf])
    np.testing.assert_array_equal(values, [0, 0, 0, 1, np.inf, np.inf, np.inf])


def test_log(kernels):
    x = np.concatenate([np.geomspace(1.2e-38, 3.4e38, 1_000_001), sweep(0.5, 2)]).astype(np.float32)
    assert ulps(kernels.function("log", x), np.log(x.astype(np.float64))) <= 1.5


def test_log_counts_tiny_as_smallest_normal(kernels):
    smallest = np.log(np.finfo(np.float32).tiny)
    np.testing.assert_allclose(kernels.function("log", [0, -1, 1e-40]), smallest, rtol=1e-6)


def test_acos(kernels):
    x = sweep(-1, 1)
    assert ulps(kernels.function("acos", x), np.arccos(x.astype(np.float64))) <= 1.5


def test_acos_outside_its_range(kernels):
    np.testing.assert_allclose(kernels.function("acos", [1 + 1e-6, 2, -1.5]), [0, 0, np.pi], atol=1e-7)


def test_asin(kernels):
    x = sweep(-1, 1)
    assert ulps(kernels.function("asin", x), np.arcsin(x.astype(np.float64))) <= 2.5
    np.testing.assert_allclose(kernels.function("asin", [1 + 1e-6, 2, -1.5]), np.array([1, 1, -1]) * np.pi / 2)


@pytest.mark.parametrize("name, exact, bound", [("sinh", np.sinh, 4), ("cosh", np.cosh, 4), ("tanh", np.tanh, 2)])
def test_hyperbolic(kernels, name, exact, bound):
    x = np.concatenate([sweep(-88, 88), sweep(-1.1, 1.1), np.geomspace(1e-30, 1, 1001)]).astype(np.float32)
    assert ulps(kernels.function(name, x), exact(x.astype(np.float64))) <= bound
    ends = kernels.function(name, [-np.inf, -1e30, 1e30, np.inf])
    np.testing.assert_array_equal(ends, exact([-np.inf, -np.inf, np.inf, np.inf]))


@pytest.mark.parametrize("name, exact", [("wide_sin", np.sin), ("wide_cos", np.cos)])
def test_sin_cos_of_large_numbers(kernels, name, exact):
    x = np.concatenate([sweep(-7, 7), sweep(-1e5, 1e5), np.geomspace(1e5, 9.9e6, 1_000_001).astype(np.float32)])
    values = kernels.function(name, x)
    assert np.max(np.abs(values - exact(x.astype(np.float64)))) <= 2.0**-23
    np.testing.assert_array_equal(kernels.function(name, [1.1e7, -1e38, np.inf, np.nan]), exact(0.0))


def test_modulo_is_exact(kernels):
    rng = np.random.default_rng(3)
    x, y = (rng.normal(size=500_000) * 10 ** rng.uniform(-9, 9, 500_000) for _ in range(2))
    x, y = x.astype(np.float32), y.astype(np.float32)
    np.testing.assert_array_equal(kernels.function("modulo", x, y), np.fmod(x, y))
    whole = rng.integers(-40, 40, (2, 10_000)).astype(np.float32)
    whole[1][whole[1] == 0] = 1
    np.testing.assert_array_equal(kernels.function("modulo", *whole), np.fmod(*whole))
    np.testing.assert_array_equal(kernels.function("modulo", [np.inf, 1e38, np.nan], [1, 1e-30, 1]), 0)


def test_atan2(kernels):
    rng = np.random.default_rng(1)
    y, x = (rng.normal(size=1_000_000) * 10 ** rng.uniform(-6, 6, 1_000_000) for _ in range(2))
    y, x = y.astype(np.float32), x.astype(np.float32)
    assert ulps(kernels.function("atan2", y, x), np.arctan2(y.astype(np.float64), x.astype(np.float64))) <= 2


def test_atan2_on_the_axes(kernels):
    y, x = np.array([0, 0, 0, 1, -1.0]), np.array([0, 1, -1, 0, 0.0])
    np.testing.assert_allclose(kernels.function("atan2", y, x), [0, 0, np.pi, np.pi / 2, -np.pi / 2], rtol=1e-7)


def test_pow(kernels):
    rng = np.random.default_rng(2)
    x = np.exp(rng.uniform(-20, 20, 500_000)).astype(np.float32).astype(np.float64)
    y = rng.uniform(-4, 4, 500_000).astype(np.float32).astype(np.float64)
    error = np.abs(kernels.function("pow", x, y) / x**y - 1)
    assert np.max(error / (2 + np.abs(y * np.log(x)))) <= 2.0**-23


def test_pow_of_zero(kernels):
    np.testing.assert_array_equal(kernels.function("pow", [0, 0, 0, 1], [0, 0.5, 3, 7]), [1, 0, 0, 1])


def test_log1p_and_expm1(kernels):
    x = np.geomspace(1e-30, 80, 1_000_001).astype(np.float32)
    exact = x.astype(np.float64)
    np.testing.assert_allclose(kernels.function("log1p", x), np.log1p(exact), rtol=6e-7)
    np.testing.assert_allclose(kernels.function("expm1", x), np.expm1(-exact), rtol=6e-7)
    np.testing.assert_array_equal([kernels.function(name, [0.0])[0] for name in ("log1p", "expm1")], 0)


def test_reference_build_agrees_with_numpy():
    reference = CppKernels(reference=True)
    x = np.linspace(-0.99, 0.99, 1001)
    for name, exact in (("sin", np.sin), ("cos", np.cos), ("exp", np.exp), ("acos", np.arccos)):
        np.testing.assert_allclose(reference.function(name, x), exact(x), rtol=1e-14, atol=1e-15)
