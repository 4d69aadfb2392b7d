"""The CPU renders while another device still compiles its kernels; nobody sees a seam, because bits are equal."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from isophote.device import Device, open_device
from isophote.schedule import WorkItem
from isophote.settings import Settings

if TYPE_CHECKING:
    from isophote.prepare import Prepared

PATIENCE = 0.3  # seconds to wait before the CPU begins: kernels from the cache are there by then


class Handover:
    """A device with the CPU in front of it until the device has taken the scene.

    What it says of itself (name, driver, kind, ...) it says of the device that draws. An item that the
    CPU has begun when the kernels are ready is dropped and drawn by the device: on a large picture the
    CPU's item would take longer than the rest of the render. An error of the device's upload comes out
    of upload or of a later render, as an error of that device.
    """

    def __init__(self, device: Device, open_cpu: Callable[[], Device]):
        self.device, self.open_cpu = device, open_cpu
        self.drawing: Device = device
        self.work: Future | None = None  # the device's upload, until the device draws

    def __getattr__(self, name: str):
        return getattr(self.drawing, name)

    def upload(self, prepared: Prepared) -> None:
        """Give the scene to the device in a thread of its own, and to the CPU where that takes long."""
        self.device.check_room(prepared)
        if self.work:
            self.take_over()
        worker = ThreadPoolExecutor(1, "isophote-kernels")
        self.work = worker.submit(self.device.upload, prepared)
        worker.shutdown(wait=False)
        if wait([self.work], PATIENCE).done:
            self.take_over()
            return
        self.drawing = self.open_cpu()
        self.drawing.upload(prepared)

    def render(self, item: WorkItem, settings: Settings, sums: np.ndarray, cancelled: Callable[[], bool]) -> int:
        """As Device.render."""
        if work := self.work:
            if not work.done():
                added = self.drawing.render(item, settings, sums, lambda: work.done() or cancelled())
                if added or not work.done():
                    return added
            self.take_over()
        return self.device.render(item, settings, sums, cancelled)

    def take_over(self) -> None:
        """From now on the device draws. Raises what its upload raised."""
        work, self.work = self.work, None
        self.close_cpu()
        work.result()

    def close_cpu(self) -> None:
        cpu, self.drawing = self.drawing, self.device
        if cpu is not self.device:
            cpu.close()

    def close(self) -> None:
        """Close both; a device that still compiles closes itself afterwards, and nobody waits."""
        self.close_cpu()
        if self.work and not self.work.done():
            self.work.add_done_callback(lambda _: self.device.close())
        else:
            self.device.close()


def with_cpu_meanwhile(device: Device, settings: Settings) -> Device:
    """The device, with the CPU in front of it where that changes no bit and the user does not want to wait.

    Fast precision waits: its bits differ between devices, and a picture must not depend on how long a
    compiler took.
    """
    if device.kind == "openmp" or settings.wait_for_kernels or settings.precision != "strict" or (
            device.strict is not True):
        return device
    return Handover(device, lambda: open_device("openmp", replace(settings, device="openmp")))
