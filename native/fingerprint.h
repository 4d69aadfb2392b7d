/* Which bytes a block of memory holds, in 128 bits: two blocks that differ have the same by a chance of about 2^-120. */
#pragma once
#include <cstddef>
#include <cstdint>

namespace isophote {

struct Fingerprint {
  uint64_t low, high;
};

/* Not for those who want to be deceived: it is made for speed and resists no attack. */
Fingerprint fingerprint(const void *bytes, size_t size, int threads);

}  // namespace isophote
