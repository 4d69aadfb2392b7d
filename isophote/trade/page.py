"""The report's page: one HTML file beside its pictures, without scripts, for light and dark mode and for paper."""

from __future__ import annotations

import math
from dataclasses import dataclass
from html import escape

from isophote.trade import plots
from isophote.trade.advice import ERRORS, Advice, front_of
from isophote.trade.analysis import Measured, Reference
from isophote.trade.grid import BASE, TRUTH
from isophote.trade.intervals import Interval
from isophote.trade.style import STYLE
from isophote.trade.words import advice_words, duration, in_short, percent, places, sentence, verdict

CHANGE_FULL, NOISE_FULL = 0.2, 0.5  # relative differences at which the colours of difference pictures are full
KINDS = {"good": "worth it", "trade": "a trade", "bad": "not here", "same": "no difference"}


@dataclass(frozen=True)
class About:
    """What was rendered: `name` of the scene, its own size, the report's size, device, when and how long."""

    name: str
    full_size: tuple[int, int]
    size: tuple[int, int]
    device: str
    scene_hash: str
    date: str
    spent: float
    budget: float
    rounds: int
    partial: bool
    notes: list[dict]
    scene_notes: list[dict]


def make_page(about: About, measured: list[Measured], reference: Reference, advice: list[Advice],
              pictures: dict[str, dict[str, str]]) -> str:
    """`pictures` maps a choice's key to paths by kind: "picture", "noise" and "change"; "reference" to "picture"."""
    base = next(one for one in measured if one.choice.key == BASE)
    parts = [header(about), short(measured, reference, pictures), recommended(about, advice),
             graphs(measured), *cards(measured, pictures), table(measured), method(about, measured, reference),
             left_out(about, base)]
    title = f"Trade report: {about.name}"
    return (f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            f'<meta name="viewport" content="width=device-width, initial-scale=1">\n<title>{escape(title)}</title>\n'
            f"<style>{STYLE}</style>\n</head>\n<body>\n<main>\n" + "\n".join(filter(None, parts))
            + "\n</main>\n</body>\n</html>\n")


def header(about: About) -> str:
    cut = ("<p class='warn'>This report was stopped before its end: what is here was measured, with wider bars than "
           "planned. The same command goes on.</p>" if about.partial else "")
    return (f"<h1>What the settings of <em>{escape(about.name)}</em> buy and cost</h1>"
            f"<p class='sub'>{about.size[0]} x {about.size[1]} pixels, {escape(about.device)}, {escape(about.date)}, "
            f"{duration(about.spent)} of rendering.</p>{cut}")


def figure(path: str, caption: str, alt: str) -> str:
    return f'<figure><img src="{escape(path)}" alt="{escape(alt)}"><figcaption>{caption}</figcaption></figure>'


def short(measured: list[Measured], reference: Reference, pictures: dict) -> str:
    base = next(one for one in measured if one.choice.key == BASE)
    lines = "".join(f"<li>{escape(line)}</li>" for line in in_short(measured, reference))
    shown = (figure(pictures["reference"]["picture"], f"The reference: {reference.samples:,} samples, nothing left out",
                    "reference")
             + figure(pictures[BASE]["picture"], f"Your settings, {base.counts[-1]:.0f} samples, "
                      f"{duration(base.seconds[-1])}", "your settings"))
    return f"<section><h2>In short</h2><ul class='short'>{lines}</ul><div class='pair'>{shown}</div></section>"


def recommended(about: About, advice: list[Advice]) -> str:
    """Two small tables: by error and by time."""
    scale, size = math.prod(about.full_size) / math.prod(about.size), f"{about.full_size[0]} x {about.full_size[1]}"
    tables = []
    for is_error, entries in ((True, advice[:len(ERRORS)]), (False, advice[len(ERRORS):])):
        larger = is_error and scale > 1.01
        rows = []
        for entry in entries:
            choice, gives, own = advice_words(entry, is_error)
            full = f"<td>{duration(scale * entry.seconds) if entry.seconds else ''}</td>" if larger else ""
            rows.append(f"<tr><th>{escape(entry.wanted)}</th><td>{escape(choice)}</td><td>{escape(gives)}</td>"
                        f"<td>{escape(own)}</td>{full}</tr>")
        last = f"<th>at {size}, about</th>" if larger else ""
        tables.append(f"<table><tr><th>{'wanted' if is_error else 'time'}</th><th>choose</th><th>and get</th>"
                      f"<th>your settings</th>{last}</tr>{''.join(rows)}</table>")
    return f"<section><h2>What to choose</h2><p>{CHOOSE}</p>{''.join(tables)}</section>"


CHOOSE = """10 % error is a rough preview, 2 to 5 % looks clean in most places, 1 % is rarely needed before denoising.
Your own settings are recommended unless something is clearly better. <em>Extrapolated</em> is what was not rendered
here: noise then falls with the number of samples as it did before, at most as one over its root."""

EXPLAINED = f"""Everything is compared with your settings at the same number of samples. Each picture shows one seed at
the same exposure. <b>Off by</b> is that picture against the reference: full <span class='blue'>blue</span> is
{percent(NOISE_FULL)} darker, full <span class='orange'>orange</span> {percent(NOISE_FULL)} brighter; most of it is
noise and goes away with more samples. <b>Lasting change</b> does not go away: the mean over all seeds against your
settings (for your settings: against nothing left out), in stronger colours ({percent(CHANGE_FULL)} is full)."""


def cards(measured: list[Measured], pictures: dict) -> list[str]:
    """A card a choice, by axis: what it buys and costs in words, and what it looks like."""
    made = [f"<section><h2>Setting by setting</h2><p>{EXPLAINED}</p>"
            + "".join(card(one, pictures[key]) for key in (BASE, TRUTH) for one in measured if one.choice.key == key)
            + "</section>"]
    for axis in dict.fromkeys(one.choice.axis for one in measured if one.choice.key not in (BASE, TRUTH)):
        inside = "".join(card(one, pictures[one.choice.key]) for one in measured if one.choice.axis == axis)
        swatch = f"<span class='swatch {plots.family(axis)}'></span>"
        made.append(f"<section><h2>{swatch}{escape(axis)}</h2>{inside}</section>")
    return made


def card(one: Measured, pictures: dict[str, str]) -> str:
    kind, words = verdict(one)
    label = escape(one.choice.label)
    shown = (figure(pictures["picture"], f"{one.counts[-1]:.0f} samples, {duration(one.seconds[-1])}", label)
             + figure(pictures["noise"], f"Off by {percent(one.error[-1].value)}", f"{label}: error")
             + figure(pictures["change"], f"Lasting change, {percent(one.shift)}", f"{label}: lasting change"))
    tag = f" <span class='tag {kind}'>{KINDS[kind]}</span>" if kind else ""
    small = " ".join(filter(None, (f"{words}.", places(one))))
    return (f"<article><h3>{label}{tag}</h3><p>{escape(sentence(one))}</p><p class='small'>{escape(small)}</p>"
            f"<div class='row'>{shown}</div></article>")


def graphs(measured: list[Measured]) -> str:
    return f"""<section><h2>Error over time</h2><p>Each line is a choice, its points more and more samples; further left
is sooner, further down is better. The large points have nothing that is both sooner and better: choose among them. A
line that bends and turns flat has met its lasting error. Rest the pointer on a point to read it.</p>
{plots.error_over_time(measured)}
<p class='small'>The large points, from soon to good: {escape(on_the_front(measured))}.</p></section>
<section><h2>What each setting buys</h2><p>Against your settings at the same number of samples; shorter to the left is
less. The thin line is where the true value lies, in 95 of 100 such reports.</p>
<h3>Rendering time</h3>{plots.ratio_bars(measured, "time", "Time over that of your settings")}
<h3>Noise</h3>{plots.ratio_bars(measured, "noise_ratio", "Noise over that of your settings")}
<h3>Time for the same noise</h3>{plots.ratio_bars(measured, "effort", "Time for the same noise")}</section>
<section><h2>What each setting costs: light</h2><p>Light gained or lost against nothing left out. <em>None found</em>
says how large it may still be.</p>{plots.bias_bars(measured)}</section>"""


def on_the_front(measured: list[Measured]) -> str:
    """The points of the Pareto front in words, those of one choice together."""
    found: dict[str, list[str]] = {}
    for place, s in front_of(measured):
        one = measured[place]
        found.setdefault(one.choice.label, []).append(f"{one.counts[s]:.0f}")
    return "; ".join(f"{label} with {' and '.join(counts)} samples" for label, counts in found.items())


def table(measured: list[Measured]) -> str:
    """All rows, folded."""
    head = ("choice", "samples", "seconds", "error", "noise", "time", "noise ratio", "light (yours)", "light (truth)",
            "tiles rms")
    rows = []
    for one in measured:
        for s, count in enumerate(one.counts):
            cells = [f"{count:.0f}", f"{one.seconds[s]:.3f}", with_ends(one.error[s]), with_ends(one.noise[s])]
            if s == len(one.counts) - 1:
                cells += [with_ends(one.time, 1.0, ""), with_ends(one.noise_ratio, 1.0, ""), with_ends(one.light),
                          with_ends(one.light_bias), f"{100 * one.tile_bias:.3g} %"]
            else:
                cells += [""] * 5
            rows.append(f"<tr><th>{escape(one.choice.label)}</th>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>")
    return (f"<section><h2>All figures</h2><details><summary>{len(rows)} rows; the same, and more, is in "
            '<a href="rows.csv">rows.csv</a> and <a href="rows.json">rows.json</a></summary><div class="wide"><table>'
            f"<tr>{''.join(f'<th>{cell}</th>' for cell in head)}</tr>{''.join(rows)}</table></div></details></section>")


def with_ends(interval: Interval, scale: float = 100.0, unit: str = " %") -> str:
    low, high = (f"{scale * end:.3g}" if math.isfinite(end) else "?" for end in (interval.low, interval.high))
    return f"{scale * interval.value:.3g}{unit} <span class='ends'>[{low}, {high}]</span>"


def method(about: About, measured: list[Measured], reference: Reference) -> str:
    base = next(one for one in measured if one.choice.key == BASE)
    counts = ", ".join(f"{count:.0f}" for count in base.counts)
    return f"""<section><h2>How this was measured</h2>
<p>Every choice was rendered {about.rounds} times, each time with another seed and in another order (a busy machine
slows all alike), at {counts} samples a pixel. Seeds are shared: with the same random numbers two settings differ by
what the setting does, and lasting changes show that are far below the noise. The reference has seeds of its own.</p>
<p><b>Error</b> is the root of relMSE, the mean over pixels and channels of (x - r)&sup2; / (r&sup2; + 0.01
mean(r)&sup2;): the noise and the lasting error together. <b>Noise</b> comes from the spread between seeds and needs no
reference. <b>Light</b> is the mean luminance of the picture. Intervals hold the true value in 95 of 100 reports
(Student's t, the jackknife). Since many settings are asked what they change, one is said to change something only where
its interval at a level corrected for their number (Sidak) says so. Where light comes in rare bright hits (caustics), a
few seeds know too little of them, and intervals are too short.</p>
<p>Seconds are those of rendering; set-up (trees, kernels) took {duration(base.setup)} a picture besides. The reference
of {reference.samples:,} samples is in {escape(precision_of(measured))}. Time goes with the number of pixels; errors do
not depend on it much.</p></section>"""


def precision_of(measured: list[Measured]) -> str:
    truth = next(one for one in measured if one.choice.key == TRUTH)
    precision = truth.choice.settings.precision
    return "64-bit precision" if precision == "reference" else f"{precision} precision"


def left_out(about: About, base: Measured) -> str:
    """Notes of the report and of the scene, and the ledger of the user's settings where the session keeps one."""
    lists = []
    for title, notes in (("Left out of this report", about.notes), ("What the scene has and this engine does not",
                                                                   about.scene_notes)):
        if notes:
            items = "".join(f"<li><b>{escape(str(n['name']))}</b>: {escape(str(n['what']))}</li>" for n in notes)
            lists.append(f"<h3>{title}</h3><ul>{items}</ul>")
    counted = [entry for entry in base.info.get("ledger") or () if entry["switch"] != "left_out"]
    if counted:
        rows = "".join(f"<tr><th>{escape(str(entry['switch']))}</th><td>{escape(str(entry['setting']))}</td>"
                       f"<td>{ledger_words(entry)}</td></tr>" for entry in counted)
        lists.append("<h3>The ledger of your settings: what they removed, counted in one render</h3>"
                     f"<table><tr><th>switch</th><th>setting</th><th>removed</th></tr>{rows}</table>")
    return f"<section><h2>Notes</h2>{''.join(lists)}</section>" if lists else ""


def ledger_words(entry: dict) -> str:
    if entry.get("removed") is None:
        return "not counted while rendering: see the bars above"
    return f"{percent(entry['removed'])} of the light" if entry["removed"] else "nothing"
