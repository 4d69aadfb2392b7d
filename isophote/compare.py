"""How far two pictures are apart: measures for people, and a statistical test for renders with known error."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from statistics import NormalDist

import numpy as np

from isophote.images import Image, encode_srgb
from isophote.statistics import Z95, sums_over_tiles

REL_MSE_FLOOR = 0.01
ROUNDING = 1e-6  # relative: what float32 sums of a render may be off by


class CompareError(ValueError):
    """Pictures that cannot be compared; the message says why."""


def compare(a: Image, b: Image) -> dict:
    """Measures between a picture and a reference `b`, over RGB of Combined, as one JSON-ready dict:

    - mean_ratio: mean(a) / mean(b) by channel R, G, B (None where b's mean is 0)
    - rmse: sqrt(mean((a - b)^2)), linear
    - relmse: mean((a - b)^2 / (b^2 + 0.01)) (Rousselle et al. 2011, section 5)
    - psnr: 10 log10(1 / mse) in dB of the sRGB-encoded pictures clipped to 0..1; None where they are equal
    - flip: mean LDR-FLIP of the same (Andersson et al. 2020), or None with the reason in notes
    - differing_floats: values of any common pass whose bits differ, of `compared_floats`

    Raises CompareError where sizes differ or there is no Combined.
    """
    rgb = []
    for image, which in ((a, "first"), (b, "second")):
        if "Combined" not in image.planes:
            raise CompareError(f"the {which} picture has no pass Combined, only {', '.join(image.planes)}")
        rgb.append(image.planes["Combined"][..., :3].astype(np.float64))
    x, y = rgb
    if x.shape != y.shape:
        raise CompareError(f"the pictures differ in size: {x.shape[1]}x{x.shape[0]} and {y.shape[1]}x{y.shape[0]}")
    means_x, means_y = x.mean(axis=(0, 1)), y.mean(axis=(0, 1))
    square = (x - y) ** 2
    mse_srgb = float(((encode_srgb(x) - encode_srgb(y)) ** 2).mean())
    flip, notes = mean_flip(y, x)
    differing, compared, only = differing_floats(a.planes, b.planes)
    if only:
        notes.append(f"passes in one picture only: {', '.join(only)}")
    return {
        "mean_ratio": [float(p / q) if q else None for p, q in zip(means_x, means_y, strict=True)],
        "rmse": math.sqrt(float(square.mean())),
        "relmse": float((square / (y * y + REL_MSE_FLOOR)).mean()),
        "psnr": 10.0 * math.log10(1.0 / mse_srgb) if mse_srgb > 0.0 else None,
        "flip": flip,
        "differing_floats": differing,
        "compared_floats": compared,
        "notes": notes,
    }


def mean_flip(reference: np.ndarray, test: np.ndarray) -> tuple[float | None, list[str]]:
    """Mean LDR-FLIP of linear RGB (h, w, 3) after sRGB encoding, and notes where it is missing."""
    try:
        import flip_evaluator
    except ImportError as error:
        return None, [f"no FLIP: {error} (pip install flip-evaluator)"]
    encoded = [np.ascontiguousarray(encode_srgb(image), np.float32) for image in (reference, test)]
    return float(flip_evaluator.evaluate(*encoded, "LDR", applyMagma=False)[1]), []


def differing_floats(a: dict, b: dict) -> tuple[int, int, list[str]]:
    """(values whose bits differ, values compared, passes that one side lacks) over passes of (h, w, c)."""
    differing = compared = 0
    for name in a.keys() & b.keys():
        p, q = (np.ascontiguousarray(planes[name], np.float32) for planes in (a, b))
        if p.shape != q.shape:
            raise CompareError(f"pass {name} has shape {p.shape} in one picture and {q.shape} in the other")
        differing += int(np.count_nonzero(p.view(np.uint32) != q.view(np.uint32)))
        compared += p.size
    return differing, compared, sorted(a.keys() ^ b.keys())


@dataclass(frozen=True)
class ZTest:
    """Outcome of z_test. `tested` counts values (pixels or tiles, times channels)."""

    tested: int
    share_outside: float  # of their own 95 % interval: 0.05 is expected
    rejected: int  # values that no chance among this many explains, at the corrected level
    p_value: float  # of the most extreme value, corrected for many: small means that some value differs
    bias_z: float  # of the difference of the pictures' means, in its standard deviations
    passed: bool

    def as_dict(self) -> dict:
        return asdict(self)


def z_test(a, b, sigma_a, sigma_b, *, tile: int = 1, dof: float | None = None, significance: float = 0.01,
           allowed: float = 0.0025) -> ZTest:
    """Do two renders with known errors show the same picture?

    a, b: means (h, w) or (h, w, c); sigma_a, sigma_b: their standard errors, of the same shape (from
    Film by statistics.pixel_error, from repeated renders by statistics.mean_and_error; 0 for a known answer).
    z = (a - b) / sqrt(sigma_a^2 + sigma_b^2) is normal where both are right. With n values, one is
    rejected when its two-sided p is below 1 - (1 - significance)^(1/n) (Sidak 1967), so that an equal
    pair has a rejection at all with probability `significance`. As in Mitsuba 3's test_renders.py the
    pair passes while at most the share `allowed` of values is rejected (errors of heavy tail, at edges
    and rare events, exceed the normal law) and the means of the whole pictures agree at the same level.

    tile > 1 tests means of tiles instead of pixels: less noise, so small systematic differences show;
    it takes pixels for independent. `dof`: degrees of freedom of the sigmas where they are themselves
    estimates (about 64 for two replicates pooled over 8 x 8); t is then turned into z (Wallace 1959).
    Differences count from ROUNDING times the value on: a background of one colour has no variance, yet
    two programs round it differently. Where both sigmas are 0, more than that is rejected. Values whose
    sigma or mean is not finite raise CompareError: an unknown error tests nothing.
    """
    a, b, sigma_a, sigma_b = (np.atleast_3d(np.asarray(x, np.float64)) for x in (a, b, sigma_a, sigma_b))
    if not a.shape == b.shape == sigma_a.shape == sigma_b.shape:
        raise CompareError(f"shapes differ: {a.shape}, {b.shape}, {sigma_a.shape}, {sigma_b.shape}")
    difference, variance = a - b, sigma_a ** 2 + sigma_b ** 2
    rounding = ROUNDING * np.maximum(np.abs(a), np.abs(b))
    difference = np.sign(difference) * np.maximum(np.abs(difference) - rounding, 0.0)
    if not (np.isfinite(difference).all() and np.isfinite(variance).all()):
        raise CompareError("a value or a standard error is not finite")
    bias = np.abs(to_z(difference.sum(axis=(0, 1)), variance.sum(axis=(0, 1)))).max()
    if tile > 1:
        difference, variance = (np.stack([sums_over_tiles(x[..., c], tile=tile) for c in range(x.shape[2])], axis=2)
                                for x in (difference, variance))
    z = np.abs(to_z(difference, variance))
    if dof is not None:
        t = z
        z = (8 * dof + 1) / (8 * dof + 3) * np.sqrt(dof * np.log1p(t * t / dof))
    rejected = int((z > limit(significance, z.size)).sum())
    passed = rejected <= allowed * z.size and bool(bias <= limit(significance, a.shape[2]))
    return ZTest(z.size, float((z > Z95).mean()), rejected, corrected_p(float(z.max()), z.size), float(bias), passed)


def to_z(difference: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """difference / sqrt(variance); 0 for equal values without variance, infinite for unequal ones."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(difference == 0.0, 0.0, difference / np.sqrt(variance))


def limit(significance: float, count: int) -> float:
    """|z| beyond which one of `count` values is rejected."""
    alpha = -math.expm1(math.log1p(-significance) / count)
    return -NormalDist().inv_cdf(alpha / 2)


def corrected_p(z: float, count: int) -> float:
    """Probability that the largest of `count` |z| of standard normals reaches z."""
    p = math.erfc(z / math.sqrt(2.0))
    return 1.0 if p >= 1.0 else -math.expm1(count * math.log1p(-p))
