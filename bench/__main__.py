"""Runs the benches, keeps their rows and writes docs/measurements.md.

    python -m bench                   all that can run here
    python -m bench compile parity    these
    python -m bench --list            what there is
    python -m bench --report-only     the page anew, of the rows that are kept

Rows go to docs/measurements/BENCH.MACHINE.json. On a machine without Blender give --scenes, a folder with
exported scenes, and --machine, a short name; bring the files back and write the page anew.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import click

from bench.catalogue import BENCHES, FOLDER, SCENES, Bench
from bench.common import ROOT, commit, machine, today, versions
from bench.cycles_process import find_python
from bench.report import RESULTS, save_result, slug, write_page
from bench.scenes import MADE, OWN, exported_scenes
from isophote.device import list_kind

KEPT_SCENES = ROOT / "build" / "bench_scenes"


def why_not(bench: Bench, scenes: Path) -> str:
    """What a bench lacks here, "" where it can run."""
    if not bench.exists:
        return "there is no such program yet"
    if "bpy" in bench.needs and find_python() is None:
        return "no Python with a bpy module (ISOPHOTE_BPY_PYTHONS)"
    if "opencl" in bench.needs and not any(info.usable for info in list_kind("opencl")):
        return "no OpenCL device"
    names = MADE if "scenes" in bench.needs else OWN if "own scenes" in bench.needs else ()
    lacking = [name for name in names if not (scenes / f"{name}.npz").is_file()]
    if lacking and find_python() is None:
        return f"no {', '.join(lacking)} (.npz) in {scenes}, and no bpy module to export them with"
    return ""


def run_bench(bench: Bench, quick: bool, scenes: Path) -> tuple[list[str], list[dict], int]:
    """The command without the interpreter, the rows that it printed, and its exit status."""
    if "own scenes" in bench.needs:
        exported_scenes(scenes, OWN)
    arguments = []
    for argument in (bench.quick or bench.arguments) if quick else bench.arguments:
        if argument == SCENES:
            arguments += [str(path) for path in exported_scenes(scenes)]
        else:
            arguments.append(str(scenes) if argument == FOLDER else argument)
    command = ["-m", f"bench.{bench.name}", *arguments]
    rows = []
    with subprocess.Popen([sys.executable, *command], cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:
        for line in process.stdout:
            click.echo(line, nl=False)
            if line.startswith("{"):
                rows.append(json.loads(line))
    if bench.then and not process.returncode and not quick:
        process = subprocess.run([sys.executable, "-m", f"bench.{bench.name}", *bench.then], cwd=ROOT)
    return command, rows, process.returncode


def readable_command(command: list[str], scenes: Path) -> str:
    """As a person would type it: without the folders of this machine."""
    return " ".join(["python", *(part.replace(f"{scenes}/", "").replace(str(scenes), "FOLDER").replace(f"{ROOT}/", "")
                                 for part in command)])


@click.command(context_settings={"help_option_names": ["-h", "--help"]}, help=__doc__.replace("\n\n", "\n\n\b\n"))
@click.argument("names", nargs=-1, metavar="[BENCH]...")
@click.option("--list", "listing", is_flag=True, help="Say what there is and what cannot run here.")
@click.option("--quick", is_flag=True, help="Small versions, to see that they run: rows are not kept.")
@click.option("--report-only", is_flag=True, help="Run nothing.")
@click.option("--results", type=click.Path(path_type=Path), default=RESULTS, help="Folder of the rows.")
@click.option("--machine", "name", help="Short name of this machine (default: its processor's).")
@click.option("--scenes", type=click.Path(path_type=Path), default=KEPT_SCENES, help="Folder of exported scenes.")
def main(names, listing, quick, report_only, results, name, scenes):
    if unknown := sorted(set(names) - set(BENCHES)):
        raise click.UsageError(f"no bench {', '.join(unknown)}: there are {', '.join(BENCHES)}")
    chosen = [BENCHES[name] for name in names] or list(BENCHES.values())
    if listing:
        for bench in chosen:
            lacking = why_not(bench, scenes)
            click.echo(f"{bench.name:<16} {bench.what}{f' (not here: {lacking})' if lacking else ''}")
        return
    failed = []
    here = {} if report_only else machine()
    for bench in [] if report_only else chosen:
        if lacking := why_not(bench, scenes):
            click.echo(f"{bench.name}: left out, {lacking}", err=True)
            failed += [bench.name] if names else []
            continue
        click.echo(f"{bench.name}: {bench.what}", err=True)
        started = time.perf_counter()
        command, rows, status = run_bench(bench, quick, scenes)
        click.echo(f"{bench.name}: {len(rows)} rows, {time.perf_counter() - started:.0f} s, status {status}", err=True)
        if status or not (rows or bench.then):
            failed.append(bench.name)
        elif rows and not quick:
            save_result(results, {
                "bench": bench.name, "command": readable_command(command, scenes), "date": today(), "commit": commit(),
                "machine": {"name": name or slug(f"{here['processor']} {here['threads']}"), **here},
                "versions": versions(), "rows": rows})
    if not quick:
        write_page(results)
    if failed:
        raise click.ClickException(f"no rows of {', '.join(failed)}")


if __name__ == "__main__":
    main(prog_name="python -m bench")
