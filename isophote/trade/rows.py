"""The figures as rows, for rows.csv and rows.json: one for each choice and number of samples."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import asdict

from isophote.json_values import finite
from isophote.trade.advice import Advice, curve_of, front_of
from isophote.trade.analysis import Measured, Reference
from isophote.trade.intervals import Interval
from isophote.trade.words import sentence, verdict

OF_CHOICE = ("time", "noise_ratio", "effort", "light", "light_bias")  # intervals at the most samples


def ends(name: str, interval: Interval) -> dict[str, float]:
    return {name: interval.value, f"{name}_low": interval.low, f"{name}_high": interval.high}


def make_rows(measured: list[Measured]) -> list[dict]:
    """Flat rows. What belongs to a choice as a whole is repeated in each of its rows."""
    front, rows = set(front_of(measured)), []
    for place, one in enumerate(measured):
        whole = {}
        for name in OF_CHOICE:
            whole |= ends(name, getattr(one, name))
        whole |= {name: getattr(one, name) for name in ("time_found", "noise_found", "light_found", "bias_found")}
        whole |= {"bias": one.bias, "tile_bias": one.tile_bias, "shift": one.shift, "worst_tile": one.worst_tile,
                  "tiles_off": one.tiles_off, "same_bits": one.same_bits, "within95": one.within,
                  "power": curve_of(one).power}
        for s, count in enumerate(one.counts):
            rows.append({"choice": one.choice.key, "axis": one.choice.axis, "label": one.choice.label,
                         "device": one.info.get("device"), "precision": one.choice.settings.precision,
                         "replicates": one.seeds, "samples": count, "seconds": one.seconds[s],
                         "setup_seconds": one.setup, **ends("error", one.error[s]), **ends("noise", one.noise[s]),
                         "pareto": (place, s) in front, **whole})
    return rows


def as_csv(rows: list[dict]) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows({key: "" if value is None else value for key, value in finite(row).items()} for row in rows)
    return text.getvalue()


def as_object(measured: list[Measured], reference: Reference, advice: list[Advice], about: dict) -> dict:
    """Everything as one object for JSON: what was rendered, the choices in words, the advice, the rows."""
    choices = [{"choice": one.choice.key, "label": one.choice.label, "sentence": sentence(one),
                "verdict": verdict(one)[0], "verdict_words": verdict(one)[1], "settings": asdict(one.choice.settings)}
               for one in measured]
    return finite({**about, "reference_samples": reference.samples, "reference_noise": reference.noise,
                   "choices": choices, "recommended": [asdict(entry) for entry in advice], "rows": make_rows(measured)})


def as_json(thing: dict) -> str:
    return json.dumps(thing, indent=1)
