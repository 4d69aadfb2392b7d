"""What a device is, which ones there are, and how one is opened."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from isophote.schedule import WorkItem
from isophote.settings import Settings

if TYPE_CHECKING:
    from isophote.prepare import Prepared


class DeviceError(RuntimeError):
    """A device that cannot be used or that failed; the message names it and says why (with the driver's log)."""


class SceneTooLarge(DeviceError):
    """A scene that does not fit into memory, found out before anything is rendered; names needed and free bytes."""


class Device(Protocol):
    """Something that turns work items into sums of samples.

    `strict` is True where the device gives strict mode's bits, else the reason why not;
    `compile_seconds` is the time spent compiling kernels so far, `kernels_from` says where the last ones
    came from ("compiler", "cache", or "" for a device whose code is built in); `notes` are what a user
    should know, in the form of a scene's notes; `memory` is what it holds, in bytes by name; `ended` says of the
    last item rendered how many paths each of film.LIMITS has ended, uint64. Every method
    may raise DeviceError; a failed `render` leaves `sums` as it was, so that another device can go on
    from there.
    """

    name: str
    driver: str
    kind: str  # "openmp", "opencl"
    strict: bool | str
    compile_seconds: float
    kernels_from: str
    notes: list[dict]
    memory: dict[str, int]
    ended: np.ndarray

    def check_room(self, prepared: Prepared) -> None:
        """Raises SceneTooLarge where the scene does not fit into the device's memory."""

    def upload(self, prepared: Prepared) -> None:
        """Take over a prepared scene that has room; what the device held before is dropped."""

    def render(self, item: WorkItem, settings: Settings, sums: np.ndarray, cancelled: Callable[[], bool]) -> int:
        """Add the item's samples, in the order of their numbers, to `sums`, float32 (planes, h, w) of its region.

        Returns the samples added to every pixel: item.samples, or fewer whole ones, 0 only where
        `cancelled`, asked at least every 0.2 s, gave True.
        """

    def leave(self) -> Device | None:
        """Instead of close: itself with kernels and scene, to be taken up; where that saves nothing, None, closed."""

    def take_up(self, settings: Settings) -> bool:
        """Go on for a render with these settings, after leave; False where they want another device."""

    def close(self) -> None:
        """Give back what the device holds; it is not used again."""


@dataclass(frozen=True)
class DeviceInfo:
    """A device as `isophote devices` shows it. `id` is what open_device takes."""

    id: str
    name: str
    driver: str
    usable: bool
    why_not: str = ""
    strict: bool | str = True


def list_devices() -> list[DeviceInfo]:
    """Every device, also those that cannot be used, with the reason."""
    return list_kind("openmp") + list_kind("opencl")


def list_kind(kind: str) -> list[DeviceInfo]:
    try:
        if kind == "opencl":
            return list(importlib.import_module("isophote.opencl").list_opencl())
        device = importlib.import_module("isophote.openmp").OpenMPDevice(Settings())
        try:
            return [DeviceInfo("openmp", device.name, device.driver, True, strict=device.strict)]
        finally:
            device.close()
    except (ImportError, DeviceError) as error:
        return [DeviceInfo(kind, kind, "", False, str(error))]


def open_device(spec: str, settings: Settings) -> Any:
    """Open "openmp", "opencl" (the first usable one) or "opencl:N" for a render with these settings.

    Raises DeviceError naming what is wrong, and which devices exist where there is none of that name.
    """
    kind, _, number = spec.partition(":")
    if kind == "openmp" and not number:
        return opened("isophote.openmp", "OpenMPDevice", settings)
    if kind == "opencl" and (not number or number.isdecimal()):
        return opened("isophote.opencl", "OpenCLDevice", settings, opencl_info(spec))
    raise DeviceError(f"no device {spec!r}: there are {existing(list_devices())}")


def opened(module: str, name: str, *arguments) -> Any:
    try:
        return getattr(importlib.import_module(module), name)(*arguments)
    except ImportError as error:
        raise DeviceError(f"{module} cannot be loaded: {error}") from error


def opencl_info(spec: str) -> DeviceInfo:
    """The entry of list_opencl() that a spec means. Raises DeviceError."""
    devices = list_kind("opencl")
    chosen = [d for d in devices if d.id == spec] if ":" in spec else [d for d in devices if d.usable] or devices[:1]
    if not chosen:
        raise DeviceError(f"no device {spec!r}: there are {existing(list_devices())}")
    if not chosen[0].usable:
        raise DeviceError(f"device {spec} cannot be used: {chosen[0].why_not}")
    return chosen[0]


def existing(devices: list[DeviceInfo]) -> str:
    return ", ".join(f"{d.id} ({d.name if d.usable else 'cannot be used: ' + d.why_not})" for d in devices) or "none"
