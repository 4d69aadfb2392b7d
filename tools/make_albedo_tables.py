"""Integrates the directional albedos of GGX closures into isophote/data/albedo_tables.npy.

Deterministic float64 quadrature: the midpoint rule over the two numbers that the sampling of visible
normals maps to a microfacet (Dupuy and Benyoub 2023), where the integrand G2/G1 is continuous and
bounded by 1. kernels/bsdf/albedo.h documents axes and layout.

    python tools/make_albedo_tables.py [output.npy]
"""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path

import numpy as np

FINE, COARSE, MU = 64, 16, 32  # as in albedo.h
STEPS_CAP, STEPS_ANGLE = 144, 72  # midpoints; doubling both changes no entry by more than 0.0015
AVERAGE_NODES = 24  # Gauss-Legendre in mu


def visible_microfacets(alpha: float, mu: np.ndarray):
    """Microfacet normals seen from directions of cosine mu (shape (n, 1)), equally weighted.

    Returns (wo, m): two 3-tuples of arrays of shape (n, 1) and (n, STEPS_CAP * STEPS_ANGLE).
    """
    sine = np.sqrt(np.maximum(1 - mu * mu, 0))
    v = (np.arange(STEPS_CAP) + 0.5) / STEPS_CAP
    phi = np.pi * (np.arange(STEPS_ANGLE) + 0.5) / STEPS_ANGLE  # the other half is its mirror image
    v, phi = (x.reshape(1, -1) for x in np.meshgrid(v, phi))
    length = np.hypot(alpha * sine, mu)
    wx, wz = alpha * sine / length, mu / length
    height = (1 - v) * (1 + wz)
    cap_sine = np.sqrt(v * (1 + wz) * (height + wx * wx / (1 + wz)))
    mx, my, mz = alpha * (wx + cap_sine * np.cos(phi)), alpha * cap_sine * np.sin(phi), height
    norm = np.sqrt(mx * mx + my * my + mz * mz)
    return (sine, np.zeros_like(sine), mu), (mx / norm, my / norm, mz / norm)


def visibility(alpha: float, cos_o, cos_i):
    """G2/G1 of height-correlated Smith masking for the cosines of both directions (Heitz 2014, eq. 99)."""
    length_o = np.sqrt(alpha**2 * (1 - cos_o**2) + cos_o**2)
    length_i = np.sqrt(alpha**2 * np.maximum(1 - cos_i**2, 0) + cos_i**2)
    cos_i = np.abs(cos_i)
    return cos_i * (cos_o + length_o) / np.maximum(cos_i * length_o + cos_o * length_i, 1e-300)


def fresnel(c, ior: float):
    """(reflectance, cosine of the refracted ray) of a dielectric at cosines c of incidence."""
    g = np.sqrt(np.maximum(ior**2 - 1 + c * c, 0))
    s = (c - g) / (c + g)
    p = (ior**2 * c - g) / (ior**2 * c + g)
    return np.where(ior**2 - 1 + c * c > 0, 0.5 * (s * s + p * p), 1.0), g / ior


def ggx_albedo(rough: float, mu: np.ndarray) -> np.ndarray:
    """E of GGX reflection with Fresnel 1, for cosines mu of shape (n,)."""
    mu = mu[:, None]
    wo, m = visible_microfacets(rough**2, mu)
    cos_mo = wo[0] * m[0] + wo[2] * m[2]
    cos_i = 2 * cos_mo * m[2] - mu
    return np.mean(np.where(cos_i > 0, visibility(rough**2, mu, cos_i), 0), axis=1)


def glass_albedo(rough: float, mu: np.ndarray, ior: float, count_misdirected: bool = True) -> np.ndarray:
    """E of a rough dielectric interface, reflection and refraction together, for mu of shape (n,).

    Cycles 4.5 absorbs rays refracted to the viewer's side, but its tables count them as kept, so that it
    compensates too little: white glass of roughness 0.6 keeps 0.98 at mu = 0.4 and 0.89 at mu = 0.1 when
    seen from inside (from outside all). Ours count them too, so that rough glass looks alike in both;
    count_misdirected=False gives the E that conserves energy.
    """
    mu = mu[:, None]
    wo, m = visible_microfacets(rough**2, mu)
    cos_mo = np.clip(wo[0] * m[0] + wo[2] * m[2], 0, 1)
    f, cos_t = fresnel(cos_mo, ior)
    reflected = 2 * cos_mo * m[2] - mu
    refracted = (cos_mo * m[2] - mu) / ior - cos_t * m[2]
    kept = (refracted < 0) | count_misdirected
    return np.mean(f * np.where(reflected > 0, visibility(rough**2, mu, reflected), 0)
                   + (1 - f) * np.where(kept, visibility(rough**2, mu, refracted), 0), axis=1)


def rise_average(rough: float, mu: np.ndarray, curve) -> np.ndarray:
    """Average of curve(wo . m) over visible microfacets whose reflection leaves the surface."""
    mu = mu[:, None]
    wo, m = visible_microfacets(rough**2, mu)
    cos_mo = np.clip(wo[0] * m[0] + wo[2] * m[2], 0, 1)
    return np.mean(np.where(2 * cos_mo * m[2] - mu > 0, curve(cos_mo), 0), axis=1)


def dielectric_rise_curve(ior: float):
    f0 = ((ior - 1) / (ior + 1)) ** 2
    return lambda c: np.clip((fresnel(c, ior)[0] - f0) / (1 - f0), 0, 1)


def nodes(count: int, power: int = 1, high: float = 1.0) -> np.ndarray:
    """Values at a table's nodes, whose coordinates are the values' power-th roots; the ends are moved
    inward where the model is singular there."""
    return np.clip((np.arange(count) / (count - 1)) ** power, 1e-4, high)


def ior_of(z: float) -> float:
    return (1 + z * z) / (1 - z * z)


def make_tables() -> np.ndarray:
    """All tables one after the other, in the order of albedo.h, float32."""
    x, w = np.polynomial.legendre.leggauss(AVERAGE_NODES)
    mu_average, weights = 0.5 + 0.5 * x, w * (0.5 + 0.5 * x)  # integrates 2 mu over [0, 1]
    linear, iors = nodes(COARSE), [ior_of(z) for z in nodes(COARSE, high=0.99)]
    rough_fine, rough_coarse = nodes(FINE, 2), nodes(COARSE, 2)
    mu_fine, mu_coarse = nodes(FINE, 2), nodes(MU, 2)

    def over(rough_nodes, function):
        return np.stack([function(rough) for rough in rough_nodes], axis=-1)

    def over_ior(ior_list, rough_nodes, function):
        return np.stack([over(rough_nodes, partial(function, ior=ior)) for ior in ior_list])

    tables = [
        over(rough_fine, lambda r: ggx_albedo(r, mu_fine)),
        over(rough_fine, lambda r: weights @ ggx_albedo(r, mu_average)),
    ]
    for ior_list in (iors, [1 / ior for ior in iors]):
        tables.append(over_ior(ior_list, rough_coarse, lambda r, ior: glass_albedo(r, mu_coarse, ior)))
        tables.append(over_ior(ior_list, rough_coarse, lambda r, ior: weights @ glass_albedo(r, mu_average, ior)))
    tables.append(over_ior(iors, linear, lambda r, ior: rise_average(r, linear, dielectric_rise_curve(ior))))
    tables.append(over(linear, lambda r: rise_average(r, linear, lambda c: (1 - c) ** 5)))
    return np.clip(np.concatenate([t.ravel() for t in tables]), 0, 1).astype(np.float32)


if __name__ == "__main__":
    default = Path(__file__).parents[1] / "isophote" / "data" / "albedo_tables.npy"
    np.save(sys.argv[1] if len(sys.argv) > 1 else default, make_tables())
