#include "totals.h"

#include <algorithm>
#include <cmath>

namespace isophote {
namespace {

constexpr size_t CHUNK = 256; /* added together or not at all */

struct Sum {
  double value, error;
};

/* Knuth, TAOCP 2, 4.2.2, theorem B; no error where the sum is not finite. */
Sum two_sum(double a, double b) {
  double value = a + b, rest = value - a;
  double error = (a - (value - rest)) + (b - rest);
  return {value, std::isfinite(value) ? error : 0.0};
}

}  // namespace

size_t add_listed(double *hi, double *lo, const float *values, const int64_t *pixels, size_t count) {
  Sum sums[CHUNK];
  for (size_t first = 0; first < count; first += CHUNK) {
    size_t n = std::min(CHUNK, count - first);
    const int64_t *at = pixels + first;
    bool exact = true;
    for (size_t k = 0; k < n; k++) {
      sums[k] = two_sum(hi[at[k]], double(values[first + k]));
      exact &= sums[k].error == 0.0;
    }
    if (!lo && !exact) return first;
    for (size_t k = 0; k < n; k++) {
      Sum sum = lo ? two_sum(sums[k].value, sums[k].error + lo[at[k]]) : sums[k];
      hi[at[k]] = sum.value;
      if (lo) lo[at[k]] = sum.error;
    }
  }
  return count;
}

}  // namespace isophote
