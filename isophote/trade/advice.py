"""What to choose: the error of each choice after any time, the Pareto front, and the choice for an error or a time.

Between the measured numbers of samples the noise is interpolated (logarithms). Beyond them its variance falls as
samples^-p, with the p that was measured over the last factor of four, not taken above MOST_POWER, for the gain of a
Sobol sequence over independent samples need not go on; what rests on that is marked as extrapolated. A bias stays.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from isophote.trade.analysis import EQUAL, SMALL, Measured
from isophote.trade.grid import BASE, TRUTH

FEWEST_POWER, MOST_POWER = 0.25, 1.0  # of the variance
WORTH = 1.1  # another choice than the user's settings is recommended where it is better by this factor
CLEARLY = 0.02  # of the error: a point of the front is better than the one before by that
ERRORS = (0.1, 0.05, 0.02, 0.01)
TIMES = (1.0, 10.0, 60.0)


@dataclass(frozen=True)
class Curve:
    """The error of a choice over time. `seconds` and `noise` are the measured points."""

    choice: str
    label: str
    seconds: np.ndarray
    counts: np.ndarray
    noise: np.ndarray
    bias: float

    @property
    def power(self) -> float:
        """p of the variance's fall with the number of samples, over the last step."""
        if len(self.noise) < 2 or not (self.noise[-2:] > 0.0).all():
            return MOST_POWER
        fall = 2.0 * math.log(self.noise[-2] / self.noise[-1]) / math.log(self.counts[-1] / self.counts[-2])
        return min(MOST_POWER, max(FEWEST_POWER, fall))

    def samples_at(self, seconds: float) -> float:
        """Samples a pixel; beyond the measured ones at the speed of the last."""
        if seconds >= self.seconds[-1]:
            return float(self.counts[-1] * seconds / self.seconds[-1])
        return float(np.interp(seconds, [0.0, *self.seconds], [0.0, *self.counts]))

    def seconds_at(self, samples: float) -> float:
        if samples >= self.counts[-1]:
            return float(self.seconds[-1] * samples / self.counts[-1])
        return float(np.interp(samples, [0.0, *self.counts], [0.0, *self.seconds]))

    def noise_at(self, samples: float) -> float:
        if samples >= self.counts[-1]:
            return float(self.noise[-1] * (self.counts[-1] / samples) ** (self.power / 2))
        if samples <= self.counts[0]:
            return float(self.noise[0] * math.sqrt(self.counts[0] / samples))
        return float(np.exp(np.interp(math.log(samples), np.log(self.counts), np.log(np.maximum(self.noise, 1e-30)))))

    def error_at(self, seconds: float) -> float | None:
        """None where the time is too short for one sample."""
        samples = self.samples_at(seconds)
        return math.hypot(self.noise_at(samples), self.bias) if samples >= 1.0 else None

    def seconds_for(self, error: float) -> float | None:
        """The time to an error; None where the bias alone is larger."""
        if self.bias >= error:
            return None
        wanted, low, high = math.sqrt(error ** 2 - self.bias ** 2), 1.0, 1e15
        if self.noise_at(high) > wanted:
            return None
        for _ in range(100):
            middle = math.sqrt(low * high)
            low, high = (middle, high) if self.noise_at(middle) > wanted else (low, middle)
        return self.seconds_at(high)


@dataclass(frozen=True)
class Advice:
    """The best choice for an error or a time. `seconds` and `error` are its, `base_seconds` and `base_error` those of
    the user's settings for the same error or time (None: out of reach). All None where nothing reaches it."""

    wanted: str
    choice: str | None
    label: str | None
    samples: float | None
    seconds: float | None
    error: float | None
    base_seconds: float | None
    base_error: float | None
    extrapolated: bool


def curve_of(measured: Measured) -> Curve:
    return Curve(measured.choice.key, measured.choice.label, np.array(measured.seconds), np.array(measured.counts),
                 np.array([max(interval.value, 1e-9) for interval in measured.noise]), measured.bias)


def for_error(curves: list[Curve], error: float) -> Advice:
    """The choice that is soonest at an error."""
    base = next(curve for curve in curves if curve.choice == BASE)
    wanted = f"{100 * error:g} % error"
    reaching = [(seconds, curve) for curve in curves if (seconds := curve.seconds_for(error)) is not None]
    if not reaching:
        return Advice(wanted, None, None, None, None, None, None, None, False)
    own = base.seconds_for(error)
    seconds, best = min(reaching, key=lambda pair: pair[0])
    if own is not None and own <= WORTH * seconds:
        seconds, best = own, base
    return Advice(wanted, best.choice, best.label, best.samples_at(seconds), seconds, error, own, error,
                  bool(seconds > best.seconds[-1]))


def for_time(curves: list[Curve], seconds: float) -> Advice:
    """The choice with the smallest error after a time."""
    base = next(curve for curve in curves if curve.choice == BASE)
    wanted = f"{seconds:g} s" if seconds < 60.0 else f"{seconds / 60:g} min"
    able = [(error, curve) for curve in curves if (error := curve.error_at(seconds)) is not None]
    if not able:
        return Advice(wanted, None, None, None, None, None, None, None, False)
    own = base.error_at(seconds)
    error, best = min(able, key=lambda pair: pair[0])
    if own is not None and own <= math.sqrt(WORTH) * error:
        error, best = own, base
    return Advice(wanted, best.choice, best.label, best.samples_at(seconds), seconds, error, seconds, own,
                  bool(seconds > best.seconds[-1]))


def differs_in_effort(one: Measured) -> bool:
    """Whether time or noise differ from the user's settings, beyond chance for all choices together."""
    return any(found and abs(ratio.value - 1.0) >= SMALL
               for ratio, found in ((one.time, one.time_found), (one.noise_ratio, one.noise_found)))


def is_eligible(one: Measured) -> bool:
    """Whether a choice may be recommended: it is quicker beyond doubt, or brings back light; a filter is taste."""
    if one.choice.key in (BASE, TRUTH):
        return True
    brings_light = one.light_found and one.light.value > EQUAL
    return one.choice.axis != "Filter" and (
        differs_in_effort(one) and one.effort.high < 1.0 or brings_light)


def advise(measured: list[Measured]) -> list[Advice]:
    curves = [curve_of(one) for one in measured if is_eligible(one)]
    return [for_error(curves, error) for error in ERRORS] + [for_time(curves, seconds) for seconds in TIMES]


def pareto(points: list[tuple[float, float]]) -> list[int]:
    """The places of the (time, error) points that no other beats in both, in the order of time.

    A later point counts where its error is less by the share CLEARLY at least: less is chance.
    """
    best, front = math.inf, []
    for place in sorted(range(len(points)), key=lambda i: points[i]):
        if points[place][1] < (1.0 - CLEARLY) * best:
            best = points[place][1]
            front.append(place)
    return front


def front_of(measured: list[Measured]) -> list[tuple[int, int]]:
    """The Pareto front as (place of the choice, place of its number of samples), in the order of time.

    Filters are taste, and a choice with the same bits as the user's settings differs from them in the clock's noise
    only, unless it is another device.
    """
    places = [(i, s) for i, one in enumerate(measured) for s in range(len(one.counts)) if one.choice.axis != "Filter"
              and (one.choice.key == BASE or one.choice.axis == "Device" or not one.same_bits)]
    return [places[k] for k in pareto([(measured[i].seconds[s], measured[i].error[s].value) for i, s in places])]
