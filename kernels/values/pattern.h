/* Textures without noise, as Cycles' svm/white_noise.h, svm/checker.h, svm/gradient.h, svm/wave.h, svm/magic.h and
 * svm/brick.h have them. */
#ifndef ISOPHOTE_VALUES_PATTERN_H
#define ISOPHOTE_VALUES_PATTERN_H
#include "../elementary.h"
#include "hash.h"
#include "value.h"

/* X(number, name, inputs, outputs) */
#define VALUES_PATTERN(X)   \
  X(140, random_1d, 1, 1)   \
  X(141, random_2d, 2, 1)   \
  X(142, random_3d, 3, 1)   \
  X(143, random_4d, 4, 1)   \
  X(144, checker, 3, 1)     \
  X(145, gradient, 3, 1)    \
  X(146, wave_profile, 1, 1) \
  X(147, magic, 5, 3)       \
  X(148, brick, 11, 2)      \
  X(149, pcg_2d, 2, 2)      \
  X(150, pcg_3d, 3, 3)      \
  X(151, pcg_4d, 4, 4)

VALUE(random_1d) { OUT(0) = random_of_1(IN(0)); }
VALUE(random_2d) { OUT(0) = random_of_2(IN(0), IN(1)); }
VALUE(random_3d) { OUT(0) = random_of_3(IN(0), IN(1), IN(2)); }
VALUE(random_4d) { OUT(0) = random_of_4(IN(0), IN(1), IN(2), IN(3)); }

/* Of whole numbers. */
VALUE(pcg_2d) {
  real2 v = pcg_2(IN(0), IN(1));
  OUT(0) = v.x;
  OUT(1) = v.y;
}
VALUE(pcg_3d) { OUT3(0, pcg_3(IN(0), IN(1), IN(2))) }
VALUE(pcg_4d) {
  real4 v = pcg_4(IN(0), IN(1), IN(2), IN(3));
  OUT(0) = v.x;
  OUT(1) = v.y;
  OUT(2) = v.z;
  OUT(3) = v.w;
}

/* Off the edges of cells, on which coordinates like to lie. */
FN real nudged(real x) { return (x + REAL(0.000001)) * REAL(0.999999); }
/* 1 where the floor of x is odd. Even and whole are all numbers beyond 2^24. */
FN real odd_of(real x) {
  real cell = floor(nudged(x));
  return cell - REAL(2.0) * floor(REAL(0.5) * cell);
}
VALUE(checker) {
  int odd = (odd_of(IN(0)) != odd_of(IN(1))) != (odd_of(IN(2)) > REAL(0.5));
  OUT(0) = odd ? REAL(1.0) : REAL(0.0);
}

/* What a step's number says; 0: linear. */
#define GRADIENT_QUADRATIC 1u
#define GRADIENT_EASING 2u
#define GRADIENT_DIAGONAL 3u
#define GRADIENT_RADIAL 4u
#define GRADIENT_QUADRATIC_SPHERE 5u
#define GRADIENT_SPHERICAL 6u

VALUE(gradient) {
  uint kind = uint_of(o.number);
  real3 p = IN3(0);
  real right = max_real(p.x, REAL(0.0)), eased = min_real(right, REAL(1.0));
  real inside = max_real(REAL(0.999999) - sqrt(dot3(p, p)), REAL(0.0));
  /* One select after the other: of a chain, compilers make a switch, which does not vectorise. */
  real f = p.x;
  f = kind == GRADIENT_QUADRATIC ? right * right : f;
  f = kind == GRADIENT_EASING ? eased * eased * (REAL(3.0) - REAL(2.0) * eased) : f;
  f = kind == GRADIENT_DIAGONAL ? (p.x + p.y) * REAL(0.5) : f;
  f = kind == GRADIENT_RADIAL ? atan2_real(p.y, p.x) / TWO_PI + REAL(0.5) : f;
  f = kind == GRADIENT_QUADRATIC_SPHERE ? inside * inside : f;
  f = kind == GRADIENT_SPHERICAL ? inside : f;
  OUT(0) = clamp01(f);
}

/* Sine, saw tooth or triangle of a phase in radians, as the step's number says; from 0 to 1. */
#define WAVE_SAW 1u
#define WAVE_TRIANGLE 2u
VALUE(wave_profile) {
  uint kind = uint_of(o.number);
  real turns = IN(0) / TWO_PI;
  real saw = turns - floor(turns);
  real within = saw < REAL(1.0) ? saw : REAL(0.0); /* of NaN too */
  real f = REAL(0.5) - REAL(0.5) * cos_real(TWO_PI * within);
  f = kind == WAVE_SAW ? saw : f;
  f = kind == WAVE_TRIANGLE ? fabs(turns - floor(turns + REAL(0.5))) * REAL(2.0) : f;
  OUT(0) = f;
}

/* Where sine and cosine are defined: whole turns off where there are many, 0 for what is beyond all measure. */
FN real wrap_angle(real x) {
  real r = fabs(x) > REAL(8000.0) ? x - floor(x / TWO_PI) * TWO_PI : x;
  return fabs(r) < REAL(8192.0) ? r : REAL(0.0);
}
/* The rest of a division by 2 pi with the sign of x, 2 pi in two parts of which few bits are set. */
FN real wrap_turn(real x) {
  real turns = floor(fabs(x) / TWO_PI);
  real r = (fabs(x) - turns * REAL(6.28125)) - turns * (TWO_PI - REAL(6.28125));
  r = r < TWO_PI ? r : REAL(0.0);
  return x < REAL(0.0) ? -r : r;
}

/* Step k changes one coordinate to the sine or cosine of a sum of all three. Bit k of these says how. */
#define MAGIC_MINUS_X 0x278u  /* 3 4 5 6 9: x is subtracted */
#define MAGIC_MINUS_Y 0x60eu  /* 1 2 3 9 10 */
#define MAGIC_MINUS_Z 0x11cu  /* 2 3 4 8 */
#define MAGIC_COSINE 0x2d6u   /* 1 2 4 6 7 9 */
#define MAGIC_NEGATIVE 0x672u /* 1 4 5 6 9 10 */
#define MAGIC_SETS_X 0x294u   /* 2 4 7 9 */
#define MAGIC_SETS_Z 0x108u   /* 3 8 */
#define MAGIC_BIT(mask) (((mask) >> k) & 1u)
/* A point, scale and distortion: as many steps as the texture is deep, and one that starts. */
VALUE(magic) {
  real scale = REAL(5.0) * IN(3), d = IN(4);
  real px = wrap_turn(IN(0)), py = wrap_turn(IN(1)), pz = wrap_turn(IN(2));
  real strength = o.repeat > 1u ? d : REAL(1.0);
  real x = k ? OUT(0) : strength * sin_real(wrap_angle((px + py + pz) * scale));
  real y = k ? OUT(1) : strength * cos_real(wrap_angle((-px + py - pz) * scale));
  real z = k ? OUT(2) : -strength * cos_real(wrap_angle((-px - py + pz) * scale));
  real sum = (MAGIC_BIT(MAGIC_MINUS_X) ? -x : x) + (MAGIC_BIT(MAGIC_MINUS_Y) ? -y : y) +
             (MAGIC_BIT(MAGIC_MINUS_Z) ? -z : z);
  real2 wave = sin_cos_real(wrap_angle(sum));
  real made = d * (MAGIC_BIT(MAGIC_COSINE) ? wave.y : wave.x);
  made = MAGIC_BIT(MAGIC_NEGATIVE) ? -made : made;
  int sets_x = MAGIC_BIT(MAGIC_SETS_X), sets_z = MAGIC_BIT(MAGIC_SETS_Z), sets_y = k > 0u && !sets_x && !sets_z;
  x = sets_x ? made : x;
  y = sets_y ? made : y;
  z = sets_z ? made : z;
  int last = k + 1u == o.repeat;
  real divisor = d != REAL(0.0) ? REAL(2.0) * d : REAL(1.0);
  OUT(0) = last ? REAL(0.5) - x / divisor : x;
  OUT(1) = last ? REAL(0.5) - y / divisor : y;
  OUT(2) = last ? REAL(0.5) - z / divisor : z;
}

FN real remainder_of(real x, real divisor) { return x - divisor * floor(x / divisor); }
/* The lowest 16 bits of a whole number; 0 for what is beyond all measure. */
FN uint low_bits(real x) {
  real m = remainder_of(x, REAL(65536.0));
  int fits = (m >= REAL(0.0)) & (m < REAL(65536.0));
  return uint_of(fits ? m : REAL(0.0));
}
FN real brick_tint(real row, real number) {
  uint n = ((low_bits(row) << 16) + low_bits(number) + 1013u) & 0x7fffffffu;
  n ^= n >> 13;
  return unit_of_31(n * (n * n * 60493u + 19990303u) + 1376312589u);
}
/* x and y, size and smoothness of mortar, bias, width of a brick, height of a row; offset and squash, each with the
 * number of rows after which it comes again. Makes the tint of the brick and the share of mortar. */
VALUE(brick) {
  real px = IN(0), py = IN(1), mortar = IN(2), smooth = IN(3), height = IN(6);
  real row = floor(py / height);
  real width = IN(5) * (remainder_of(row, IN(10)) == REAL(0.0) ? IN(9) : REAL(1.0));
  real shifted = px + (remainder_of(row, IN(8)) == REAL(0.0) ? width * IN(7) : REAL(0.0));
  real number = floor(shifted / width);
  real x = shifted - width * number, y = py - height * row;
  real edge = min_real(min_real(x, y), min_real(width - x, height - y));
  real t = clamp01((REAL(1.0) - edge / mortar) / (smooth != REAL(0.0) ? smooth : REAL(1.0)));
  real share = smooth != REAL(0.0) ? t * t * (REAL(3.0) - REAL(2.0) * t) : REAL(1.0);
  OUT(0) = clamp01(brick_tint(row, number) + IN(4));
  OUT(1) = edge >= mortar ? REAL(0.0) : share;
}

#endif
