"""The table of the extremes: one row a case, filled by the tests and printed when pytest is done."""

from __future__ import annotations

import os
from dataclasses import asdict, dataclass
from dataclasses import field as dataclass_field

import numpy as np
import pytest

WIDE = os.environ.get("ISOPHOTE_EXTREMES") == "wide"  # as bench.extremes runs them: more steps, more samples


def step(quick, wide):
    """One of two: what a test drives in CI, and what it drives in the bench."""
    return wide if WIDE else quick


@dataclass
class Row:
    """A case of the table. As a context it judges itself: `largest` is to stay at or below `limit`.

    `driven` says how far the case was driven, `measure` what the error is, `where` the place of the largest one.
    """

    case: str
    driven: str
    measure: str
    limit: float = 0.0
    largest: float = 0.0
    where: str = ""
    verdict: str = ""
    seen: int = dataclass_field(default=0, repr=False)

    def see(self, error, where: object = "") -> None:
        """Takes an error, or the largest of an array of them; NaN counts as infinite."""
        error = np.abs(np.asarray(error, np.float64))
        largest = float(np.where(np.isnan(error), np.inf, error).max()) if error.size else 0.0
        self.seen += 1
        if largest > self.largest:
            self.largest, self.where = largest, str(where)

    def __enter__(self) -> Row:
        ROWS.append(self)
        return self

    def __exit__(self, kind, error, _) -> None:
        if kind is not None:
            skipped = issubclass(kind, pytest.skip.Exception)
            self.verdict = f"not run: {error}" if skipped else f"breaks: {str(error).splitlines()[0]}"
            return
        assert self.seen, f"{self.case}: nothing was measured"
        self.verdict = "holds" if self.largest <= self.limit else "breaks"
        assert self.largest <= self.limit, f"{self.case}: {self.measure} {self.largest:.3g} at {self.where}"


# What the renderer does not have yet, so that nobody takes a missing row for a good one.
NOT_BUILT = [
    Row("denormals", "light below 1.2e-38 in the film", "",
        verdict="open: numpy takes it for 0 where the host flushes to zero"),
]
ROWS: list[Row] = []


def table() -> list[dict]:
    """The rows as plain values, in the order of the cases' first appearance."""
    rows = ROWS + NOT_BUILT
    order = {case: number for number, case in enumerate(dict.fromkeys(row.case for row in rows))}
    return [{key: value for key, value in asdict(row).items() if key != "seen"}
            for row in sorted(rows, key=lambda row: order[row.case])]


def shown(row: dict) -> tuple[str, str, str, str]:
    """A row's cells: case, range driven, largest error (and its limit), verdict."""
    error = f"{row['measure']}: {row['largest']:.2g} (limit {row['limit']:.2g})" if row["measure"] else ""
    return row["case"], row["driven"], error, row["verdict"]


HEADINGS = ("case", "range driven", "largest error", "verdict")
