"""Samples a second with 1, 2, 4, ... threads, beside as many processes that share nothing.

    python -m bench.scaling SCENE.npz ... [--threads 1,2,16] [--rounds 3] [--seconds 0.4] [--side 288]

For each number of threads n: one process renders the middle of the picture with n threads (`ours`), and n processes,
each with one thread that stays on a processor of its own, render the same at the same time (`control`, their rates
together). A process repeats the item until `seconds` have passed. Both have the same n processors, first one of each
core, and both were forked from the one that prepared the scene, which therefore lies in memory once. All have the
same batches of 16 samples a pixel; an item of the control has half the side. Everything is measured once in each
round.

`scaling` is the rate over that of one thread, `efficiency` our scaling over the control's: what is lost in waiting for
each other. What the control itself lacks the machine does not give: threads that share a core, a clock that falls,
memory, neighbours. Medians over rounds. Linux only: it needs fork and affinities.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import re
import statistics
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from bench.common import in_turn, print_row
from isophote.device import open_device
from isophote.openmp import processor_name
from isophote.prepare import prepare
from isophote.records import numbers
from isophote.scene import load_scene
from isophote.schedule import WorkItem
from isophote.settings import Settings
from isophote.validate import clean

SAMPLES = 16
TOPOLOGY = "/sys/devices/system/cpu/cpu{}/topology/thread_siblings_list"


def siblings(cpu: int) -> str:
    """The processors of a core as the system names them, "" where it does not say."""
    try:
        return Path(TOPOLOGY.format(cpu)).read_text().strip()
    except OSError:
        return ""


def cores_first(cpus: list[int], core_of: Callable[[int], str]) -> list[int]:
    """One processor of each core, then the second of each, and so on."""
    seen: dict[str, int] = {}
    turn = {}
    for cpu in cpus:
        core = core_of(cpu) or str(cpu)
        turn[cpu] = seen[core] = seen.get(core, -1) + 1
    return sorted(cpus, key=lambda cpu: (turn[cpu], cpu))


def doublings(most: int) -> list[int]:
    """1, 2, 4, ... and `most`."""
    return sorted({1 << k for k in range(most.bit_length())} | {most})


def megahertz(cpus: list[int]) -> float | None:
    """The processors' clock now as the system tells it; a virtual machine's is its nominal one."""
    try:
        found = dict(re.findall(r"^processor\s*: (\d+)$.*?^cpu MHz\s*: ([\d.]+)$", Path("/proc/cpuinfo").read_text(),
                                re.MULTILINE | re.DOTALL))
    except OSError:
        return None
    return round(statistics.median(float(found[str(cpu)]) for cpu in cpus)) if found else None


def middle(resolution: tuple[int, int], side: int) -> tuple[int, int, int, int]:
    """A square in the middle of the picture, or as much of it as there is."""
    width, height = resolution
    x, y = max(0, (width - side) // 2), max(0, (height - side) // 2)
    return x, y, min(width, x + side), min(height, y + side)


def serve(pipe, prepared, settings: Settings, cpus: list[int], side: int, seconds: float) -> None:
    """Renders on `cpus` each time the pipe asks, until it says False: answers with samples a second."""
    os.sched_setaffinity(0, cpus)
    device = open_device("openmp", settings)
    device.upload(prepared)

    def render(region) -> int:
        x0, y0, x1, y1 = region
        sums = np.zeros((numbers()["PLANES_COMBINED"], y1 - y0, x1 - x0), np.float32)
        device.render(WorkItem(region, 0, SAMPLES), settings, sums, lambda: False)
        return (x1 - x0) * (y1 - y0) * SAMPLES

    render(middle(prepared.resolution, 64))
    pipe.send(True)
    while pipe.recv():
        started, done = time.perf_counter(), 0
        while time.perf_counter() - started < seconds:
            done += render(middle(prepared.resolution, side))
        pipe.send(done / (time.perf_counter() - started))


class Workers:
    """Processes that render at the same time."""

    def __init__(self, prepared, options, cpu_sets: list[list[int]], side: int):
        limits = {f"{kind}_bounces": options.bounces for kind in ("max", "diffuse", "glossy", "transmission")}
        self.cpus = [cpu for cpus in cpu_sets for cpu in cpus]
        self.pipes, self.processes, self.clocks = [], [], []
        context = multiprocessing.get_context("fork")
        for cpus in cpu_sets:
            pipe, other = context.Pipe()
            settings = Settings(device="openmp", precision="strict", threads=len(cpus), **limits)
            process = context.Process(target=serve, args=(other, prepared, settings, cpus, side, options.seconds))
            process.start()
            other.close()
            self.pipes.append(pipe)
            self.processes.append(process)
        for pipe in self.pipes:
            pipe.recv()

    def rate(self) -> float:
        """Million samples a second of all together."""
        for pipe in self.pipes:
            pipe.send(True)
        time.sleep(0.1)
        self.clocks.append(megahertz(self.cpus))
        return sum(pipe.recv() for pipe in self.pipes) / 1e6

    def close(self) -> None:
        for pipe, process in zip(self.pipes, self.processes, strict=True):
            pipe.send(False)
            process.join()


def measure(prepared, options, cpus: list[int]) -> list[dict]:
    """A row for each number of threads."""
    teams = {}
    for n in options.threads:
        teams[f"ours {n}"] = Workers(prepared, options, [cpus[:n]], options.side)
        teams[f"control {n}"] = Workers(prepared, options, [[cpu] for cpu in cpus[:n]], options.side // 2)
    found = in_turn({name: team.rate for name, team in teams.items()}, options.rounds)
    for team in teams.values():
        team.close()
    rows, one = [], options.threads[0]
    for n in options.threads:
        ours, control = ([b / a for a, b in zip(found[f"{kind} {one}"], found[f"{kind} {n}"], strict=True)]
                         for kind in ("ours", "control"))
        efficiency = [a / b for a, b in zip(ours, control, strict=True)]
        rows.append({
            "threads": n, "msamples_per_second": round(statistics.median(found[f"ours {n}"]), 3),
            "control_msamples_per_second": round(statistics.median(found[f"control {n}"]), 3),
            "scaling": round(statistics.median(ours), 2), "control_scaling": round(statistics.median(control), 2),
            "efficiency": round(statistics.median(efficiency), 3), "efficiency_min": round(min(efficiency), 3),
            "efficiency_max": round(max(efficiency), 3), "mhz": teams[f"ours {n}"].clocks[-1],
            "control_mhz": teams[f"control {n}"].clocks[-1]})
    return rows


def main() -> None:
    if not hasattr(os, "sched_setaffinity"):
        raise SystemExit("bench.scaling: this system does not let a process choose its processors; Linux does")
    cpus = cores_first(sorted(os.sched_getaffinity(0)), siblings)
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="+", type=Path)
    parser.add_argument("--threads", type=lambda text: sorted({1, *map(int, text.split(","))}),
                        default=doublings(len(cpus)), help="numbers with commas; one thread is always measured")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=0.4, help="of each measurement, at least")
    parser.add_argument("--side", type=int, default=288, help="of the square that is rendered, pixels")
    parser.add_argument("--bounces", type=int, default=8, help="limit of every kind")
    options = parser.parse_args()
    if not 1 <= options.threads[0] <= options.threads[-1] <= len(cpus):
        parser.error(f"--threads from 1 to {len(cpus)}, the processors that there are")
    cores = len({siblings(cpu) or str(cpu) for cpu in cpus})
    # A team that has done its work must not wait for more on processors that the next one needs.
    os.environ["OMP_WAIT_POLICY"] = "passive"
    for path in options.scenes:
        prepared = prepare(clean(load_scene(path))[0])
        prepared.geometry.wide_tree  # noqa: B018 - made here, before processes are forked
        for row in measure(prepared, options, cpus):
            print_row({"scene": path.stem, **row, "processor": processor_name(), "processors": len(cpus),
                       "threads_per_core": len(cpus) / cores})


if __name__ == "__main__":
    main()
