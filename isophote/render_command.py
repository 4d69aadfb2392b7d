"""What `isophote render` does, in order: check the output, get the scene, render, write the picture."""

from __future__ import annotations

import signal
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import click
from rich.console import Console
from rich.progress import BarColumn, TextColumn
from rich.progress import Progress as ProgressBar

from isophote.blender_process import export_blend
from isophote.device import DeviceError, open_device
from isophote.images import LAYER, ImageError, check_writable, write_image
from isophote.ledger import ledger_lines
from isophote.passes import PASSES, USUAL, check_passes, make_named, make_passes, with_catchers
from isophote.scene import Scene, SceneError, load_scene, resized
from isophote.session import Progress, Session
from isophote.settings import Settings

NO_LIMIT = 1 << 30  # samples, where only the time limits a render
MOST_SAMPLES = 1 << 16  # where only the error does: one that cannot be reached shall not render for ever
LINE_SECONDS = 10.0  # between lines of progress where stderr is no terminal


class Interrupted(Exception):
    """A render that was interrupted and whose partial picture was written."""


@dataclass(frozen=True)
class Job:
    """One call of `isophote render`; frame and size None stand for the scene's own.

    `settings` are those of the options; where no option was given, the scene file's own stand
    (`given` names the settings that options have set).
    """

    scene: Path
    output: Path
    settings: Settings
    given: frozenset[str]
    frame: int | None = None
    size: tuple[int, int] | None = None
    blender: str | None = None


def checked_settings(output: Path, time_limit: float | None, passes: str | None,
                     **options) -> tuple[Settings, frozenset[str]]:
    """Settings from the command line's options, and which of them were given. Raises click.UsageError."""
    options = {name: value for name, value in options.items() if value is not None}
    if options.get("error_target"):
        options = {"samples": MOST_SAMPLES, **options}
    if time_limit:
        options = {"samples": NO_LIMIT, "time_limit": time_limit, **options}
    if passes is None:
        passes = "combined" if output.suffix.lower() == ".png" else ",".join(USUAL)
    try:
        names = check_passes(PASSES if passes == "all" else passes.split(","))
        return Settings(passes=names, **options), frozenset(options)
    except ValueError as error:
        raise click.UsageError(str(error)) from None


def with_file_settings(job: Job, scene: Scene) -> Job:
    """The job with the scene file's settings where no option was given, and what the scene itself asks for.

    Raises SceneError for values that cannot be.
    """
    wanted = {name: value for name, value in scene.settings.items() if name not in job.given}
    if "samples" in job.given:  # asking for samples, a time or an error lifts the file's other limits
        wanted.pop("time_limit", None)
        wanted.pop("error_target", None)
    try:
        return replace(job, settings=with_catchers(replace(job.settings, **wanted), scene))
    except (TypeError, ValueError) as error:
        raise SceneError(f"{job.scene}: its settings cannot be used: {error}") from None


def export_scene_file(blend: Path, out: Path, frame, size, blender, console: Console) -> dict:
    """export_blend with a line of progress. Raises BlenderError."""
    with console.status(f"exporting {blend} ..."):
        return export_blend(blend, out, frame, size, blender)


def open_scene(path: Path, frame, size, blender, console: Console) -> tuple[Scene, float]:
    """The scene in a .blend or .npz file, and the seconds that it took. Raises SceneError, BlenderError."""
    started = time.perf_counter()
    suffix = path.suffix.lower()
    if suffix == ".blend":
        with tempfile.TemporaryDirectory(prefix="isophote_") as folder:
            exported = Path(folder) / "scene.npz"
            export_scene_file(path, exported, frame, size, blender, console)
            scene = load_scene(exported)
    elif suffix == ".npz":
        if frame is not None:
            raise click.UsageError(f"{path}: a scene file holds one frame; --frame is for .blend files")
        scene = load_scene(path)
        scene = resized(scene, size) if size else scene
    else:
        raise SceneError(f"{path}: neither a .blend nor a .npz file")
    return scene, time.perf_counter() - started


def render_job(job: Job, console: Console) -> dict:
    """Render and write the picture; Session.result() with "output", "partial" and "export_seconds" comes back.

    An interrupt or a failure on the way writes what is there, marked as partial; the failure is then
    raised. KeyboardInterrupt where there was nothing to write yet.
    """
    check_writable(job.output)
    started = time.perf_counter()
    device = open_device(job.settings.device, job.settings)
    opening = time.perf_counter() - started
    scene, export_seconds = open_scene(job.scene, job.frame, job.size, job.blender, console)
    job = with_file_settings(job, scene)
    if job.output.suffix.lower() == ".exr":
        job = replace(job, settings=replace(job.settings, named=scene.named))
    if device.kind != "opencl" or not device.take_up(job.settings):
        device.close()
        device = open_device(job.settings.device, job.settings)  # what the file asks for
    session = Session(scene, job.settings, device)
    del scene  # the session lets go of what it does not render
    with session:
        session.setup_seconds += opening
        try:
            with interrupts(session), progress_shown(console) as show:
                session.run(show)
        except (DeviceError, MemoryError) as error:
            raise type(error)(f"{error}{rescued(job, session)}") from error
        if session.film.samples == 0:
            raise KeyboardInterrupt
        partial = session.why_stopped == "cancelled"
        write_picture(job, session, partial)
        return {"output": str(job.output), "partial": partial, **session.result(), "export_seconds": export_seconds}


def rescued(job: Job, session: Session) -> str:
    """Write what a failed render has; the end of the error's message."""
    if session.film.samples == 0:
        return f"; {job.output} was not written"
    write_picture(job, session, True)
    return f"; {job.output} holds the {session.film.samples} samples that were done and is marked as partial"


def write_picture(job: Job, session: Session, partial: bool) -> None:
    """Write the passes; where that fails after all, into the folder for temporary files. Raises ImageError."""
    film, result = session.film, session.result()
    metadata = {"Software": "Isophote", "isophote:partial": int(partial), "isophote:samples": result["samples"],
                "isophote:most_samples": result["most_samples"],
                "isophote:device": result["device"], "isophote:precision": result["precision"],
                "isophote:seed": result["seed"], "isophote:scene": result["scene_hash"]}
    for name in ("error", "error_95", "error_target", "unsure", "why_stopped"):
        if result[name]:
            metadata[f"isophote:{name}"] = result[name]
    metadata["isophote:ledger"] = "; ".join(ledger_lines(result["ledger"]))
    metadata |= session.matte_metadata(LAYER)
    planes = make_passes(film, job.settings.passes) | make_named(film)
    try:
        write_image(job.output, planes, metadata)
    except ImageError as error:
        spare = Path(tempfile.mkdtemp(prefix="isophote_")) / job.output.name
        write_image(spare, planes, metadata)
        raise ImageError(f"{error}; the picture was written to {spare} instead") from error


@contextmanager
def interrupts(session: Session) -> Iterator[None]:
    """Ctrl-C or SIGTERM cancels the session; a second one interrupts at once."""

    asked = False

    def stop(number, frame):
        nonlocal asked
        if asked:
            raise KeyboardInterrupt
        asked = True
        session.cancel()

    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def progress_shown(console: Console):
    """A function that shows Progress: a bar on a terminal, else a line now and then."""
    if not console.is_terminal:
        last = time.perf_counter()

        def line(progress: Progress) -> None:
            nonlocal last
            if progress.why_stopped or time.perf_counter() - last > LINE_SECONDS:
                last = time.perf_counter()
                console.print(described(progress), markup=False)

        yield line
        return
    bar = ProgressBar(BarColumn(), TextColumn("{task.description}", markup=False), console=console, transient=True)
    with bar:
        task = bar.add_task("preparing", total=None)

        def show(progress: Progress) -> None:
            limited = progress.samples_total < NO_LIMIT and not progress.error_target
            done, total = ((progress.samples_done, progress.samples_total) if limited else
                           (progress.seconds, progress.seconds + (progress.remaining or 0.0)))
            bar.update(task, completed=done, total=total, description=described(progress))

        yield show


def described(progress: Progress) -> str:
    """One line: samples, error, remaining time."""
    limited = progress.samples_total < NO_LIMIT and not progress.error_target
    total = f"/{progress.samples_total}" if limited else ""
    error = "" if progress.error is None else f", error {100 * progress.error:.2f} %"
    if progress.error_target and progress.error_95 is not None:
        error = f", 95 % of pixels within {100 * progress.error_95:.2f} % (wanted {100 * progress.error_target:g} %)"
    remaining = "" if not progress.remaining else f", {progress.remaining:.0f} s left"
    most = f" (at most {progress.most_samples})" if progress.most_samples > progress.samples_done else ""
    return f"{progress.samples_done}{total} samples{most}{error}{remaining}"
