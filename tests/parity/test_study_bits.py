"""Every traversal and every schedule of the study gives the bits of the shipping device."""

from functools import cache

import numpy as np
import pytest

from bench.parity import EVERY_PASS, differences, differing_floats, full_frame, opened, render_in_parts
from bench.study.device import StudyDevice
from bench.study.scenes import ready_with_leaves
from bench.study.trees import as_list
from bench.study.variant import Variant
from isophote.settings import Settings
from tests.parity.test_devices import pocl
from tests.scenes import Builder, ball, box, diffuse, emission, place, quad

TREES = [Variant("stack"), Variant("stack", ordered=False, pruned=False), Variant("stackless"),
         Variant("stackless", ordered=False, leaf=8), Variant("wide4"), Variant("quantised4", leaf=4, ordered=False),
         Variant("quantised8"), Variant("list"), Variant(leaf=32)]
SCHEDULES = [Variant("list_local", schedule="pipeline"), Variant("list_local", schedule="scan", group=256),
             Variant(schedule="megakernel", group=32), Variant(schedule="groups", group=128),
             Variant(schedule="scan", group=32), Variant("stackless", schedule="compact"),
             Variant(schedule="compact", sort="material"), Variant(schedule="compact", sort="ray"),
             Variant(schedule="regeneration", paths=512), Variant(schedule="breadth_first"),
             Variant(group=256, paths=1000)]


@cache
def scene():
    """Instances, one of them mirrored, spheres, single meshes, a lamp; all diffuse, so that kernels compile soon."""
    b = Builder((24, 20))
    b.look((0, -6, 2), (0, 0, 0.7), 0.45)
    b.world = (0.2, 0.3, 0.4)
    shape = ball(rings=6)
    paint = b.material(diffuse((0.8, 0.5, 0.2)))
    mesh = b.mesh(shape, normals=shape[0])
    for k, scale in enumerate(((0.8, 0.8, 0.8), (-0.5, 0.9, 0.6))):
        b.instance(mesh, paint, matrix=place((1.8 * k - 1.4, 0.4, 0.9), scale, 0.6 * k))
    b.add(quad((0, 0, 0), (4, 0, 0), (0, 4, 0)), diffuse((0.7, 0.6, 0.5)))
    b.add(box((0.3, -1.4, 0.3), 0.3), diffuse((0.3, 0.6, 0.4)))
    b.add(quad((-1, 1, 3), (0.5, 0, 0), (0, -0.5, 0)), emission((6, 5, 4)))
    b.sphere((1.5, -1, 0.5), 0.5, b.material(diffuse(0.9)))
    b.sphere((-0.8, -1.6, 0.25), 0.25, paint)
    return b.make()


@cache
def prepared():
    return ready_with_leaves(scene(), 1)


PASSES = tuple(name for name in EVERY_PASS if name != "ambient_occlusion")  # a kernel that no other schedule launches
SETTINGS = Settings(samples=12, threads=2, max_bounces=8, passes=PASSES)


def film_of(device):
    return render_in_parts(device, full_frame(scene()), SETTINGS)


@cache
def expected():
    device = opened("openmp", SETTINGS, prepared())
    film = film_of(device)
    device.close()
    return film


def shown(variant):
    return "-".join(str(value) for name, value in vars(variant).items() if value != getattr(Variant(), name))


@pytest.mark.parametrize("variant", TREES + SCHEDULES, ids=shown)
def test_bits(variant):
    device = StudyDevice(SETTINGS, variant, spec=pocl())
    try:
        device.upload(prepared())
        counts = differences(expected(), film_of(device), PASSES)
        assert not any(counts.values()), counts
    finally:
        device.close()


def test_openmp_without_a_tree():
    device = opened("openmp", SETTINGS, as_list(prepared()))
    counts = differences(expected(), film_of(device), PASSES)
    device.close()
    assert not any(counts.values()), counts


def test_another_precision_is_another_picture():
    """The comparison can fail, and the device's own mathematics are used where they are asked for."""
    device = StudyDevice(SETTINGS, Variant(precision="native"), spec=pocl())
    device.upload(prepared())
    film = film_of(device)
    device.close()
    assert differing_floats(expected().sum(0), film.sum(0)) > 100
    np.testing.assert_allclose(expected().sum(0).mean(), film.sum(0).mean(), rtol=0.02)
