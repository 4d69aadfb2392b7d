/* Vertices whose corners do not all have one normal, in several: as a GPU's vertex buffers want them. */
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isophote {

struct SplitVertices {
  std::vector<uint32_t> corner; /* vertex of each corner */
  std::vector<uint32_t> origin; /* of which vertex each added one is a copy; they follow those that were there */
  std::vector<float> normals;   /* 3 of each vertex, added ones too; 0 where it is no corner's */
};

/* `vertex` and `normal` (3 floats) of each corner. Normals differ where their bits do. A vertex keeps the normal of its
 * first corner; others are added in the order of the corners that need them, whatever the number of threads. */
SplitVertices split_vertices(const uint32_t *vertex, const float *normal, size_t corners, size_t vertices, int threads);

}  // namespace isophote
