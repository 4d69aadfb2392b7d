"""`isophote trade`: its options, the progress shown, and what it prints."""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import click
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from isophote.device import list_devices
from isophote.render_command import LINE_SECONDS, Interrupted, open_scene, with_file_settings
from isophote.render_command import Job as RenderJob
from isophote.scene import Scene, resized
from isophote.settings import Settings
from isophote.trade.job import Job, Status
from isophote.trade.plan import reduced
from isophote.trade.report import make_report

UNITS = {"": 1.0, "s": 1.0, "m": 60.0, "min": 60.0, "h": 3600.0}


class Duration(click.ParamType):
    """A time written 90, 90s, 10m or 1h, as seconds."""

    name = "TIME"

    def convert(self, value, param, ctx):
        if isinstance(value, float):
            return value
        number = value.strip().rstrip("smhin")
        try:
            seconds = float(number) * UNITS[value.strip()[len(number):]]
        except (KeyError, ValueError):
            self.fail(f"{value!r} is no time; write it as 90s, 10m or 1h", param, ctx)
        if not 0.0 < seconds < float("inf"):
            self.fail(f"{value!r} is no time above 0", param, ctx)
        return seconds


def trade_job(path: Path, folder: Path, size, frame, blender, devices: tuple[str, ...], console: Console,
              **options) -> Job:
    """A report's job from the command line's options. Without devices: the CPU, and all others that can be used."""
    if folder.exists() and not folder.is_dir():
        raise click.UsageError(f"{folder}: is no folder")
    scene, _ = open_scene(path, frame, None, blender, console)
    settings = with_file_settings(RenderJob(path, folder, Settings(), frozenset()), scene).settings
    first, others = (devices[0], devices[1:]) if devices else (settings.device, other_devices(settings.device))
    full = tuple(int(n) for n in scene.resolution)
    return Job(sized(scene, size or reduced(full)), path.stem, full, replace(settings, device=first), folder,
               devices=others, **options)


def sized(scene: Scene, size: tuple[int, int]) -> Scene:
    return scene if tuple(scene.resolution) == size else resized(scene, size)


def other_devices(first: str) -> tuple[str, ...]:
    return tuple(device.id for device in list_devices() if device.usable and device.id != first)


def run_trade(job: Job, console: Console) -> dict:
    """Make the report and show how far it is. Ctrl-C ends it in good order; a second one at once."""
    with stopped_by_signals() as stop, shown(console) as show:
        return make_report(job, show, lambda: stop[0])


def check_partial(result: dict) -> None:
    if result["partial"]:
        raise Interrupted(f"{result['page']} is of what was done; the same command goes on")


@contextmanager
def stopped_by_signals() -> Iterator[list[bool]]:
    stop = [False]

    def ask(number, frame):
        if stop[0]:
            raise KeyboardInterrupt
        stop[0] = True

    before = {number: signal.signal(number, ask) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def shown(console: Console):
    """A function that shows a Status: a bar on a terminal, else a line now and then."""
    if not console.is_terminal:
        last = -LINE_SECONDS

        def say(status: Status) -> None:
            nonlocal last
            if time.perf_counter() - last > LINE_SECONDS:
                last = time.perf_counter()
                console.print(f"{status.spent:.0f} of {status.seconds:.0f} s: {status.doing}", markup=False)

        yield say
        return
    bar = Progress(BarColumn(), TimeRemainingColumn(), TextColumn("{task.description}", markup=False), console=console,
                   transient=True)
    with bar:
        task = bar.add_task("preparing", total=None)
        yield lambda status: bar.update(task, completed=status.spent, total=status.seconds, description=status.doing)


def print_report(result: dict) -> None:
    """The report in a few lines."""
    for choice in result["choices"][1:]:  # behind the user's own
        click.echo(f"{choice['verdict']:<6} {choice['sentence']}")
    for entry in result["recommended"]:
        click.echo(f"{entry['wanted']:<12} {entry['label'] or 'out of reach'}")
    click.echo(f"page   {result['page']}")
