"""The OpenCL device with a variant's kernels and schedule, for experiments and tests only."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from bench.study.schedules import SCHEDULES
from bench.study.trees import adapt
from bench.study.variant import Variant
from isophote.device import DeviceError, opencl_info
from isophote.opencl import OpenCLDevice, build_options, kernel_source
from isophote.prepare import Prepared
from isophote.records import numbers
from isophote.schedule import WorkItem
from isophote.settings import Settings
from isophote.wavefront import GROUP, shade_group

SOURCE = Path(__file__).parents[2] / "kernels" / "study" / "variants.cl"
# Put behind the elementary functions' definitions: the device's instructions instead of them, as in the report.
AFTER_ELEMENTARY = "FN real sin_real(real x)"
NATIVE = """
#define sin_cos_real(x) ((float2)(native_sin(x), native_cos(x)))
#define exp_real(x) native_exp(x)
#define log_real(x) native_log(x)
"""
# Shared by the devices of a process, so that no variant is compiled twice.
CONTEXTS: dict = {}
PROGRAMS: dict = {}

# Features that no schedule but the shipping one has.
LACKING = ("SUBSURFACE", "SHINES", "VOLUME", "MOTION", "LINKING", "CATCHERS")


class StudyDevice(OpenCLDevice):
    """An OpenCL device that renders as a Variant says. Once `start_profile` is called it keeps the time of each kernel
    in `kernel_seconds`, launch by launch, and, where the schedule has places, the paths that begin each bounce in
    `alive`.
    """

    profile = False

    def __init__(self, settings: Settings, variant: Variant, spec: str = "opencl"):
        super().__init__(settings, opencl_info(spec))
        self.variant, self.group = variant, variant.group or GROUP
        self.context = CONTEXTS.setdefault(self.name, self.context)
        self.queue = self.calling(self.cl.CommandQueue, self.context)
        self.start_counting()

    def start_profile(self) -> None:
        """From now on events are kept, through a queue that notes their times."""
        flags = self.cl.command_queue_properties.PROFILING_ENABLE
        self.queue, self.wavefront = self.calling(self.cl.CommandQueue, self.context, properties=flags), None
        self.profile = True

    def start_counting(self) -> None:
        """Forget what was kept."""
        self.events: list = []
        self.kernel_seconds: dict[str, list[float]] = {}
        self.alive = np.zeros(0, np.int64)

    def upload(self, prepared: Prepared) -> None:
        """Copy the scene in the variant's form and compile the variant's kernels. Raises DeviceError, ValueError."""
        transparent = prepared.features & numbers()["FEATURE_TRANSPARENT"]
        if self.variant.traversal == "list_local" and transparent:
            raise ValueError("list_local: shadow rays that pass transparent surfaces cannot go together")
        n = numbers()
        lacking = sum(n[f"FEATURE_{name}"] for name in LACKING)
        if self.variant.schedule != "shipping" and prepared.features & lacking:
            raise ValueError(f"{self.variant.schedule}: it knows nothing of {', '.join(LACKING).lower()}")
        if self.variant.traversal != "shipping" and prepared.features & (n["FEATURE_MOTION"] | n["FEATURE_STRANDS"]):
            raise ValueError(f"{self.variant.traversal}: it knows nothing of what moves, nor of strands")
        prepared = adapt(prepared, self.variant)
        self.copy_scene(prepared)
        self.wavefront, self.features = None, prepared.features
        options = build_options(self.device, self.settings, prepared)
        options += [f"-D{name}={value}" for name, value in
                    self.variant.macros(len(prepared.buffers["triangles"])).items()]
        if self.variant.schedule == "shipping" and not self.variant.group:
            if group := shade_group(self.device, self.cl):
                options.append(f"-DSHADE_GROUP={group}")
        if self.variant.precision != "strict":
            options = [o for o in options if "correctly-rounded" not in o] + ["-DISOPHOTE_FAST"]
        if self.variant.precision == "native":
            options += ["-cl-fast-relaxed-math", "-cl-mad-enable"]
        started = time.perf_counter()
        key = (self.name, *options)
        if key not in PROGRAMS:
            PROGRAMS[key] = self.compiled(options)
        self.program = PROGRAMS[key]
        self.kernels = {kernel.function_name: kernel for kernel in self.program.all_kernels()}
        self.compile_seconds += time.perf_counter() - started

    def compiled(self, options: list[str]):
        source = kernel_source(SOURCE)
        if self.variant.precision == "native":
            assert AFTER_ELEMENTARY in source
            source = source.replace(AFTER_ELEMENTARY, NATIVE + AFTER_ELEMENTARY)
        program = self.cl.Program(self.context, source)
        try:
            return program.build(options=options)
        except self.cl.Error as error:
            raise DeviceError(f"opencl: {self.variant} does not compile for {self.name}: {error}") from error

    def paths_at_once(self, item: WorkItem, film_bytes: int) -> int:
        """As the shipping device, but for as many paths as the variant asks for and samples as its schedule takes."""
        if not self.variant.paths:
            return super().paths_at_once(item, film_bytes)
        x0, y0, x1, y1 = item.region
        pixels = max(1, self.variant.paths * SCHEDULES[self.variant.schedule].samples_per_path // item.samples)
        return min(pixels, (x1 - x0) * (y1 - y0)) * item.samples

    def reserve(self, paths: int) -> None:
        """Room for a pass of so many samples."""
        if self.wavefront is None or self.wavefront.paths < paths:
            self.wavefront = None
            self.wavefront = self.calling(SCHEDULES[self.variant.schedule], self, paths)

    def render(self, item, settings, sums, cancelled) -> int:
        done = super().render(item, settings, sums, cancelled)
        for name, event in self.events:
            spent = 1e-9 * (event.profile.end - event.profile.start)
            self.kernel_seconds.setdefault(name, []).append(spent)
        self.events.clear()
        return done

    def launch(self, name: str, count: int, *arguments) -> None:
        """Enqueue a kernel over at least `count` work-items in groups of the variant's size."""
        size = -(-count // self.group) * self.group
        self.keep(name, self.calling(self.kernels[name], self.queue, (size,), (self.group,), *arguments))

    def keep(self, name: str, event) -> None:
        """Remember a launch until the item is done, for its time."""
        if self.profile:
            self.events.append((name, event))

    def add_alive(self, counts: np.ndarray) -> None:
        """Add the paths that began each bounce of a pass."""
        longer, shorter = sorted((self.alive, counts.astype(np.int64)), key=len, reverse=True)
        self.alive = longer.copy()
        self.alive[:len(shorter)] += shorter

    def strided(self, count: int) -> int:
        """Work-items of a launch that strides through a queue of at most `count`: enough to fill the device."""
        return min(count, self.device.max_compute_units * 2048)

    def fill(self, buffer, value: int, count: int) -> None:
        """Write one value to `count` places of a buffer of uints."""
        self.calling(self.cl.enqueue_fill_buffer, self.queue, buffer, np.uint32(value), 0, 4 * count)

    def copy(self, source, to, count: int) -> None:
        """Copy `count` uints from one buffer to another."""
        self.calling(self.cl.enqueue_copy, self.queue, to, source, byte_count=4 * count)

    def read(self, buffer, index: int, count: int = 1) -> np.ndarray:
        """`count` uints of a buffer, waiting for the device."""
        values = np.zeros(count, np.uint32)
        self.calling(self.cl.enqueue_copy, self.queue, values, buffer, src_offset=4 * index)
        return values
