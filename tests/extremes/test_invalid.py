"""Samples that are no numbers: injected behind validation, counted where they are, and nothing else changes."""

import numpy as np
import pytest

from bench.parity import differing_floats
from isophote.film import COMBINED_PLANES
from isophote.ledger import ledger_of
from isophote.passes import make_passes
from isophote.planes import INVALID
from tests.extremes.table import Row
from tests.extremes.variants import opencl_film, openmp_film, settings_for
from tests.scenes import POINT, Builder, diffuse, emission, place, quad, ready

SIZE = 32


def scene(radiance=1.0):
    """A floor with a lamp, and a square that shines where half of the picture's paths may meet it."""
    b = Builder((SIZE, SIZE))
    b.look((0, -4, 3), (0, 0, 0), 0.5)
    b.add(quad((0, 0, 0), (3, 0, 0), (0, 3, 0)), diffuse((0.8, 0.5, 0.2)))
    b.add(quad((0.5, 0, 0.5), (0.3, 0, 0), (0, 0, 0.3)), diffuse(0.5))
    b.add(quad((-0.7, 0, 0.7), (0.6, 0, 0), (0, 0, 0.6)), emission(radiance))
    b.lamp(POINT, 100.0, place((1, -2, 4)))
    return b.make()


def broken(prepared, value):
    """Radiance, wherever the scene holds the square's, replaced where validation cannot see it any more."""
    buffers = {name: array.copy() for name, array in prepared.buffers.items()}
    emits = buffers["materials"]["emission"].any(axis=1)
    assert emits.sum() == 1
    buffers["materials"]["emission"][emits] = value
    prepared.buffers = buffers
    return prepared


def films_of(prepared, samples=1, **changes):
    """On both devices, which have the same bits."""
    settings = settings_for(samples, **changes)
    region = (0, 0, SIZE, SIZE)
    mine, other = (draw(prepared, region, samples, settings) for draw in (openmp_film, opencl_film))
    assert all(differing_floats(mine.sum(plane), other.sum(plane)) == 0 for plane in range(mine.planes.sums))
    return mine


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_invalid_samples_are_left_out_and_counted(value):
    """One sample a pixel: a pixel either has the bits of the sound scene, or is black and counted."""
    sound, ill = films_of(ready(scene())), films_of(broken(ready(scene()), value))
    count = ill.sum(INVALID)
    with Row("NaN and infinity anywhere", f"a light of radiance {value:g}", "pixels not kept or not counted") as row:
        assert set(np.unique(count)) == {0.0, 1.0} and 0.05 < count.mean() < 0.9
        kept = count == 0
        row.see(sum(differing_floats(sound.sum(plane)[kept], ill.sum(plane)[kept]) for plane in range(8)))
        row.see(sum(np.count_nonzero(ill.sum(plane)[~kept]) for plane in range(8)))
    assert (make_passes(ill, ["invalid"])["Invalid"][..., 0] == count).all()
    entry = next(e for e in ledger_of(ill, settings_for(1), []) if e["switch"] == "invalid_samples")
    assert (entry["samples"], entry["pixels"]) == (count.sum(), np.count_nonzero(count)) and entry["removed"] is None


@pytest.mark.parametrize("value", [2.0**119, 2.0**120, 3e38])
def test_large_light_does_not_overflow_the_film(value):
    """64 samples just below the limit still add up in float32, and from the limit on none counts."""
    film = films_of(broken(ready(scene()), value), 64)
    with Row("NaN and infinity anywhere", f"a light of radiance {value:.3g}, 64 samples", "sums not finite") as row:
        row.see(sum(np.count_nonzero(~np.isfinite(film.sum(plane))) for plane in range(COMBINED_PLANES)))
    assert film.sum(0).max() > 1e36
    assert film.sum(INVALID).any() == (value > 2.0**119)


@pytest.mark.parametrize("precision", ["fast", "reference"])
def test_other_precisions_see_them_too(precision):
    settings = settings_for(4, precision=precision)
    film = openmp_film(broken(ready(scene()), np.nan), (0, 0, SIZE, SIZE), 4, settings)
    assert film.sum(INVALID).sum() > 0 and all(np.isfinite(film.sum(plane)).all() for plane in range(film.planes.sums))


def test_other_passes_hold_numbers_only():
    """An albedo that is none; the picture's bits do not depend on whether it is asked for."""
    prepared = ready(scene())
    buffers = {name: array.copy() for name, array in prepared.buffers.items()}
    buffers["instructions"]["weight"][0] = np.nan
    prepared.buffers = buffers
    lean, full = films_of(prepared, 4), films_of(prepared, 4, passes=("combined", "albedo"))
    assert all(np.isfinite(full.sum(plane)).all() for plane in range(full.planes.sums))
    assert all(differing_floats(lean.sum(plane), full.sum(plane)) == 0 for plane in range(8))
    assert (full.sum(INVALID) > lean.sum(INVALID)).any()
