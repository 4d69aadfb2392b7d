import io
import zipfile
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from noise_device import AOV_PLANES, radiance

from isophote.film import COMBINED_PLANES, Film, FilmError, load_film, merge
from isophote.passes import USUAL, make_passes
from isophote.schedule import BLOCK, sample_items, split
from isophote.settings import Settings
from isophote.totals import Total

REGION = (3, 2, 8, 6)
PRINT = Settings().fingerprint()


def exposed(first, end, step=16, planes=AOV_PLANES, film=None):
    """A film of the samples [first, end), rendered in items of at most `step`."""
    film = film or Film(REGION, planes, first)
    for item in sample_items(film.first, end, step):
        if item.end_sample > film.end:
            begin = max(item.first_sample, film.end)
            for sample in range(begin, item.end_sample):
                film.open[:] += radiance(REGION, sample, 0, planes)
            film.add_samples(item.end_sample - begin)
    return film


def bits(film):
    return {name: array.tobytes() for name, array in make_passes(film, USUAL).items()}


@settings(max_examples=25, deadline=None)
@given(st.integers(2, 5 * BLOCK), st.integers(1, 6), st.integers(1, BLOCK), st.randoms())
def test_any_split_and_order_of_merging_gives_the_same_bits(samples, parts, step, random):
    whole = bits(exposed(0, samples))
    films = [exposed(first, end, step) for first, end in split(samples, parts)]
    random.shuffle(films)
    while len(films) > 1:  # merge neighbours pair by pair, in a random tree
        films.sort(key=lambda film: film.first)
        at = random.randrange(len(films) - 1)
        films[at:at + 2] = [merge(reversed(films[at:at + 2]))]
    assert bits(films[0]) == whole


@settings(max_examples=15, deadline=None)
@given(st.integers(1, 3 * BLOCK), st.integers(1, 3 * BLOCK))
def test_resuming_gives_the_same_bits(tmp_path_factory, cut, more):
    path = tmp_path_factory.mktemp("film") / "film.npz"
    exposed(0, cut).save(path, "scene", PRINT)
    resumed = exposed(0, cut + more, film=load_film(path, "scene", PRINT))
    assert bits(resumed) == bits(exposed(0, cut + more))


# 24 bits at any of 70 powers of two: float64 alone loses most of it.
wide = st.builds(lambda mantissa, power: mantissa * 2.0**power, st.integers(-(2**24) + 1, 2**24 - 1),
                 st.integers(-35, 35))


@given(st.lists(wide, max_size=30), st.randoms())
def test_totals_are_exact_whatever_the_order(values, random):
    exact = float(sum((Fraction(value) for value in values), Fraction(0)))  # rounded once
    planes = [np.full((1, 1), value, np.float32) for value in values]
    for _ in range(3):
        random.shuffle(planes)
        total, other = Total(), Total()
        for plane in planes:
            random.choice((total, other)).add(plane)
        if other.hi is not None:
            total.add(other.hi, other.lo)
        assert (0.0 if total.hi is None else total.hi[0, 0]) == exact


@pytest.mark.parametrize("powers", [0.0, 40.0])
def test_listed_values_are_added_as_planes_are(powers):
    rng, shape = np.random.default_rng(2), (30, 41)
    plain, listed = Total(np.zeros(shape)), Total(np.zeros(shape))
    for number in range(20):
        pixels = rng.permutation(shape[0] * shape[1])[:900]
        values = (rng.standard_normal(900) * np.exp2(powers * rng.uniform(-1, 1, 900))).astype(np.float32)
        values[:3] = (np.inf, -np.inf, np.nan) if number == 7 else 1.0
        plane = np.zeros(shape, np.float32)
        plane.flat[pixels] = values
        plain.add(plane)
        listed.add_listed(values, pixels)
    assert (plain.lo is None) == (listed.lo is None)
    assert np.array_equal(plain.hi, listed.hi, equal_nan=True) and np.isnan(plain.hi).any()
    assert powers == 0.0 or (plain.lo == listed.lo).all() and plain.lo.any()


@pytest.mark.parametrize("pixels", [[-1, 2], [0, 6], [1]])
def test_listed_values_need_their_pixels(pixels):
    with pytest.raises(ValueError):
        Total(np.zeros((2, 3))).add_listed(np.ones(2, np.float32), np.array(pixels))


def test_totals_hold_what_one_float64_loses():
    total = Total()
    for value in (2.0**60, 1.0, -(2.0**60)):
        total.add(np.full((2, 3), value, np.float32))
    assert (total.hi == 1.0).all()


def test_nothing_is_allocated_before_it_is_needed():
    film = exposed(0, BLOCK - 1)
    assert all(total.hi is None for total in film.totals)
    film = exposed(0, 2 * BLOCK)
    assert all(total.lo is None for total in film.totals)


def test_2_to_the_24_samples_do_not_drift():
    value = np.float32(0.1)
    films = []
    for part in range(64):  # 2^18 samples each; the first is exposed, the others are as it is, further on
        film = Film((0, 0, 1, 1), COMBINED_PLANES, part << 18)
        if part == 0:
            for _ in range(1 << 12):
                film.open[:] = block_sum(value)
                film.add_samples(BLOCK)
        else:
            film.end, film.totals = film.first + (1 << 18), films[0].totals
        films.append(film)
    whole = merge(films)
    assert whole.samples == 2**24
    mean = (whole.sum(0) + whole.sum(4))[0, 0] / whole.samples
    assert abs(mean / float(value) - 1.0) < 1e-6


def block_sum(value):
    total = np.float32(0)
    for _ in range(BLOCK // 2):
        total += value
    return total


@pytest.mark.parametrize("seed", range(20))
def test_float32_sums_of_one_block_stay_within_a_millionth(seed):
    value = np.float32(np.random.default_rng(seed).uniform(0.5, 1.0))
    assert abs(float(block_sum(value)) / (float(value) * BLOCK / 2) - 1.0) < 1e-6


def test_infinities_stay_infinite():
    total = Total()
    for value in (1.0, np.inf, 2.0, 2.0**-80, 3.0):
        total.add(np.full((1, 2), value, np.float32))
    assert (total.hi == np.inf).all()


@pytest.mark.parametrize(("first", "end", "counts"), [(0, 5, (3, 2)), (64, 70, (3, 3)), (0, 1, (1, 0))])
def test_replicates_are_even_and_odd_samples(first, end, counts):
    assert exposed(first, end).replicate_samples == counts


@pytest.mark.parametrize(("ranges", "message"), [
    ([(0, 128), (64, 192)], r"overlap: samples \[0, 128\) and \[64, 192\)"),
    ([(0, 64), (128, 192)], r"gap: samples \[0, 64\) and \[128, 192\)"),
    ([(0, 60), (64, 128)], "gap"),
    ([], "no films"),
])
def test_films_that_do_not_tile_are_refused(ranges, message):
    with pytest.raises(FilmError, match=message):
        merge([exposed(first, end) for first, end in ranges])


def test_films_of_other_regions_or_planes_are_refused():
    with pytest.raises(FilmError, match="do not merge"):
        merge([Film((0, 0, 2, 2), COMBINED_PLANES), Film((0, 0, 3, 2), COMBINED_PLANES)])
    with pytest.raises(FilmError, match="do not merge"):
        merge([Film((0, 0, 2, 2), COMBINED_PLANES), Film((0, 0, 2, 2), AOV_PLANES)])


@pytest.mark.parametrize("make", [
    lambda: Film((0, 0, 0, 2), COMBINED_PLANES),
    lambda: Film((0, 0, 1, 1), COMBINED_PLANES, 10), lambda: exposed(0, 60).add_samples(5),
    lambda: exposed(0, 60).close_block()])
def test_misuse_is_refused(make):
    with pytest.raises(FilmError):
        make()


def test_merging_leaves_its_films_alone():
    a, b = exposed(0, 64), exposed(64, 100)
    before = bits(merge([a])), b.sum(0).tobytes()
    merge([b, a])
    assert (bits(merge([a])), b.sum(0).tobytes()) == before


def saved(tmp_path):
    path = tmp_path / "film.npz"
    exposed(0, 70).save(path, "a" * 64, PRINT)
    return path


def test_damaged_checkpoints_name_the_file(tmp_path):
    path = saved(tmp_path)
    whole = path.read_bytes()
    for cut in (0, 10, len(whole) // 2, len(whole) - 30):
        path.write_bytes(whole[:cut])
        with pytest.raises(FilmError, match="film.npz: not a readable film"):
            load_film(path, "a" * 64, PRINT)
    flipped = bytearray(whole)
    flipped[len(whole) // 3] ^= 0x10  # zip's check sum sees it
    path.write_bytes(flipped)
    with pytest.raises(FilmError, match="film.npz"):
        load_film(path, "a" * 64, PRINT)


def test_foreign_checkpoints_are_refused(tmp_path):
    path = saved(tmp_path)
    with pytest.raises(FilmError, match="film.npz: a film of another scene"):
        load_film(path, "b" * 64, PRINT)
    with pytest.raises(FilmError, match="film.npz: a film with other settings: seed was 0, is 7"):
        load_film(path, "a" * 64, Settings(seed=7).fingerprint())
    np.savez(path, x=np.zeros(3))
    with pytest.raises(FilmError, match="no Isophote film"):
        load_film(path, "a" * 64, PRINT)
    with pytest.raises(FilmError, match="no such file"):
        load_film(tmp_path / "none.npz", "a" * 64, PRINT)


def test_arrays_of_the_wrong_shape_are_refused(tmp_path):
    path = saved(tmp_path)
    with np.load(path) as data:
        arrays = dict(data) | {"open": np.zeros((2, 2), np.float32)}
    np.savez(path, **arrays)
    with pytest.raises(FilmError, match="film.npz: open is float32"):
        load_film(path, "a" * 64, PRINT)


def test_what_may_change_between_parts_does_not_matter(tmp_path):
    path = saved(tmp_path)
    assert load_film(path, "a" * 64, Settings(samples=999, threads=3, time_limit=5.0).fingerprint()).samples == 70


def test_a_failed_save_keeps_the_old_file(tmp_path, monkeypatch):
    path = saved(tmp_path)
    before = path.read_bytes()

    def full_disk(file, **arrays):
        file.write(b"x" * 100)
        raise OSError("No space left on device")

    monkeypatch.setattr(np, "savez", full_disk)
    with pytest.raises(OSError, match="No space"):
        exposed(0, 64).save(path, "a" * 64, PRINT)
    assert path.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == ["film.npz"]
    assert zipfile.is_zipfile(io.BytesIO(before))
