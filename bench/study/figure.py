"""Pieces that the study's figures are made of: axes with a table, bars, curves, and how rows are found."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

REPORT = "#d1495b"  # the founding report's values
OURS = ["#00798c", "#edae49", "#30638e", "#66a182", "#8d6a9f", "#3b3b3b"]
SPEED = "msamples_per_second"


class Figure:
    """Axes side by side, saved under a name; and lines of a Markdown table below it."""

    def __init__(self, title: str, axes: int = 1, width: float = 5.2):
        self.figure, made = plt.subplots(1, axes, figsize=(width * axes, 3.6), squeeze=False)
        self.axes, self.table = list(made[0]), []
        self.figure.suptitle(title, fontsize=11)

    def head(self, *cells) -> None:
        self.table += [f"| {' | '.join(map(str, cells))} |", "|" + " --- |" * len(cells)]

    def line(self, *cells) -> None:
        self.table.append(f"| {' | '.join(shown(cell) for cell in cells)} |")

    def save(self, path: Path) -> None:
        for axes in self.axes:
            handles, _ = axes.get_legend_handles_labels()
            if handles:
                axes.legend(fontsize=7)
            axes.tick_params(labelsize=8)
        self.figure.tight_layout()
        self.figure.savefig(path, dpi=110)
        plt.close(self.figure)


def shown(cell) -> str:
    return cell if isinstance(cell, str) else "-" if cell is None else f"{cell:.3g}"


def select(rows, **wanted) -> list[dict]:
    """Rows that were measured and have these values, by x."""
    found = [r for r in rows if "failed" not in r and all(r[name] == value for name, value in wanted.items())]
    return sorted(found, key=lambda r: r["x"])


def scenes_of(rows) -> list[str]:
    return list(dict.fromkeys(r["scene"] for r in rows))


def speed_of(rows, **wanted):
    """The speed of the one such row, or None."""
    found = select(rows, **wanted)
    return found[0][SPEED] if found else None


def bars(axes, labels: list[str], groups: dict[str, list], ylabel: str, report: dict[str, tuple] | None = None) -> None:
    """Bars of each group beside each other at each label; the report's ranges (low, high) as bands."""
    width = 0.8 / max(len(groups), 1)
    for k, (name, values) in enumerate(groups.items()):
        at = np.arange(len(labels)) + (k - (len(groups) - 1) / 2) * width
        axes.bar(at, [v or 0 for v in values], width, label=name, color=OURS[k % len(OURS)])
    for label, (low, high) in (report or {}).items():
        if label in labels:
            at = labels.index(label)
            axes.fill_between([at - 0.45, at + 0.45], low, max(high, low * 1.01), color=REPORT, alpha=0.5,
                              label="report" if label == next(iter(report)) else None)
    axes.set_xticks(range(len(labels)), labels, rotation=30, ha="right")
    axes.set_ylabel(ylabel, fontsize=8)


def curve(axes, rows, value: Callable, label: str, k: int, **style) -> None:
    axes.plot([r["x"] for r in rows], [value(r) for r in rows], "o-", label=label, color=OURS[k % len(OURS)], ms=3,
              **style)


def report_points(axes, x, y) -> None:
    axes.plot(x, y, "s--", color=REPORT, label="report", ms=4)


def logarithmic(axes, x=True, y=False) -> None:
    if x:
        axes.set_xscale("log", base=2)
    if y:
        axes.set_yscale("log")


def ratio(a, b):
    return a / b if a and b else None
