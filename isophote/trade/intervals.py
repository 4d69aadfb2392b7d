"""Confidence intervals from few replicates: Student's t, and the jackknife for ratios and roots.

Blender's Python has no scipy; Student's law is a finite sum for whole degrees of freedom.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

LEVEL = 0.95


@dataclass(frozen=True)
class Interval:
    """An estimate with the ends of its confidence interval; the ends are infinite where nothing is known."""

    value: float
    low: float
    high: float

    def map(self, function) -> Interval:
        """Through an increasing function."""
        return Interval(*(function(x) for x in (self.value, self.low, self.high)))

    @property
    def largest(self) -> float:
        """How large the true value may be, whatever its sign."""
        return max(abs(self.low), abs(self.high))

    @property
    def holds_zero(self) -> bool:
        return self.low <= 0.0 <= self.high


def student_share(t: float, freedom: int) -> float:
    """The probability that |T| <= t (Abramowitz, Stegun 26.7.3 and 26.7.4)."""
    angle = math.atan(t / math.sqrt(freedom))
    cosine, sine = math.cos(angle), math.sin(angle)
    odd = freedom % 2
    term, total = (cosine, 0.0) if odd else (1.0, 0.0)
    for k in range(odd, freedom - 1, 2):  # the powers of the cosine up to freedom - 2
        total += term
        term *= cosine * cosine * (k + 1) / (k + 2)
    return 2.0 / math.pi * (angle + sine * total) if odd else sine * total


def student_quantile(level: float, freedom: int) -> float:
    """t with |T| <= t in the share `level` of cases, by bisection; infinite without degrees of freedom."""
    if freedom < 1:
        return math.inf
    low, high = 0.0, 1.0
    while student_share(high, freedom) < level and high < 1e9:
        high *= 2.0
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if student_share(middle, freedom) < level else (low, middle)
    return high


def corrected_level(tests: int, level: float = LEVEL) -> float:
    """The level of each of so many intervals at which all of them hold together (Sidak 1967)."""
    return level ** (1.0 / max(1, tests))


def interval_of(values, level: float = LEVEL) -> Interval:
    """The mean of independent values (K), with Student's interval."""
    values = np.asarray(values, np.float64)
    mean, freedom = float(values.mean()), len(values) - 1
    if freedom < 1:
        return Interval(mean, -math.inf, math.inf)
    half = student_quantile(level, freedom) * float(values.std(ddof=1)) / math.sqrt(len(values))
    return Interval(mean, mean - half, mean + half)


def jackknife(whole: float, parts, level: float = LEVEL) -> Interval:
    """An estimate from K replicates and the K estimates without one each (Efron, Tibshirani 1993, chapter 11)."""
    parts = np.asarray(parts, np.float64)
    count = len(parts)
    if count < 2 or not np.isfinite(parts).all() or not math.isfinite(whole):
        return Interval(whole, -math.inf, math.inf)
    error = math.sqrt((count - 1) / count * float(((parts - parts.mean()) ** 2).sum()))
    half = student_quantile(level, count - 1) * error
    return Interval(whole, whole - half, whole + half)


def log_jackknife(whole: float, parts, level: float = LEVEL) -> Interval:
    """As jackknife, of a positive estimate whose logarithm is nearer to normal."""
    if not whole > 0.0 or not (np.asarray(parts) > 0.0).all():
        return Interval(whole, 0.0, math.inf)
    return jackknife(math.log(whole), np.log(parts), level).map(lambda x: math.exp(min(x, 700.0)))
