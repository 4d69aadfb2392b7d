"""How much memory there is and how much a scene takes: known before a render begins, not when it fails.

Limits can be lowered for tests and for machines that are shared: ISOPHOTE_HOST_MEMORY,
ISOPHOTE_DEVICE_MEMORY (all of a device) and ISOPHOTE_DEVICE_BUFFER (its largest single buffer), in
bytes or as 512M, 4G.
"""

from __future__ import annotations

import os
import re

from isophote.device import SceneTooLarge

# bench.memory measures the peak of preparing a scene with corner normals; tests/unit/test_memory.py holds it below.
BUILD_BYTES_PER_TRIANGLE = 200
FILM_BYTES_PER_VALUE = 20  # sums in float32, their copy while an item is rendered, totals in float64, the pass
UNITS = {"": 1, "K": 1 << 10, "M": 1 << 20, "G": 1 << 30}
HOST, DEVICE, BUFFER = "ISOPHOTE_HOST_MEMORY", "ISOPHOTE_DEVICE_MEMORY", "ISOPHOTE_DEVICE_BUFFER"


def readable(count: float) -> str:
    """Bytes as a person reads them: 12 bytes, 3.4 KiB, 5.6 MiB, 7.8 GiB."""
    for unit, size in (("GiB", 1 << 30), ("MiB", 1 << 20), ("KiB", 1 << 10)):
        if count >= size:
            return f"{count / size:.1f} {unit}"
    return f"{int(count)} bytes"


def lowered(found: int | None, variable: str) -> int | None:
    """What was found, or less where an environment variable says so. Raises ValueError for one that is no size."""
    text = os.environ.get(variable, "")
    if not text:
        return found
    match = re.fullmatch(r"(\d+)([KMG]?)", text.upper())
    if not match:
        raise ValueError(f"{variable}={text}: a number of bytes, or as 512M or 4G, is needed")
    limit = int(match.group(1)) * UNITS[match.group(2)]
    return limit if found is None else min(found, limit)


def host_available() -> int | None:
    """Bytes that this process may still take on this machine (Linux; a container's limit counts), None if unknown."""
    found = [value for value in (meminfo_available(), container_available()) if value is not None]
    return lowered(min(found, default=None), HOST)


def meminfo_available() -> int | None:
    try:
        with open("/proc/meminfo") as file:
            return next((int(line.split()[1]) << 10 for line in file if line.startswith("MemAvailable:")), None)
    except OSError:
        return None


def container_available(folder: str = "/sys/fs/cgroup") -> int | None:
    """What a version 2 control group leaves, None where it sets no limit."""
    try:
        with open(f"{folder}/memory.max") as limit, open(f"{folder}/memory.current") as used:
            return max(0, int(limit.read()) - int(used.read()))
    except (OSError, ValueError):  # no such group, or "max"
        return None


def check_host_memory(triangles: int, film_values: int) -> None:
    """Raises SceneTooLarge where a scene's trees and its film (planes times pixels) would not fit into this machine."""
    trees, film, available = BUILD_BYTES_PER_TRIANGLE * triangles, FILM_BYTES_PER_VALUE * film_values, host_available()
    if available is not None and trees + film > available:
        raise SceneTooLarge(
            f"the scene needs about {readable(trees + film)} of this machine's memory, of which {readable(available)} "
            f"are free: {trees} bytes to prepare its {triangles} triangles and {film} bytes for the picture, of "
            f"{available} bytes")


def check_device_memory(name: str, parts: dict[str, int], total: int, largest: int) -> None:
    """Raises SceneTooLarge where buffers of these sizes (bytes, by name) do not fit on a device.

    `total` is the device's memory, `largest` what it allows a single buffer.
    """
    needed = sum(parts.values())
    most = max(parts, key=parts.get)
    if needed > total or parts[most] > largest:
        raise SceneTooLarge(
            f"the scene does not fit on {name}: it needs {readable(needed)} ({needed} bytes) of {readable(total)} "
            f"({total} bytes), and its largest buffer, {most}, {readable(parts[most])} ({parts[most]} bytes) of "
            f"{readable(largest)} ({largest} bytes); the CPU (device openmp) may have room for it")
