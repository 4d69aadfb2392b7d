"""The analysis in plain sentences, for people who know rendering and not statistics."""

from __future__ import annotations

import math

from isophote.trade.advice import Advice, differs_in_effort
from isophote.trade.analysis import EQUAL, SMALL, Measured, Reference
from isophote.trade.grid import BASE, TRUTH
from isophote.trade.intervals import Interval

ADAPTIVE_AXIS = "Adaptive sampling"
GAIN = 0.9  # of the time for the same noise: less than this is a gain
UNKNOWN = 0.2  # of the time: an interval that wide is said
UNSURE = 0.1  # of the picture: less is not worth a warning
SHOWN = 0.02  # of the light: that much one sees side by side


def percent(share: float) -> str:
    """A share with two digits that say something: 12 %, 3.1 %, 0.042 %."""
    value = 100.0 * abs(share)
    if not math.isfinite(value):
        return "an unknown share"
    if value < 1e-5:
        return "less than 0.00001 %" if value else "0 %"
    text = f"{value:.{max(0, 1 - math.floor(math.log10(value)))}f}"
    return f"{text.rstrip('0').rstrip('.') if '.' in text else text} %"


def duration(seconds: float) -> str:
    if seconds < 0.1:
        return f"{1000 * seconds:.0f} ms"
    if seconds < 10.0:
        return f"{seconds:.1f} s"
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    if seconds < 5400.0:
        return f"{seconds / 60:.0f} min"
    hours = seconds / 3600
    return f"{hours:.0f} h" if hours < 72 else f"{hours / 24:,.0f} days"


def time_words(time: Interval, found: bool) -> str:
    """What happens to the time; where that is not known well, between what and what it may be."""
    value = time.value
    if not found and max(abs(time.low - 1.0), abs(time.high - 1.0)) >= UNKNOWN:
        about = "probably saves time" if time.high < 1.0 else "probably takes longer" if time.low > 1.0 else (
            "takes about as long")
        return f"{about} (between {change_words(time.low)} and {change_words(time.high)})"
    if not found or abs(value - 1.0) < SMALL:
        return "takes as long"
    if value < 1.0:
        return f"saves {percent(1.0 - value)} of the time"
    return f"takes {value:.1f} times as long" if value >= 1.5 else f"takes {percent(value - 1.0)} longer"


def change_words(ratio: float) -> str:
    """\"12 % less\", \"30 % more\", \"2.3 times\"."""
    if not math.isfinite(ratio):
        return "any"
    if ratio >= 2.0:
        return f"{ratio:.1f} times"
    return f"{percent(1.0 - ratio)} {'less' if ratio < 1.0 else 'more'}"


def noise_words(ratio: float, found: bool) -> str:
    if not found or abs(ratio - 1.0) < SMALL:
        return "leaves the noise as it is"
    if ratio < 1.0:
        return f"makes the picture {percent(1.0 - ratio)} less noisy"
    if ratio >= 2.0:
        return f"makes the picture {ratio:.1f} times as noisy"
    return f"makes the picture {percent(ratio - 1.0)} noisier"


def light_words(light: Interval, found: bool) -> str:
    """What happens to the light; where nothing was found, how much it might be."""
    if light.largest <= EQUAL:
        return f"keeps the light (within {percent(max(light.largest, 1e-7))})"
    if not found:
        return f"keeps the light as far as one can tell (a change is smaller than {percent(light.largest)})"
    return f"{'removes' if light.value < 0.0 else 'adds'} {percent(light.value)} of the light"


def sentence(one: Measured) -> str:
    """What a choice buys and costs, against the user's settings with the same samples."""
    if one.choice.key == BASE:
        return "The settings of the file, as they are."
    took = time_words(one.time, one.time_found)
    if one.choice.axis == ADAPTIVE_AXIS:
        return (f"{one.choice.label} {took}, and 95 of 100 pixels are within {percent(one.within)} of "
                f"their brightness; with your settings within {percent(one.base_within)}.")
    if one.same_bits:
        return f"{one.choice.label} {took}; the picture is the same, bit by bit."
    noise = noise_words(one.noise_ratio.value, one.noise_found)
    return f"{one.choice.label} {took}, {light_words(one.light, one.light_found)}, and {noise}."


def places(one: Measured) -> str:
    """Where a choice differs in single places; "" where nowhere."""
    if one.worst_tile is None:
        return ""
    side = "darker" if one.worst_tile < 0.0 else "brighter"
    share = percent(one.tiles_off) if one.tiles_off >= 0.01 else "less than 1 %"
    other = "with nothing left out" if one.choice.key == BASE else "with your settings"
    return f"Beyond chance in {share} of the picture; the worst place is {percent(one.worst_tile)} {side} than {other}."


def verdict(one: Measured) -> tuple[str, str]:
    """(kind, words): "good", "trade", "bad", "same", or "" for what is not to be judged."""
    if one.choice.key in (BASE, TRUTH):
        return "", "What the others are compared with" if one.choice.key == BASE else "What light is measured against"
    if one.choice.axis == "Filter":
        return "", "A matter of taste: sharper or softer, not faster"
    adaptive = one.choice.axis == ADAPTIVE_AXIS
    effort = one.time if adaptive else one.effort
    differs = one.time_found if adaptive else differs_in_effort(one)
    gains = differs and effort.high < 1.0 and effort.value < GAIN
    loses = differs and effort.low > 1.0 and effort.value > 1.0 / GAIN
    changed = one.light_found and one.light.largest > EQUAL
    if changed and one.light.value > 0.0:  # light that the user's settings lose
        if loses:
            return "trade", f"Brings light back, and takes {effort.value:.1f} times as long for the same noise"
        return "good", "Worth it: brings light back for no more time"
    if gains:
        faster = f"the same {'error' if adaptive else 'noise'} in {percent(effort.value)} of the time"
        if not changed and not one.tiles_off:
            return "good", f"Worth it: {faster}"
        seen = "which one sees" if one.light.largest > SHOWN else "hardly seen in the picture as a whole"
        price = f"{percent(one.light.value)} of the light, {seen}" if changed else "light in single places"
        return "trade", f"A trade: {faster}, for {price}"
    if loses:
        return "bad", f"Costs time here: {effort.value:.1f} times as long for the same noise"
    if changed:
        return "bad", "Gains nothing here, and loses light"
    return "same", "Makes no difference worth noting here"


def in_short(measured: list[Measured], reference: Reference) -> list[str]:
    """The page's first lines."""
    base = next(one for one in measured if one.choice.key == BASE)
    lines = [f"With your settings a picture of {base.counts[-1]:.0f} samples takes {duration(base.seconds[-1])} at "
             f"this size, and its pixels are off by about {percent(base.error[-1].value)} of their brightness."]
    if base.bias_found and base.light_bias.largest > EQUAL:
        what = "loses" if base.light_bias.value < 0.0 else "gains"
        lines.append(f"Of that, more samples cure only the noise: your settings' picture {what} "
                     f"{percent(base.light_bias.value)} of the light, whatever the number of samples.")
    elif not base.light_bias.largest:
        lines.append("That is only noise: with nothing left out the picture is the same, bit by bit.")
    else:
        lines.append("That is only noise, as far as one can tell: no lasting error of the light was found, and one "
                     f"would have to be smaller than {percent(base.light_bias.largest)}.")
    if len(base.noise) > 1 and base.noise[-2].value > 0.0:
        lines.append(f"From {base.counts[-2]:.0f} to {base.counts[-1]:.0f} samples the noise fell to "
                     f"{percent(base.noise[-1].value / base.noise[-2].value)}; half is usual for four times the time.")
    others = [one for one in measured if one.choice.key not in (BASE, TRUTH) and one.choice.axis != "Filter"]
    rated = [(verdict(one)[0], one) for one in others]
    good = best_of_axes([one for kind, one in rated if kind == "good"])
    trades = best_of_axes([one for kind, one in rated if kind == "trade" and one.effort.value < 1.0])
    lines += [f"Worth it: {sentence(one)}" for one in good[:2]]
    lines += [f"A trade: {sentence(one)}" for one in trades[:3]]
    if not good:
        lines.append("Nothing that was tried makes this scene faster without changing its picture.")
    unsure = base.info.get("unsure")
    if unsure and unsure > UNSURE:
        lines.append(f"In {percent(unsure)} of a picture of {base.counts[-1]:.0f} samples light comes in few bright "
                     "hits or slivers; what is said of noise and light is less sure there than its bars say.")
    lines.append(f"The reference has {reference.samples:,} samples a pixel; what is left of its own noise is "
                 f"{percent(reference.noise)}.")
    return lines


def best_of_axes(choices: list[Measured]) -> list[Measured]:
    """The best of each axis, the best first."""
    ordered = sorted(choices, key=lambda one: one.effort.value)
    return [one for place, one in enumerate(ordered)
            if one.choice.axis not in {better.choice.axis for better in ordered[:place]}]


def advice_words(advice: Advice, is_error: bool) -> tuple[str, str, str]:
    """Three cells: what to choose, what that gives, and what the user's settings give."""
    if advice.choice is None:
        return ("nothing that was tried", "no choice comes that near" if is_error else "too short for one sample", "")
    mark = " (extrapolated)" if advice.extrapolated else ""
    samples = max(1, round(advice.samples))
    samples = round(samples, 2 - len(str(samples)))  # two digits
    count = f"{samples:,} sample{'s' if samples > 1 else ''}"
    if is_error:
        own = "never: their lasting error is larger" if advice.base_seconds is None else duration(advice.base_seconds)
        return advice.label, f"{duration(advice.seconds)}, {count}{mark}", own
    own = "too short for one sample" if advice.base_error is None else f"{percent(advice.base_error)} error"
    return advice.label, f"{percent(advice.error)} error, {count}{mark}", own
