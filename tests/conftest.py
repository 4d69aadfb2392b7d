"""What all tests share; behind pytest's own summary the table of the extremes, written where that is asked for."""

import json
import os
from dataclasses import asdict
from pathlib import Path

import pytest

from tests.extremes.table import HEADINGS, ROWS, Row, shown, table

# Tests leave the user's cache alone: each compiles what it runs, or has a cache of its own.
os.environ["ISOPHOTE_KERNEL_CACHE"] = "off"


def missing(what: str) -> None:
    """Skip a test that lacks a part of the machine; fail where CI=true, which wants every test to run."""
    if os.environ.get("CI") == "true":
        pytest.fail(f"{what}, and CI=true wants every test to run")
    pytest.skip(what)


# Minutes each, most of it in compilers: first, so that the last file that runs is a short one.
LONGEST = ("test_extension.py", "test_vectorised.py", "test_compilers.py")


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: item.path.name not in LONGEST)


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
