"""The CPU renders while another device still compiles its kernels; nobody sees a seam, because bits are equal."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from isophote.device import Device, open_device
from isophote.schedule import WorkItem
from isophote.settings import Settings

if TYPE_CHECKING:
    from isophote.prepare import Prepared

PATIENCE = 0.3  # seconds to wait before the CPU begins: kernels from the cache are there by then
POLL_SECONDS = 0.05  # between two looks at whether the user has cancelled


class Handover:
    """A device with the CPU in front of it until the device has taken the scene.

    What it says of itself (name, driver, kind, ...) it says of the device that draws. An item that the
    CPU has begun when the kernels are ready is dropped and drawn by the device: on a large picture the
    CPU's item would take longer than the rest of the render. Both take the scene in threads of their own;
    an error of the device's upload comes out of `upload` or of a later `render`, as that device's error.
    """

    def __init__(self, device: Device, open_cpu: Callable[[], Device]):
        self.device, self.open_cpu = device, open_cpu
        self.drawing: Device = device
        self.uploading: Future | None = None  # until the device draws
        self.cpu: Future | None = None  # the CPU's device, with the scene

    def __getattr__(self, name: str):
        return getattr(self.drawing, name)

    def upload(self, prepared: Prepared) -> None:
        """Give the scene to the device, and to the CPU where the device takes long."""
        self.device.check_room(prepared)
        if self.uploading:
            self.take_over()
        pool = ThreadPoolExecutor(2, "isophote-handover")
        self.uploading = pool.submit(self.device.upload, prepared)
        if wait([self.uploading], PATIENCE).done:
            self.take_over()
        else:
            self.cpu = pool.submit(self.prepare_cpu, prepared)
        pool.shutdown(wait=False)

    def prepare_cpu(self, prepared: Prepared) -> Device:
        cpu = self.open_cpu()
        cpu.upload(prepared)
        prepared.geometry.drop_wide_tree()  # now it is the device's alone, and goes with it
        return cpu

    def render(self, item: WorkItem, settings: Settings, sums: np.ndarray, cancelled: Callable[[], bool]) -> int:
        """As Device.render."""
        while (uploading := self.uploading) and not uploading.done():
            if self.cpu.done():
                self.drawing = self.cpu.result()
                added = self.drawing.render(item, settings, sums, lambda: uploading.done() or cancelled())
                if added or not uploading.done():
                    return added
            elif cancelled():
                return 0
            else:
                wait([uploading, self.cpu], POLL_SECONDS, FIRST_COMPLETED)
        if uploading:
            self.take_over()
        return self.device.render(item, settings, sums, cancelled)

    def take_over(self) -> None:
        """From now on the device draws. Raises what its upload raised."""
        uploading, self.uploading = self.uploading, None
        self.close_cpu()
        uploading.result()

    def close_cpu(self) -> None:
        """Close the CPU's device, as soon as it has the scene if it is just taking it."""
        self.drawing, cpu, self.cpu = self.device, self.cpu, None
        if cpu:
            cpu.add_done_callback(lambda made: None if made.exception() else made.result().close())

    def leave(self) -> Device | None:
        """The device, where it draws; one that still compiles closes itself afterwards."""
        if self.drawing is self.device and not self.uploading:
            return self.device.leave()
        return self.close()

    def close(self) -> None:
        """Close both; a device that still compiles closes itself afterwards, and nobody waits."""
        self.close_cpu()
        if self.uploading and not self.uploading.done():
            self.uploading.add_done_callback(lambda _: self.device.close())
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
