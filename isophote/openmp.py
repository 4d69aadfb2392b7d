"""The CPU as a device: the native module's OpenMP loops."""

from __future__ import annotations

import os
import platform
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait

import numpy as np

from isophote.device import DeviceError
from isophote.film import LIMITS
from isophote.geometry import plain
from isophote.params import make_params
from isophote.prepare import Prepared
from isophote.records import scene_buffers
from isophote.schedule import WorkItem
from isophote.settings import Settings

POLL_SECONDS = 0.05  # between two looks at whether the user has cancelled


class OpenMPDevice:
    """All cores, or settings.threads of them, with the widest instructions that the processor has.

    The environment variable ISOPHOTE_ISA (v2, v3, v4) asks for other instructions, for tests.
    """

    kind = "openmp"
    strict: bool | str = True
    compile_seconds, kernels_from = 0.0, ""
    notes: list[dict] = []
    memory: dict[str, int] = {}

    def __init__(self, settings: Settings):
        try:
            from isophote import _native
        except ImportError as error:
            raise DeviceError(f"openmp: the native module cannot be loaded ({error})") from error
        self.native = _native
        self.threads, self.precision = settings.threads or os.cpu_count() or 1, settings.precision
        self.variant = choose_variant(_native.variants, settings.precision, os.environ.get("ISOPHOTE_ISA", ""))
        self.name = f"{processor_name()}, {self.threads} threads"
        self.driver = f"OpenMP, {_native.compiler}, {self.variant}"
        if settings.precision != "strict":
            self.strict = f"precision {settings.precision} was asked for"
        self.buffers: list[np.ndarray] = []
        self.tree = None
        self.rays = np.zeros(2, np.uint64)  # paths' rays and shadow rays traced so far
        self.ended = np.zeros(len(LIMITS), np.uint64)
        # One thread for all items: to OpenMP a new caller is a new team of threads.
        self.worker = ThreadPoolExecutor(1, "isophote-openmp")

    def check_room(self, prepared: Prepared) -> None:
        """Nothing: the buffers lie in the host's memory already (memory.check_host_memory)."""

    def upload(self, prepared: Prepared) -> None:
        """Keep the buffers' bytes, in the order of kernels/scene_buffers.h, and build the CPU's own tree.

        Reference precision traces the BVH2 as OpenCL devices do.
        """
        buffers = prepared.traced() if self.precision == "reference" else prepared.buffers
        nothing = np.zeros(0, np.uint8)
        self.buffers = [plain(buffers[name]) if name in buffers else nothing for name in scene_buffers()]
        self.tree = prepared.geometry.wide_tree
        self.memory = {"scene": sum(buffer.nbytes for buffer in self.buffers), "tree": sum(self.tree.bytes.values()),
                       "paths": self.threads * self.native.batch_bytes(self.variant)}

    def render(self, item: WorkItem, settings: Settings, sums: np.ndarray, cancelled: Callable[[], bool]) -> int:
        """As Device.render; `sums` stay as they were where the item was cancelled."""
        params = make_params(item, settings, len(sums))
        made, flag = sums.copy(), np.zeros(1, np.int32)
        rays, ended = np.zeros_like(self.rays), np.zeros_like(self.ended)
        work = self.worker.submit(self.native.render, self.variant, self.buffers, self.tree, params, self.threads, made,
                                  rays, ended, flag)
        while not wait([work], POLL_SECONDS).done:
            if cancelled():
                flag[0] = 1
        try:
            if not work.result():
                return 0
        except MemoryError as error:
            raise DeviceError("openmp: out of memory while rendering") from error
        sums[:] = made
        self.rays += rays
        self.ended = ended
        return item.samples

    def leave(self) -> None:
        """Nothing: what it holds is the prepared scene's, and code is built in."""
        self.close()

    def close(self) -> None:
        self.worker.shutdown()
        self.buffers, self.tree = [], None


def choose_variant(variants: list[tuple[str, str, int, bool]], precision: str, isa: str = "") -> str:
    """The variant of a precision with the highest instruction set that this processor runs.

    Raises DeviceError naming what there is.
    """
    fitting = [(level, name) for name, of, level, supported in variants
               if of == precision and supported and (not isa or name.endswith(isa))]
    if not fitting:
        there = ", ".join(name for name, _, _, supported in variants if supported) or "none"
        raise DeviceError(f"openmp: no {precision} {isa} code for this processor; there is: {there}")
    return max(fitting)[1]


def processor_name() -> str:
    """The processor's name as the system tells it."""
    try:
        with open("/proc/cpuinfo") as file:
            for line in file:
                if line.startswith("model name"):
                    return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
