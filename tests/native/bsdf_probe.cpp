// Kernel functions over arrays, for tests/kernel_lib.py. Each loop is one closure, as in the renderer,
// so that building with -Werror=pass-failed shows that it vectorises.
#include "bsdf_probe.h"

extern "C" {

int probe_real_size() { return sizeof(real); }

void probe_eval(const Instruction *instruction, int backfacing, const float *__restrict tables, int n,
                const real *__restrict wo, const real *__restrict wi, real *__restrict f,
                real *__restrict pdf) {
  const Closure c = make_closure(*instruction);
  switch (c.op) {
#define X(number, name, labels)                             \
  case number:                                              \
    _Pragma("omp simd") for (int i = 0; i < n; ++i) { PROBE_EVAL(name) } \
    break;
    CLOSURES(X)
#undef X
  }
}

void probe_sample(const Instruction *instruction, int backfacing, const float *__restrict tables, int n,
                  const real *__restrict wo, const real *__restrict u, real *__restrict wi,
                  real *__restrict f, int *__restrict flags) {
  const Closure c = make_closure(*instruction);
  switch (c.op) {
#define X(number, name, labels)                             \
  case number:                                              \
    _Pragma("omp simd") for (int i = 0; i < n; ++i) { PROBE_SAMPLE(name) } \
    break;
    CLOSURES(X)
#undef X
  }
}

// Albedo of a closure, or what a layer lets pass.
void probe_albedo(const Instruction *instruction, int backfacing, const float *__restrict tables, int n,
                  const real *__restrict wo, real *__restrict albedo) {
  const Closure c = make_closure(*instruction);
  switch (c.op) {
#define X(number, name, labels)                                                            \
  case number:                                                                             \
    _Pragma("omp simd") for (int i = 0; i < n; ++i)                                        \
        put3(albedo, i, albedo_##name(c, backfacing, tables, get3(wo, i)));                \
    break;
    CLOSURES(X)
#undef X
#define X(number, name)                                                                    \
  case number:                                                                             \
    _Pragma("omp simd") for (int i = 0; i < n; ++i)                                        \
        put3(albedo, i, layer_##name(c, backfacing, tables, get3(wo, i), splat3(REAL(1.0)))); \
    break;
    LAYERS(X)
#undef X
  }
}

void probe_function(int function, int n, const real *__restrict xs, const real *__restrict ys,
                    real *__restrict out) {
  switch (function) {
#define X(number, name, value)                              \
  case number:                                              \
    _Pragma("omp simd") for (int i = 0; i < n; ++i) {       \
      [[maybe_unused]] real x = xs[i], y = ys[i];           \
      out[i] = value;                                       \
    }                                                       \
    break;
    PROBE_FUNCTIONS(X)
#undef X
  }
}
}
