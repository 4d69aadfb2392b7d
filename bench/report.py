"""Rows of JSON kept in files, and the page docs/measurements.md made of them.

A result is a file BENCH.MACHINE.json: what ran, where, when, and the rows. The page is a template, in
which people write what the figures mean, with a line `<!-- rows: BENCH -->` where tables go. What was
measured on another machine is a file brought from there. `by_hand` marks rows that were copied from a
run's output.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

from bench.catalogue import BENCHES, Bench
from bench.common import ROOT

RESULTS = ROOT / "docs" / "measurements"
TEMPLATE = RESULTS / "template.md"
PAGE = ROOT / "docs" / "measurements.md"
PLACE = re.compile(r"^<!-- rows: (\w+) -->$", re.M)
NONE_YET = "*No rows yet: `python -m bench {name}`.*"


def slug(text: str) -> str:
    """A name for files: small letters, digits and dashes."""
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")


def save_result(folder: Path, result: dict) -> Path:
    """Keep a result; it replaces an older one of the same bench and machine."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{result['bench']}.{result['machine']['name']}.json"
    rows = ",\n  ".join(json.dumps(row) for row in result["rows"])
    head = json.dumps({key: value for key, value in result.items() if key != "rows"}, indent=1)
    path.write_text(f'{head[:-2]},\n "rows": [\n  {rows}\n ]\n}}\n')
    return path


def load_results(folder: Path, name: str) -> list[dict]:
    """All results of a bench, the oldest first."""
    found = [json.loads(path.read_text()) for path in sorted(folder.glob(f"{name}.*.json"))]
    return sorted(found, key=lambda result: result["date"])


def value_at(row: dict, path: str):
    """row["a"]["b"] for the path "a.b", None where something is missing."""
    for key in path.split("."):
        if not isinstance(row, dict) or key not in row:
            return None
        row = row[key]
    return row


def shown(value) -> str:
    """A cell: three digits of a fraction, whole numbers in full, a dash for nothing."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:#.3g}".rstrip(".") if abs(value) < 1000 else f"{value:,.0f}"
    if isinstance(value, int):
        return f"{value:,}"
    if isinstance(value, (list, tuple)):
        return ", ".join(shown(item) for item in value)
    if isinstance(value, dict):
        return ", ".join(f"{key}: {shown(item)}" for key, item in value.items())
    return str(value).replace("|", "\\|")


def table(heads: list[str], lines: list[list]) -> str:
    cells = [heads, ["---"] * len(heads), *([shown(value) for value in line] for line in lines)]
    return "\n".join(f"| {' | '.join(line)} |" for line in cells)


def plain_columns(rows: list[dict]) -> dict[str, str]:
    """Every key that holds something plain in some row, in the order of their first appearance."""
    return {key: key for row in rows for key, value in row.items() if isinstance(value, (str, int, float))}


def rows_table(bench: Bench, rows: list[dict]) -> str:
    """The rows of one result. Columns that no row fills are left out."""
    if bench.pivot:
        line, heading, value = bench.pivot
        heads = list(dict.fromkeys(heading.format(**row) for row in rows))
        names = list(dict.fromkeys(row[line] for row in rows))
        cell = {(row[line], heading.format(**row)): value_at(row, value) for row in rows}
        return table([line, *heads], [[name, *(cell.get((name, head)) for head in heads)] for name in names])
    columns = bench.columns or plain_columns(rows)
    columns = {head: path for head, path in columns.items() if any(value_at(row, path) is not None for row in rows)}
    return table(list(columns), [[value_at(row, path) for path in columns.values()] for row in rows])


def caption(result: dict) -> str:
    """Where, when and by which command rows were measured."""
    machine = result["machine"]
    where = [str(machine["processor"]), f"{machine['threads']} threads", *machine.get("opencl", ())]
    said = [result["date"], *where]
    if result.get("commit"):
        said.append(f"commit {result['commit']}")
    versions = ", ".join(f"{name} {version}" for name, version in result.get("versions", {}).items())
    by_hand = "Entered by hand from the output of that day. " if result.get("by_hand") else ""
    remark = f" {result['remark']}" if result.get("remark") else ""
    return f"{by_hand}{'; '.join(said)}. `{result['command']}`{f'; {versions}' if versions else ''}.{remark}"


def tables(folder: Path, name: str) -> str:
    """All that is known of a bench."""
    made = [f"{caption(result)}\n\n{rows_table(BENCHES[name], result['rows'])}"
            for result in load_results(folder, name)]
    return "\n\n".join(made) or NONE_YET.format(name=name)


def page(template: str, folder: Path) -> str:
    """The template with tables in their places. Raises KeyError for a bench that is not in the catalogue."""
    unknown = set(PLACE.findall(template)) - set(BENCHES)
    if unknown:
        raise KeyError(f"the template asks for rows of {', '.join(sorted(unknown))}, which is no bench")
    return PLACE.sub(lambda place: tables(folder, place.group(1)), template)


def write_page(folder: Path = RESULTS, template: Path = TEMPLATE, out: Path = PAGE) -> None:
    out.write_text(page(template.read_text(), folder))
