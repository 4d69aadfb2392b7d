"""OpenCL devices: the wavefront of kernels/wavefront.cl, run through pyopencl.

The host only launches. Paths, queues and their lengths stay on the device; per item it reads the
film's sums once. Kernels are compiled for the features of the scene at hand.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from isophote.device import DeviceError, DeviceInfo
from isophote.film import LIMITS
from isophote.kernel_build import KernelBuild, build_key
from isophote.kernel_cache import open_cache
from isophote.memory import BUFFER, DEVICE, check_device_memory, lowered
from isophote.params import make_params, times_of_paths
from isophote.passes import film_planes
from isophote.planes import Planes
from isophote.prepare import Prepared
from isophote.records import header_path, numbers, scene_buffers
from isophote.schedule import WorkItem
from isophote.settings import Settings
from isophote.wavefront import Wavefront, path_columns, shade_group

PATHS_ON_GPU, PATHS_ON_CPU = 1 << 22, 1 << 15
FEWEST_PATHS = 1 << 12  # with fewer in flight a device would wait for its launches
PATHS_SHARE = 0.5  # of the memory that the scene leaves: others want some, too


def import_pyopencl():
    """The module, or DeviceError saying why there is none."""
    try:
        import pyopencl
    except ImportError as error:
        raise DeviceError(f"opencl: pyopencl cannot be loaded ({error})") from error
    return pyopencl


def opencl_devices() -> list:
    """All devices of all platforms, GPUs first. Raises DeviceError where there is no driver."""
    cl = import_pyopencl()
    try:
        found = [device for platform in cl.get_platforms() for device in platform.get_devices()]
    except cl.Error as error:
        raise DeviceError(f"opencl: no driver is installed ({error})") from error
    if not found:
        raise DeviceError("opencl: no driver has a device")
    return sorted(found, key=lambda device: not device.type & cl.device_type.GPU)


def list_opencl() -> list[DeviceInfo]:
    """Every OpenCL device; one that cannot be used says why."""
    made = []
    for number, device in enumerate(opencl_devices()):
        why_not = ""
        if not device.available or not device.compiler_available:
            why_not = "it is not available" if not device.available else "its driver has no compiler"
        made.append(DeviceInfo(f"opencl:{number}", device.name.strip(), driver_name(device), not why_not, why_not,
                               is_strict(device)))
    return made


def driver_name(device) -> str:
    return f"{device.platform.name.strip()}, {device.version.strip()}, driver {device.driver_version.strip()}"


def is_strict(device) -> bool | str:
    """True where the device can give strict mode's bits, else the reason why not."""
    cl = import_pyopencl()
    config = device.single_fp_config
    if not config & cl.device_fp_config.CORRECTLY_ROUNDED_DIVIDE_SQRT:
        return "its driver does not round division and square root correctly"
    if not config & cl.device_fp_config.DENORM:
        return "it flushes denormal numbers to zero"
    return True


def build_options(device, settings: Settings, prepared: Prepared) -> list[str]:
    """Compiler options: the scene's features, and what keeps the bits in strict mode."""
    options = ["-cl-std=CL1.2", f"-DSCENE_FEATURES={prepared.features}u",
               f"-DCLOSURES_USED={prepared.operations}u", f"-DGROUPS_USED={film_planes(settings).mask}u",
               f"-DCLAMPS={int(settings.clamps)}", f"-DREGISTERS={max(prepared.registers, 1)}"]
    if prepared.features & numbers()["FEATURE_VALUES"]:
        options += [f"-DVALUES_USED_{family}={mask}u" for family, mask in enumerate(prepared.values)]
    if settings.precision == "fast":
        return [*options, "-DISOPHOTE_FAST"]
    if is_strict(device) is True:
        options.append("-cl-fp32-correctly-rounded-divide-sqrt")
    return options


def kernel_source(entry: Path | None = None) -> str:
    """kernels/wavefront.cl, or another file, with its headers put in, each once: a text that caches can be keyed by."""
    seen: set = set()

    def expand(path) -> str:
        if path in seen:
            return ""
        seen.add(path)
        lines = []
        for line in path.read_text().splitlines():
            include = re.fullmatch(r'\s*#include "(.+)"\s*', line)
            lines.append(expand((path.parent / include.group(1)).resolve()) if include else line)
        return "\n".join(lines)

    return expand((entry or header_path("wavefront.cl")).resolve())


class OpenCLDevice:
    """One OpenCL device, given by its entry of list_opencl()."""

    kind = "opencl"

    def __init__(self, settings: Settings, info: DeviceInfo):
        self.cl = import_pyopencl()
        if settings.precision == "reference":
            raise DeviceError("opencl: reference precision is for the CPU (device openmp)")
        self.device = opencl_devices()[int(info.id.partition(":")[2])]
        self.name, self.driver = info.name, info.driver
        self.strict = info.strict if settings.precision == "strict" else f"precision {settings.precision} was asked for"
        self.settings = settings
        self.compile_seconds, self.kernels_from = 0.0, ""
        self.notes: list[dict] = []
        self.built: KernelBuild | None = None
        self.context = self.calling(self.cl.Context, [self.device])
        self.queue = self.calling(self.cl.CommandQueue, self.context)
        self.total_memory = lowered(self.device.global_mem_size, DEVICE)
        self.largest_buffer = lowered(min(self.device.max_mem_alloc_size, self.total_memory), BUFFER)
        self.memory: dict[str, int] = {}
        self.ended = np.zeros(len(LIMITS), np.uint64)
        self.made = np.zeros(0, np.float32)  # where an item's sums are read to: new memory takes longer than that
        self.scene: dict = {}  # buffers by name, in the order of kernels/scene_buffers.h
        self.arrays: dict[str, np.ndarray] = {}  # what was copied into them and others hold anyway
        self.geometry = None
        self.wavefront: Wavefront | None = None
        self.features = 0  # that the kernels are compiled for

    def calling(self, function, *arguments, **named):
        """Call into OpenCL; its errors come out as DeviceError naming the device."""
        try:
            return function(*arguments, **named)
        except (self.cl.Error, MemoryError) as error:
            raise DeviceError(f"opencl: {self.name} failed: {error}") from error

    def buffer(self, size: int = 0, array: np.ndarray | None = None):
        flags = self.cl.mem_flags
        if array is not None and array.nbytes:
            return self.calling(self.cl.Buffer, self.context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=array)
        return self.calling(self.cl.Buffer, self.context, flags.READ_WRITE, max(size, 4))

    def check_room(self, prepared: Prepared) -> None:
        """Raises SceneTooLarge where the scene, its film and the fewest paths do not fit."""
        x0, y0, x1, y1 = self.settings.region or (0, 0, *prepared.resolution)
        planes = film_planes(self.settings)
        columns = path_columns(planes, prepared.features)
        paths = min(FEWEST_PATHS, (x1 - x0) * (y1 - y0))
        check_device_memory(self.name, prepared.traced_sizes() | {"film": 4 * int(planes) * (x1 - x0) * (y1 - y0),
                                                "paths": 4 * sum(columns.values()) * paths},
                            self.total_memory, self.largest_buffer)

    def upload(self, prepared: Prepared) -> None:
        """Copy the scene's buffers, but those that are there already, and compile the kernels for its features."""
        self.check_room(prepared)
        self.copy_scene(prepared)
        self.wavefront = None
        self.features = prepared.features
        options = build_options(self.device, self.settings, prepared)
        if group := shade_group(self.device, self.cl):
            options.append(f"-DSHADE_GROUP={group}")
        self.build(kernel_source(), options)

    def copy_scene(self, prepared: Prepared) -> None:
        """Copy the scene's arrays. One that is the same object as before is there already (nobody changes them), and
        so are the trees of a geometry that is the same."""
        there = {id(array): self.scene[name] for name, array in self.arrays.items()}
        arrays = prepared.traced(self.geometry)
        self.scene = {name: there.get(id(arrays[name])) if name in arrays else self.scene[name]
                      for name in scene_buffers()}
        self.arrays, self.geometry = {}, None
        there.clear()  # what is not used again makes room first
        for name, array in arrays.items():
            self.scene[name] = self.scene[name] or self.buffer(array=array.reshape(-1).view(np.uint8))
        self.arrays = {name: array for name, array in arrays.items() if array is prepared.buffers.get(name)}
        self.geometry = prepared.geometry
        self.memory = {"scene": sum(prepared.traced_sizes().values())}

    def build(self, source: str, options: list[str]) -> None:
        """Make the kernels ready, unless they are already those of this source and these options."""
        if self.built and self.built.key == build_key(self.device, source, options):
            return
        self.keep_kernels()
        started = time.perf_counter()
        try:
            self.built = KernelBuild(self.cl, self.context, self.device, source, options, open_cache())
        except self.cl.Error as error:
            raise DeviceError(f"opencl: the kernels do not compile for {self.name}: {error}") from error
        self.warm_up()
        self.kernels_from = "cache" if self.built.from_cache else "compiler"
        self.compile_seconds += time.perf_counter() - started
        for problem in self.built.problems:
            self.note(problem)

    def keep_kernels(self) -> None:
        if self.built:
            self.built.keep(self.note)
            self.built = None

    def warm_up(self) -> None:
        """Render one sample of one pixel: PoCL compiles a kernel when it first runs, others load it then."""
        sums = np.zeros((film_planes(self.settings), 1, 1), np.float32)
        self.render(WorkItem((0, 0, 1, 1), 0, 1), self.settings, sums, lambda: False)

    def note(self, what: str) -> None:
        self.notes.append({"kind": "device", "name": self.name, "what": what})

    @property
    def planes(self) -> Planes:
        """Those of the films for which the kernels are compiled."""
        return film_planes(self.settings)

    def reserve(self, paths: int) -> None:
        """Make room for the state of so many paths."""
        if self.wavefront and paths <= self.wavefront.paths:
            return
        self.wavefront = None
        self.wavefront = self.calling(Wavefront, self.cl, self.queue, self.built.program, [*self.scene.values()], paths,
                                      self.planes, self.features)
        self.memory["paths"] = 4 * sum(path_columns(self.planes, self.features).values()) * paths

    def paths_at_once(self, item: WorkItem, film_bytes: int) -> int:
        """Paths in flight: as many as the device has use and memory for, whole pixels, at least one."""
        columns = path_columns(self.planes, self.features)
        room = self.total_memory - self.memory["scene"] - film_bytes
        fitting = min(PATHS_SHARE * room / sum(columns.values()), self.largest_buffer / max(columns.values())) // 4
        gpu = bool(self.device.type & self.cl.device_type.GPU)
        pixels = max(1, int(min(PATHS_ON_GPU if gpu else PATHS_ON_CPU, fitting)) // item.samples)
        x0, y0, x1, y1 = item.region
        return min(pixels, (x1 - x0) * (y1 - y0)) * item.samples

    def render(self, item: WorkItem, settings: Settings, sums: np.ndarray, cancelled: Callable[[], bool]) -> int:
        """As Device.render; `sums` stay as they were where the item was cancelled or the device failed."""
        if film_planes(settings) != self.planes:
            raise DeviceError(f"opencl: {self.name} holds kernels for {self.planes} of a film, not for "
                              f"{film_planes(settings)}")
        self.memory["film"] = sums.nbytes
        paths = self.paths_at_once(item, sums.nbytes)
        self.reserve(paths)
        film = self.buffer(array=np.ascontiguousarray(sums))
        params_buffers = [self.buffer(array=make_params(item, settings, len(sums), catching))
                          for catching in times_of_paths(self.features, settings)]
        x0, y0, x1, y1 = item.region
        pixels = (x1 - x0) * (y1 - y0)
        at_once = paths // item.samples
        limits = np.zeros((3, len(LIMITS)), np.uint32)  # of a pass, and the two halves of their sum
        self.calling(self.cl.enqueue_copy, self.queue, self.wavefront.limits, limits)
        walks = bool(self.features & numbers()["FEATURE_SUBSURFACE"])  # one vertex more: where it enters
        bounces = settings.max_bounces + settings.transparent_bounces + 3 + walks
        for first in range(0, pixels, at_once):
            if not self.calling(self.wavefront.trace, params_buffers, film, first, min(at_once, pixels - first),
                                item.samples, bounces, cancelled):
                return 0
        if len(self.made) < sums.size:
            self.made = np.empty(sums.size, np.float32)
        made = self.made[:sums.size].reshape(sums.shape)
        self.calling(self.cl.enqueue_copy, self.queue, made, film)
        self.calling(self.cl.enqueue_copy, self.queue, limits, self.wavefront.limits)
        sums[:] = made
        self.ended = limits[1] + (limits[2].astype(np.uint64) << np.uint64(32))
        return item.samples

    def leave(self) -> OpenCLDevice:
        """As Device.leave: room for paths and sums is given back, since it is made again at once."""
        self.wavefront, self.made = None, np.zeros(0, np.float32)
        if self.built:
            self.built.keep(self.note)
        return self

    def take_up(self, settings: Settings) -> bool:
        """As Device.take_up. Other devices and precisions want other kernels and say other things of themselves."""
        if (settings.device, settings.precision) != (self.settings.device, self.settings.precision):
            return False
        self.settings, self.compile_seconds, self.notes = settings, 0.0, []
        return True

    def close(self) -> None:
        """Drop all buffers."""
        self.calling(self.queue.finish)
        self.keep_kernels()
        self.scene, self.arrays, self.geometry, self.memory, self.wavefront = {}, {}, None, {}, None
