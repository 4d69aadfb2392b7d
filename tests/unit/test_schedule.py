import pytest
from hypothesis import given
from hypothesis import strategies as st

from isophote.schedule import (
    BLOCK,
    WorkItem,
    choose_step,
    is_decision,
    next_decision,
    next_samples,
    sample_items,
    split,
)


@given(st.integers(0, 40), st.integers(1, 1000), st.integers(1, BLOCK))
def test_items_tile_the_range_in_order_within_blocks(first_block, count, step):
    first = first_block * BLOCK
    now = first
    for item in sample_items(first, first + count, step):
        assert item.first_sample == now
        assert 1 <= item.samples <= step
        assert item.first_sample // BLOCK == (item.end_sample - 1) // BLOCK
        now = item.end_sample
    assert now == first + count


def test_items_double_up_to_the_step():
    assert [item.samples for item in sample_items(0, 150, 32)] == [1, 1, 2, 4, 8, 16, 32, 32, 32, 22]


def test_items_after_a_cut_end_at_the_border():
    assert next_samples(0, 60, 200, 64) == 4
    assert next_samples(0, 200, 200, 64) == 0


@given(st.integers(1, 100_000), st.integers(1, 40), st.integers(0, 5))
def test_split_tiles_at_block_borders_and_is_even(samples, parts, first_block):
    first = first_block * BLOCK
    ranges = split(samples, parts, first)
    assert ranges[0][0] == first and ranges[-1][1] == first + samples
    assert all(a[1] == b[0] for a, b in zip(ranges, ranges[1:], strict=False))
    assert all(start % BLOCK == 0 and start < end for start, end in ranges)
    blocks = [-(-(end - start) // BLOCK) for start, end in ranges]
    assert max(blocks) - min(blocks) <= 1
    assert len(ranges) == min(parts, -(-samples // BLOCK))


@pytest.mark.parametrize(("seconds", "step"), [(0.0, 1), (10.0, 1), (0.35 / 5, 4), (1e-6, BLOCK)])
def test_step_fits_the_speed(seconds, step):
    assert choose_step(seconds) == step


@pytest.mark.parametrize(("region", "first", "count"), [((0, 0, 1, 1), 60, 8), ((0, 0, 1, 1), 0, 0),
                                                        ((3, 0, 3, 1), 0, 1), ((-1, 0, 1, 1), 0, 1)])
def test_impossible_items_are_refused(region, first, count):
    with pytest.raises(ValueError, match="region|samples"):
        WorkItem(region, first, count)


def test_split_refuses_a_start_within_a_block():
    with pytest.raises(ValueError, match="border"):
        split(100, 2, first=10)


def test_decisions_are_fixed_numbers_of_samples():
    assert [n for n in range(0, 130) if is_decision(n)] == [16, 20, 24, 28, 32, 40, 48, 56, 64, 80, 96, 112, 128]
    for n in range(0, 5000):
        assert next_decision(n) == next(m for m in range(n + 1, 2 * n + 20) if is_decision(m))
    assert all(n % BLOCK == 0 for n in range(256, 5000) if is_decision(n))
