"""Every traversal and every schedule of the study gives the bits of the shipping device, and says what it cannot do."""

from functools import cache

import pytest

from bench.parity import differences, full_frame, render_in_parts
from bench.study.device import StudyDevice
from bench.study.scenes import ready_with_leaves
from bench.study.variant import Variant
from tests.parity.scenes import SCENES
from tests.parity.test_devices import film_of, pocl, settings_of

SAMPLES = 16
TREES = [Variant("stack"), Variant("stack", ordered=False, pruned=False), Variant("stackless"),
         Variant("stackless", ordered=False, leaf=8), Variant("wide4"), Variant("quantised4", leaf=4),
         Variant("quantised8"), Variant("list"), Variant(leaf=32)]
OTHERS = [Variant("list_local", schedule="pipeline"), Variant("list_local", schedule="scan", group=256),
          Variant(schedule="megakernel", group=32), Variant(schedule="pipeline"), Variant(schedule="groups", group=128),
          Variant(schedule="scan", group=32), Variant("stackless", schedule="compact"),
          Variant(schedule="compact", sort="material"), Variant(schedule="compact", sort="ray"),
          Variant(schedule="regeneration", paths=512), Variant(schedule="breadth_first"),
          Variant(group=256, paths=1000)]


@cache
def expected(name):
    return film_of(name, samples=SAMPLES, threads=2)


@cache
def prepared_of(name):
    return ready_with_leaves(SCENES[name](), 1)


def shown(variant):
    return "-".join(str(value) for name, value in vars(variant).items() if value != getattr(Variant(), name)) or "plain"


def assert_bits(name, variant):
    settings = settings_of(name, samples=SAMPLES)
    device = StudyDevice(settings, variant, spec=pocl())
    try:
        device.upload(prepared_of(name))
        counts = differences(expected(name), render_in_parts(device, full_frame(SCENES[name]()), settings))
        assert not any(counts.values()), counts
    finally:
        device.close()


@pytest.mark.parametrize("name", ["instances", "spheres"])
@pytest.mark.parametrize("variant", TREES, ids=shown)
def test_traversals(name, variant):
    assert_bits(name, variant)


@pytest.mark.parametrize("variant", OTHERS, ids=shown)
def test_schedules(variant):
    assert_bits("spheres", variant)
