"""The sampler: nets, scrambling, independence of pairs, pixels and replicates; an own implementation in numpy, and the
kernel's, compiled by the first C++ compiler, which must be equal bit for bit."""

import ctypes
import re

import numpy as np
import pytest
from scipy import stats

from tests.kernel_lib import ROOT, compiled

U = np.uint32
PIXELS, PER_PIXEL = 64, 256
SIGNIFICANCE = 1e-6

PROBE = """
#include "sampler.h"
extern "C" void probe(unsigned x, unsigned y, unsigned replicate, unsigned seed, unsigned pair, int n,
                      const unsigned *index, float *out) {
  unsigned pixel = pixel_seed(x, y, replicate, seed);
  for (int i = 0; i < n; i++) {
    real2 u = sample_pair(pixel, index[i], pair);
    out[2 * i] = u.x;
    out[2 * i + 1] = u.y;
  }
}
"""


# ------------------------------------------------------------------ numpy


def mixed(x):
    """lowbias32 (Wellons 2018)."""
    x = np.asarray(x, U)
    x = (x ^ x >> U(16)) * U(0x7FEB352D)
    x = (x ^ x >> U(15)) * U(0x846CA68B)
    return x ^ x >> U(16)


def reversed_bits(x):
    return np.array([int(f"{int(v):032b}"[::-1], 2) for v in np.ravel(x)], U).reshape(np.shape(x))


def scrambled(x, seed):
    """Each bit flipped by a hash of the bits below it (Laine and Karras 2011; Vegdahl's constants)."""
    x = x ^ x * U(0x3D20ADEA)
    x = (x + seed) * (seed >> U(16) | U(1))
    x = x ^ x * U(0x05526C56)
    return x ^ x * U(0x53A22864)


def second_sobol(index):
    """Second dimension by its direction numbers, v_k = v_(k-1) ^ (v_(k-1) >> 1): Joe and Kuo 2008, dimension 2."""
    directions, v = [], 1 << 31
    for _ in range(32):
        directions.append(v)
        v ^= v >> 1
    used = ([directions[k] for k in range(32) if int(i) >> k & 1] for i in index)
    return np.array([np.bitwise_xor.reduce([0, *those]) for those in used], U)


def seed_of(x, y, replicate, seed):
    with np.errstate(over="ignore"):
        return mixed(U(x) ^ mixed(U(y) ^ mixed(U(seed) * U(2) + U(replicate) + U(0x9E3779B9))))


def pair_of(pixel, index, pair):
    """Two numbers as unsigned 32 bits, (n, 2)."""
    with np.errstate(over="ignore"):
        order = mixed(pixel ^ (U(pair) * U(0x9E3779B9) + U(0x7F4A7C15)))
        shuffled = reversed_bits(scrambled(reversed_bits(index), order))
        x = scrambled(shuffled, mixed(order ^ U(0x68BC21EB)))
        y = scrambled(reversed_bits(second_sobol(shuffled)), mixed(order ^ U(0x02E5BE93)))
        return np.stack([reversed_bits(x), reversed_bits(y)], axis=1)


def to_float(bits):
    return (bits >> U(8)).astype(np.float32) * np.float32(2.0**-24)


# ------------------------------------------------------------------ the kernel


class Kernel:
    """sample_pair of kernels/sampler.h over arrays of sample numbers."""

    def __init__(self):
        self.probe = compiled(PROBE).probe

    def __call__(self, pair, index, x=3, y=5, replicate=0, seed=0):
        index = np.ascontiguousarray(index, U)
        out = np.empty((len(index), 2), np.float32)
        self.probe(*(ctypes.c_uint32(v) for v in (x, y, replicate, seed, pair)), len(index),
                   index.ctypes.data_as(ctypes.c_void_p), out.ctypes.data_as(ctypes.c_void_p))
        return out


@pytest.fixture(scope="module")
def kernel():
    return Kernel()


def test_kernel_is_the_one_in_numpy(kernel):
    rng = np.random.default_rng(1)
    for _ in range(40):
        x, y, seed = (int(v) for v in rng.integers(0, 2**32, 3))
        pair, replicate = int(rng.integers(0, 1024)), int(rng.integers(2))
        index = np.concatenate([np.arange(20), rng.integers(0, 2**31, 40)]).astype(U)
        mine = to_float(pair_of(seed_of(x, y, replicate, seed), index, pair))
        np.testing.assert_array_equal(kernel(pair, index, x, y, replicate, seed), mine)


@pytest.mark.parametrize("bits", [0, 1, 4, 7, 10])
def test_pairs_are_nets(kernel, bits):
    """Every prefix of 2^m samples is a (0, m, 2)-net: each elementary interval of area 2^-m holds one point."""
    for pair in range(40):
        for replicate in (0, 1):
            points = kernel(pair, np.arange(1 << bits), x=pair, replicate=replicate)
            for split in range(bits + 1):
                cells = np.floor(points * (1 << split, 1 << (bits - split))).astype(int)
                assert len(np.unique(cells[:, 0] << (bits - split) | cells[:, 1])) == 1 << bits


def test_later_blocks_are_nets_too(kernel):
    """Any aligned block of 2^m samples, so that each item of work is well spread."""
    for block in (1, 5, 1000):
        points = kernel(3, np.arange(64) + 64 * block)
        for split in range(7):
            cells = np.floor(points * (1 << split, 1 << (6 - split))).astype(int)
            assert len(np.unique(cells[:, 0] << (6 - split) | cells[:, 1])) == 64


def test_values_stay_below_one(kernel):
    """Also where all bits are set; and they are multiples of 2^-24, exact in float32."""
    assert to_float(np.array([0xFFFFFFFF], U))[0] == 1 - 2.0**-24
    points = kernel(7, np.arange(1 << 16))
    assert points.min() >= 0 and points.max() < 1
    assert (points.astype(float) * 2**24 % 1 == 0).all()


def uniform_p_value(values):
    counts = np.histogram(values, 64, (0, 1))[0]
    return stats.chisquare(counts).pvalue


@pytest.mark.parametrize("index", [0, 1, 17, 1023])
def test_each_sample_is_uniform_over_pixels(kernel, index):
    """Scrambling is Owen's: one sample alone is uniform (over pixels, pairs and replicates), in the square as well."""
    points = np.concatenate([kernel(pair, [index], x, 9, replicate) for x in range(1000) for pair in (0, 3, 8)
                             for replicate in (0, 1)])
    assert uniform_p_value(points[:, 0]) > SIGNIFICANCE and uniform_p_value(points[:, 1]) > SIGNIFICANCE
    joint = np.histogram2d(*points.T, 8, ((0, 1), (0, 1)))[0]
    assert stats.chisquare(joint.ravel()).pvalue > SIGNIFICANCE


def independent_p_value(a, b):
    """Of a 8 x 8 table of pairs of numbers from sequences that should know nothing of each other."""
    return stats.chisquare(np.histogram2d(a, b, 8, ((0, 1), (0, 1)))[0].ravel()).pvalue


@pytest.mark.parametrize("other", [
    dict(pair=4), dict(pair=259), dict(x=4), dict(y=6), dict(replicate=1), dict(seed=1), dict(x=5, y=3),
], ids=str)
def test_sequences_are_independent(kernel, other):
    """Of pairs, pixels, replicates and seeds: tables over many pixels have no pattern. Each prefix of 16 samples is
    stratified, so one sample of each pixel is taken."""
    first, second = [], []
    for x in range(3000):
        place = dict(pair=3, x=x * 7, y=5, replicate=0, seed=0)
        moved = place | {k: v + (x * 7 if k == "x" else 0) for k, v in other.items()}
        first.append(kernel(index=[x % 64], **place)[0])
        second.append(kernel(index=[x % 64], **moved)[0])
    first, second = np.array(first), np.array(second)
    for a in (0, 1):
        for b in (0, 1):
            assert independent_p_value(first[:, a], second[:, b]) > SIGNIFICANCE
            assert abs(stats.pearsonr(first[:, a], second[:, b]).statistic) < 5 / np.sqrt(len(first))


def test_means_of_replicates_do_not_correlate(kernel):
    """The error bar is the replicates' difference: their errors of one integral are uncorrelated, and small."""
    errors = []
    for x in range(1500):
        means = [(np.prod(kernel(2, np.arange(16), x, 1, replicate), axis=1) ** 2).mean() for replicate in (0, 1)]
        errors.append(np.array(means) - 1 / 9)
    errors = np.array(errors)
    assert abs(stats.pearsonr(*errors.T).statistic) < 5 / np.sqrt(len(errors))
    assert np.abs(errors.mean(0)).max() < 5 * errors.std() / np.sqrt(len(errors))
    assert errors.std() < 0.5 * np.sqrt((1 / 25 - 1 / 81) / 16), "no better than random numbers"


def test_pairs_of_different_bounces_do_not_coincide():
    """The numbering of pairs in the header: none is used twice."""
    text = (ROOT / "kernels" / "sampler.h").read_text()
    number = {name: int(value) for name, value in re.findall(r"#define (PAIRS?_\w+) (\d+)u", text)}
    names = ("PAIR_BSDF", "PAIR_LIGHT", "PAIR_CHOICE", "PAIR_ROULETTE")
    of_bounce = {number[name] for name in names}
    assert len(of_bounce) == 4 and max(of_bounce) < number["PAIRS_PER_BOUNCE"]
    assert max(number["PAIR_FILTER"], number["PAIR_LENS"]) < number["PAIR_FIRST_BOUNCE"]
