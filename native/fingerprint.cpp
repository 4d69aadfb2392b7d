#include "fingerprint.h"

#include <algorithm>
#include <cstring>
#include <vector>

namespace isophote {
namespace {

constexpr size_t BLOCK_BYTES = 1 << 20; /* that a thread takes at once */
/* Digits of pi, so that nothing is up the sleeve. */
constexpr uint64_t SECRET[2][2] = {{0x243f6a8885a308d3u, 0x13198a2e03707344u}, {0xa4093822299f31d0u, 0x082efa98ec4e6c89u}};

/* Both halves of a product of 64 by 64 bits: every bit of either factor reaches about half of those of the result. */
uint64_t fold(uint64_t a, uint64_t b) {
  unsigned __int128 product = static_cast<unsigned __int128>(a) * b;
  return uint64_t(product) ^ uint64_t(product >> 64);
}

/* Two chains over the same bytes, with secrets of their own. */
struct Chains {
  uint64_t state[2];
  void add(uint64_t a, uint64_t b) {
    for (int k = 0; k < 2; k++) state[k] = fold(a ^ SECRET[k][0], b ^ state[k]);
  }
};

Fingerprint of_block(const char *bytes, size_t size) {
  Chains c{{SECRET[0][1] ^ size, SECRET[1][1] ^ size}};
  uint64_t words[2];
  size_t at = 0;
  for (; at + sizeof words <= size; at += sizeof words) {
    std::memcpy(words, bytes + at, sizeof words);
    c.add(words[0], words[1]);
  }
  words[0] = words[1] = 0;
  if (at < size) std::memcpy(words, bytes + at, size - at);
  c.add(words[0], words[1]);
  return {c.state[0], c.state[1]};
}

}  // namespace

Fingerprint fingerprint(const void *bytes, size_t size, int threads) {
  const char *from = static_cast<const char *>(bytes);
  std::vector<Fingerprint> blocks((size + BLOCK_BYTES - 1) / BLOCK_BYTES);
#pragma omp parallel for num_threads(threads) schedule(static) if (blocks.size() > 1)
  for (size_t b = 0; b < blocks.size(); b++)
    blocks[b] = of_block(from + b * BLOCK_BYTES, std::min(BLOCK_BYTES, size - b * BLOCK_BYTES));
  return of_block(reinterpret_cast<const char *>(blocks.data()), blocks.size() * sizeof(Fingerprint));
}

}  // namespace isophote
