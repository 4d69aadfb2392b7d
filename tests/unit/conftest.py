import sys
import types

import pytest
from noise_device import NoiseDevice, Prepared


@pytest.fixture
def engine(monkeypatch):
    """Session without the native module: prepare does nothing, the CPU is a NoiseDevice. Its module comes back."""
    prepare = types.ModuleType("isophote.prepare")
    prepare.prepare = lambda scene, kept=None: Prepared()
    openmp = types.ModuleType("isophote.openmp")
    openmp.OpenMPDevice = NoiseDevice
    opencl = types.ModuleType("isophote.opencl")
    opencl.list_opencl = lambda: []
    for module in (prepare, openmp, opencl):
        monkeypatch.setitem(sys.modules, module.__name__, module)
    return openmp
