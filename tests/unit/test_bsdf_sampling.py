"""Sampling of every closure against its density: chi-squared, integral, and the share that is absorbed."""

import zlib

import numpy as np
import pytest
from scipy import stats

from tests.bsdf_cases import (
    TOONS,
    Case,
    anisotropic,
    beckmann_glasses,
    diffuses,
    direction,
    fabrics,
    integrate_pdf,
    reflections,
    refractions,
)
from tests.kernel_lib import CppKernels

SAMPLES = 200_000
SIGNIFICANCE = 0.01  # of all tests of this file together

CASES = [*diffuses(), *TOONS, *fabrics(0.3), *fabrics(1.0), *anisotropic(0.5, 0.25), *anisotropic(0.2, 0.6)]
for roughness in (0.01, 0.1, 0.4, 1.0):
    CASES += reflections(roughness)
    CASES += refractions(roughness)
CASES += refractions(0.5, iors=(1.02, 10.0))
CASES += [*beckmann_glasses(0.4), *beckmann_glasses(1.0, iors=(1.1, 3.0))]
ANGLES = (0.98, 0.5, 0.1)


@pytest.fixture(scope="module")
def kernels():
    return CppKernels()


@pytest.mark.parametrize("mu", ANGLES)
@pytest.mark.parametrize("case", CASES, ids=str)
def test_sampling_follows_pdf(kernels, case, mu):
    """Pearson's test over cells around each lobe; the share of valid samples is the integral of the pdf."""
    rng = np.random.default_rng(zlib.crc32(f"{case} {mu}".encode()))
    wo = np.tile(direction(mu), (SAMPLES, 1))
    wi, _, flags = kernels.sample(case.instruction, wo, rng.random((SAMPLES, 3), np.float32), case.backfacing)
    wi, delta, valid = wi.astype(np.float64), flags[:, 0] == 1, flags[:, 2] == 1
    assert not np.any(delta), "no case of this test is a delta"

    observed, expected = [], []
    for transmits, grid, probabilities in integrate_pdf(kernels, case, mu):
        expected.append(probabilities * SAMPLES)
        observed.append(grid.count(wi[valid & ((wi[:, 2] < 0) == transmits)]))
    observed, expected = np.concatenate(observed), np.concatenate(expected)

    total = expected.sum() / SAMPLES
    assert total <= 1 + 2e-3
    spread = np.sqrt(max(total * (1 - total), 1e-6) / SAMPLES)
    assert abs(valid.mean() - total) <= 5 * spread + 2e-3

    big = expected >= 10
    observed = np.array([*observed[big], observed[~big].sum()])
    expected = np.array([*expected[big], expected[~big].sum()])
    kept = expected >= 10
    if kept.sum() < 2:  # total internal reflection of a closure that only refracts: all is absorbed
        return
    expected *= observed.sum() / expected.sum()  # the quadrature's own error is judged above
    statistic = np.sum((observed[kept] - expected[kept]) ** 2 / expected[kept])
    freedom = kept.sum() - 1
    p_value = stats.chi2.sf(statistic, freedom)
    assert p_value > SIGNIFICANCE / (len(CASES) * len(ANGLES)), f"chi2 {statistic:.0f} of {freedom}"


@pytest.mark.parametrize("case", [*reflections(0.0), *refractions(0.0), *anisotropic(0.0, 0.0), *beckmann_glasses(0.0),
                                  Case("transparent")], ids=str)
def test_delta_is_never_evaluated(kernels, case):
    rng = np.random.default_rng(3)
    wo = np.tile(direction(0.6), (1000, 1))
    wi, f, flags = kernels.sample(case.instruction, wo, rng.random((1000, 3)), case.backfacing)
    value, pdf = kernels.eval(case.instruction, wo, wi, case.backfacing)
    assert np.all(flags[:, 0] == 1) and not value.any() and not pdf.any()
    assert np.isfinite(f).all()


def test_smooth_glass_chooses_by_fresnel(kernels):
    """Shares of reflection at normal incidence and at 60 degrees: ((n-1)/(n+1))^2, and Fresnel's 0.0892."""
    case = Case("glass", dict(roughness=0.0, ior=1.5, multiscatter=0))
    u = np.stack([np.linspace(0, 1, 100_000, endpoint=False), np.full(100_000, 0.5), np.full(100_000, 0.5)], axis=1)
    for mu, share in ((1.0, 0.04), (0.5, 0.089187)):
        wi, f, _ = kernels.sample(case.instruction, np.tile(direction(mu), (len(u), 1)), u)
        assert np.mean(wi[:, 2] > 0) == pytest.approx(share, abs=2e-5)
        np.testing.assert_allclose(f, 1, rtol=1e-4)
