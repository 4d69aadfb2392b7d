/* Gradient noise in one to four dimensions (Perlin 2002, "Improving Noise"), and sums of its octaves (Musgrave, in Ebert
 * et al. 2003, "Texturing and Modeling", chapter 16), as Cycles' svm/noise.h and svm/fractal_noise.h have them.
 *
 * A step adds one octave and is repeated; what it keeps between octaves are its outputs. */
#ifndef ISOPHOTE_VALUES_NOISE_H
#define ISOPHOTE_VALUES_NOISE_H
#include "../elementary.h"
#include "hash.h"
#include "value.h"

/* X(number, name, inputs, outputs) */
#define VALUES_NOISE(X)     \
  X(128, noise_1d, 6, 5)    \
  X(129, noise_2d, 7, 5)    \
  X(130, noise_3d, 8, 5)    \
  X(131, noise_4d, 9, 5)    \
  X(132, perlin_1d, 1, 1)   \
  X(133, perlin_2d, 2, 1)   \
  X(134, perlin_3d, 3, 1)   \
  X(135, perlin_4d, 4, 1)   \
  X(136, positive_power, 2, 1)

#define NOISE_PERIOD REAL(100000.0)
#define MANY_PERIODS REAL(409600000.0) /* 4096, so that products with whole numbers have few bits and are exact */

/* A coordinate in the period in which cells are told apart, with the sign of p; half a cell on where p is so large that
 * it is a whole number. 0 counts for NaN and what is beyond all measure. */
FN real wrap_noise(real p) {
  real size = fabs(p);
  real r = size < REAL(1e15) ? size : REAL(0.0);
  r = r - floor(r / MANY_PERIODS) * MANY_PERIODS;
  r = r - floor(r * REAL(1e-5)) * NOISE_PERIOD;
  r = r < REAL(0.0) ? r + NOISE_PERIOD : r;
  r = r >= NOISE_PERIOD ? r - NOISE_PERIOD : r;
  return (p < REAL(0.0) ? -r : r) + (size >= REAL(1000000.0) ? REAL(0.5) : REAL(0.0));
}

FN uint cell_of(real floored) { return uint_of(int_of(floored)); }
FN real fade(real t) { return t * t * t * (t * (t * REAL(6.0) - REAL(15.0)) + REAL(10.0)); }
FN real between(real a, real b, real t) { return a + t * (b - a); }
FN real signed_by(uint minus, real x) { return minus ? -x : x; }

/* A corner's gradient, chosen by its hash, times the way from the corner. */
FN real slope_1(uint hash, real x) { return signed_by(hash & 8u, real_of(1u + (hash & 7u)) * x); }
FN real slope_2(uint hash, real x, real y) {
  int first = (hash & 7u) < 4u;
  return signed_by(hash & 1u, first ? x : y) + signed_by(hash & 2u, REAL(2.0) * (first ? y : x));
}
FN real slope_3(uint hash, real x, real y, real z) {
  uint h = hash & 15u;
  int turned = (h == 12u) | (h == 14u);
  return signed_by(h & 1u, h < 8u ? x : y) + signed_by(h & 2u, h < 4u ? y : turned ? x : z);
}
FN real slope_4(uint hash, real x, real y, real z, real w) {
  uint h = hash & 31u;
  return signed_by(h & 1u, h < 24u ? x : y) + signed_by(h & 2u, h < 16u ? y : z) + signed_by(h & 4u, h < 8u ? z : w);
}

/* Noise in about [-1, 1]; the factors are those of Open Shading Language. */
FN real signed_noise_1(real px) {
  real x = wrap_noise(px), fx = floor(x);
  uint i = cell_of(fx);
  x = x - fx;
  return REAL(0.25) * between(slope_1(hash_1(i), x), slope_1(hash_1(i + 1u), x - REAL(1.0)), fade(x));
}

FN real signed_noise_2(real px, real py) {
  real x = wrap_noise(px), y = wrap_noise(py), fx = floor(x), fy = floor(y);
  uint i = cell_of(fx), j = cell_of(fy);
  x = x - fx;
  y = y - fy;
  real x1 = x - REAL(1.0), y1 = y - REAL(1.0), u = fade(x);
  real low = between(slope_2(hash_2(i, j), x, y), slope_2(hash_2(i + 1u, j), x1, y), u);
  real high = between(slope_2(hash_2(i, j + 1u), x, y1), slope_2(hash_2(i + 1u, j + 1u), x1, y1), u);
  return REAL(0.6616) * between(low, high, fade(y));
}

FN real noise_row_3(uint i, uint j, uint k, real x, real y, real z, real u) {
  return between(slope_3(hash_3(i, j, k), x, y, z), slope_3(hash_3(i + 1u, j, k), x - REAL(1.0), y, z), u);
}
FN real signed_noise_3(real px, real py, real pz) {
  real x = wrap_noise(px), y = wrap_noise(py), z = wrap_noise(pz), fx = floor(x), fy = floor(y), fz = floor(z);
  uint i = cell_of(fx), j = cell_of(fy), k = cell_of(fz);
  x = x - fx;
  y = y - fy;
  z = z - fz;
  real y1 = y - REAL(1.0), z1 = z - REAL(1.0), u = fade(x), v = fade(y);
  real low = between(noise_row_3(i, j, k, x, y, z, u), noise_row_3(i, j + 1u, k, x, y1, z, u), v);
  real high = between(noise_row_3(i, j, k + 1u, x, y, z1, u), noise_row_3(i, j + 1u, k + 1u, x, y1, z1, u), v);
  return REAL(0.982) * between(low, high, fade(z));
}

FN real noise_row_4(uint i, uint j, uint k, uint l, real x, real y, real z, real w, real u) {
  return between(slope_4(hash_4(i, j, k, l), x, y, z, w), slope_4(hash_4(i + 1u, j, k, l), x - REAL(1.0), y, z, w), u);
}
FN real noise_face_4(uint i, uint j, uint k, uint l, real x, real y, real z, real w, real u, real v) {
  return between(noise_row_4(i, j, k, l, x, y, z, w, u), noise_row_4(i, j + 1u, k, l, x, y - REAL(1.0), z, w, u), v);
}
FN real signed_noise_4(real px, real py, real pz, real pw) {
  real x = wrap_noise(px), y = wrap_noise(py), z = wrap_noise(pz), w = wrap_noise(pw);
  real fx = floor(x), fy = floor(y), fz = floor(z), fw = floor(w);
  uint i = cell_of(fx), j = cell_of(fy), k = cell_of(fz), l = cell_of(fw);
  x = x - fx;
  y = y - fy;
  z = z - fz;
  w = w - fw;
  real z1 = z - REAL(1.0), w1 = w - REAL(1.0), u = fade(x), v = fade(y), t = fade(z);
  real low = between(noise_face_4(i, j, k, l, x, y, z, w, u, v), noise_face_4(i, j, k + 1u, l, x, y, z1, w, u, v), t);
  real high = between(noise_face_4(i, j, k, l + 1u, x, y, z, w1, u, v),
                      noise_face_4(i, j, k + 1u, l + 1u, x, y, z1, w1, u, v), t);
  return REAL(0.8344) * between(low, high, fade(w));
}

VALUE(perlin_1d) { OUT(0) = signed_noise_1(IN(0)); }
VALUE(perlin_2d) { OUT(0) = signed_noise_2(IN(0), IN(1)); }
VALUE(perlin_3d) { OUT(0) = signed_noise_3(IN(0), IN(1), IN(2)); }
VALUE(perlin_4d) { OUT(0) = signed_noise_4(IN(0), IN(1), IN(2), IN(3)); }

/* How a step adds its octaves: its number, plus NOISE_NORMALIZED. */
#define NOISE_FBM 0u
#define NOISE_MULTIFRACTAL 1u
#define NOISE_HYBRID 2u
#define NOISE_RIDGED 3u
#define NOISE_TERRAIN 4u
#define NOISE_NORMALIZED 8u

typedef struct {
  real detail, roughness, lacunarity, offset, gain;
} NoiseShape;

/* What is known after some octaves. `sum` is also the weight of hybrid noise, the signal of ridged noise. */
typedef struct {
  real value, amplitude, frequency, sum, largest;
} Octaves;

FN Octaves start_octaves(uint kind) {
  Octaves o;
  o.value = kind == NOISE_MULTIFRACTAL ? REAL(1.0) : REAL(0.0);
  o.amplitude = REAL(1.0);
  o.frequency = REAL(1.0);
  o.sum = kind == NOISE_HYBRID ? REAL(1.0) : REAL(0.0);
  o.largest = REAL(0.0);
  return o;
}

/* Adds octave k, where noise is n: whole octaves up to the whole part of detail, then its fraction of one more. */
FN Octaves add_octave(Octaves o, NoiseShape s, real n, uint mode, uint k) {
  uint kind = mode & 7u;
  real whole = floor(s.detail), fraction = s.detail - whole, number = real_of(k);
  real last = kind == NOISE_TERRAIN ? max_real(whole, REAL(0.0)) : whole;
  int is_whole = number <= whole, is_part = number == last + REAL(1.0);
  real part = is_whole ? REAL(1.0) : is_part ? fraction : REAL(0.0);

  /* fBm, and scaled to [0, 1] */
  real sum = o.sum + o.amplitude * n, largest = o.largest + o.amplitude;
  real scaled = REAL(0.5) * sum / largest + REAL(0.5);
  real fuller = (mode & NOISE_NORMALIZED) ? scaled : sum;
  real fbm = is_whole ? fuller : between(o.value, fuller, part);
  /* multifractal */
  real product = o.value * (part * o.amplitude * n + REAL(1.0));
  /* heterogeneous terrain: the first octave is not scaled by what is there */
  real raised = n + s.offset;
  real terrain = k ? o.value + part * (raised * o.amplitude * o.value) : raised;
  /* hybrid multifractal: each octave is weighted by the one before, until that is next to nothing */
  real signal = raised * o.amplitude, weight = min_real(o.sum, REAL(1.0));
  int counts = (o.sum > REAL(0.001)) & (part > REAL(0.0));
  real hybrid = counts ? o.value + part * weight * signal : o.value;
  real next_weight = counts ? weight * (s.gain * signal) : o.sum;
  /* ridged multifractal: no fraction of an octave */
  real ridge = square(s.offset - fabs(n)) * (k ? clamp01(o.sum * s.gain) : REAL(1.0));
  int adds = (k == 0u) | is_whole;
  real ridged = adds ? o.value + ridge * o.amplitude : o.value;

  /* One select after the other: of a chain, compilers make a switch, which does not vectorise. */
  Octaves next = o;
  next.value = kind == NOISE_FBM ? fbm : next.value;
  next.value = kind == NOISE_MULTIFRACTAL ? product : next.value;
  next.value = kind == NOISE_HYBRID ? hybrid : next.value;
  next.value = kind == NOISE_RIDGED ? ridged : next.value;
  next.value = kind == NOISE_TERRAIN ? terrain : next.value;
  next.sum = kind == NOISE_FBM ? sum : next.sum;
  next.sum = kind == NOISE_HYBRID ? next_weight : next.sum;
  next.sum = kind == NOISE_RIDGED ? ridge : next.sum;
  next.largest = largest;
  next.amplitude = o.amplitude * s.roughness;
  next.frequency = o.frequency * s.lacunarity;
  return next;
}

FN Octaves load_octaves(ValueStep o, const real *r, uint k) {
  Octaves at = start_octaves(uint_of(o.number) & 7u);
  at.value = k ? OUT(0) : at.value;
  at.amplitude = k ? OUT(1) : at.amplitude;
  at.frequency = k ? OUT(2) : at.frequency;
  at.sum = k ? OUT(3) : at.sum;
  at.largest = k ? OUT(4) : at.largest;
  return at;
}

FN NoiseShape load_shape(ValueStep o, const real *r, uint first) {
  NoiseShape s;
  s.detail = IN(first);
  s.roughness = IN(first + 1u);
  s.lacunarity = IN(first + 2u);
  s.offset = IN(first + 3u);
  s.gain = IN(first + 4u);
  return s;
}

#define NOISE(name, dimensions, noise)                                                               \
  VALUE(name) {                                                                                      \
    Octaves before = load_octaves(o, r, k);                                                          \
    real f = before.frequency;                                                                       \
    Octaves after = add_octave(before, load_shape(o, r, dimensions), noise, uint_of(o.number), k);   \
    OUT(0) = after.value;                                                                            \
    OUT(1) = after.amplitude;                                                                        \
    OUT(2) = after.frequency;                                                                        \
    OUT(3) = after.sum;                                                                              \
    OUT(4) = after.largest;                                                                          \
  }

/* A point, then detail, roughness, lacunarity, offset and gain: noise of so many octaves as the step is repeated. */
NOISE(noise_1d, 1u, signed_noise_1(f * IN(0)))
NOISE(noise_2d, 2u, signed_noise_2(f * IN(0), f * IN(1)))
NOISE(noise_3d, 3u, signed_noise_3(f * IN(0), f * IN(1), f * IN(2)))
NOISE(noise_4d, 4u, signed_noise_4(f * IN(0), f * IN(1), f * IN(2), f * IN(3)))
#undef NOISE

/* The first, which is not negative, to the power of the second. */
VALUE(positive_power) { OUT(0) = pow_real(IN(0), IN(1)); }

#endif
