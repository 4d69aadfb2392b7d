"""Items that list their pixels, and adaptive renders: the same bits on every device, in every order and cut."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from bench.parity import differing_floats, opened
from isophote.film import load_film
from isophote.passes import film_planes
from isophote.schedule import BLOCK, WorkItem
from isophote.session import Session
from isophote.settings import Settings
from tests.parity.test_devices import assert_same, expose_region, pocl, prepared_of, scene_of, settings_of

NAME, REGION = "cornell_like", (3, 2, 17, 13)
TARGET = dict(samples=1024, error_target=0.2)


def devices():
    return [("openmp", 1), ("openmp", 2), ("pocl", 0)]


def spec_of(kind):
    return pocl() if kind == "pocl" else kind


@cache
def whole_blocks():
    """The sums of each of four blocks of a region, float32 (4, planes, h, w)."""
    device = opened("openmp", settings_of(NAME), prepared_of(NAME))
    sums = np.zeros((4, film_planes(settings_of(NAME)), REGION[3] - REGION[1], REGION[2] - REGION[0]), np.float32)
    for block in range(4):
        device.render(WorkItem(REGION, block * BLOCK, BLOCK), settings_of(NAME), sums[block], lambda: False)
    device.close()
    return sums


@pytest.mark.parametrize("kind,threads", devices())
def test_listed_pixels_have_the_bits_of_the_whole_picture(kind, threads):
    rng, blocks = np.random.default_rng(3), whole_blocks()
    _, _, height, width = blocks.shape
    device = opened(spec_of(kind), settings_of(NAME, threads=threads), prepared_of(NAME))
    for count, parts in ((1, (64,)), (7, (64,)), (120, (1, 7, 56)), (3 * height * width, (16, 48))):
        at = rng.integers(0, height * width, count)  # some several times
        of_block = rng.integers(0, 4, count)
        pixels = np.stack([REGION[0] + at % width, REGION[1] + at // width, BLOCK * of_block], axis=-1).astype(np.int32)
        sums, first = np.zeros((blocks.shape[1], 1, count), np.float32), 0
        for samples in parts:
            item = WorkItem((0, 0, count, 1), first, samples, pixels)
            assert device.render(item, settings_of(NAME), sums, lambda: False) == samples
            first += samples
        expected = blocks[of_block, :, at // width, at % width].T[:, None]
        assert differing_floats(sums, np.ascontiguousarray(expected)) == 0, (count, parts)
    device.close()


@cache
def adaptive_film(kind, threads):
    with Session(scene_of(NAME), adaptive_settings(spec_of(kind), threads)) as session:
        session.run()
    return session.film


def adaptive_settings(device, threads) -> Settings:
    return replace(settings_of(NAME, threads=threads), device=device, wait_for_kernels=True, **TARGET)


@pytest.mark.parametrize("kind,threads", devices()[1:])
def test_adaptive_renders_are_the_same_everywhere(kind, threads):
    plain, film = adaptive_film("openmp", 1), adaptive_film(kind, threads)
    assert film.ends is not None and (film.counts == plain.counts).all() and len(np.unique(film.counts)) > 2
    assert_same(plain, film)


def test_adaptive_renders_resumed_within_a_turn_are_the_same(tmp_path, monkeypatch):
    """Begun on OpenMP in small items, saved within a turn, ended by PoCL."""
    monkeypatch.setattr("isophote.session.choose_blocks", lambda *seconds: 50)
    with Session(scene_of(NAME), adaptive_settings("openmp", 2)) as session:
        while not (session.film.turn and session.film.turn.given and session.film.most_samples > 4 * BLOCK):
            assert not session.step().why_stopped
        session.film.save(tmp_path / "film.npz", session.scene_hash, session.settings.fingerprint())
    settings = adaptive_settings(pocl(), 0)
    film = load_film(tmp_path / "film.npz", scene_of(NAME).content_hash, settings.fingerprint())
    with Session(scene_of(NAME), settings, film=film) as session:
        session.run()
    assert_same(adaptive_film("openmp", 1), film)


def test_the_pictures_blocks_are_those_of_a_film():
    """What the listed pixels were compared with."""
    film = expose_region(NAME, REGION)
    for plane in range(film.planes.sums):
        assert (film.sum(plane) == whole_blocks()[0, plane]).all()
