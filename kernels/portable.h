/* The only file that asks which compiler reads it: OpenCL C 1.2, or C++20 (clang or g++).
 *
 * Kernels are written in the common part of both: functions take and return values, only scene
 * arrays are GLOBAL pointers, every literal stands in REAL(), selects instead of branches where a loop
 * shall vectorise. `real` is float, or double in the reference build (C++ only).
 *
 * STRICT_FP is the first statement of functions that keep their bits in fast builds too (ISOPHOTE_FAST,
 * where the compiler may fuse multiplications and additions): hits and where rays start. UNROLL comes before a loop of
 * few turns inside one that shall vectorise. */
#ifndef ISOPHOTE_PORTABLE_H
#define ISOPHOTE_PORTABLE_H

#ifdef __OPENCL_VERSION__
/* ---------------------------------------------------------------- OpenCL C */
#ifndef ISOPHOTE_FAST
#pragma OPENCL FP_CONTRACT OFF
#endif
#define STRICT_FP _Pragma("OPENCL FP_CONTRACT OFF")
#define UNROLL _Pragma("unroll")
#define GLOBAL __global
#define FN static inline
#define FN_APART FN
#define REGISTER_STRIDE 1u
typedef float real;
typedef float4 real4;
typedef float3 real3;
typedef float2 real2;
#define REAL(x) x##f
#define REAL_IS_DOUBLE 0
#define make_real2(x, y) ((float2)(x, y))
#define make_real3(x, y, z) ((float3)(x, y, z))
#define make_real4(x, y, z, w) ((float4)(x, y, z, w))
#define to_real(x) (x)
#define to_float(x) (x)
#define uint_of(x) ((uint)(x))
#define int_of(x) ((int)(x))
#define real_of(x) ((float)(x))
#define bits_of_float(x) as_uint(x)
#define float_of_bits(x) as_float((uint)(x))
/* Four floats in one load, the k-th four of a record that lies at a multiple of 16 bytes. Through a pointer of
 * its own: compilers remember that a field of floats is aligned to 4 bytes only, and load it in four. */
FN float4 load_float4(GLOBAL const void *record, uint k) {
  GLOBAL const float4 *quads = (GLOBAL const float4 *)record;
  return quads[k];
}
/* One instruction each where min_real and max_real need two; which NaN or zero comes out is left open, so
 * only for what may err: tests of boxes. */
#define loose_min(a, b) fmin(a, b)
#define loose_max(a, b) fmax(a, b)
/* How many lanes of a warp run together here; many where the compiler cannot tell. OpenCL C 1.2 has no word for it. */
#ifdef __NV_CL_C_VERSION
FN uint lanes_together(void) {
  uint lanes;
  asm volatile("activemask.b32 %0;" : "=r"(lanes));
  return popcount(lanes);
}
#else
#define lanes_together() 0xffffffffu
#endif

#else
/* ------------------------------------------------------------------ C++20 */
#include <cmath>
#include <cstdint>
#include <cstring>
#ifdef __clang__
#define STRICT_FP _Pragma("clang fp contract(off)")
#define UNROLL _Pragma("unroll")
#else
#define STRICT_FP
#define UNROLL _Pragma("GCC unroll 32")
#endif
#define GLOBAL
#define FN static inline __attribute__((always_inline))
#define FN_APART static __attribute__((noinline, unused)) /* large, and in no loop that is to vectorise */
#ifndef REGISTER_STRIDE
#define REGISTER_STRIDE 1024u /* native/batch.h: a register is a column of its paths */
#endif
typedef unsigned int uint;
typedef unsigned short ushort;
#ifdef ISOPHOTE_REFERENCE
typedef double real;
#define REAL(x) x
#define REAL_IS_DOUBLE 1
#else
typedef float real;
#define REAL(x) x##f
#define REAL_IS_DOUBLE 0
#endif
/* Copied by constructors of their own, so that they travel in scalars: the ABI would pack trivial
 * structs into two-float registers, which stops the loop vectoriser even after inlining. */
struct real2 {
  real x, y;
  real2() = default;
  __attribute__((always_inline)) real2(real x_, real y_) : x(x_), y(y_) {}
  __attribute__((always_inline)) real2(const real2 &o) : x(o.x), y(o.y) {}
  __attribute__((always_inline)) real2 &operator=(const real2 &o) {
    x = o.x;
    y = o.y;
    return *this;
  }
};
struct real3 {
  real x, y, z;
  real3() = default;
  __attribute__((always_inline)) real3(real x_, real y_, real z_) : x(x_), y(y_), z(z_) {}
  __attribute__((always_inline)) real3(const real3 &o) : x(o.x), y(o.y), z(o.z) {}
  __attribute__((always_inline)) real3 &operator=(const real3 &o) {
    x = o.x;
    y = o.y;
    z = o.z;
    return *this;
  }
};
struct real4 {
  real x, y, z, w;
  real4() = default;
  __attribute__((always_inline)) real4(real x_, real y_, real z_, real w_) : x(x_), y(y_), z(z_), w(w_) {}
  __attribute__((always_inline)) real4(const real4 &o) : x(o.x), y(o.y), z(o.z), w(o.w) {}
  __attribute__((always_inline)) real4 &operator=(const real4 &o) {
    x = o.x;
    y = o.y;
    z = o.z;
    w = o.w;
    return *this;
  }
};
#define to_real(x) ((real)(x))
#define to_float(x) ((float)(x))
#define uint_of(x) ((uint)(x))
#define int_of(x) ((int)(x))
#define real_of(x) ((real)(x))
FN real2 make_real2(real x, real y) { return real2{x, y}; }
FN real3 make_real3(real x, real y, real z) { return real3{x, y, z}; }
FN real4 make_real4(real x, real y, real z, real w) { return real4{x, y, z, w}; }
FN real2 operator+(real2 a, real2 b) { return real2{a.x + b.x, a.y + b.y}; }
FN real2 operator-(real2 a, real2 b) { return real2{a.x - b.x, a.y - b.y}; }
FN real2 operator*(real2 a, real s) { return real2{a.x * s, a.y * s}; }
FN real3 operator+(real3 a, real3 b) { return real3{a.x + b.x, a.y + b.y, a.z + b.z}; }
FN real3 operator-(real3 a, real3 b) { return real3{a.x - b.x, a.y - b.y, a.z - b.z}; }
FN real3 operator*(real3 a, real3 b) { return real3{a.x * b.x, a.y * b.y, a.z * b.z}; }
FN real3 operator*(real3 a, real s) { return real3{a.x * s, a.y * s, a.z * s}; }
FN real3 operator*(real s, real3 a) { return real3{s * a.x, s * a.y, s * a.z}; }
FN real3 operator/(real3 a, real s) { return real3{a.x / s, a.y / s, a.z / s}; }
FN real3 operator-(real3 a) { return real3{-a.x, -a.y, -a.z}; }
FN real4 operator+(real4 a, real4 b) { return real4{a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w}; }
FN real4 operator-(real4 a, real4 b) { return real4{a.x - b.x, a.y - b.y, a.z - b.z, a.w - b.w}; }
FN real4 operator*(real4 a, real s) { return real4{a.x * s, a.y * s, a.z * s, a.w * s}; }
FN uint bits_of_float(float x) { return __builtin_bit_cast(uint, x); }
FN float float_of_bits(uint x) { return __builtin_bit_cast(float, x); }
struct float4 {
  float x, y, z, w;
};
FN float4 load_float4(const void *record, uint k) {
  float4 f;
  std::memcpy(&f, static_cast<const char *>(record) + 16 * k, sizeof f);
  return f;
}
#define lanes_together() 0xffffffffu
#define loose_min(a, b) min_real(a, b)
#define loose_max(a, b) max_real(a, b)
/* The square root of the compiler, correctly rounded and without errno. */
#if REAL_IS_DOUBLE
#define sqrt(x) __builtin_sqrt(x)
#define fma(a, b, c) __builtin_fma(a, b, c)
#define fabs(x) __builtin_fabs(x)
#define floor(x) __builtin_floor(x)
#else
#define sqrt(x) __builtin_sqrtf(x)
#define fma(a, b, c) __builtin_fmaf(a, b, c)
#define fabs(x) __builtin_fabsf(x)
#define floor(x) __builtin_floorf(x)
#endif
#endif

/* ------------------------------------------------------- common to both */
/* min and max as a comparison: fmin and fmax treat NaN and signed zeros differently on each device. */
FN real min_real(real a, real b) { return a < b ? a : b; }
FN real max_real(real a, real b) { return a > b ? a : b; }
FN int min_int(int a, int b) { return a < b ? a : b; }
FN int max_int(int a, int b) { return a > b ? a : b; }
FN uint min_uint(uint a, uint b) { return a < b ? a : b; }

#endif
