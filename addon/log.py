# SPDX-License-Identifier: GPL-3.0-or-later
"""What the add-on says: lines in the log that begin with `Isophote:`, progress, and stamps in pictures."""

from __future__ import annotations

from collections import defaultdict

from isophote.ledger import ledger_lines
from isophote.session import Progress

NAMED = 3  # things that a grouped note names


def line(text: str) -> None:
    print(f"Isophote: {text}", flush=True)


def notes(entries: list[dict], told: list[str]) -> None:
    """Log a line for each note that is not among those `told`, and tell it; notes that say the same are joined."""
    for text in note_lines(entries):
        if text not in told:
            line(f"note: {text}")
            told.append(text)


def note_lines(entries: list[dict]) -> list[str]:
    """"light 'Lamp': what" for each note; where more than NAMED things share one, they share a line."""
    groups: dict[tuple, list[str]] = defaultdict(list)
    for entry in entries:
        groups[entry["kind"], entry["what"]].append(entry["name"])
    lines = []
    for (kind, what), names in groups.items():
        if len(names) > NAMED:
            quoted = ", ".join(f"'{name}'" for name in names[:NAMED])
            lines.append(f"{kind} {quoted} and {len(names) - NAMED} more: {what}")
        else:
            lines += [f"{kind} '{name}': {what}" for name in names]
    return lines


def percent(error: float | None) -> str:
    return "unknown" if error is None else f"{100.0 * error:.3g} %"


def progress_line(progress: Progress) -> str:
    """For the status line of the image editor."""
    parts = [f"Sample {progress.samples_done}/{progress.samples_total}"]
    if progress.remaining is not None:
        minutes, seconds = divmod(int(progress.remaining + 0.5), 60)
        parts.append(f"Remaining {minutes}:{seconds:02d}")
    if progress.error_target and progress.error_95 is not None:
        parts.append(f"95 % of pixels within {percent(progress.error_95)} (wanted {percent(progress.error_target)})")
    elif progress.error is not None:
        parts.append(f"Error {percent(progress.error)}")
    return " | ".join(parts)


def finished(result: dict, export_seconds: float) -> None:
    """The last line of a render; `result` is Session.result()."""
    stopped = "" if result["why_stopped"] == "samples" else f", stopped by {result['why_stopped'] or 'an error'}"
    strict = result["strict"] if isinstance(result["strict"], str) else "strict"
    drawn = result["samples_by_device"]
    shares = f" ({', '.join(f'{count} by {name}' for name, count in drawn.items())})" if len(drawn) > 1 else ""
    line(
        f"device {result['device']}, {result['samples']} samples{shares}, "
        f"{result['samples_per_second']:.4g} samples/s, error {percent(result['error'])}, "
        f"95 % of pixels within {percent(result['error_95'])}, {percent(result['unsure'])} of the picture unsure, "
        f"export {export_seconds:.2f} s, build {result['build_seconds']:.2f} s, "
        f"compile {result['compile_seconds']:.2f} s, render {result['render_seconds']:.2f} s, {strict}{stopped}"
    )
    for sentence in ledger_lines(taken(result)):
        line(f"ledger: {sentence}")


def taken(result: dict) -> list[dict]:
    """The ledger without what was left out: that has its notes."""
    return [entry for entry in result["ledger"] if entry["switch"] != "left_out"]


def stamp_fields(result: dict, layer: str, partial: bool) -> dict[str, str]:
    """Metadata of the picture, "isophote.LAYER.WHAT" as Cycles names its own; `result` is Session.result()."""
    fields = {
        "device": result["device"],
        "driver": result["driver"],
        "samples": str(result["samples"]),
        "most_samples": str(result["most_samples"]),
        "error": percent(result["error"]),
        "error_95": percent(result["error_95"]),
        "error_target": percent(result["error_target"]) if result["error_target"] else "none",
        "unsure": percent(result["unsure"]),
        "stopped": result["why_stopped"] or "an error",
        "precision": result["precision"],
        "strict": result["strict"] if isinstance(result["strict"], str) else "yes",
        "seed": str(result["seed"]),
        "scene": result["scene_hash"],
        "partial": "yes" if partial or result["why_stopped"] == "cancelled" else "no",
        "ledger": "; ".join(ledger_lines(taken(result))),
        "left_out": "; ".join(note_lines(result["notes"])) or "nothing",
    }
    return {f"isophote.{layer}.{name}": value for name, value in fields.items()}
