import sys
import types

import pytest
from noise_device import NoiseDevice

from isophote.device import DeviceError, DeviceInfo, list_devices, open_device
from isophote.settings import Settings


@pytest.fixture
def opencl(engine, monkeypatch):
    module = types.ModuleType("isophote.opencl")
    module.list_opencl = lambda: [
        DeviceInfo("opencl:0", "Old card", "1.0", False, "OpenCL 1.0, at least 1.2 is needed"),
        DeviceInfo("opencl:1", "Card", "3.0", True),
    ]
    module.OpenCLDevice = lambda settings, info: (info, NoiseDevice(kind="opencl"))
    monkeypatch.setitem(sys.modules, "isophote.opencl", module)


def test_openmp_opens(engine):
    assert open_device("openmp", Settings()).name == "noise openmp"


@pytest.mark.usefixtures("opencl")
def test_opencl_takes_the_first_usable_one_or_that_named():
    assert open_device("opencl", Settings())[0].id == "opencl:1"
    assert open_device("opencl:1", Settings())[0].name == "Card"


@pytest.mark.usefixtures("opencl")
@pytest.mark.parametrize(("spec", "message"), [
    ("opencl:0", "opencl:0 cannot be used: OpenCL 1.0"),
    ("opencl:7", r"no device 'opencl:7': there are openmp \(noise openmp\), opencl:0 \(cannot be .*opencl:1 \(Card"),
    ("cuda", "no device 'cuda': there are openmp"),
    ("openmp:1", "no device 'openmp:1'"),
    ("opencl:x", "no device 'opencl:x'"),
])
def test_what_cannot_be_opened_is_named_with_what_exists(spec, message):
    with pytest.raises(DeviceError, match=message):
        open_device(spec, Settings())


def test_modules_that_do_not_load_are_listed_with_the_reason(engine, monkeypatch):
    monkeypatch.setitem(sys.modules, "isophote.opencl", None)
    opencl = list_devices()[-1]
    assert opencl.id == "opencl" and not opencl.usable and "isophote.opencl" in opencl.why_not
    with pytest.raises(DeviceError, match="opencl cannot be used: .*isophote.opencl"):
        open_device("opencl", Settings())
    monkeypatch.setitem(sys.modules, "isophote.openmp", None)
    with pytest.raises(DeviceError, match="isophote.openmp cannot be loaded"):
        open_device("openmp", Settings())
