"""Models of the sky against what they are known to be; tests/images/test_skies.py compares them with Cycles."""

import math

import numpy as np
import pytest

from isophote import _native, skies
from isophote.skies import Air

DAY = Air(False, 0.6, 100.0, 1.0, 1.0, 1.0)


@pytest.mark.parametrize("often", [False, True])
def test_threads_change_no_bit(often):
    latitudes, longitudes = np.linspace(0.0, 1.5, 9, dtype=np.float32), np.linspace(-3.0, 0.0, 21, dtype=np.float32)
    made = []
    for threads in (1, 3):
        made.append(np.empty((9 * 21, 3), np.float32))
        _native.scatter_sky(often, DAY.numbers(), latitudes, longitudes, threads, made[-1])
    assert made[0].tobytes() == made[1].tobytes() and (made[0] > 0.0).all()


def test_without_matter_the_sky_is_black_and_the_sun_as_in_space():
    nothing = Air(False, 0.6, 100.0, 0.0, 0.0, 0.0)
    assert not skies.dome(nothing).any()
    low, high = nothing.irradiance(0.1, 1.5)
    np.testing.assert_allclose(low, high, rtol=1e-5)
    assert 170.0 < high[1] < 200.0  # the luminous part of 1,361 W/m^2


def test_thin_air_scatters_by_rayleigh():
    """Scattered once, in proportion to its density and to 1 + the squared cosine of the angle to the sun."""
    def zenith(density, elevation):
        return skies.scattered(Air(False, elevation, 100.0, density, 0.0, 0.0), np.array([math.pi / 2.0]), 0.0)[0, 0]
    np.testing.assert_allclose(zenith(2e-3, 0.6), 2.0 * zenith(1e-3, 0.6), rtol=3e-3)
    np.testing.assert_allclose(zenith(1e-4, 0.9) / zenith(1e-4, 0.4),
                               (1.0 + math.sin(0.9) ** 2) / (1.0 + math.sin(0.4) ** 2), rtol=1e-3)


@pytest.mark.parametrize("often", [False, True])
def test_skies_are_bluer_than_their_sun_which_reddens_as_it_sets(often):
    air = Air(often, 0.6, 100.0, 1.0, 1.0, 1.0)
    sky = skies.globe(air)[skies.HEIGHT + 20:].mean(axis=(0, 1))
    high, low = air.irradiance(1.0, 0.05)
    assert sky[2] / sky[0] > high[2] / high[0] > low[2] / low[0]


def test_preetham_has_the_published_zenith():
    """Luminance in kcd/m^2 at the zenith, times Blender's 0.06 (Preetham, Shirley and Smits 1999, appendix A.2)."""
    turbidity, theta = 3.0, 0.7
    sun = np.array([math.sin(theta), 0.0, math.cos(theta)])
    brightness, a, b, c, d, e, f = skies.preetham(sun, turbidity)[4:11]
    at_zenith = brightness * (1.0 + a * math.exp(b)) * (c + d * math.exp(e * theta) + f * math.cos(theta) ** 2)
    chi = (4.0 / 9.0 - turbidity / 120.0) * (math.pi - 2.0 * theta)
    wanted = (4.0453 * turbidity - 4.9710) * math.tan(chi) - 0.2155 * turbidity + 2.4192
    assert math.isclose(at_zenith, 0.06 * wanted, rel_tol=1e-12)


def test_hosek_wilkie_reads_the_published_rows():
    data = skies.hosek_wilkie_data()
    np.testing.assert_array_equal(data[0, 0, 0, 0, :3], (-1.117001, -0.1867262, -11.13505))
    np.testing.assert_array_equal(data[2, 1, 9, 5, 8:], (0.6791814, 31.10255))
    level = np.array([1.0, 0.0, 0.0])  # at elevation 0 the first control point counts alone
    np.testing.assert_allclose(skies.hosek_wilkie(level, 4.0, 1.0)[5:14], data[0, 1, 3, 0, :9], rtol=1e-9)
    half_way = skies.hosek_wilkie(level, 4.5, 0.5)[5:14]
    np.testing.assert_allclose(half_way, data[0, :, 3:5, 0, :9].mean(axis=(0, 1)), rtol=1e-9)
