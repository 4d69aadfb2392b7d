#include "split_vertices.h"

#include <algorithm>
#include <atomic>
#include <cstring>

namespace isophote {
namespace {

constexpr size_t CHUNK = 4096; /* corners that a thread takes at once */
constexpr uint32_t NOBODY = 0xffffffffu;

void lower(uint32_t &value, uint32_t to) {
  std::atomic_ref<uint32_t> shared(value);
  uint32_t seen = shared.load(std::memory_order_relaxed);
  while (to < seen && !shared.compare_exchange_weak(seen, to, std::memory_order_relaxed)) {}
}

}  // namespace

SplitVertices split_vertices(const uint32_t *vertex, const float *normal, size_t corners, size_t vertices, int threads) {
  auto differ = [&](size_t a, size_t b) { return std::memcmp(normal + 3 * a, normal + 3 * b, 3 * sizeof(float)) != 0; };
  SplitVertices made;
  made.corner.resize(corners);
  std::vector<uint32_t> leader(vertices, NOBODY); /* the first corner with a vertex's normal */
  std::vector<std::vector<uint32_t>> found((corners + CHUNK - 1) / CHUNK);
#pragma omp parallel num_threads(threads) if (corners > CHUNK)
  {
#pragma omp for schedule(static)
    for (size_t c = 0; c < corners; c++) lower(leader[vertex[c]], uint32_t(c));
#pragma omp for schedule(static)
    for (size_t chunk = 0; chunk < found.size(); chunk++)
      for (size_t c = chunk * CHUNK; c < std::min(corners, (chunk + 1) * CHUNK); c++) {
        made.corner[c] = vertex[c];
        if (differ(c, leader[vertex[c]])) found[chunk].push_back(uint32_t(c));
      }
  }
  std::vector<uint32_t> following; /* of each vertex, the next one in the same place */
  for (const auto &chunk : found)
    for (uint32_t c : chunk) {
      following.resize(leader.size(), NOBODY);
      uint32_t at = vertex[c];
      while (following[at] != NOBODY && differ(c, leader[following[at]])) at = following[at];
      if (following[at] == NOBODY) {
        following[at] = uint32_t(leader.size());
        leader.push_back(c);
        made.origin.push_back(vertex[c]);
      }
      made.corner[c] = following[at];
    }
  made.normals.assign(3 * leader.size(), 0.0f);
#pragma omp parallel for num_threads(threads) schedule(static) if (corners > CHUNK)
  for (size_t v = 0; v < leader.size(); v++)
    if (leader[v] != NOBODY) std::copy_n(normal + 3 * size_t(leader[v]), 3, made.normals.data() + 3 * v);
  return made;
}

}  // namespace isophote
