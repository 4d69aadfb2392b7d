"""The command line: render, ledger, trade, export, info, devices, compare.

Results go to stdout (one JSON object with --json), progress and messages to stderr. Exit status: 0
done, 1 error, 2 wrong usage, 130 interrupted (what was rendered is written and marked as partial).
"""

from __future__ import annotations

import functools
import json
import math
import sys
from pathlib import Path

import click
from rich.console import Console

from isophote.bias import FEWEST_PAIRS, PAIRS, SAMPLES, SIDE
from isophote.blender_process import BlenderError
from isophote.compare import CompareError, compare
from isophote.device import DeviceError, list_devices
from isophote.film import LIMITS, FilmError
from isophote.images import ImageError, check_place, read_image
from isophote.json_values import finite
from isophote.kernel_cache import describe_cache
from isophote.ledger import CLAMPS, ledger_lines
from isophote.ledger_command import Measurement, measure_job
from isophote.memory import readable
from isophote.passes import USUAL
from isophote.render_command import (
    MOST_SAMPLES,
    Interrupted,
    Job,
    checked_settings,
    export_scene_file,
    open_scene,
    render_job,
)
from isophote.scene import FIELDS, SceneError
from isophote.settings import PRECISIONS, Settings
from isophote.trade.command import Duration, check_partial, print_report, run_trade, trade_job
from isophote.trade.pictures import FORMATS
from isophote.trade.runs import TradeError
from isophote.validate import validate

EXPECTED = (BlenderError, CompareError, DeviceError, FilmError, ImageError, SceneError, TradeError)
stderr = Console(stderr=True, highlight=False, soft_wrap=True)
DEFAULTS = Settings()


class Size(click.ParamType):
    """WxH in pixels, as (width, height)."""

    name = "WxH"

    def convert(self, value, param, ctx):
        if isinstance(value, tuple):
            return value
        width, _, height = value.lower().partition("x")
        if not (width.isdecimal() and height.isdecimal() and int(width) and int(height)):
            self.fail(f"{value!r} is no size; write it as 640x480", param, ctx)
        return int(width), int(height)


class Percent(click.ParamType):
    """A share above 0, written 1% or 1, as 0.01."""

    name = "PERCENT"

    def convert(self, value, param, ctx):
        if isinstance(value, float):
            return value
        try:
            share = float(value.strip().removesuffix("%")) / 100.0
        except ValueError:
            share = math.nan
        if not 0.0 < share < math.inf:
            self.fail(f"{value!r} is no share; write it as 1%", param, ctx)
        return share


def reported(command):
    """Turn expected errors into a message on stderr (and {"failed": message} on stdout with --json) and status 1."""

    @functools.wraps(command)
    def wrapper(**options):
        try:
            command(**options)
        except Interrupted as interrupted:
            stderr.print(f"interrupted: {interrupted}", markup=False)
            sys.exit(130)
        except KeyboardInterrupt:
            fail("interrupted before anything was written", options, 130)
        except MemoryError as error:
            fail(f"out of memory: {error}", options, 1)
        except EXPECTED as error:
            fail(str(error), options, 1)

    return wrapper


def fail(message: str, options: dict, status: int):
    if options.get("json"):
        print_json({"failed": message})
    stderr.print(f"isophote: error: {message}", markup=False)
    sys.exit(status)


def print_json(value: dict) -> None:
    click.echo(json.dumps(finite(value), indent=1))


json_option = click.option("--json", is_flag=True, help="Print one JSON object.")
frame_option = click.option("--frame", type=int, help="Frame of the .blend file (default: its current one).")
size_option = click.option("--size", type=Size(), help="Pixels (default: the scene's own).")
blender_option = click.option("--blender", metavar="PROGRAM", help="Blender, or a Python with the bpy wheel.")
device_option = click.option("--device", default=DEFAULTS.device, show_default=True, help="openmp, opencl or opencl:N.")
threads_option = click.option("--threads", type=click.IntRange(min=0), default=DEFAULTS.threads,
                              help="CPU threads (default: all).")
precision_option = click.option("--precision", type=click.Choice(PRECISIONS), default=DEFAULTS.precision,
                                show_default=True)
seed_option = click.option("--seed", type=click.IntRange(min=0, max=2**32 - 1),
                           help="Seed (default: the file's, else 0).")


def bias_options(command):
    """Options of the settings that change the expected picture: bounce limits and clamps."""
    for name in reversed(LIMITS):
        command = click.option(f"--{name.replace('_', '-')}", type=click.IntRange(min=0),
                               help=f"Default: the file's, else {getattr(DEFAULTS, name)}.")(command)
    for name in reversed(CLAMPS):
        command = click.option(f"--{name.replace('_', '-')}", type=click.FloatRange(min=0.0), metavar="BRIGHTNESS",
                               help="Cut brighter light, 0: none (default: the file's, else none).")(command)
    return command


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
def cli():
    """Isophote renders .blend files and exported scenes, and says how accurate the picture is."""


@cli.command()
@click.argument("scene", metavar="FILE", type=click.Path(path_type=Path))
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="Picture, .exr or .png.")
@click.option("--samples", type=click.IntRange(min=1),
              help=f"Samples a pixel (default: the file's, else {DEFAULTS.samples}; no limit with --time alone, "
                   f"{MOST_SAMPLES} with --error).")
@click.option("--time", "time_limit", type=click.FloatRange(min=0, min_open=True), metavar="S",
              help="Stop after this many seconds of rendering.")
@click.option("--error", "error_target", type=Percent(), metavar="E%",
              help="Stop when 95 % of the pixels are within this of their brightness (docs/error.md).")
@click.option("--adaptive/--uniform", default=None,
              help="With --error: samples go where they are needed (default), or every pixel gets as many.")
@device_option
@click.option("--wait-for-kernels", is_flag=True, default=None,
              help="Do not let the CPU render while an OpenCL device compiles its kernels.")
@threads_option
@precision_option
@seed_option
@bias_options
@click.option("--passes", help=f"Comma-separated, or all (default: {','.join(USUAL)} for .exr, combined for .png).")
@click.option("--explain", is_flag=True, help="Say what the kernels were compiled for and what memory was used.")
@frame_option
@size_option
@blender_option
@json_option
@reported
def render(scene, output, frame, size, blender, explain, json, **options):
    """Render FILE, a .blend or an exported .npz, with the file's own settings where no option is given."""
    job = Job(scene, output, *checked_settings(output, **options), frame, size, blender)
    result = render_job(job, stderr)
    if json:
        print_json(result)
    else:
        print_result(result)
        if explain:
            print_explanation(result)
    if result["partial"]:
        raise Interrupted(f"{output} holds the {result['samples']} samples that were done and is marked as partial")


STOPPED = {"samples": "all samples are done", "time": "the time is over", "error": "the wanted error is reached",
           "cancelled": "cancelled"}


def print_result(result: dict) -> None:
    error = "unknown" if result["error"] is None else f"{100 * result['error']:.2f} % of the mean brightness"
    click.echo(f"picture    {result['output']}{' (partial)' if result['partial'] else ''}")
    click.echo(f"device     {result['device']} ({result['driver']})")
    if len(result["samples_by_device"]) > 1:
        drawn = ", ".join(f"{count} by {name}" for name, count in result["samples_by_device"].items())
        click.echo(f"drawn      {drawn}")
    click.echo(f"samples    {result['samples']} a pixel, {result['samples_per_second'] / 1e6:.3f} million a second, "
               f"{result['render_seconds']:.2f} s")
    click.echo(f"error      {error}")
    if result["error_95"] is not None:
        target = f" (wanted: {100 * result['error_target']:g} %)" if result["error_target"] else ""
        click.echo(f"pixels     95 % are within {100 * result['error_95']:.2f} % of their brightness{target}")
    if result["unsure"]:
        click.echo(f"unsure     {100 * result['unsure']:.1f} % of the picture, where light came in too few bright hits")
    click.echo(f"stopped    {STOPPED[result['why_stopped']]}")
    for sentence in ledger_lines([one for one in result["ledger"] if one["switch"] != "left_out"]):
        click.echo(f"ledger     {sentence}")
    for note in result["notes"]:
        click.echo(f"note       {note['name']}: {note['what']}")


def print_explanation(result: dict) -> None:
    """What of the scene decides the work: the JSON holds the same."""
    for label, used in (("used", True), ("left out", False)):
        names = [name.replace("_", " ") for name, is_used in result["features"].items() if is_used is used]
        click.echo(f"{label:<10} {', '.join(names) or 'nothing'}")
    if result["kernels_from"]:
        click.echo(f"kernels    from the {result['kernels_from']} in {result['compile_seconds']:.2f} s")
    for sentence in ledger_lines(result["ledger"], all_entries=True):
        click.echo(f"ledger     {sentence}")
    click.echo(f"memory     {', '.join(f'{name} {readable(size)}' for name, size in result['memory'].items())}")


@cli.command()
@click.argument("scene", metavar="FILE", type=click.Path(path_type=Path))
@click.option("--samples", type=click.IntRange(min=1), default=SAMPLES, show_default=True, help="A pixel and render.")
@click.option("--pairs", type=click.IntRange(min=FEWEST_PAIRS), default=PAIRS, show_default=True,
              help="Renders with seeds of their own, as set and without each setting.")
@device_option
@threads_option
@precision_option
@seed_option
@bias_options
@frame_option
@click.option("--size", type=Size(), help=f"Pixels (default: at most {SIDE} a side).")
@blender_option
@json_option
@reported
def ledger(scene, pairs, frame, size, blender, json, **options):
    """Measure what the settings of FILE take from its picture: clamps, bounce limits, fast precision.

    Pairs of renders with the same random numbers, as set and without each setting (docs/error.md).
    """
    given = {name: value for name, value in options.items() if value is not None}
    try:
        settings = Settings(**given)
    except ValueError as error:
        raise click.UsageError(str(error)) from None
    result = measure_job(Measurement(scene, settings, frozenset(given), pairs, frame, size, blender), stderr)
    if json:
        print_json(result)
        return
    click.echo(f"measured   {result['pairs']} pairs of {result['width']} x {result['height']} pixels, "
               f"{result['samples']} samples each, {result['precision']}")
    for sentence in ledger_lines(result["ledger"], all_entries=True):
        click.echo(f"ledger     {sentence}")


@cli.command()
@click.argument("scene", metavar="FILE", type=click.Path(path_type=Path))
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="Folder for the report.")
@click.option("--time", "seconds", type=Duration(), default="10m", show_default=True, help="Time in all: 90s, 10m, 1h.")
@click.option("--device", "devices", multiple=True,
              help="The device to render with; more of them are compared (default: openmp, with all that there are).")
@click.option("--pictures", type=click.Choice(FORMATS), default="png", show_default=True, help="Their format.")
@click.option("--anew", is_flag=True, help="Begin again where the folder holds a report of another scene or settings.")
@frame_option
@click.option("--size", type=Size(), help="Pixels (default: the scene's own, at most 256 on the longer side).")
@blender_option
@json_option
@reported
def trade(scene, output, frame, size, blender, json, **options):
    """Measure for FILE what each setting buys and costs, and write a report to look at (docs/trade.md).

    Ctrl-C writes the report of what is done; the same command goes on.
    """
    job = trade_job(scene, output, size, frame, blender, console=stderr, **options)
    result = run_trade(job, stderr)
    if json:
        print_json(result)
    else:
        print_report(result)
    check_partial(result)


@cli.command()
@click.argument("blend", metavar="FILE.blend", type=click.Path(path_type=Path))
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="Scene file, .npz.")
@frame_option
@size_option
@blender_option
@json_option
@reported
def export(blend, output, frame, size, blender, json):
    """Export a frame of a .blend file to a scene file that renders without Blender."""
    if output.suffix != ".npz":
        raise click.UsageError(f"{output}: scene files end in .npz")
    check_place(output)
    report = export_scene_file(blend, output, frame, size, blender, stderr)
    if json:
        print_json({"output": str(output), **report})
    else:
        click.echo(f"{output}: {report.get('triangles')} triangles, {report.get('instances')} instances, "
                   f"{report.get('notes')} notes")


@cli.command()
@click.argument("scene", type=click.Path(path_type=Path))
@frame_option
@blender_option
@json_option
@reported
def info(scene, frame, blender, json):
    """Say what is in a scene: sizes, materials, lights, problems and what was left out."""
    loaded, _ = open_scene(scene, frame, None, blender, stderr)
    width, height = (int(n) for n in loaded.resolution)
    result = {
        "file": str(scene),
        "scene_hash": loaded.content_hash,
        "resolution": [width, height],
        "vertices": len(loaded.vertices),
        "triangles": len(loaded.triangles),
        "meshes": len(loaded.mesh_normals),
        "instances": len(loaded.instance_mesh),
        "spheres": len(loaded.sphere_radius),
        "materials": len(loaded.material_first) - 1,
        "lights": len(loaded.light_kind),
        "bytes": sum(loaded.arrays[name].nbytes for name in FIELDS),
        "names": loaded.names,
        "problems": [{"severity": p.severity, "thing": p.thing, "what": p.what} for p in validate(loaded)],
        "notes": loaded.notes,
    }
    if json:
        print_json(result)
        return
    for key, value in result.items():
        if key == "names":
            continue
        if key in ("problems", "notes"):
            for entry in value:
                label = entry.get("severity", "note")
                click.echo(f"{label:<10} {entry.get('thing') or entry.get('name')}: {entry['what']}")
        else:
            click.echo(f"{key:<10} {' x '.join(map(str, value)) if isinstance(value, list) else value}")


@cli.command()
@json_option
@reported
def devices(json):
    """List every device with its driver, and where one cannot be used, why; and where built kernels are kept."""
    found, cache = list_devices(), describe_cache()
    if json:
        print_json({"devices": [vars(device) for device in found], "kernel_cache": cache})
        return
    for device in found:
        if device.usable:
            strict = "strict" if device.strict is True else f"not strict: {device.strict}"
            click.echo(f"{device.id:<10} {device.name} ({device.driver}), {strict}")
        else:
            click.echo(f"{device.id:<10} {device.name} cannot be used: {device.why_not}")
    if cache["folder"]:
        size, limit = (f"{cache[name] / 1e6:.1f} MB" for name in ("bytes", "limit"))
        click.echo(f"kernels    kept in {cache['folder']}: {cache['entries']} entries, {size} of at most {limit}")
    else:
        click.echo("kernels    not kept")


@cli.command(name="compare")
@click.argument("a", type=click.Path(path_type=Path))
@click.argument("b", type=click.Path(path_type=Path))
@json_option
@reported
def compare_command(a, b, json):
    """Measure how far picture A is from picture B (the reference)."""
    result = compare(read_image(a), read_image(b))
    if json:
        print_json(result)
        return
    for key, value in result.items():
        for line in value if key == "notes" else [value]:
            click.echo(f"{key:<17} {line}")


def main() -> None:
    """The entry point `isophote`."""
    cli(prog_name="isophote")
