"""What benches share: rows of JSON, rounds in turn, and what the machine is."""

from __future__ import annotations

import datetime
import json
import os
import platform
import statistics
import subprocess
import time
from collections.abc import Callable, Iterable
from importlib import metadata
from pathlib import Path

from isophote.device import list_kind
from isophote.openmp import processor_name

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("bpy", "numpy", "pyopencl", "embreex", "OpenImageIO")


def print_row(row: dict) -> None:
    """One row of JSON on stdout, at once: what follows may take long."""
    print(json.dumps(row), flush=True)


def seconds_of(work: Callable[[], object]) -> float:
    started = time.perf_counter()
    work()
    return time.perf_counter() - started


def in_turn(works: dict[str, Callable[[], float]], rounds: int) -> dict[str, list[float]]:
    """What each work returns, `rounds` times: a, b, c, a, b, c, ..., so that a change of the load meets all."""
    found: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(rounds):
        for name, work in works.items():
            found[name].append(work())
    return found


def medians(found: dict[str, Iterable[float]], digits: int = 4) -> dict[str, float]:
    return {name: round(statistics.median(values), digits) for name, values in found.items()}


def machine() -> dict:
    """The processor, its threads, the memory in GiB and the OpenCL devices, as they name themselves."""
    try:
        memory = round(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30, 1)
    except (AttributeError, OSError, ValueError):
        memory = None
    return {
        "processor": processor_name(),
        "threads": os.cpu_count(),
        "memory_gib": memory,
        "system": f"{platform.system()}, {platform.machine()}",
        "opencl": [f"{info.name} ({info.driver})" for info in list_kind("opencl") if info.usable],
    }


def versions() -> dict:
    """Python, the compiler of the native module, and of each of PACKAGES that is installed, its version."""
    from isophote import _native

    found = {"python": platform.python_version(), "native module": _native.compiler}
    for name in PACKAGES:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return found


def commit() -> str:
    """The commit that is checked out, with a + where the tree has changes, or "" without git."""
    try:
        asked = {"cwd": ROOT, "capture_output": True, "text": True, "check": True}
        name = subprocess.run(["git", "rev-parse", "--short=10", "HEAD"], **asked).stdout.strip()
        changed = subprocess.run(["git", "status", "--porcelain", "--untracked-files=no"], **asked).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""
    return name + ("+" if changed else "")


def today() -> str:
    return datetime.date.today().isoformat()
