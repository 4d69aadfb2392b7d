"""The extremes of docs/extremes.md in their wide form: runs tests/extremes, prints its rows and writes the page.

    python -m bench.extremes

prints one JSON row a case (range driven, largest error, its limit, verdict); the exit status is 1 where a case breaks.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from bench.common import ROOT, commit, machine, print_row, today

PAGE = ROOT / "docs" / "extremes.md"
HEAD = """# The extremes

Where renderers break, and how far each case was driven here: strict float32 on OpenMP and on OpenCL (PoCL), whose bits
are compared in every film, against float64 (precision "reference") or an exact answer. `tests/extremes` holds the
cases; CI runs them with `--quick`, over fewer steps and samples. An error is the largest of its case, and the limit is
what the test allows.

Written by `python -m bench.extremes{quick}` on {date}, commit {commit}, {processor},
{opencl}.

| case | range driven | largest error | limit | verdict |
| --- | --- | --- | --- | --- |
"""


def run_tests(quick: bool) -> tuple[list[dict], int]:
    """The table's rows, and pytest's exit status. What pytest itself says goes to stderr."""
    with tempfile.TemporaryDirectory() as folder:
        rows = Path(folder) / "rows"
        wanted = {"ISOPHOTE_EXTREMES_ROWS": str(rows)} | ({} if quick else {"ISOPHOTE_EXTREMES": "wide"})
        status = subprocess.run([sys.executable, "-m", "pytest", "tests/extremes", "-q"], cwd=ROOT, stdout=sys.stderr,
                                env=os.environ | wanted).returncode
        found = [json.loads(line) for line in rows.read_text().splitlines()] if rows.exists() else []
        return found, status


def page(rows: list[dict], quick: bool) -> str:
    here = machine()
    text = HEAD.format(quick=" --quick" if quick else "", date=today(), commit=commit(), processor=here["processor"],
                       opencl=", ".join(here["opencl"]))
    for row in rows:
        measured = bool(row["measure"])
        error = f"{row['measure']}: {row['largest']:.2g}" if measured else ""
        limit = f"{row['limit']:.2g}" if measured else ""
        text += f"| {row['case']} | {row['driven']} | {error} | {limit} | {row['verdict']} |\n"
    return text


def main(argv=None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--quick", action="store_true", help="as CI drives them")
    arguments = parser.parse_args(argv)
    rows, status = run_tests(arguments.quick)
    for row in rows:
        print_row(row)
    if rows:
        PAGE.write_text(page(rows, arguments.quick))
    return 1 if status or not rows else 0


if __name__ == "__main__":
    sys.exit(main())
