"""Memory: what does not fit is refused before rendering with the bytes named; what is scarce is used sparingly."""

import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from noise_device import NoiseDevice, tiny_scene

from bench.parity import differing_floats, expose, full_frame, opened
from isophote.device import SceneTooLarge, list_kind
from isophote.film import COMBINED_PLANES, Film
from isophote.memory import (
    BUILD_BYTES_PER_TRIANGLE,
    FILM_BYTES_PER_VALUE,
    check_device_memory,
    container_available,
    host_available,
    lowered,
    readable,
)
from isophote.passes import film_planes
from isophote.records import header
from isophote.scene import resized
from isophote.session import Session
from isophote.settings import Settings
from isophote.wavefront import COLUMNS, MEDIUM_COLUMNS
from tests.conftest import missing
from tests.parity.scenes import SCENES
from tests.scenes import ready


def test_columns_are_those_of_the_kernels():
    path = header("path.h")
    lists = {name: re.search(rf"#define {name}\(X\)((?:.*\\\n)*.*)", text).group(1)
             for name, text in (("PATH_REALS", path), ("PATH_UINTS", path), ("MEDIUM_REALS", header("walk.h")))}
    assert [lists[name].count("X(") for name in lists] == [COLUMNS["reals"], COLUMNS["uints"], MEDIUM_COLUMNS]


@pytest.mark.parametrize(("count", "text"), [(12, "12 bytes"), (2048, "2.0 KiB"), (3 << 20, "3.0 MiB"),
                                             (5.5 * 2**30, "5.5 GiB")])
def test_readable(count, text):
    assert readable(count) == text


def test_a_variable_lowers_but_never_raises(monkeypatch):
    for text, value in (("", 1000), ("500", 500), ("2000", 1000), ("1K", 1000)):
        monkeypatch.setenv("LIMIT", text)
        assert lowered(1000, "LIMIT") == value
    monkeypatch.setenv("LIMIT", "512m")
    assert lowered(None, "LIMIT") == 512 << 20
    monkeypatch.setenv("LIMIT", "much")
    with pytest.raises(ValueError, match="LIMIT=much"):
        lowered(1000, "LIMIT")


def test_the_hosts_memory_is_known_and_a_containers_limit_counts(tmp_path):
    available = host_available()
    assert available is None or 1 << 20 < available < 1 << 50
    assert container_available(str(tmp_path)) is None
    (tmp_path / "memory.current").write_text("300\n")
    (tmp_path / "memory.max").write_text("max\n")
    assert container_available(str(tmp_path)) is None
    (tmp_path / "memory.max").write_text("1000\n")
    assert container_available(str(tmp_path)) == 700


def test_what_does_not_fit_on_a_device_is_named():
    parts = {"nodes": 100, "triangles": 300}
    check_device_memory("card", parts, 400, 300)
    with pytest.raises(SceneTooLarge, match=r"on card: it needs .*400 bytes.*399 bytes.*triangles.*300 bytes"):
        check_device_memory("card", parts, 399, 300)
    with pytest.raises(SceneTooLarge, match=r"300 bytes\) of 299 bytes"):
        check_device_memory("card", parts, 1000, 299)


@pytest.mark.usefixtures("engine")
def test_a_scene_too_large_for_the_host_is_refused_before_anything_is_built(monkeypatch):
    film = FILM_BYTES_PER_VALUE * 12 * 10 * int(COMBINED_PLANES)
    monkeypatch.setenv("ISOPHOTE_HOST_MEMORY", str(BUILD_BYTES_PER_TRIANGLE + film - 1))
    with pytest.raises(SceneTooLarge, match=f"{BUILD_BYTES_PER_TRIANGLE} bytes to prepare its 1 triangles and {film}"):
        Session(tiny_scene(), Settings(samples=1), NoiseDevice())
    monkeypatch.setenv("ISOPHOTE_HOST_MEMORY", str(BUILD_BYTES_PER_TRIANGLE + film))
    assert Session(tiny_scene(), Settings(samples=1), NoiseDevice()).run().samples_done == 1


def test_the_estimate_for_the_host_is_above_what_preparing_takes_and_not_far():
    if not Path("/proc/self/clear_refs").exists():
        missing("no /proc to measure with")
    script = Path(__file__).with_name("measure_build.py")
    done = subprocess.run([sys.executable, script], capture_output=True, text=True,
                          env=os.environ | {"PYTHONPATH": str(script.parents[2])})
    assert done.returncode == 0, done.stderr
    assert 0.3 * BUILD_BYTES_PER_TRIANGLE < float(done.stdout) < BUILD_BYTES_PER_TRIANGLE


# ------------------------------------------------------------------ with a real driver


def pocl() -> str:
    found = [info.id for info in list_kind("opencl") if info.usable and "Portable Computing" in info.driver]
    return found[0] if found else missing("no OpenCL platform 'Portable Computing Language'")


SETTINGS = Settings(samples=64, passes=("combined",))


def rendered(scene, prepared, spec, settings=SETTINGS):
    device = opened(spec, settings, prepared)
    film = expose(device, Film(full_frame(scene), film_planes(settings)), settings.samples, settings)
    held = dict(device.memory), device.wavefront.paths if spec != "openmp" else 0
    device.close()
    assert spec == "openmp" or device.memory == {}
    return film, *held


def test_little_memory_means_fewer_paths_and_the_same_bits(monkeypatch):
    spec, scene = pocl(), SCENES["cornell_like"]()
    prepared = ready(scene)
    film, memory, paths = rendered(scene, prepared, spec)
    width, height = (int(n) for n in scene.resolution)
    assert paths == min(1 << 15, 64 * width * height) and memory["paths"] > 100 * paths
    assert memory["scene"] == sum(prepared.traced_sizes().values())
    monkeypatch.setenv("ISOPHOTE_DEVICE_MEMORY", str(memory["scene"] + memory["film"] + memory["paths"] // 3))
    scarce, less, fewer = rendered(scene, prepared, spec)
    assert fewer < paths // 3 and sum(less.values()) < sum(memory.values()) // 3
    monkeypatch.setenv("ISOPHOTE_DEVICE_MEMORY", "1G")
    monkeypatch.setenv("ISOPHOTE_DEVICE_BUFFER", str(max(prepared.traced_sizes().values()) + 150_000))
    tight, _, capped = rendered(scene, prepared, spec)
    assert capped < paths
    for other in (scarce, tight, rendered(scene, prepared, "openmp")[0]):
        assert differing_floats(film.open, other.open) == 0 and other.samples == film.samples
        assert all(differing_floats(film.sum(plane), other.sum(plane)) == 0 for plane in range(film.planes.sums))


def test_small_pictures_take_little_memory():
    spec, scene = pocl(), resized(SCENES["cornell_like"](), (8, 8))
    _, memory, paths = rendered(scene, ready(scene), spec, replace(SETTINGS, samples=4))
    assert paths == 4 * 64 and memory["paths"] < 300 * paths


@pytest.mark.parametrize("meanwhile", [True, False])
@pytest.mark.parametrize("variable", ["ISOPHOTE_DEVICE_MEMORY", "ISOPHOTE_DEVICE_BUFFER"])
def test_a_scene_that_does_not_fit_is_refused_with_its_bytes(monkeypatch, variable, meanwhile):
    spec, scene = pocl(), SCENES["cornell_like"]()
    most = max(ready(scene).traced_sizes().values())
    monkeypatch.setenv(variable, str(most - 1))
    settings = replace(SETTINGS, device=spec, wait_for_kernels=not meanwhile)
    with pytest.raises(SceneTooLarge, match=rf"does not fit on .*\({most} bytes\) of .*\({most - 1} bytes\).*openmp"):
        Session(scene, settings)


def test_the_cpu_says_what_it_holds():
    scene = SCENES["cornell_like"]()
    _, memory, _ = rendered(scene, ready(scene), "openmp", replace(SETTINGS, samples=1))
    assert memory["tree"] > 0 and memory["paths"] > 1024 * 100
    assert memory["scene"] == sum(np.ascontiguousarray(b).nbytes for b in ready(scene).buffers.values())
