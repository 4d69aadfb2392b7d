"""Adaptive sampling: pixels of a film may have different numbers of samples, which other pixels decide."""

import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from noise_device import AOV_PLANES, NoiseDevice, hashed, radiance, tiny_scene
from test_session import bits, rendered
from test_session import settings as of

from isophote.adaptive import GROWTH, WITHIN, X, at_price, next_limits, price_of, wanted_samples, within_at_price
from isophote.confidence import SHARE, claim_of
from isophote.film import COMBINED_PLANES, Film, FilmError, load_film, merge
from isophote.passes import USUAL, make_passes
from isophote.schedule import BLOCK
from isophote.session import Session
from isophote.settings import Settings
from isophote.statistics import Luminance
from isophote.turns import first_turn

REGION = (3, 2, 16, 13)
PRINT = Settings().fingerprint()
TARGET = dict(samples=100_000, error_target=0.06)  # beyond the pilot
pytestmark = pytest.mark.usefixtures("engine")


def add(film, samples, step=16):
    """Add so many samples to the pixels whose turn it is."""
    while samples:
        count = min(samples, step, BLOCK - film.open_samples)
        for k in range(count):
            film.open[:] += radiance(film.region, film.end + k, 0, film.planes)
        film.add_samples(count)
        samples -= count
    return film


def add_blocks(film, blocks):
    """Add at most so many blocks to the pixels whose turn it is."""
    item = film.next_blocks(blocks)
    sums = np.zeros((film.planes, 1, len(item.pixels)), np.float32)
    for k in range(BLOCK):
        sums += radiance(item.region, k, 0, film.planes, item.pixels)
    film.add_blocks(sums)


def uneven(limits, blocks=100, film=None):
    """A film whose pixels go on to their limits, in items of so many blocks."""
    film = film or add(Film(REGION, AOV_PLANES), BLOCK)
    film.allow(limits)
    while not film.settled:
        add_blocks(film, blocks)
    return film


def some_limits(seed=3):
    rng = np.random.default_rng(seed)
    return BLOCK * rng.integers(1, 6, (REGION[3] - REGION[1], REGION[2] - REGION[0]))


def test_each_pixel_has_the_bits_of_a_film_of_its_own_number():
    limits = some_limits()
    film = uneven(limits)
    assert (film.counts == limits).all() and film.most_samples == limits.max()
    assert film.samples == int(limits.mean())
    assert (make_passes(film, ["sample_count"])["Sample Count"][..., 0] == limits).all()
    lean = tuple(name for name in USUAL if name != "error")  # pooled over pixels
    made = make_passes(film, lean)
    for count in np.unique(limits):
        even = make_passes(add(Film(REGION, AOV_PLANES), int(count)), lean)
        for name in made:
            assert (made[name] == even[name])[limits == count].all(), name


def test_replicates_of_uneven_films_are_counted():
    film = uneven(some_limits())
    even, odd = film.replicate_samples
    assert (even == film.counts / 2).all() and (odd == even).all()
    assert film.paths == film.counts.sum()


@settings(max_examples=8, deadline=None)
@given(st.integers(1, 1000), st.integers(1, 3))
def test_the_size_of_items_does_not_matter(blocks, seed):
    assert bits(uneven(some_limits(seed), blocks)) == bits(uneven(some_limits(seed)))


def test_items_give_each_pixel_one_block_a_turn():
    film = add(Film(REGION, COMBINED_PLANES), BLOCK)
    film.allow(some_limits())
    listed = film.next_blocks(1 << 20).pixels
    assert len(listed) == (film.limits - film.ends).sum() // BLOCK
    x, y, first = listed.T
    assert (np.diff(first) >= 0).all() and (first < film.limits[y - REGION[1], x - REGION[0]]).all()
    assert len(np.unique(listed, axis=0)) == len(listed)
    film.add_blocks(np.zeros((film.planes, 1, 77), np.float32))
    assert (film.next_blocks(1 << 20).pixels == listed[77:]).all()


def test_turns_take_any_number_of_blocks():
    rng = np.random.default_rng(1)
    turn, given = first_turn(rng.integers(0, 9, (9, 20))), []
    lacking = int(turn.lacks.sum())
    while len(turn.pixels):
        parts, turn = turn.give(int(rng.integers(1, 200)))
        assert all(len(np.unique(part.pixels)) == len(part.pixels) for part in parts)
        given += [np.stack([part.pixels, part.lacks]) for part in parts]
    given = np.concatenate(given, axis=1)
    assert given.shape[1] == lacking == len(np.unique(given, axis=1).T)


@pytest.mark.parametrize("blocks", [0, 17, 143, 200])
def test_a_checkpoint_within_a_turn_goes_on(tmp_path, blocks):
    limits, film = some_limits(), add(Film(REGION, AOV_PLANES), BLOCK)
    film.allow(limits)
    if blocks:
        add_blocks(film, blocks)
    film.save(tmp_path / "film.npz", "scene", PRINT)
    film = load_film(tmp_path / "film.npz", "scene", PRINT)
    assert film.paths == film.counts.sum()
    while not film.settled:
        add_blocks(film, 50)
    assert bits(film) == bits(uneven(limits))


def test_parts_of_uneven_films_merge():
    limits = some_limits()
    begin = add(Film(REGION, AOV_PLANES), BLOCK)
    left = np.where(np.arange(limits.shape[1]) < 5, limits, BLOCK)
    right = np.where(np.arange(limits.shape[1]) < 5, BLOCK, limits)
    full = np.full(limits.shape, BLOCK)
    parts = [begin] + [uneven(half, film=Film(REGION, AOV_PLANES, full)) for half in (left, right)]
    more = uneven(limits + BLOCK, film=Film(REGION, AOV_PLANES, limits))
    whole = bits(uneven(limits + BLOCK))
    assert bits(merge([more, *parts])) == bits(merge([merge(parts), more])) == whole
    with pytest.raises(FilmError, match="gap"):
        merge([parts[0], parts[1], more])
    with pytest.raises(FilmError, match="overlap"):
        merge([*parts, parts[1]])
    with pytest.raises(FilmError, match="between blocks only"):
        merge([uneven(full, film=Film(REGION, AOV_PLANES, 0 * full)), add(Film(REGION, AOV_PLANES, BLOCK), 3)])


@pytest.mark.parametrize("misuse", [
    lambda film: add(film, 3).allow(some_limits()), lambda film: film.allow(some_limits() + 1),
    lambda film: film.allow(some_limits()[1:]), lambda film: Film(REGION, film.planes, np.full((11, 13), 3)),
    lambda film: uneven(some_limits(), film=film).add_samples(1),
    lambda film: uneven(some_limits(), film=film).add_blocks(np.zeros((film.planes, 1, 1), np.float32))])
def test_misuse_is_refused(misuse):
    with pytest.raises(FilmError):
        misuse(Film(REGION, COMBINED_PLANES))


def noisy(shape=(40, 48), seed=1):
    """A film of two blocks: calm to the left, rough to the right."""
    film, rng = Film((0, 0, shape[1], shape[0]), COMBINED_PLANES), np.random.default_rng(seed)
    rough = np.where(np.arange(shape[1]) < shape[1] // 2, 0.2, 2.0)
    for _ in range(2):
        film.open[:8] = BLOCK / 2 * (1.0 + rough * rng.standard_normal((8, *shape)) / np.sqrt(BLOCK / 2))
        film.add_samples(BLOCK)
    return film


def test_no_pixel_has_a_say_in_its_own_number():
    film = noisy()
    before = next_limits(film, 0.02, 1 << 20)
    for row, column in ((3, 30), (20, 5), (0, 0), (39, 47)):
        other = noisy()
        for plane in range(3):
            other.totals[plane].hi[row, column] += 1e4
        after = next_limits(other, 0.02, 1 << 20)
        same = np.indices(after.shape).sum(0) % 2 == (row + column) % 2
        assert (after == before)[same].all()
        assert (after != before).any()


def test_samples_go_where_noise_is():
    film = noisy()
    limits = next_limits(film, 0.02, 1 << 20)
    assert GROWTH[0] <= limits.mean() / film.samples <= 1.05 * GROWTH[1]
    assert (limits % BLOCK == 0).all() and limits.min() >= 2 * BLOCK
    assert (limits[:, 32:] > 2 * BLOCK).mean() > 0.2 and (limits[:, :16] == 2 * BLOCK).all()


def test_decisions_end_at_the_most_samples():
    film = noisy((5, 7))
    for _ in range(100):
        if np.all(film.now() == 6 * BLOCK):
            break
        film.allow(next_limits(film, 1e-3, 6 * BLOCK + 30))
        while not film.settled:
            blocks = len(film.next_blocks(20).pixels)
            film.add_blocks(np.random.default_rng(0).random((film.planes, 1, blocks), np.float32))
    assert (film.now() == 6 * BLOCK).all()


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1), (2, 2), (3, 17)])
@pytest.mark.parametrize("value", [0.0, 1.0, np.inf])
def test_small_black_calm_and_broken_pictures_get_their_samples(shape, value):
    film = Film((3, 5, 3 + shape[1], 5 + shape[0]), COMBINED_PLANES)
    film.open[:] = value
    film.add_samples(BLOCK)
    with np.errstate(invalid="ignore"):
        limits = next_limits(film, 0.01, 1 << 20)
    assert (limits % BLOCK == 0).all() and limits.sum() > BLOCK * limits.size


def test_the_price_leaves_the_wanted_share_within_the_error():
    k = np.exp(np.random.default_rng(5).normal(4.0, 1.5, (200, 200)))
    wanted = wanted_samples_of(k)
    z = np.random.default_rng(6).standard_normal(k.shape)
    assert abs((np.abs(z) * np.sqrt(k / wanted) < 1.0).mean() - SHARE) < 0.004
    assert price_of(k) * 4 == pytest.approx(price_of(k / 4), rel=0.05)


def wanted_samples_of(k):
    return k * X[at_price(price_of(k), k)]


@pytest.mark.parametrize("price", [1e-9, 1e-3, 0.7, 1e4])
def test_the_table_looked_up_in_sorted_numbers(price):
    k = np.sort(np.exp(np.random.default_rng(8).normal(0.0, 3.0, 5000)))
    k[:3], k[100:200] = 0.0, k[100]
    assert (within_at_price(price, k) == WITHIN[at_price(price, k)]).all()


def test_wanted_samples_scale_with_the_error():
    seen = Luminance(np.ones((16, 24)), np.random.default_rng(2).chisquare(1, (16, 24)), (0, 0))
    counts = np.full((16, 24), 64)
    ratio = wanted_samples(seen, counts, 0.1) / wanted_samples(seen, counts, 0.2)
    assert np.allclose(ratio, 4.0, rtol=0.1)


# ------------------------------------------------------------------ sessions


def test_a_render_reaches_its_error_and_says_how_many_samples_it_took():
    session = rendered(**TARGET)
    result = session.result()
    assert result["why_stopped"] == "error" and result["error_95"] <= 0.06
    assert result["most_samples"] > result["samples"] == session.film.samples > BLOCK
    assert claim_of(session.film).most.value == result["error_95"]


@pytest.mark.parametrize("step,blocks", [(1, 50), (64, 200)])
def test_items_and_restarts_do_not_change_the_bits(monkeypatch, tmp_path, step, blocks):
    whole = rendered(**TARGET)
    monkeypatch.setattr("isophote.session.choose_step", lambda *seconds: step)
    monkeypatch.setattr("isophote.session.choose_blocks", lambda *seconds: blocks)
    other = rendered(**TARGET)
    assert bits(other.film) == bits(whole.film)
    part = Session(tiny_scene(), of(**TARGET), NoiseDevice())
    while not (part.film.ends is not None and part.film.most_samples > 4 * BLOCK and not part.film.settled):
        assert not part.step().why_stopped
    part.film.save(tmp_path / "film.npz", part.scene_hash, part.settings.fingerprint())
    film = load_film(tmp_path / "film.npz", part.scene_hash, of(**TARGET).fingerprint())
    resumed = Session(tiny_scene(), of(**TARGET), NoiseDevice(), film)
    resumed.run()
    assert bits(film) == bits(whole.film)


def test_samples_are_the_most_that_a_pixel_gets():
    session = rendered(400, error_target=1e-4)
    assert session.why_stopped == "samples" and (session.film.counts == 384).all()


def test_uniform_renders_give_every_pixel_as_many():
    session = rendered(adaptive=False, **TARGET)
    assert session.film.ends is None and session.result()["most_samples"] == session.result()["samples"]


def test_an_uneven_film_is_levelled_without_a_wanted_error():
    film = rendered(**TARGET).film
    session = Session(tiny_scene(), of(film.most_samples + BLOCK), NoiseDevice(), film)
    session.run()
    assert len(np.unique(film.counts)) == 1 and session.why_stopped == "samples"


def test_cancelled_and_failed_renders_know_their_samples():
    session = Session(tiny_scene(), of(samples=100_000, error_target=1e-3), NoiseDevice(delay=0.001))
    threading.Timer(0.5, session.cancel).start()
    assert session.run().why_stopped == "cancelled" and session.film.ends is not None
    film = session.film
    made = make_passes(film, ["combined"])["Combined"]
    for count in np.unique(film.counts):
        even = make_passes(rendered(int(count)).film, ["combined"])["Combined"]
        assert (made == even)[film.counts == count].all()


def test_the_cpu_goes_on_where_a_device_fails():
    failing = NoiseDevice(kind="opencl", fail_after=150)
    session = Session(tiny_scene(), of(**TARGET), failing)
    session.run()
    assert failing.closed and bits(session.film) == bits(rendered(**TARGET).film)
    assert sum(session.result()["samples_by_device"].values()) == pytest.approx(session.film.samples, abs=2)


def test_whether_it_was_adaptive_is_no_setting_of_the_samples():
    assert Settings(adaptive=False).fingerprint() == Settings().fingerprint()


class HitDevice(NoiseDevice):
    """Light comes in rare hits, one of fifty samples: each pixel's mean is 1."""

    def render(self, item, settings, sums, cancelled):
        x0, y0, x1, y1 = item.region
        y, x = np.mgrid[y0:y1, x0:x1]
        first = np.zeros(x.shape, int)
        if item.pixels is not None:
            x, y, first = (column[None] for column in item.pixels.T)
        for sample in range(item.first_sample, item.first_sample + item.samples):
            hit = 50.0 * (hashed(x, y, first + sample, settings.seed) < 0.02)
            sums[4 * (sample & 1):4 * (sample & 1) + 3] += hit.astype(np.float32)
        return item.samples


def test_pictures_of_rare_hits_are_neither_too_dark_nor_too_bright():
    means, sizes = [], []
    for seed in range(40):
        session = Session(tiny_scene(24, 20), of(4096, error_target=0.9, seed=seed), HitDevice())
        assert session.run().why_stopped == "error"
        means.append(make_passes(session.film, ["combined"])["Combined"][..., 0].mean())
        sizes.append(len(np.unique(session.film.counts)))
    assert min(sizes) > 1
    assert abs(np.mean(means) - 1.0) < 3.0 * np.std(means, ddof=1) / len(means) ** 0.5 + 0.002
    assert np.std(means, ddof=1) / len(means) ** 0.5 < 0.005
