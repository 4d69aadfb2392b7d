"""Built kernels on disk: never stale, whole or not at all, bounded; on PoCL the same bits as compiled ones."""

import multiprocessing
import os
import threading
import time

import pytest

from bench.parity import differing_floats, expose, full_frame, opened
from isophote import kernel_build
from isophote.device import list_kind
from isophote.film import Film
from isophote.kernel_cache import CacheError, KernelCache, cache_folder, cache_key, describe_cache
from isophote.passes import film_planes
from isophote.settings import Settings
from tests.conftest import missing
from tests.parity.scenes import SCENES
from tests.scenes import ready


@pytest.fixture
def cache(tmp_path):
    return KernelCache(tmp_path / "cache")


def test_what_is_stored_is_loaded(cache):
    assert cache.load("a") is None
    cache.store("a", b"binary")
    assert cache.load("a") == b"binary" and cache.load("b") is None
    cache.store("a", b"another")
    assert cache.load("a") == b"another"


def test_keys_differ_in_every_part():
    keys = [cache_key(*parts) for parts in (["a", "b"], ["ab"], ["ab", ""], ["", "ab"], ["b", "a"], ["a", "b", ""])]
    assert len(set(keys)) == len(keys)


@pytest.mark.parametrize("damage", [lambda data: data[:-1], lambda data: data[:10], lambda data: b"",
                                    lambda data: data[:-1] + bytes([data[-1] ^ 1]), lambda data: b"x" * len(data)])
def test_damaged_entries_are_found_and_removed(cache, damage):
    cache.store("a", b"binary" * 100)
    path = cache.path("a")
    path.write_bytes(damage(path.read_bytes()))
    with pytest.raises(CacheError, match="was damaged"):
        cache.load("a")
    assert cache.load("a") is None


def test_the_folder_is_bounded_and_the_oldest_go_first(cache):
    cache = KernelCache(cache.folder, limit=3500)
    for number in range(5):
        cache.store(str(number), bytes(1000))
        os.utime(cache.path(str(number)), (number, number))
        if number == 2:
            cache.load("0")  # used now
    assert sorted(path.stem for _, _, path in cache.entries()) == ["0", "3", "4"]


def test_what_killed_writers_left_goes(cache):
    cache.store("a", b"binary")
    old, new = (cache.folder / f".{name}.kernels" for name in ("old", "new"))
    for path in (old, new):
        path.write_bytes(b"half")
    os.utime(old, (0, 0))
    cache.store("b", b"binary")
    assert not old.exists() and new.exists() and len(cache.entries()) == 2


def write_often(folder, number):
    cache = KernelCache(folder, limit=200_000)
    for turn in range(60):
        cache.store(f"{turn % 7}", bytes([turn % 7]) * 20_000)
        for key in range(7):
            binary = cache.load(str(key))
            assert binary is None or binary == bytes([key]) * 20_000


def test_several_processes_may_write_at_once(cache):
    context = multiprocessing.get_context("spawn")
    workers = [context.Process(target=write_often, args=(cache.folder, n)) for n in range(3)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join(60)
    assert [worker.exitcode for worker in workers] == [0, 0, 0]
    assert len(cache.entries()) == 7


def test_the_variable_names_the_folder_or_turns_it_off(monkeypatch, tmp_path):
    assert cache_folder() is None and describe_cache()["folder"] is None
    monkeypatch.setenv("ISOPHOTE_KERNEL_CACHE", str(tmp_path))
    assert cache_folder() == tmp_path
    KernelCache(tmp_path).store("a", bytes(100))
    assert describe_cache()["entries"] == 1 and describe_cache()["bytes"] > 100
    monkeypatch.delenv("ISOPHOTE_KERNEL_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    pytest.importorskip("platformdirs")
    assert cache_folder() == tmp_path / "xdg" / "isophote" / "kernels"


# ------------------------------------------------------------------ with a real driver


@pytest.fixture
def pocl(monkeypatch, tmp_path):
    """A render with PoCL and a cache of its own; the driver's cache is off."""
    found = [info.id for info in list_kind("opencl") if info.usable and "Portable Computing" in info.driver]
    if not found:
        missing("no OpenCL platform 'Portable Computing Language'")
    monkeypatch.setenv("ISOPHOTE_KERNEL_CACHE", str(tmp_path / "kernels"))
    scene = SCENES["cornell_like"]()
    prepared, settings = ready(scene), Settings(samples=2, passes=("combined",))

    def render():
        device = opened(found[0], settings, prepared)
        film = expose(device, Film(full_frame(scene), film_planes(settings)), 2, settings)
        device.close()
        for thread in threading.enumerate():
            if thread.name == "isophote-kernel-cache":
                thread.join()
        return film, device

    return render


@pytest.mark.timed
def test_kernels_from_the_cache_give_the_same_bits_and_come_at_once(pocl, tmp_path):
    (first, compiled), (again, cached) = pocl(), pocl()
    assert (compiled.kernels_from, cached.kernels_from) == ("compiler", "cache")
    assert cached.compile_seconds < 0.3 and cached.notes == []
    assert differing_floats(first.open, again.open) == 0
    entry, = (tmp_path / "kernels").iterdir()
    entry.write_bytes(entry.read_bytes()[:-100])
    film, rebuilt = pocl()
    assert rebuilt.kernels_from == "compiler" and "nothing is lost" in rebuilt.notes[0]["what"]
    assert differing_floats(first.open, film.open) == 0
    KernelCache(tmp_path / "kernels").store(entry.stem, b"no program of any driver")
    film, rebuilt = pocl()
    assert rebuilt.kernels_from == "compiler" and "the driver refused" in rebuilt.notes[0]["what"]
    assert differing_floats(first.open, film.open) == 0
    assert pocl()[1].kernels_from == "cache"


def test_a_cache_that_cannot_be_written_is_named(pocl, tmp_path, monkeypatch):
    (tmp_path / "kernels").write_text("a file where the folder should be")
    _, device = pocl()
    assert device.kernels_from == "compiler" and "kernels" in device.notes[0]["what"]


def test_another_source_option_or_driver_is_another_entry():
    class Platform:
        vendor, name, version = "v", "n", "1.0"

    class Device:
        platform = Platform()
        vendor, name, version, driver_version = "v", "card", "3.0", "550.1"

    key = kernel_build.build_key(Device(), "source", ["-DA"])
    assert key == kernel_build.build_key(Device(), "source", ["-DA"])
    newer = Device()
    newer.driver_version = "550.2"
    others = [(newer, "source", ["-DA"]), (Device(), "source ", ["-DA"]), (Device(), "source", ["-DB"])]
    assert key not in {kernel_build.build_key(*arguments) for arguments in others}


@pytest.mark.timed
def test_reading_the_binary_leaves_the_interpreter_free(pocl, monkeypatch):
    """PoCL compiles for a second there; a thread must go on meanwhile."""
    longest, done = [0.0], threading.Event()

    def tick():
        last = time.perf_counter()
        while not done.wait(0.005):
            now = time.perf_counter()
            longest[0], last = max(longest[0], now - last), now

    seconds = []
    plain = kernel_build.program_binary

    def timed(cl, program):
        watcher = threading.Thread(target=tick)
        watcher.start()
        started = time.perf_counter()
        try:
            return plain(cl, program)
        finally:
            seconds.append(time.perf_counter() - started)
            done.set()
            watcher.join()

    monkeypatch.setattr(kernel_build, "program_binary", timed)
    monkeypatch.setenv("POCL_KERNEL_CACHE", "0")
    pocl()
    assert longest[0] < max(0.25, 0.5 * seconds[0]), (longest, seconds)
