"""The ledger of bias: what each setting that changes the expected picture has taken from it.

Error bars are about noise. Clamped light, paths that a limit has ended and samples that were no numbers are missing
however long a render takes. Each is an entry, a dict that JSON can hold:

    switch      the setting's name, "invalid_samples" or "left_out"
    setting     its value; of left_out the note
    status      "none": it has taken nothing in this render; "rendered": summed while rendering, exact for these
                samples; "measured": by pairs of renders (bias.py); "not measured"
    removed     what it took, as a share of the luminance that the picture has without it; None: not measured
    interval    the ends of its 95 % confidence interval; None: not known
    luminance   the mean luminance of a pixel that was removed; with the picture's own it is the picture without
    paths       of a bounce limit: how many paths it has ended, as a share of the camera's paths
    samples     of invalid_samples: how many there were; `pixels`: in how many pixels
    how         where it was not measured: what measures it

A limit's `paths` counts ends, also of shadow rays that pass transparent surfaces, so it may exceed 1.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.confidence import student95
from isophote.film import LIMITS, Film
from isophote.planes import INVALID
from isophote.settings import Settings
from isophote.statistics import LUMINANCE, variance_of_mean, weighted_sums

CLAMPS = ("clamp_direct", "clamp_indirect")
MEASURE = "isophote ledger FILE measures it"
COMPARE = "only another renderer that has it can tell: isophote compare measures the difference of two pictures"


def ledger_of(film: Film, settings: Settings, notes: list[dict]) -> list[dict]:
    """The entries of a render; `notes` are those of Session, of which those about devices and passes are left out."""
    entries = [clamp_entry(film, settings, name) for name in CLAMPS if getattr(settings, name) > 0.0]
    entries += [limit_entry(film, settings, name) for name in LIMITS]
    if settings.precision == "fast":
        entries.append(entry("precision", "fast", "not measured", how=MEASURE))
    entries.append(invalid_entry(film))
    left_out = {f"{note['kind']} '{note['name']}': {note['what']}" for note in notes
                if note["kind"] not in ("device", "pass")}
    return entries + [entry("left_out", what, "not measured", how=COMPARE) for what in sorted(left_out)]


def entry(switch: str, setting, status: str, removed: float | None = None, interval: list[float] | None = None,
          luminance: float | None = None, **more) -> dict:
    return {"switch": switch, "setting": setting, "status": status, "removed": removed, "interval": interval,
            "luminance": luminance, **more}


def nothing(switch: str, setting, **more) -> dict:
    """An entry of what has taken nothing."""
    return entry(switch, setting, "none", 0.0, [0.0, 0.0], 0.0, **more)


def clamp_entry(film: Film, settings: Settings, name: str) -> dict:
    """What one clamp cut off, summed while rendering.

    Its share R = mean cut / mean luminance without clamping is exact for these samples; the interval is that of other
    seeds' renders: the spread between the replicates of each pixel's cut - R x luminance (the ratio's first order), by
    the central limit theorem over the picture, with Student's t as in confidence.py.
    """
    cuts = [np.stack([film.cut(kind, replicate) for replicate in (0, 1)]) for kind in (False, True)]
    cut, setting = cuts[CLAMPS.index(name)], getattr(settings, name)
    if not cut.any():
        return nothing(name, setting)
    whole = np.stack(weighted_sums(film, LUMINANCE)) + sum(cuts)
    cut_light, light = (float((sums.sum(axis=0) / film.counts).sum()) for sums in (cut, whole))
    removed, interval = cut_light / light, None
    if np.min(film.replicate_samples) > 0:
        rest = cut - removed * whole
        variance = variance_of_mean((rest[0], rest[1]), film.replicate_samples)
        total = float(variance.sum())
        if total > 0.0:
            freedom = 3.0 * total * total / float((variance * variance).sum())
            half = float(student95(freedom)) * math.sqrt(total) / light
            interval = [max(0.0, removed - half), min(1.0, removed + half)]
    return entry(name, setting, "rendered", removed, interval, cut_light / math.prod(film.shape))


def limit_entry(film: Film, settings: Settings, name: str) -> dict:
    """What a bounce limit ended: nothing where no path got so far, else it is not known."""
    ended, setting = int(film.ended[LIMITS.index(name)]), getattr(settings, name)
    if not ended:
        return nothing(name, setting, paths=0.0)
    return entry(name, setting, "not measured", paths=ended / film.paths, how=MEASURE)


def invalid_entry(film: Film) -> dict:
    """Samples that were NaN, infinite or too large, which count as 0. What they should have brought nobody knows."""
    counts = film.sum(INVALID)
    samples, where = int(counts.sum()), int(np.count_nonzero(counts))
    if not samples:
        return nothing("invalid_samples", "count as 0", samples=0, pixels=0)
    return entry("invalid_samples", "count as 0", "not measured", samples=samples, pixels=where,
                 how="the pass Invalid shows where; a scene whose numbers are sound should have none")


# ------------------------------------------------------------------ in words

LABELS = {"clamp_direct": "Clamping direct light at {:g}", "clamp_indirect": "Clamping indirect light at {:g}",
          "max_bounces": "The limit of {} bounces", "diffuse_bounces": "The limit of {} diffuse bounces",
          "glossy_bounces": "The limit of {} glossy bounces", "transmission_bounces": "The limit of {} transmissions",
          "volume_bounces": "The limit of {} further scatterings in volumes",
          "transparent_bounces": "The limit of {} transparent surfaces", "all_bounces": "All bounce limits together",
          "precision": "{} precision", "invalid_samples": "Invalid samples", "left_out": "Left out: {}"}


def ledger_lines(entries: list[dict], all_entries: bool = False) -> list[str]:
    """A sentence for each entry, without those that took nothing unless `all_entries`."""
    lines = [described(entry) for entry in entries if all_entries or entry["status"] != "none"]
    return lines or ["No setting took anything from the picture"]


def described(entry: dict) -> str:
    """"The limit of 4 diffuse bounces ended 9 % of the paths and took 3.2 % of the light (95 %: 3.1 % to 3.3 %)"."""
    label, facts = LABELS[entry["switch"]].format(entry["setting"]), ""
    label = label[0].upper() + label[1:]
    if entry["switch"] == "invalid_samples" and entry["samples"]:
        facts = f" ({entry['samples']} in {entry['pixels']} pixels, they count as 0)"
    elif entry.get("paths"):
        facts = f" ended {percent(entry['paths'])} of the paths"
    if entry["switch"] == "left_out":
        return label
    if entry["status"] == "none":
        return f"{label} took nothing"
    if entry["status"] == "not measured":
        joint = "; " if facts else ": "
        return f"{label}{facts}{joint}the light that is missing was not measured ({entry['how']})"
    low_high = f" (95 %: {' to '.join(map(percent, entry['interval']))})" if entry["interval"] else ""
    return f"{label}{facts + ' and' if facts else ''} took {percent(entry['removed'])} of the light{low_high}"


def percent(share: float) -> str:
    return f"{100.0 * share:.3g} %"
