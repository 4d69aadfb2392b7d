/* Hashes of words and of numbers, for textures: those of Cycles (its util/hash.h), or pictures would differ.
 *
 * One to four words become one by the last steps of B. Jenkins' lookup3 (2006). */
#ifndef ISOPHOTE_VALUES_HASH_H
#define ISOPHOTE_VALUES_HASH_H
#include "../types.h"

#define ROTATED(x, k) (((x) << (k)) | ((x) >> (32u - (k))))
#define HASH_START(words) (0xdeadbeefu + 4u * (words) + 13u)

FN uint finish_hash(uint a, uint b, uint c) {
  c = (c ^ b) - ROTATED(b, 14u);
  a = (a ^ c) - ROTATED(c, 11u);
  b = (b ^ a) - ROTATED(a, 25u);
  c = (c ^ b) - ROTATED(b, 16u);
  a = (a ^ c) - ROTATED(c, 4u);
  b = (b ^ a) - ROTATED(a, 14u);
  return (c ^ b) - ROTATED(b, 24u);
}

FN uint hash_1(uint x) { return finish_hash(HASH_START(1u) + x, HASH_START(1u), HASH_START(1u)); }
FN uint hash_2(uint x, uint y) { return finish_hash(HASH_START(2u) + x, HASH_START(2u) + y, HASH_START(2u)); }
FN uint hash_3(uint x, uint y, uint z) {
  return finish_hash(HASH_START(3u) + x, HASH_START(3u) + y, HASH_START(3u) + z);
}
/* The first three words are mixed before the fourth comes in. */
FN uint hash_4(uint x, uint y, uint z, uint w) {
  uint a = HASH_START(4u) + x, b = HASH_START(4u) + y, c = HASH_START(4u) + z;
  a = (a - c) ^ ROTATED(c, 4u);
  c += b;
  b = (b - a) ^ ROTATED(a, 6u);
  a += c;
  c = (c - b) ^ ROTATED(b, 8u);
  b += a;
  a = (a - c) ^ ROTATED(c, 16u);
  c += b;
  b = (b - a) ^ ROTATED(a, 19u);
  a += c;
  c = (c - b) ^ ROTATED(b, 4u);
  b += a;
  return finish_hash(a + w, b, c);
}

/* All NaNs are one: devices make them with other bits. */
FN uint word_of(real x) { return x == x ? bits_of_float(to_float(x)) : 0x7fc00000u; }
/* In [0, 1]. */
FN real unit_of(uint hash) { return real_of(hash) * REAL(2.3283064365386963e-10); }

FN real random_of_1(real x) { return unit_of(hash_1(word_of(x))); }
FN real random_of_2(real x, real y) { return unit_of(hash_2(word_of(x), word_of(y))); }
FN real random_of_3(real x, real y, real z) { return unit_of(hash_3(word_of(x), word_of(y), word_of(z))); }
FN real random_of_4(real x, real y, real z, real w) {
  return unit_of(hash_4(word_of(x), word_of(y), word_of(z), word_of(w)));
}

/* Jarzynski and Olano 2020, "Hash Functions for GPU Rendering": as many numbers in [0, 1] as there are whole numbers, of
 * 31 bits and with signed shifts, as Cycles hashes cells since Blender 5.0. */
FN uint pcg_start(real x) { return uint_of(int_of(fabs(x) < REAL(2.0e9) ? x : REAL(0.0))) * 1664525u + 1013904223u; }
FN uint pcg_fold(uint x) { return x ^ uint_of(int_of(x) >> 16); }
FN real unit_of_31(uint hash) { return real_of(int_of(hash & 0x7fffffffu)) * REAL(4.656612873077393e-10); }

FN real2 pcg_2(real px, real py) {
  uint x = pcg_start(px), y = pcg_start(py);
  x += y * 1664525u;
  y += x * 1664525u;
  x = pcg_fold(x);
  y = pcg_fold(y);
  x += y * 1664525u;
  y += x * 1664525u;
  return make_real2(unit_of_31(x), unit_of_31(y));
}
FN real3 pcg_3(real px, real py, real pz) {
  uint x = pcg_start(px), y = pcg_start(py), z = pcg_start(pz);
  x += y * z;
  y += z * x;
  z += x * y;
  x = pcg_fold(x);
  y = pcg_fold(y);
  z = pcg_fold(z);
  x += y * z;
  y += z * x;
  z += x * y;
  return make_real3(unit_of_31(x), unit_of_31(y), unit_of_31(z));
}
FN real4 pcg_4(real px, real py, real pz, real pw) {
  uint x = pcg_start(px), y = pcg_start(py), z = pcg_start(pz), w = pcg_start(pw);
  x += y * w;
  y += z * x;
  z += x * y;
  w += y * z;
  x = pcg_fold(x);
  y = pcg_fold(y);
  z = pcg_fold(z);
  w = pcg_fold(w);
  x += y * w;
  y += z * x;
  z += x * y;
  w += y * z;
  return make_real4(unit_of_31(x), unit_of_31(y), unit_of_31(z), unit_of_31(w));
}

#endif
