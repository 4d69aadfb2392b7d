/* Elementary functions with the same bits on every device: polynomials and bit patterns, selects
 * instead of branches, no fma and no library. Polynomials are minimax fits (Lawson's iteration) of
 * the named remainder. The reference build calls the double library functions.
 *
 * Bounds are in units in the last place of float32, found over dense sweeps by
 * tests/unit/test_math.py, for finite arguments in the range named at each function. */
#ifndef ISOPHOTE_ELEMENTARY_H
#define ISOPHOTE_ELEMENTARY_H
#include "types.h"

#if REAL_IS_DOUBLE
FN real2 sin_cos_real(real x) { return make_real2(__builtin_sin(x), __builtin_cos(x)); }
FN real exp_real(real x) { return __builtin_exp(x); }
FN real log_real(real x) { return __builtin_log(max_real(x, 1.1754943508222875e-38)); }
FN real acos_real(real x) { return __builtin_acos(min_real(max_real(x, -1.0), 1.0)); }
FN real asin_real(real x) { return __builtin_asin(min_real(max_real(x, -1.0), 1.0)); }
FN real atan2_real(real y, real x) { return __builtin_atan2(y + 0.0, x + 0.0); }
FN real sinh_real(real x) { return __builtin_sinh(x); }
FN real cosh_real(real x) { return __builtin_cosh(x); }
FN real tanh_real(real x) { return __builtin_tanh(x); }
FN real2 wide_sin_cos(real x) { return sin_cos_real(x); }
FN real modulo_real(real x, real y) { return __builtin_fmod(x, y); }
#else

#define SMALLEST_NORMAL 1.17549435e-38f
#define INFINITY_BITS 0x7f800000u

/* (sin, cos) of r in [-pi/4, pi/4] and so many right angles: r + r^3 P(r^2) and 1 - r^2/2 + r^4 Q(r^2). */
FN real2 sin_cos_of_rest(real r, int quadrant) {
  real z = r * r;
  real s = r + r * z * ((-1.95172353e-4f * z + 8.33217800e-3f) * z - 0.166666552f);
  real c = (1.0f - 0.5f * z) + z * z * ((2.44383791e-5f * z - 1.38873665e-3f) * z + 4.16666456e-2f);
  real sine = (quadrant & 1) ? c : s;
  real cosine = (quadrant & 1) ? s : c;
  return make_real2((quadrant & 2) ? -sine : sine, ((quadrant + 1) & 2) ? -cosine : cosine);
}

/* (sin x, cos x) for |x| <= 8192, absolute error at most 2^-23.
 * Cody and Waite's reduction: x - j pi/2 with pi/2 in three parts, of which the first two times j
 * are exact. */
FN real2 sin_cos_real(real x) {
  real turns = floor(x * 0.636619772f + 0.5f);
  real r = ((x - turns * 1.5703125f) - turns * 4.83751297e-4f) - turns * 7.54978942e-8f;
  return sin_cos_of_rest(r, int_of(turns) & 3);
}

/* e^x within 1.5 ulp; 0 below -87.3 (no denormals) and infinity above 88.72.
 * x = n ln 2 + r with ln 2 in two parts; 1 + r + r^2 P(r); 2^n in two factors because n reaches 128. */
FN real exp_real(real x) {
  real clamped = min_real(max_real(x, -88.0f), 89.0f);
  real n = floor(clamped * 1.44269504f + 0.5f);
  real r = (clamped - n * 0.693359375f) + n * 2.12194440e-4f;
  real p = (((1.38144672e-3f * r + 8.36878084e-3f) * r + 4.16683927e-2f) * r + 0.166665196f) * r +
           0.49999994f;
  real y = (p * (r * r) + r) + 1.0f;
  int low = int_of(n) >> 1;
  int high = int_of(n) - low;
  y = y * float_of_bits(uint_of(low + 127) << 23) * float_of_bits(uint_of(high + 127) << 23);
  y = x < -87.3365448f ? 0.0f : y;
  return x > 88.7228394f ? float_of_bits(INFINITY_BITS) : y;
}

/* ln x within 1.5 ulp; arguments below the smallest normal number count as it (-87.34).
 * x = 2^n m with m in [sqrt(1/2), sqrt(2)); f - f^2/2 + f^3 P(f) with f = m - 1. */
FN real log_real(real x) {
  uint bits = bits_of_float(max_real(x, SMALLEST_NORMAL));
  uint shifted = bits - 0x3f3504f3u; /* sqrt(1/2) */
  int n = int_of(shifted) >> 23;
  real f = float_of_bits((shifted & 0x007fffffu) + 0x3f3504f3u) - 1.0f;
  real z = f * f;
  real p = ((((((-7.85961747e-2f * f + 0.128816500f) * f - 0.131287530f) * f + 0.141811922f) * f -
              0.166245535f) * f + 0.200022861f) * f - 0.250008106f) * f + 0.333333164f;
  real y = (f * z * p - real_of(n) * 2.12194440e-4f) - 0.5f * z;
  return (f + y) + real_of(n) * 0.693359375f;
}

/* arcsin s = s + s z P(z), z = s^2, for s in [0, 1/2]. */
FN real small_arcsine(real s, real z) {
  real p = (((4.22305539e-2f * z + 2.41409857e-2f) * z + 4.54783440e-2f) * z + 7.49523267e-2f) * z +
           0.166667536f;
  return s + s * z * p;
}

/* arccos within 1.5 ulp; arguments outside [-1, 1] count as the nearer end.
 * Beyond 1/2, arccos |x| = 2 arcsin sqrt((1 - |x|)/2). */
FN real acos_real(real x) {
  real a = min_real(fabs(x), 1.0f);
  int outer = a > 0.5f;
  real z = outer ? 0.5f * (1.0f - a) : a * a;
  real arcsine = small_arcsine(outer ? sqrt(z) : a, z);
  real signed_arcsine = x < 0.0f ? -arcsine : arcsine;
  real inner_value = 1.57079637f - (signed_arcsine + 4.37113883e-8f); /* pi/2 in two parts */
  real outer_value = x < 0.0f ? 3.14159274f - (2.0f * arcsine + 8.74227766e-8f) : 2.0f * arcsine;
  return outer ? outer_value : inner_value;
}

/* arcsin within 2.5 ulp; arguments outside [-1, 1] count as the nearer end. */
FN real asin_real(real x) {
  real a = min_real(fabs(x), 1.0f);
  int outer = a > 0.5f;
  real z = outer ? 0.5f * (1.0f - a) : a * a;
  real arcsine = small_arcsine(outer ? sqrt(z) : a, z);
  arcsine = outer ? 1.57079637f - (2.0f * arcsine + 4.37113883e-8f) : arcsine;
  return x < 0.0f ? -arcsine : arcsine;
}

/* Angle of (x, y) in [-pi, pi] within 2 ulp; 0 at the origin; signs of zeros are ignored.
 * arctan q = q + q^3 P(q^2) on [0, 1], the rest by symmetry. */
FN real atan2_real(real y, real x) {
  real ax = fabs(x);
  real ay = fabs(y);
  int steep = ay > ax;
  real q = (steep ? ax : ay) / max_real(steep ? ay : ax, SMALLEST_NORMAL);
  real z = q * q;
  real p = (((((((-1.82721403e-3f * z + 1.10644456e-2f) * z - 3.14557105e-2f) * z + 5.82345612e-2f) *
                   z - 8.41946006e-2f) * z + 0.109575763f) * z - 0.142652452f) * z + 0.199986383f) * z -
           0.333333015f;
  real angle = q + q * z * p;
  angle = steep ? 1.57079637f - (angle + 4.37113883e-8f) : angle;
  angle = x < 0.0f ? 3.14159274f - (angle + 8.74227766e-8f) : angle;
  return y < 0.0f ? -angle : angle;
}

/* e^|x| / 2 in two factors that multiply without overflow as long as the product is finite. */
FN real exp_abs_halved(real x) {
  real root = exp_real(0.5f * fabs(x));
  return (0.5f * root) * root;
}

/* Within 4 ulp; infinite beyond 89.4. x + x^3 P(x^2) on [-1, 1]. */
FN real sinh_real(real x) {
  real z = x * x, half_exp = exp_abs_halved(x);
  real outer = half_exp - 0.25f / half_exp;
  real inner = x + x * z * ((2.03774049e-4f * z + 8.33021104e-3f) * z + 0.166667178f);
  return fabs(x) > 1.0f ? (x < 0.0f ? -outer : outer) : inner;
}

/* Within 4 ulp; infinite beyond 89.4. */
FN real cosh_real(real x) {
  real half_exp = exp_abs_halved(x);
  return half_exp + 0.25f / half_exp;
}

/* Within 2 ulp. x + x^3 P(x^2) on [-0.625, 0.625], beyond 1 - 2 / (e^2x + 1). */
FN real tanh_real(real x) {
  real a = fabs(x), z = x * x;
  real outer = 1.0f - 2.0f / (exp_real(2.0f * a) + 1.0f);
  real p = (((-5.71704516e-3f * z + 2.06505880e-2f) * z - 5.37434965e-2f) * z + 0.133314908f) * z - 0.333332837f;
  return a > 0.625f ? (x < 0.0f ? -outer : outer) : x + x * z * p;
}

/* a b - p, where p is the rounded product: exact while nothing over- or underflows (Dekker 1971). */
FN real product_error(real a, real b, real p) {
  STRICT_FP
  real wide_a = 4097.0f * a, wide_b = 4097.0f * b;
  real high_a = wide_a - (wide_a - a), high_b = wide_b - (wide_b - b);
  real low_a = a - high_a, low_b = b - high_b;
  return ((high_a * high_b - p) + high_a * low_b + low_a * high_b) + low_a * low_b;
}

/* (sin x, cos x), absolute error at most 2^-23 for |x| < 1e7; beyond, where floats are 1 and more apart, (0, 1).
 * pi/2 in two parts, the first times j exactly. */
FN real2 wide_sin_cos(real x) {
  STRICT_FP
  real within = fabs(x) < 1.0e7f ? x : 0.0f;
  real turns = floor(within * 0.636619772f + 0.5f);
  real whole = turns * 1.57079637f;
  real rest = ((within - whole) - product_error(turns, 1.57079637f, whole)) + turns * 4.37113883e-8f;
  real more = floor(rest * 0.636619772f + 0.5f); /* of large x the turns were rounded */
  rest = (rest - more * 1.57079637f) + more * 4.37113883e-8f;
  return sin_cos_of_rest(rest, int_of(turns + more) & 3);
}

/* x less floor(x / y) y: exact, but for quotients beyond 2^24 some multiple of y may be left. */
FN real subtract_multiples(real x, real y) {
  STRICT_FP
  real times = floor(x / y);
  real whole = times * y;
  return (x - whole) - product_error(times, y, whole);
}

/* C's fmod, exactly, while |x / y| < 2^69 and |x| < 8e34; beyond, 0. y must not be 0. */
FN real modulo_real(real x, real y) {
  real size = fabs(y);
  real rest = subtract_multiples(subtract_multiples(subtract_multiples(fabs(x), size), size), size);
  rest = rest < 0.0f ? rest + size : rest;
  rest = rest >= size ? rest - size : rest;
  rest = rest >= 0.0f ? rest : 0.0f;
  return x < 0.0f ? -rest : rest;
}
#endif

FN real sin_real(real x) { return sin_cos_real(x).x; }
FN real cos_real(real x) { return sin_cos_real(x).y; }

/* x^y for x > 0; 0^y is 0 for y > 0 and 1 for y = 0. Relative error at most (2 + |y ln x|) 2^-23. */
FN real pow_real(real x, real y) {
  real power = exp_real(y * log_real(x));
  real power_of_zero = y > REAL(0.0) ? REAL(0.0) : power;
  return x > REAL(0.0) ? power : power_of_zero;
}

/* ln(1 + x) for x >= 0 and e^x - 1 for x <= 0, with the relative error of log_real and exp_real: Kahan's trick.
 * What rounding 1 + x or e^x loses is in both factors of the quotient, and cancels. */
FN real log1p_real(real x) {
  real sum = REAL(1.0) + x;
  real difference = sum - REAL(1.0);
  return difference == REAL(0.0) ? x : log_real(sum) * (x / difference);
}
FN real expm1_real(real x) {
  real power = exp_real(x);
  real difference = power - REAL(1.0);
  real small = power <= REAL(1e-6) ? difference : difference * (x / log_real(power));
  return difference == REAL(0.0) ? x : small;
}

#endif
