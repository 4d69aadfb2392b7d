/* Sums of blocks in two float64 a value, as isophote/totals.py has them. */
#pragma once
#include <cstddef>
#include <cstdint>

namespace isophote {

/* Adds values[k] to pixel pixels[k] of a plane's sum hi + lo, for all k < count; no pixel is listed twice. `lo` may be
 * nullptr as long as sums are exact in `hi`. Returns how many were added: fewer where a sum needs a `lo`. */
size_t add_listed(double *hi, double *lo, const float *values, const int64_t *pixels, size_t count);

}  // namespace isophote
