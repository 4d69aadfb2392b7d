"""An OpenCL device that one frame leaves for the next: what it copies, and that no bit knows."""

import threading
from dataclasses import replace

import numpy as np
import pytest

from isophote.device import list_kind, open_device
from isophote.opencl import OpenCLDevice
from isophote.passes import make_passes
from isophote.session import Session
from isophote.settings import Settings
from tests.conftest import missing
from tests.parity.scenes import SCENES

SETTINGS = Settings(device="opencl", samples=3, max_bounces=4, wait_for_kernels=True, passes=("combined", "depth"))


@pytest.fixture(scope="module")
def scene():
    if not any(info.usable for info in list_kind("opencl")):
        missing("no OpenCL device")
    return SCENES["instances"]()


def moved(scene, x):
    camera = scene.camera_to_world.copy()
    camera[0, 3] += x
    return replace(scene, arrays=scene.arrays | {"camera_to_world": camera})


def pictures(session):
    session.run()
    return make_passes(session.film, session.settings.passes)


def test_the_next_frame_copies_what_is_new(scene):
    with Session(scene, SETTINGS) as first:
        first.run()
        device, geometry = first.leave(), first.prepared.geometry
        held = dict(device.scene)
    assert device.take_up(SETTINGS) and device.wavefront is None
    frame = moved(scene, 0.1)
    with Session(frame, SETTINGS, device, kept=geometry) as second, Session(frame, SETTINGS) as alone:
        stayed = {name for name, buffer in device.scene.items() if buffer is held[name]}
        assert stayed >= {"nodes", "triangles", "vertices", "indices", "normals", "spheres", "instances"}
        assert "camera" not in stayed and device.compile_seconds == 0.0
        kept, fresh = pictures(second), pictures(alone)
    for name in fresh:
        assert np.array_equal(kept[name].view(np.uint32), fresh[name].view(np.uint32)), name


def test_another_scene_on_the_device(scene):
    other = SCENES["spheres"]()
    with Session(scene, SETTINGS) as first:
        first.run()
        device = first.leave()
    assert device.take_up(SETTINGS)
    with Session(other, SETTINGS, device, kept=first.prepared.geometry) as second, Session(other, SETTINGS) as alone:
        kept, fresh = pictures(second), pictures(alone)
    for name in fresh:
        assert np.array_equal(kept[name].view(np.uint32), fresh[name].view(np.uint32)), name


def test_who_takes_it_up(scene):
    device = open_device("opencl", SETTINGS)
    assert device.take_up(replace(SETTINGS, samples=9, passes=("combined",))) and device.settings.samples == 9
    assert not device.take_up(replace(SETTINGS, precision="fast"))
    assert not device.take_up(replace(SETTINGS, device="openmp"))
    device.close()


def test_the_cpu_leaves_nothing(scene):
    with Session(scene, replace(SETTINGS, device="openmp")) as session:
        session.run()
        assert session.leave() is None


def test_a_device_that_still_takes_the_scene_is_not_left(scene, monkeypatch):
    ready, uploaded, inner = threading.Event(), threading.Event(), OpenCLDevice.upload

    def slow(self, prepared):
        ready.wait(10)
        inner(self, prepared)
        uploaded.set()

    monkeypatch.setattr("isophote.handover.PATIENCE", 0.01)
    monkeypatch.setattr(OpenCLDevice, "upload", slow)
    with Session(scene, replace(SETTINGS, wait_for_kernels=False)) as session:
        assert session.leave() is None
    ready.set()
    assert uploaded.wait(30)
