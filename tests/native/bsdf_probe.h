/* What the probes of bsdf_probe.cpp and bsdf_probe.cl do with one element; the callers hold the loop.
 * Vectors lie in memory as 3 numbers in a row. */
#ifndef ISOPHOTE_TESTS_BSDF_PROBE_H
#define ISOPHOTE_TESTS_BSDF_PROBE_H
#include "../../kernels/bsdf/bsdf.h"

FN real3 get3(GLOBAL const real *v, int i) { return make_real3(v[3 * i], v[3 * i + 1], v[3 * i + 2]); }
FN void put3(GLOBAL real *v, int i, real3 x) {
  v[3 * i] = x.x;
  v[3 * i + 1] = x.y;
  v[3 * i + 2] = x.z;
}

#define PROBE_EVAL(name)                                                              \
  BsdfValue value = eval_##name(c, backfacing, tables, get3(wo, i), get3(wi, i));     \
  put3(f, i, value.f);                                                                \
  pdf[i] = value.pdf;

#define PROBE_SAMPLE(name)                                                            \
  BsdfSample s = sample_##name(c, backfacing, tables, get3(wo, i), u[3 * i],          \
                               make_real2(u[3 * i + 1], u[3 * i + 2]));               \
  put3(wi, i, s.wi);                                                                  \
  put3(f, i, s.f);                                                                    \
  flags[3 * i] = s.delta;                                                             \
  flags[3 * i + 1] = s.label;                                                         \
  flags[3 * i + 2] = s.valid;

/* X(number, name, its value for arguments x and y) */
#define PROBE_FUNCTIONS(X)       \
  X(0, sin, sin_real(x))         \
  X(1, cos, cos_real(x))         \
  X(2, exp, exp_real(x))         \
  X(3, log, log_real(x))         \
  X(4, acos, acos_real(x))       \
  X(5, atan2, atan2_real(x, y))  \
  X(6, pow, pow_real(x, y))      \
  X(7, log1p, log1p_real(fabs(x))) \
  X(8, expm1, expm1_real(-fabs(x))) \
  X(9, asin, asin_real(x))       \
  X(10, sinh, sinh_real(x))      \
  X(11, cosh, cosh_real(x))      \
  X(12, tanh, tanh_real(x))      \
  X(13, wide_sin, wide_sin_cos(x).x) \
  X(14, wide_cos, wide_sin_cos(x).y) \
  X(15, modulo, modulo_real(x, y))

#endif
