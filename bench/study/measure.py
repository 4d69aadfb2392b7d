"""Timing cases side by side: all of a group are opened and warmed up, then timed in turn, round after round."""

from __future__ import annotations

import json
import statistics
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import asdict, dataclass, replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from bench.study.device import StudyDevice
from bench.study.scenes import prepared_scene
from bench.study.trees import as_list
from bench.study.variant import Variant
from isophote.device import DeviceError
from isophote.openmp import OpenMPDevice
from isophote.records import numbers
from isophote.schedule import BLOCK, WorkItem
from isophote.settings import Settings

ROUNDS, SECONDS_PER_CASE = 5, 1.5  # a group is timed so often, or twice where that takes longer


@dataclass(frozen=True)
class Case:
    """One thing to time. `samples` 0: as many as take about the time that a round shall last."""

    label: str
    scene: str
    device: str = "opencl"
    variant: Variant = Variant()
    size: int = 512  # pixels a side
    samples: int = 0
    bounces: int = 8
    threads: int = 0  # openmp; 0: all
    over: str = "pixels"  # what OpenMP's threads share: pixels (dynamic) or samples (static)
    profile: bool = False  # also the time of each kernel, launch by launch
    x: float = 0  # the sweep's value

    @property
    def key(self) -> str:
        return json.dumps(asdict(self), sort_keys=True)


class Run:
    """A case, opened: `once` renders its samples and returns the seconds."""

    def __init__(self, case: Case, folder: Path, spec: str, target: float):
        limits = {f"{kind}_bounces": case.bounces for kind in ("max", "diffuse", "glossy", "transmission")}
        self.case, self.settings = case, Settings(threads=case.threads, passes=("combined",), **limits)
        prepared = prepared_scene(folder, case.scene, case.size, case.variant.leaf > 0)
        self.triangles, self.resolution = len(prepared.buffers["triangles"]), prepared.resolution
        if case.device == "openmp":
            settings = replace(self.settings, precision=case.variant.precision)
            self.devices = [OpenMPDevice(replace(settings, threads=1) if case.over == "samples" else settings)
                            for _ in range(case.threads if case.over == "samples" else 1)]
            prepared = as_list(prepared) if case.variant.traversal == "list" else prepared
        else:
            self.devices = [StudyDevice(self.settings, case.variant, spec)]
        for device in self.devices:
            device.upload(prepared)
        self.samples = case.samples or self.fitting_samples(target)
        if case.samples:
            self.once()

    def fitting_samples(self, target: float) -> int:
        """A power of two of samples, at most a block, that takes about `target` seconds."""
        samples = 1
        while True:
            self.samples = samples
            self.once()  # the first call compiles on some drivers
            seconds = self.once()
            if seconds > target / 2 or samples >= BLOCK:
                return samples
            samples = min(BLOCK, samples * max(2, 1 << int(np.log2(target / seconds))))

    def once(self) -> float:
        started = time.perf_counter()
        shares = [self.blocks()[k::len(self.devices)] for k in range(len(self.devices))]
        if len(self.devices) == 1:
            self.expose(self.devices[0], shares[0])
        else:
            with ThreadPoolExecutor(len(self.devices)) as pool:
                films = list(pool.map(self.expose, self.devices, shares))
            np.sum(films, axis=0, dtype=np.float64)  # the merge belongs to it
        return time.perf_counter() - started

    def blocks(self) -> list[tuple[int, int]]:
        return [(first, min(BLOCK, self.samples - first)) for first in range(0, self.samples, BLOCK)]

    def expose(self, device, blocks) -> np.ndarray:
        width, height = self.resolution
        sums = np.zeros((numbers()["PLANES_COMBINED"], height, width), np.float32)
        for first, count in blocks:
            added = device.render(WorkItem((0, 0, width, height), first, count), self.settings, sums, lambda: False)
            if added != count:
                raise DeviceError(f"{device.name} gave {added} of {count} samples")
        return sums

    def row(self, seconds: list[float]) -> dict:
        width, height = self.resolution
        median = statistics.median(seconds)
        made = {"name": self.devices[0].name, "driver": self.devices[0].driver, "triangles": self.triangles,
                "width": width, "height": height, "samples_made": self.samples,
                "compile_seconds": round(self.devices[0].compile_seconds, 2),
                "seconds": [round(s, 6) for s in seconds], "median": round(median, 6),
                "msamples_per_second": round(width * height * self.samples / median / 1e6, 5)}
        if self.case.profile:
            device = self.devices[0]
            device.start_profile()
            self.once()
            device.start_counting()
            self.once()
            made["kernel_seconds"] = {name: [round(s, 9) for s in spent]
                                      for name, spent in device.kernel_seconds.items()}
            made["alive"] = device.alive.tolist()
        return made

    def close(self) -> None:
        for device in self.devices:
            device.close()


def measure_group(cases: list[Case], folder: Path, spec: str, target: float, until: float):
    """Yields (case, row) for each case of a group; a case that cannot be run is yielded with its reason."""
    runs = []
    try:
        for case in cases:
            try:
                runs.append(Run(case, folder, spec, target))
            except (DeviceError, ValueError) as error:
                yield case, {"failed": str(error)}
        seconds: dict[int, list[float]] = {k: [] for k in range(len(runs))}
        enough = time.perf_counter() + SECONDS_PER_CASE * len(runs)
        for done in range(ROUNDS):
            for k, run in enumerate(runs):
                seconds[k].append(run.once())
            if time.perf_counter() > min(until, enough) and done > 0:
                break
        for k, run in enumerate(runs):
            yield run.case, run.row(seconds[k])
    finally:
        for run in runs:
            run.close()


class Rows:
    """The rows of an experiment in a file of JSON lines; what is there is not measured again."""

    def __init__(self, path: Path):
        self.path = path
        self.known = {row["key"] for row in self.read()} if path.is_file() else set()

    def read(self) -> list[dict]:
        return [json.loads(line) for line in self.path.read_text().splitlines()]

    def add(self, case: Case, row: dict) -> None:
        with self.path.open("a") as file:
            file.write(json.dumps({"key": case.key, **asdict(case), **row}) + "\n")
        self.known.add(case.key)
        what = row.get("failed") or f"{row['msamples_per_second']:.3f} M samples/s"
        print(f"{self.path.stem}: {case.scene} {case.label} {case.x:g}: {what}", file=sys.stderr, flush=True)


def compile_case(case: Case, folder: Path, spec: str) -> None:
    """Compile a case's kernels, for a driver that keeps them on disk; what fails will say so when it is measured."""
    device = StudyDevice(Settings(), case.variant, spec=spec)
    try:
        device.upload(prepared_scene(folder, case.scene, 64, case.variant.leaf > 0))
    except (DeviceError, ValueError):
        pass
    finally:
        device.close()


def compile_all(cases: list[Case], folder: Path, spec: str, jobs: int) -> None:
    """Compile the kernels of all cases in processes of their own: one after the other they take minutes."""
    wanted = {(case.scene, case.variant): case for case in cases if case.device == "opencl"}
    started = time.perf_counter()
    with ProcessPoolExecutor(jobs, get_context("spawn")) as pool:
        list(pool.map(partial(compile_case, folder=folder, spec=spec), wanted.values()))
    print(f"compiled {len(wanted)} variants in {time.perf_counter() - started:.1f} s", file=sys.stderr, flush=True)


def run_experiment(name: str, groups: list[list[Case]], folder: Path, out: Path, spec: str, target: float,
                   budget: float) -> None:
    """Measure the groups of an experiment that have no rows yet, until its time is spent."""
    rows, until = Rows(out / f"{name}.jsonl"), time.perf_counter() + budget
    for group in groups:
        left = [case for case in group if case.key not in rows.known]
        if not left:
            continue
        if time.perf_counter() > until:
            print(f"{name}: its {budget:g} s are spent; run it again to go on", file=sys.stderr)
            return
        for case, row in measure_group(left, folder, spec, target, until):
            rows.add(case, row)
