"""Models of the sky: constants of the analytic ones, pictures of those that scatter light, the sun's disc.

All of it is CIE XYZ, by the numbers and formulas of Cycles (intern/cycles/scene/shader_nodes.cpp, intern/sky). Angles
are radians, the sun's elevation is counted from the horizon.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

import numpy as np

THREADS = os.cpu_count() or 1
WIDTH, HEIGHT = 512, 128  # of pictures; HEIGHT from the horizon to the zenith
SMALLEST_SUN = 0.0005  # across
LOWEST, HIGHEST = 1.0, {False: 59999.0, True: 99999.0}  # altitudes, metres; of light scattered once, and often
EARTH = 6371.0  # km

# ------------------------------------------------------------------ analytic skies, as kernels/values/sky.h has them


def preetham(sun: np.ndarray, turbidity: float) -> np.ndarray:
    """Constants of the operation daylight for Yxy, of a sun in a unit direction (Preetham, Shirley and Smits 1999,
    appendix A.2)."""
    theta, t = math.acos(max(-1.0, min(1.0, sun[2]))), turbidity
    powers = np.array([theta ** 3, theta ** 2, theta, 1.0])
    chi = (4.0 / 9.0 - t / 120.0) * (math.pi - 2.0 * theta)
    zenith = [
        0.06 * ((4.0453 * t - 4.9710) * math.tan(chi) - 0.2155 * t + 2.4192),
        np.dot(powers, np.array([[0.00166, -0.00375, 0.00209, 0.0], [-0.02903, 0.06377, -0.03202, 0.00394],
                                 [0.11693, -0.21196, 0.06052, 0.25886]]).T) @ (t * t, t, 1.0),
        np.dot(powers, np.array([[0.00275, -0.00610, 0.00317, 0.0], [-0.04214, 0.08970, -0.04153, 0.00516],
                                 [0.15346, -0.26756, 0.06670, 0.26688]]).T) @ (t * t, t, 1.0)]
    perez = np.array([
        [[0.1787, -1.4630], [-0.3554, 0.4275], [-0.0227, 5.3251], [0.1206, -2.5771], [-0.0670, 0.3703]],
        [[-0.0193, -0.2592], [-0.0665, 0.0008], [-0.0004, 0.2125], [-0.0641, -0.8989], [-0.0033, 0.0452]],
        [[-0.0167, -0.2608], [-0.0950, 0.0092], [-0.0079, 0.2102], [-0.0441, -1.6537], [-0.0109, 0.0529]],
    ]) @ (t, 1.0)
    channels = []
    for brightness, (a, b, c, d, e) in zip(zenith, perez, strict=True):
        above = (1.0 + a * math.exp(b)) * (1.0 + c * math.exp(d * theta) + e * math.cos(theta) ** 2)
        channels.append([brightness / above, a, b, 1.0, c, d, e, 0.0, 0.0, 0.0])
    return np.concatenate([sun, [0.0], np.ravel(channels)])


@cache
def hosek_wilkie_data() -> np.ndarray:
    """By channel, ground albedo (0 and 1), turbidity (1 to 10), control point: coefficients and radiance, f8 [10]."""
    return np.loadtxt(Path(__file__).parent / "data" / "hosek_wilkie_xyz.txt").reshape(3, 2, 10, 6, 10)


def hosek_wilkie(sun: np.ndarray, turbidity: float, albedo: float) -> np.ndarray:
    """Constants of the operation daylight for XYZ, of a sun in a unit direction (Hosek and Wilkie 2012, section 5).

    A sun below the horizon counts as one that lies on it.
    """
    theta = min(math.acos(max(-1.0, min(1.0, sun[2]))), math.pi / 2.0)
    place = min(max(turbidity, 1.0), 10.0) - 1.0
    low = min(int(place), 8)
    of_turbidity = hosek_wilkie_data()[:, :, low:low + 2]
    x = (1.0 - theta / (math.pi / 2.0)) ** (1.0 / 3.0)
    bezier = [math.comb(5, k) * (1.0 - x) ** (5 - k) * x ** k for k in range(6)]
    found = np.einsum("catpn,a,t,p->cn", of_turbidity, (1.0 - albedo, albedo), (1.0 - place + low, place - low), bezier)
    channels = np.concatenate([found[:, 9:] * (2.0 * math.pi / 683.0), found[:, :9]], axis=1)
    across = math.hypot(sun[0], sun[1])
    around = np.array(sun[:2]) / across if across > 0.0 else np.zeros(2)
    return np.concatenate([around * math.sin(theta), [math.cos(theta), 0.01], channels.ravel()])


# ------------------------------------------------------------------ skies of scattered light


@dataclass(frozen=True)
class Air:
    """What the sun shines through: its elevation, the viewer's altitude in metres, densities (1: an average day).

    `often`: light is scattered many times, else once.
    """

    often: bool
    elevation: float
    altitude: float
    air: float
    dust: float
    ozone: float

    def numbers(self) -> np.ndarray:
        altitude = min(max(self.altitude, LOWEST), HIGHEST[self.often])
        return np.array([self.elevation, altitude, self.air, self.dust, self.ozone], np.float32)

    def irradiance(self, *elevations: float) -> np.ndarray:
        """Of the sun, seen at elevations, W/m^2, f8 [n, 3]."""
        from isophote import _native  # the add-on loads without it, to say what is wrong

        made = np.empty((len(elevations), 3), np.float32)
        _native.shine_through(self.often, self.numbers(), np.array(elevations, np.float32), made)
        return made.astype(np.float64)


def scattered(air: Air, latitudes: np.ndarray, first: float) -> np.ndarray:
    """Radiance, f4 [n, WIDTH, 3], W/(m^2 sr), at latitudes, f8 [n]. The sun's longitude is in the middle; columns begin
    `first` of their widths from the left."""
    from isophote import _native

    longitudes = 2.0 * np.pi * (np.arange(WIDTH // 2) + first) / WIDTH - np.pi
    made = np.empty((len(latitudes) * (WIDTH // 2), 3), np.float32)
    _native.scatter_sky(air.often, air.numbers(), latitudes.astype(np.float32), longitudes.astype(np.float32), THREADS,
                        made)
    half = made.reshape(len(latitudes), WIDTH // 2, 3)
    return np.concatenate([half, half[:, ::-1]], axis=1)


@lru_cache(4)
def dome(air: Air) -> np.ndarray:
    """Above the horizon, f4 [HEIGHT, WIDTH, 3], as Blender 2.90 to 4.5 have it."""
    zenith = np.pi / 2.0 * (1.0 + 0.5 / HEIGHT)
    return scattered(air, zenith * (np.arange(HEIGHT) / HEIGHT) ** 2, 0.0)


@lru_cache(4)
def globe(air: Air) -> np.ndarray:
    """In all directions, f4 [2 HEIGHT, WIDTH, 3], as Blender 5 has it: of light scattered once the horizon fades away
    below it."""
    if air.often:
        places = (np.arange(2 * HEIGHT) + 0.5) / HEIGHT - 1.0
        return scattered(air, np.pi / 2.0 * np.sign(places) * places ** 2, 0.5)
    above = scattered(air, np.pi / 2.0 * (np.arange(HEIGHT) / HEIGHT) ** 2, 0.0)
    depths = np.sin(np.pi / 2.0 * (1.0 - np.arange(HEIGHT) / HEIGHT) ** 2)
    left = np.maximum(1.0 - 2.5 * depths, 0.0) ** 3
    return np.concatenate([above[0] * left.astype(np.float32)[:, None, None], above])


# ------------------------------------------------------------------ the sun


@dataclass(frozen=True)
class Disc:
    """The sun's: the lowest height at which it is seen; factor and summand that make 0 of the height of its lower end
    and 1 of that of its upper; the radiances of both, f8 [3]."""

    lowest: float
    factor: float
    summand: float
    low: np.ndarray
    high: np.ndarray


def disc(air: Air, size: float) -> Disc | None:
    """Of Blender 5: a sun `size` across."""
    dip = math.pi / 2.0 - math.asin(EARTH / (EARTH + max(air.altitude, 0.0) / 1000.0))
    low, high = air.elevation - size / 2.0, air.elevation + size / 2.0
    if not air.often:
        if high <= 0.0:
            return None
        low = max(low, 0.0)
    radiance = air.irradiance(low, high) / solid_angle(size)
    return Disc(-dip, 1.0 / size, 0.5 - air.elevation / size, *radiance)


def setting_disc(air: Air, size: float) -> Disc | None:
    """Of Blender 2.90 to 4.5: where the horizon cuts it, all of its colours are above."""
    low, high = air.elevation - size / 2.0, air.elevation + size / 2.0
    if high <= 0.0:
        return None
    radiance = air.irradiance(max(low, 0.0), high) / solid_angle(size)
    bottom = max(low, 0.0)
    return Disc(0.0, 1.0 / (high - bottom), -bottom / (high - bottom), *radiance)


def solid_angle(size: float) -> float:
    return 4.0 * math.pi * math.sin(size / 4.0) ** 2
