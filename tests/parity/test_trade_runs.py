"""Runs of a trade report: one OpenCL device serves choices that want other kernels, and gives the CPU's pictures."""

import numpy as np

from isophote.settings import Settings
from isophote.trade.runs import Renderer
from tests.parity.scenes import SCENES
from tests.parity.test_devices import pocl


def test_a_kept_device_takes_every_choice():
    renderer, clamps = Renderer(SCENES["cornell_like"]()), (0.0, 1.0, 0.0)
    try:
        plain, clamped, again = ([renderer.render(Settings(device=device, clamp_indirect=clamp, samples=4), 1, [2, 4])
                                  for device in ("openmp", pocl())] for clamp in clamps)
    finally:
        renderer.close()
    for cpu, opencl in (plain, clamped, again):
        assert np.array_equal(cpu.pictures, opencl.pictures)
    assert clamped[0].pictures.sum() < plain[0].pictures.sum()
    assert np.array_equal(plain[0].pictures, again[0].pictures)
