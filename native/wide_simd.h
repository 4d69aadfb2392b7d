/* Vectors of four, eight and sixteen, as the tracer of the wide tree needs them: a few intrinsics where the
 * instruction set has them, plain loops elsewhere. Included once for each variant; only for float. */
#pragma once
#if defined(__SSE__)
#include <immintrin.h>
#endif

#include "../kernels/portable.h"
#include "wide_tree.h"

/* Vectors wider than the target's registers only pass between functions that are inlined. */
#pragma GCC diagnostic ignored "-Wpsabi"

namespace isophote {
namespace ISOPHOTE_VARIANT {

typedef float Float8 __attribute__((vector_size(32)));
typedef float Float4 __attribute__((vector_size(16)));
typedef float Float16 __attribute__((vector_size(64)));
typedef int Int8 __attribute__((vector_size(32)));
typedef int Int4 __attribute__((vector_size(16)));
typedef int Int16 __attribute__((vector_size(64)));
typedef float Float8u __attribute__((vector_size(32), aligned(4), may_alias));
typedef int Int8u __attribute__((vector_size(32), aligned(4), may_alias));

/* Not by adding to zero, which -0 makes an addition. */
FN Float8 splat8(float x) { return Float8{x, x, x, x, x, x, x, x}; }
FN Float4 splat4(float x) { return Float4{x, x, x, x}; }
FN Float16 splat16(float x) { return Float16{x, x, x, x, x, x, x, x, x, x, x, x, x, x, x, x}; }

FN Float8 larger(Float8 a, Float8 b) { return a > b ? a : b; }
FN Float8 smaller(Float8 a, Float8 b) { return a < b ? a : b; }
FN Float4 larger(Float4 a, Float4 b) { return a > b ? a : b; }
FN Float4 absolute(Float4 a) { return Float4(Int4(a) & 0x7fffffff); }
FN Float16 larger(Float16 a, Float16 b) { return a > b ? a : b; }
FN Float16 absolute(Float16 a) { return Float16(Int16(a) & 0x7fffffff); }
FN Float16 smaller(Float16 a, Float16 b) { return a < b ? a : b; }
FN Int8 larger(Int8 a, Int8 b) { return a > b ? a : b; }
FN Int8 smaller(Int8 a, Int8 b) { return a < b ? a : b; }

/* a * b + c, rounded once where the processor can. Only for box tests, which err on the side of looking. */
FN Float8 multiply_add(Float8 a, Float8 b, Float8 c) {
#if defined(__FMA__)
  return Float8(_mm256_fmadd_ps(__m256(a), __m256(b), __m256(c)));
#else
  return a * b + c;
#endif
}

FN Float16 multiply_add(Float16 a, Float16 b, Float16 c) {
#if defined(__AVX512F__)
  return Float16(_mm512_fmadd_ps(__m512(a), __m512(b), __m512(c)));
#elif defined(__FMA__)
  Float16 r;
  auto *x = reinterpret_cast<__m256 *>(&a), *y = reinterpret_cast<__m256 *>(&b), *z = reinterpret_cast<__m256 *>(&c);
  auto *to = reinterpret_cast<__m256 *>(&r);
  for (int k = 0; k < 2; k++) to[k] = _mm256_fmadd_ps(x[k], y[k], z[k]);
  return r;
#else
  return a * b + c;
#endif
}

FN unsigned bits_of(Int8 mask) {
#if defined(__AVX__)
  return unsigned(_mm256_movemask_ps(__m256(mask)));
#elif defined(__SSE__)
  typedef int Half __attribute__((vector_size(16)));
  Half lo = __builtin_shufflevector(mask, mask, 0, 1, 2, 3), hi = __builtin_shufflevector(mask, mask, 4, 5, 6, 7);
  return unsigned(_mm_movemask_ps(__m128(lo))) | unsigned(_mm_movemask_ps(__m128(hi))) << 4;
#else
  unsigned bits = 0;
  for (int k = 0; k < WIDTH; k++) bits |= unsigned(mask[k] & 1) << k;
  return bits;
#endif
}
FN unsigned bits_of(Int4 mask) {
#if defined(__SSE__)
  return unsigned(_mm_movemask_ps(__m128(mask)));
#else
  unsigned bits = 0;
  for (int k = 0; k < BLOCK; k++) bits |= unsigned(mask[k] & 1) << k;
  return bits;
#endif
}

FN bool any_of(Int16 mask) {
#if defined(__AVX512DQ__)
  return _mm512_movepi32_mask(__m512i(mask)) != 0;
#else
  return (bits_of(__builtin_shufflevector(mask, mask, 0, 1, 2, 3, 4, 5, 6, 7)) |
          bits_of(__builtin_shufflevector(mask, mask, 8, 9, 10, 11, 12, 13, 14, 15))) != 0;
#endif
}

/* from[at[k] & 7] for each k. */
FN Int8 pick(const uint32_t *from, Int8 at) {
#if defined(__AVX2__)
  return Int8(_mm256_permutevar8x32_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i *>(from)), __m256i(at)));
#else
  Int8 r;
  for (int k = 0; k < WIDTH; k++) r[k] = int(from[at[k] & 7]);
  return r;
#endif
}

FN Float4 pick(Float4 from, Int4 at) {
#if defined(__AVX__)
  return Float4(_mm_permutevar_ps(__m128(from), __m128i(at)));
#else
  Float4 r;
  for (int k = 0; k < 4; k++) r[k] = from[at[k]];
  return r;
#endif
}

/* One layer of a sorting network: of each pair of places the lower one keeps the larger value. */
#define SORT_LAYER(v, a, b, c, d, e, f, g, h)                                                       \
  {                                                                                                 \
    Int8 other = __builtin_shufflevector(v, v, a, b, c, d, e, f, g, h);                             \
    v = __builtin_shufflevector(larger(v, other), smaller(v, other), a > 0 ? 0 : 8, b > 1 ? 1 : 9,  \
                                c > 2 ? 2 : 10, d > 3 ? 3 : 11, e > 4 ? 4 : 12, f > 5 ? 5 : 13,     \
                                g > 6 ? 6 : 14, h > 7 ? 7 : 15);                                    \
  }

/* Descending: the bitonic network (Batcher 1968, "Sorting networks and their applications"). */
FN Int8 sorted(Int8 v) {
  SORT_LAYER(v, 1, 0, 3, 2, 5, 4, 7, 6)
  SORT_LAYER(v, 3, 2, 1, 0, 7, 6, 5, 4)
  SORT_LAYER(v, 1, 0, 3, 2, 5, 4, 7, 6)
  SORT_LAYER(v, 7, 6, 5, 4, 3, 2, 1, 0)
  SORT_LAYER(v, 2, 3, 0, 1, 6, 7, 4, 5)
  SORT_LAYER(v, 1, 0, 3, 2, 5, 4, 7, 6)
  return v;
}
#undef SORT_LAYER

}  // namespace ISOPHOTE_VARIANT
}  // namespace isophote
