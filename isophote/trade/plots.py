"""Plots as SVG text that stands in the page: light and dark mode, no JavaScript, nothing to load.

Why not matplotlib: Blender's Python has none, and the button must work there; its SVG has fixed colours, so no dark
mode, and weighs some hundred kB. pygal and the like would have to be bundled for three simple plots and bring scripts.
What is left is two axes, lines, bars and text; colours are classes and variables of the page's style sheet (page.py),
the Okabe-Ito palette, and no meaning hangs on colour alone: shapes, labels and tooltips (title) say it too.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from html import escape

from isophote.trade.advice import front_of
from isophote.trade.analysis import Measured
from isophote.trade.grid import BASE, TRUTH
from isophote.trade.intervals import Interval
from isophote.trade.words import duration, percent

WIDTH, LEFT, RIGHT, TOP, BOTTOM = 860, 64, 230, 14, 46
AXES = ("Your settings", "Nothing left out", "Bounces", "Clamping", "Filter", "Precision", "Device",
        "Adaptive sampling", "Textures", "All savings")
SHAPES = {"Your settings": "square", "Nothing left out": "diamond"}


def family(axis: str) -> str:
    """The class that gives an axis of the grid its colour."""
    return f"c{AXES.index(axis) if axis in AXES else 0}"


def svg(height: float, body: list[str], label: str) -> str:
    return (f'<svg viewBox="0 0 {WIDTH} {height:.0f}" role="img" aria-label="{escape(label)}">'
            f'{"".join(body)}</svg>')


def text(x: float, y: float, words: str, anchor: str = "start", kind: str = "") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" class="{kind}">{escape(words)}</text>'


def line(x0: float, y0: float, x1: float, y1: float, kind: str) -> str:
    return f'<line x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}" class="{kind}"/>'


def marker(x: float, y: float, axis: str, title: str, big: bool = False) -> str:
    """A point with a tooltip: a square for the user's settings, a diamond for the truth, else a disk."""
    r, shape = 6.5 if big else 3.5, SHAPES.get(axis)
    kind = f"dot {family(axis)}{' front' if big else ''}"
    if shape == "square":
        drawn = f'<rect x="{x - r:.1f}" y="{y - r:.1f}" width="{2 * r}" height="{2 * r}" class="{kind}">'
    elif shape == "diamond":
        r *= 1.25
        drawn = (f'<polygon points="{x:.1f},{y - r:.1f} {x + r:.1f},{y:.1f} {x:.1f},{y + r:.1f} {x - r:.1f},{y:.1f}" '
                 f'class="{kind}">')
    else:
        drawn = f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{r}" class="{kind}">'
    tag = drawn[1:drawn.index(" ")]
    return f"{drawn}<title>{escape(title)}</title></{tag}>"


def log_ticks(low: float, high: float) -> list[float]:
    """1, 2, 5 times the powers of ten between low and high, or powers alone where that is many."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    steps = (1, 2, 5) if last - first <= 3 else (1,)
    return [s * 10.0 ** e for e in range(first, last + 1) for s in steps if low <= s * 10.0 ** e <= high]


def log_scale(low: float, high: float, start: float, end: float) -> Callable[[float], float]:
    a, b = math.log(low), math.log(high)
    return lambda value: start + (math.log(max(value, low)) - a) / (b - a) * (end - start)


def error_over_time(measured: list[Measured]) -> str:
    """Error over rendering time on logarithmic axes, a line a choice, with the Pareto front marked."""
    height = 470
    times = [seconds for one in measured for seconds in one.seconds]
    errors = [max(interval.value, 1e-6) for one in measured for interval in one.error]
    ends = min(times) / 1.3, max(times) * 1.3, min(errors) / 1.3, max(errors) * 1.3
    x = log_scale(ends[0], ends[1], LEFT, WIDTH - RIGHT)
    y = log_scale(ends[2], ends[3], height - BOTTOM, TOP)
    body = []
    for tick in log_ticks(*ends[:2]):
        body += [line(x(tick), TOP, x(tick), height - BOTTOM, "grid"),
                 text(x(tick), height - BOTTOM + 16, duration(tick), "middle", "tick")]
    for tick in log_ticks(*ends[2:]):
        body += [line(LEFT, y(tick), WIDTH - RIGHT, y(tick), "grid"),
                 text(LEFT - 6, y(tick) + 4, f"{100 * tick:g} %", "end", "tick")]
    body += [text((LEFT + WIDTH - RIGHT) / 2, height - 8, "rendering time of one picture, without set-up", "middle"),
             f'<text transform="translate(14 {height / 2:.0f}) rotate(-90)" text-anchor="middle">error</text>']
    for one in measured:
        path = " ".join(f"{x(t):.1f},{y(max(e.value, 1e-6)):.1f}" for t, e in zip(one.seconds, one.error, strict=True))
        body.append(f'<polyline points="{path}" class="line {family(one.choice.axis)}"/>')
    front = front_of(measured)
    corners = [(measured[i].seconds[s], measured[i].error[s].value) for i, s in front]
    steps = " ".join(f"{x(seconds):.1f},{y(max(error, 1e-6)):.1f}" for seconds, error in corners)
    body.append(f'<polyline points="{steps}" class="pareto"/>')
    for place, one in enumerate(measured):
        for s, (seconds, error) in enumerate(zip(one.seconds, one.error, strict=True)):
            title = (f"{one.choice.label}, {one.counts[s]:.0f} samples: {duration(seconds)}, "
                     f"{percent(error.value)} error")
            body.append(marker(x(seconds), y(max(error.value, 1e-6)), one.choice.axis, title, (place, s) in front))
    used = [axis for axis in AXES if any(one.choice.axis == axis for one in measured)]
    at = WIDTH - RIGHT + 24
    for row, axis in enumerate(used):
        body += [marker(at, TOP + 12 + 21 * row, axis, axis), text(at + 14, TOP + 16 + 21 * row, axis)]
    row = len(used)
    body += [line(at - 10, TOP + 12 + 21 * row, at + 10, TOP + 12 + 21 * row, "pareto"),
             text(at + 14, TOP + 16 + 21 * row, "large: nothing is both"),
             text(at + 14, TOP + 33 + 21 * row, "sooner and better")]
    return svg(height, body, "Error over rendering time")


def bars(rows: list[tuple[str, str, Interval, str]], limits: tuple[float, float], unit: Callable[[float], str],
         ticks: list[float], label: str, zero: float, log: bool = False) -> str:
    """Horizontal bars from `zero`, with intervals: rows of (name, axis, interval, words). Ends are cut at `limits`."""
    left, right, step = 240, 190, 24
    height = TOP + step * len(rows) + 40
    low, high = limits
    x = (log_scale(low, high, left, WIDTH - right) if log else
         lambda value: left + (min(max(value, low), high) - low) / (high - low) * (WIDTH - right - left))

    def place(value: float) -> float:
        return x(min(max(value, low), high))

    body = []
    for tick in ticks:
        body += [line(x(tick), TOP, x(tick), height - 36, "zero" if tick == zero else "grid"),
                 text(x(tick), height - 20, unit(tick), "middle", "tick")]
    for row, (name, axis, interval, words) in enumerate(rows):
        y = TOP + step * row + step / 2
        a, b = sorted((x(zero), place(interval.value)))
        body += [text(left - 10, y + 4, name, "end"),
                 f'<rect x="{a:.1f}" y="{y - 7:.1f}" width="{max(b - a, 1.0):.1f}" height="14" '
                 f'class="bar {family(axis)}"><title>{escape(name)}: {escape(words)}</title></rect>',
                 line(place(interval.low), y, place(interval.high), y, "whisker"),
                 line(place(interval.low), y - 4, place(interval.low), y + 4, "whisker"),
                 line(place(interval.high), y - 4, place(interval.high), y + 4, "whisker"),
                 text(WIDTH - right + 10, y + 4, words)]
    return svg(height, body, label)


def shorter(label: str, most: int = 34) -> str:
    return label if len(label) <= most else label.split(":")[0][:most]


def ratio_bars(measured: list[Measured], which: str, label: str) -> str:
    """Time or noise over that of the user's settings, on a logarithmic axis around 1."""
    rows = [(shorter(one.choice.label), one.choice.axis, getattr(one, which), ratio_text(getattr(one, which).value))
            for one in measured if one.choice.key != BASE]
    finite = [abs(math.log(value)) for _, _, interval, _ in rows for value in (interval.value,) if value > 0.0]
    most = min(8.0, max(1.5, math.exp(max(finite, default=0.0)) * 1.15))
    ticks = [t for t in (1 / 8, 1 / 4, 1 / 2, 0.75, 1.0, 1.5, 2.0, 4.0, 8.0) if 1 / most <= t <= most]
    if most > 2.0:
        ticks = [t for t in ticks if t not in (0.75, 1.5)]
    return bars(rows, (1 / most, most), ratio_text, ticks, label, 1.0, log=True)


def ratio_text(value: float) -> str:
    """A ratio as people say it: -37 %, the same, +12 %, 2.6 times."""
    if value >= 1.995:
        return f"{value:.2g} times"
    return "the same" if abs(value - 1.0) < 0.005 else f"{100.0 * (value - 1.0):+.0f} %"


def bias_bars(measured: list[Measured]) -> str:
    """Light gained or lost against the truth, in per cent, with 95 % intervals."""
    rows = [(shorter(one.choice.label), one.choice.axis, one.light_bias, bias_text(one))
            for one in measured if one.choice.key != TRUTH]
    values = [abs(one.light_bias.value) for one in measured if math.isfinite(one.light_bias.value)]
    most = 1.15 * max(*values, 0.001)
    step = 10.0 ** math.floor(math.log10(most))
    step = next(s for s in (step / 5, step / 2, step, 2 * step, 5 * step) if most / s <= 4)
    ticks = [k * step for k in range(-math.floor(most / step), math.floor(most / step) + 1)]
    return bars(rows, (-most, most), lambda t: f"{100 * t:+.3g} %" if t else "0", ticks,
                "Light gained or lost against the truth", 0.0)


def bias_text(one: Measured) -> str:
    if one.light_bias.largest < 1e-7:
        return "none"
    if not one.bias_found:
        return f"none found (< {percent(one.light_bias.largest)})"
    return f"{'-' if one.light_bias.value < 0 else '+'}{percent(one.light_bias.value)}"
