"""Prints the peak bytes a triangle of preparing a wavy sheet and building the CPU's tree, in a process of its own."""

import re

import numpy as np
from noise_device import tiny_scene

from isophote.openmp import OpenMPDevice
from isophote.prepare import prepare
from isophote.settings import Settings

SIDE = 501  # vertices


def status(key: str) -> int:
    """A size from /proc/self/status in bytes."""
    with open("/proc/self/status") as file:
        return int(re.search(key + r":\s+(\d+)", file.read()).group(1)) << 10


def sheet():
    x, y = np.meshgrid(np.linspace(-1, 1, SIDE), np.linspace(-1, 1, SIDE))
    first = (np.arange(SIDE - 1)[:, None] * SIDE + np.arange(SIDE - 1)).ravel()
    triangles = np.concatenate([np.stack([first, first + 1, first + SIDE], 1),
                                np.stack([first + 1, first + SIDE + 1, first + SIDE], 1)])
    return tiny_scene(vertices=np.stack([x, y, np.sin(9 * x) * np.cos(7 * y) - 3], -1).reshape(-1, 3),
                      triangles=triangles, mesh_triangles=[0, len(triangles)])


scene = sheet()
before = status("VmRSS")
with open("/proc/self/clear_refs", "w") as file:
    file.write("5")
device = OpenMPDevice(Settings())
device.upload(prepare(scene))
print((status("VmHWM") - before) / len(scene.triangles))
