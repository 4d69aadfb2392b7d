"""The CPU renders while another device takes the scene: the same bits, and neither cancelling nor closing waits."""

import threading
import time
from concurrent.futures import wait
from dataclasses import replace

import pytest
from noise_device import NoiseDevice, tiny_scene
from test_session import bits, rendered, settings

from isophote.device import DeviceError
from isophote.handover import Handover
from isophote.session import Session
from isophote.settings import Settings
from tests.conftest import missing


class SlowDevice(NoiseDevice):
    """Takes the scene once `compiled` is set, and perhaps with an error."""

    def __init__(self, error=None, **options):
        super().__init__(kind="opencl", **options)
        self.compiled, self.error = threading.Event(), error

    def upload(self, prepared):
        self.compiled.wait(10)
        super().upload(prepared)
        if self.error:
            raise self.error


@pytest.fixture
def cpu(engine, monkeypatch):
    """The CPUs that were opened; one takes 10 ms a sample."""
    opened = []

    def open_cpu(settings):
        opened.append(NoiseDevice(delay=0.01))
        return opened[-1]

    monkeypatch.setattr(engine, "OpenMPDevice", open_cpu)
    monkeypatch.setattr("isophote.handover.PATIENCE", 0.01)
    return opened


def started(device, *args, **options):
    """A session, and the CPU that draws first."""
    session = Session(tiny_scene(), settings(*args, **options), device)
    return session, session.device.cpu.result(10)


def run(device, samples=100, ready_after=9, **options):
    """A session whose device is ready after so many samples."""
    def watch(progress):
        if progress.samples_done >= ready_after:
            device.compiled.set()
            wait([handover.uploading] if handover.uploading else [])

    session = Session(tiny_scene(), settings(samples, **options), device)
    handover = session.device
    session.run(watch)
    return session


def test_the_cpu_begins_and_the_device_goes_on_with_the_same_bits(cpu):
    device = SlowDevice()
    session = run(device)
    first, = cpu
    done_by_cpu = sum(item.samples for item in first.items)
    assert done_by_cpu == 16 and device.items[0].first_sample == 16 and device.items[-1].end_sample == 100
    assert bits(session.film) == bits(rendered(100).film)
    result = session.result()
    assert result["device"] == "noise opencl"
    assert result["samples_by_device"] == {"noise openmp": 16, "noise opencl": 84}
    assert first.closed and not device.closed
    session.close()
    assert device.closed


@pytest.mark.parametrize("ready_at", [4, 6])  # the first sample of an item, and one in its midst
def test_an_item_of_the_cpu_is_dropped_when_the_kernels_are_ready(cpu, ready_at):
    def ready(sample):
        if sample == ready_at:
            device.compiled.set()
            wait([session.device.uploading])

    device = SlowDevice()
    session, first = started(device, 128)
    first.on_sample = ready
    session.run()
    assert bits(session.film) == bits(rendered(128).film)
    assert session.result()["samples_by_device"] == {"noise openmp": ready_at, "noise opencl": 128 - ready_at}


def test_kernels_that_are_there_at_once_need_no_cpu(cpu):
    device = SlowDevice()
    device.compiled.set()
    session = run(device, 4)
    assert cpu == [] and session.result()["samples_by_device"] == {"noise opencl": 4}


@pytest.mark.timed
def test_a_short_render_ends_before_the_kernels_are_ready(cpu):
    device = SlowDevice()
    session = run(device, 4)
    assert session.result()["samples_by_device"] == {"noise openmp": 4}
    before = time.perf_counter()
    session.close()
    assert time.perf_counter() - before < 0.2 and cpu[0].closed and not device.closed
    device.compiled.set()
    wait([session.device.uploading])
    time.sleep(0.05)
    assert device.closed


@pytest.mark.timed
def test_cancelling_while_kernels_compile_is_quick(cpu):
    device = SlowDevice()
    session = Session(tiny_scene(), settings(100_000), device)
    threading.Timer(0.2, session.cancel).start()
    before = time.perf_counter()
    assert session.run().why_stopped == "cancelled" and time.perf_counter() - before < 0.5
    session.close()
    device.compiled.set()
    assert bits(session.film) == bits(rendered(session.film.samples).film)


@pytest.mark.timed
def test_cancelling_while_neither_has_the_scene_is_quick(cpu, monkeypatch):
    monkeypatch.setattr(NoiseDevice, "upload", lambda self, prepared: time.sleep(1))
    device = SlowDevice()
    session = Session(tiny_scene(), settings(100), device)
    threading.Timer(0.1, session.cancel).start()
    before = time.perf_counter()
    assert session.run().why_stopped == "cancelled" and time.perf_counter() - before < 0.4
    session.close()
    assert time.perf_counter() - before < 0.5
    device.compiled.set()


def test_a_device_that_is_ready_before_the_cpu_is_not_kept_waiting(cpu, monkeypatch):
    tree = threading.Event()
    monkeypatch.setattr("isophote.handover.Handover.prepare_cpu", lambda self, _: tree.wait(10) and self.open_cpu())
    device = SlowDevice()
    threading.Timer(0.1, device.compiled.set).start()
    session = Session(tiny_scene(), settings(20), device)
    making = session.device.cpu
    assert session.run().samples_done == 20
    assert session.result()["samples_by_device"] == {"noise opencl": 20} and cpu == []
    tree.set()
    made = making.result(10)
    session.close()
    assert made.closed and device.closed


def test_a_compiler_that_fails_leaves_the_render_on_the_cpu(cpu):
    device = SlowDevice(DeviceError("opencl: the kernels do not compile"))
    session = run(device)
    assert session.film.samples == 100 and device.closed and cpu[0].closed
    assert bits(session.film) == bits(rendered(100).film)
    (note,) = [note for note in session.notes if note["kind"] == "device"]
    assert note["name"] == "noise opencl" and "on the CPU: opencl: the kernels do not compile" in note["what"]


def test_a_device_that_fails_at_once_is_replaced_at_once(cpu):
    device = SlowDevice(DeviceError("out of device memory"))
    device.compiled.set()
    session = run(device, 4)
    assert session.notes[0]["what"].startswith("failed after 0 samples") and len(cpu) == 1


def test_an_error_of_the_cpu_is_raised(cpu):
    session, first = started(SlowDevice())
    first.fail_after = 3
    with pytest.raises(DeviceError, match="the driver reset"):
        session.run()
    assert session.film.samples == 2
    session.device.device.compiled.set()
    session.close()


def test_who_waits(cpu):
    def wrapped(device, **options):
        device.compiled.set()
        return isinstance(Session(tiny_scene(), settings(1, **options), device).device, Handover)

    lax = SlowDevice()
    lax.strict = "it flushes denormal numbers to zero"
    assert wrapped(SlowDevice())
    assert not wrapped(SlowDevice(), wait_for_kernels=True)
    assert not wrapped(SlowDevice(), precision="fast")
    assert not wrapped(lax)
    assert not isinstance(Session(tiny_scene(), settings(1), NoiseDevice()).device, Handover)


def test_the_device_may_take_another_scene(cpu):
    device = SlowDevice()
    handover = Handover(device, lambda: NoiseDevice())
    handover.upload(None)
    device.compiled.set()
    handover.upload(None)
    assert device.uploads == 2 and handover.drawing is device


def test_whether_it_waited_is_no_setting_of_the_samples():
    assert Settings(wait_for_kernels=True).fingerprint() == Settings().fingerprint()


def test_no_seam_with_real_devices(monkeypatch):
    """OpenMP draws some samples, PoCL the rest: the film of OpenMP alone."""
    from bench.parity import EVERY_PASS, differences
    from isophote.device import list_kind
    from isophote.opencl import OpenCLDevice
    from tests.parity.scenes import SCENES

    found = [info.id for info in list_kind("opencl") if info.usable and "Portable Computing" in info.driver]
    if not found:
        missing("no OpenCL platform 'Portable Computing Language'")
    ready, uploaded, compiled = threading.Event(), threading.Event(), OpenCLDevice.upload

    def slow(self, prepared):
        compiled(self, prepared)
        ready.wait(30)
        uploaded.set()

    def look(progress):
        if progress.samples_done >= 5:
            ready.set()
            uploaded.wait(60)

    monkeypatch.setattr(OpenCLDevice, "upload", slow)
    scene = SCENES["cornell_like"]()
    films = []
    for device in (found[0], "openmp"):
        with Session(scene, replace(settings(50, device=device), passes=EVERY_PASS), None) as session:
            uploaded.clear()
            session.run(look if device != "openmp" else None)
            films.append(session.film)
            drawn = session.result()["samples_by_device"]
        assert len(drawn) == (2 if device != "openmp" else 1) and sum(drawn.values()) == 50
    assert not any(differences(*films).values())
