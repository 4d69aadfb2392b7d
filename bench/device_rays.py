"""Rays a second of an OpenCL device: closest hits of a path's first, second, ... ray, in rooms of many triangles.

    python -m bench.device_rays [--device opencl:0] [--triangles 280000,1000000,2000000] [--samples 16] [--rounds 3]

The rooms are those of bench.rays, white and lit by nothing, so that every ray but the camera's leaves a surface in a
direction drawn by the cosine. The time is that of the kernel `extend` alone, by the device's own clock: it reads a
path's ray and writes its hit. Prints a row of JSON for each room: billions of rays a second by bounce, and of all
rays after the camera's together ("diffuse"). Needs no Blender.
"""

from __future__ import annotations

import argparse
import statistics
from dataclasses import replace

import numpy as np

from bench.common import print_row
from bench.rays import room
from isophote.device import DeviceError, opencl_info
from isophote.material_program import join_materials, make_material
from isophote.materials import make_instruction
from isophote.opencl import OpenCLDevice
from isophote.prepare import prepare
from isophote.records import numbers
from isophote.scene import Scene
from isophote.schedule import WorkItem
from isophote.settings import Settings
from isophote.validate import clean
from isophote.wavefront import MOST_BOUNCES, Wavefront

BOUNCES = 8


class TimedWavefront(Wavefront):
    """Keeps the time and the number of the rays of each bounce's `extend`."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.extends: list[tuple[int, object]] = []
        self.seconds, self.rays = np.zeros(MOST_BOUNCES), np.zeros(MOST_BOUNCES)

    def launch(self, name: str, count: int, *changing, parity: int = 0, each: int = 1):
        event = super().launch(name, count, *changing, parity=parity, each=each)
        if name == "extend":
            self.extends.append((int(changing[-1]), event))
        return event

    def trace(self, *arguments) -> bool:
        done = super().trace(*arguments)
        lengths = np.zeros(2 * MOST_BOUNCES, np.uint32)
        self.cl.enqueue_copy(self.queue, lengths, self.counts)
        self.rays += lengths[::2]
        for bounce, event in self.extends:
            self.seconds[bounce] += 1e-9 * (event.profile.end - event.profile.start)
        self.extends.clear()
        return done


class TimedDevice(OpenCLDevice):
    """An OpenCL device whose queue notes when kernels begin and end."""

    def __init__(self, settings: Settings, spec: str):
        super().__init__(settings, opencl_info(spec))
        flags = self.cl.command_queue_properties.PROFILING_ENABLE
        self.queue = self.calling(self.cl.CommandQueue, self.context, properties=flags)

    def reserve(self, paths: int) -> None:
        self.wavefront = self.calling(TimedWavefront, self.cl, self.queue, self.built.program,
                                      [*self.scene.values()], paths, self.planes, self.features)


def white_room(triangles: int) -> Scene:
    """The room with a diffuse material of albedo 0.8."""
    scene = room(triangles)
    white = make_material([make_instruction("diffuse", (0.8, 0.8, 0.8))])
    return replace(scene, arrays=scene.arrays | join_materials([white]))


def measure(scene: Scene, spec: str, samples: int, rounds: int) -> dict:
    """The row of one scene."""
    settings = Settings(samples=samples, max_bounces=BOUNCES, diffuse_bounces=BOUNCES, passes=("combined",))
    device = TimedDevice(settings, spec)
    try:
        device.upload(prepare(clean(scene)[0]))
        width, height = (int(n) for n in scene.resolution)
        sums = np.zeros((numbers()["PLANES_COMBINED"], height, width), np.float32)
        rates = []
        for _ in range(1 + rounds):
            device.render(WorkItem((0, 0, width, height), 0, samples), settings, sums, lambda: False)
            rays, seconds = device.wavefront.rays, device.wavefront.seconds
            rates.append([*rays[:4] / seconds[:4] / 1e9, rays[1:].sum() / seconds[1:].sum() / 1e9])
        found = [round(statistics.median(column), 2) for column in zip(*rates[1:], strict=True)]
        return {"name": device.name, "driver": device.driver, "triangles": len(scene.triangles), "samples": samples,
                "grays_per_second": dict(zip(("primary", "bounce 1", "bounce 2", "bounce 3", "diffuse"), found,
                                             strict=True)),
                "rays_per_sample": round(float(rays.sum() / (width * height * samples)), 2)}
    finally:
        device.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--device", default="opencl:0")
    parser.add_argument("--triangles", default="280000,1000000,2000000")
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    for triangles in options.triangles.split(","):
        try:
            print_row(measure(white_room(int(triangles)), options.device, options.samples, options.rounds))
        except DeviceError as error:
            raise SystemExit(f"bench.device_rays: {error}") from None


if __name__ == "__main__":
    main()
