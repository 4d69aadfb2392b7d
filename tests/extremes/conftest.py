"""Prints the table of the extremes behind pytest's own summary, and writes its rows where it is asked to."""

import json
import os
from dataclasses import asdict
from pathlib import Path

import pytest

from tests.extremes.table import HEADINGS, ROWS, Row, shown, table


def pytest_sessionfinish(session):
    if (output := getattr(session.config, "workeroutput", None)) is not None:
        output["extremes"] = [asdict(row) for row in ROWS]


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node):
    """What a process of pytest-xdist has found."""
    ROWS.extend(Row(**row) for row in getattr(node, "workeroutput", {}).get("extremes", ()))


def pytest_terminal_summary(terminalreporter):
    if not ROWS:
        return
    lines = [HEADINGS, *map(shown, table())]
    widths = [max(len(line[column]) for line in lines) for column in range(len(HEADINGS))]
    terminalreporter.section("extremes")
    for line in lines:
        terminalreporter.write_line("  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)))
    if path := os.environ.get("ISOPHOTE_EXTREMES_ROWS"):
        Path(path).write_text("".join(json.dumps(row) + "\n" for row in table()))
