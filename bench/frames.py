"""Seconds from a scene to its first sample when only the camera moved, with what a frame leaves for the next.

    python -m bench.frames SCENE.npz ... [--devices openmp,opencl:0] [--size 720x720] [--frames 4] [--rounds 3]

Each round renders an animation of `frames` frames, one sample a pixel, in three ways in turn: "nothing" is kept from
frame to frame, the "geometry", or the "device" with its kernels and scene, too. The medians of all frames but the first
are printed as rows of JSON: `upload` is the device's, `prepare` all else until there is a session, `sample` that of the
whole picture. Kernels come from the cache. Needs no Blender.
"""

from __future__ import annotations

import argparse
import time
from collections import defaultdict
from dataclasses import replace
from pathlib import Path

import numpy as np

from bench.common import medians, print_row, seconds_of
from isophote.device import Device, open_device
from isophote.geometry import Geometry
from isophote.scene import Scene, load_scene
from isophote.session import Session
from isophote.settings import Settings

WAYS = ("nothing", "geometry", "device")


class Timed:
    """A device whose uploads are timed."""

    def __init__(self, device: Device):
        self.device, self.upload_seconds = device, 0.0

    def __getattr__(self, name: str):
        return getattr(self.device, name)

    def upload(self, prepared) -> None:
        self.upload_seconds = seconds_of(lambda: self.device.upload(prepared))


def frame_of(scene: Scene, number: int, size: tuple[int, int]) -> Scene:
    """The scene with the camera moved by `number` steps, which is all that differs."""
    camera = scene.camera_to_world.copy()
    camera[:, 3] += 0.001 * number * camera[:, 0]
    return replace(scene, arrays=scene.arrays | {"camera_to_world": camera,
                                                 "resolution": np.array(size, scene.resolution.dtype)})


def animation(scene: Scene, settings: Settings, size: tuple[int, int], frames: int, way: str) -> list[dict]:
    """Seconds of each frame but the first."""
    geometry: Geometry | None = None
    device: Device | None = None
    rows = []
    for number in range(frames):
        started = time.perf_counter()
        timed = Timed(device if device and device.take_up(settings) else open_device(settings.device, settings))
        session = Session(frame_of(scene, number, size), settings, timed, kept=geometry)
        before, upload = time.perf_counter() - started, timed.upload_seconds
        sample = seconds_of(session.step)
        if number:
            rows.append({"prepare": before - upload, "upload": upload, "sample": sample, "total": before + sample})
        geometry = session.prepared.geometry if way != "nothing" else None
        device = session.leave() if way == "device" else session.close()
    if device:
        device.close()
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(prog="bench.frames", description=__doc__.partition("\n")[0])
    parser.add_argument("scenes", nargs="+", type=Path)
    parser.add_argument("--devices", default="openmp,opencl:0")
    parser.add_argument("--size", default="720x720")
    parser.add_argument("--frames", type=int, default=4)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    size = tuple(int(n) for n in options.size.split("x"))
    for path in options.scenes:
        scene = load_scene(path)
        for spec in options.devices.split(","):
            settings = Settings(device=spec, samples=1, passes=("combined",), wait_for_kernels=True)
            animation(scene, settings, size, 1, "nothing")  # fills the cache of kernels
            found = {way: defaultdict(list) for way in WAYS}
            for _ in range(options.rounds):
                for way in WAYS:
                    for row in animation(scene, settings, size, options.frames, way):
                        for name, seconds in row.items():
                            found[way][name].append(seconds)
            for way in WAYS:
                print_row({"scene": path.stem, "device": spec, "kept": way, "size": size, **medians(found[way])})


if __name__ == "__main__":
    main()
