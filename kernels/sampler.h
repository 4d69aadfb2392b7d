/* Random numbers as a pure function of (pixel, sample, dimension, seed).
 *
 * Owen-scrambled Sobol points (Burley 2020, "Practical Hash-based Owen Scrambling", JCGT 9(4)): each
 * pair of dimensions is the two-dimensional Sobol sequence, whose order is shuffled and whose
 * coordinates are scrambled by hashes of the pair's number. Samples of even and odd number are two
 * independently scrambled replicates: their difference is the error bar. */
#ifndef ISOPHOTE_SAMPLER_H
#define ISOPHOTE_SAMPLER_H
#include "types.h"

/* Pairs of dimensions: those of the camera, then PAIRS_PER_BOUNCE for each bounce. */
#define PAIR_FILTER 0u
#define PAIR_LENS 1u
#define PAIR_FIRST_BOUNCE 2u
#define PAIR_TIME 0x40000000u /* of the shutter; the second is unused; no bounce comes so far */
#define PAIR_BSDF 0u     /* direction */
#define PAIR_LIGHT 1u    /* point on the light */
#define PAIR_CHOICE 2u   /* which light, which closure */
#define PAIR_ROULETTE 3u /* survival; the second is unused */
#define PAIRS_PER_BOUNCE 4u

/* Bijective mixing of 32 bits: Wellons' "lowbias32" (hash-prospector, 2018). */
FN uint hash_uint(uint x) {
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  x ^= x >> 16;
  return x;
}

FN uint reverse_bits(uint x) {
  x = (x << 16) | (x >> 16);
  x = ((x & 0x00ff00ffu) << 8) | ((x >> 8) & 0x00ff00ffu);
  x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
  x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
  x = ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
  return x;
}

/* Owen scrambling of a number whose bits are reversed: each bit is flipped by a hash of the bits below
 * it (Laine and Karras 2011, with the constants that N. Vegdahl found in 2021). */
FN uint scramble_reversed(uint x, uint seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}

/* Second dimension of Sobol's sequence with its bits reversed. The generator is Pascal's triangle
 * modulo 2, the substitution z -> z + 1 in a polynomial over GF(2), done by halving. */
FN uint sobol_second_reversed(uint index) {
  index ^= (index >> 16) & 0x0000ffffu;
  index ^= (index >> 8) & 0x00ff00ffu;
  index ^= (index >> 4) & 0x0f0f0f0fu;
  index ^= (index >> 2) & 0x33333333u;
  index ^= (index >> 1) & 0x55555555u;
  return index;
}

/* The 24 highest bits as a number in [0, 1 - 2^-24]. */
FN real unit_real(uint x) { return real_of(x >> 8) * REAL(5.9604644775390625e-8); }

FN uint pixel_seed(uint x, uint y, uint replicate, uint seed) {
  return hash_uint(x ^ hash_uint(y ^ hash_uint(seed * 2u + replicate + 0x9e3779b9u)));
}

/* Two numbers of sample `index` of the replicate whose pixel seed is given. */
FN real2 sample_pair(uint seed, uint index, uint pair) {
  uint order = hash_uint(seed ^ (pair * 0x9e3779b9u + 0x7f4a7c15u));
  uint first = hash_uint(order ^ 0x68bc21ebu);
  uint second = hash_uint(order ^ 0x02e5be93u);
  uint shuffled = reverse_bits(scramble_reversed(reverse_bits(index), order));
  uint x = reverse_bits(scramble_reversed(shuffled, first));
  uint y = reverse_bits(scramble_reversed(sobol_second_reversed(shuffled), second));
  return make_real2(unit_real(x), unit_real(y));
}

FN real2 sample_bounce(uint seed, uint index, int bounce, uint pair) {
  return sample_pair(seed, index, PAIR_FIRST_BOUNCE + uint_of(bounce) * PAIRS_PER_BOUNCE + pair);
}

#define FILTER_STEPS 1024 /* the table has one entry more */
#define SHUTTER_TABLE (FILTER_STEPS + 1) /* where the shutter's begins, which is as long */

/* Offset from the pixel's centre in widths of the filter, drawn in proportion to the pixel filter (importance
 * sampling of the filter: Ernst, Stamminger and Greiner 2006); all samples then have equal weight. */
FN real sample_filter(GLOBAL const float *table, real u) {
  real x = u * REAL(1024.0);
  int i = int_of(x);
  real a = to_real(table[i]), b = to_real(table[i + 1]);
  return a + (b - a) * (x - real_of(i));
}

#endif
