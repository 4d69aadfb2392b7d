/* Triangles whose boxes are mostly empty, in pieces. */
#pragma once
#include <cstdint>
#include <vector>

#include "bvh_build.h"
#include "bvh_split.h"

namespace isophote {

struct Piece {
  Box box;
  uint32_t triangle; /* position in the input */
};

/* The pieces of all triangles that are better cut, in their order, two or more of each; `scene` holds them all.
 *
 * A slanted beam or wire fills little of its box, and rays that pass through the rest test it in vain. Such a
 * triangle gets several boxes and is in several leaves; hits stay what they are, because triangle_hit decides.
 * Cut beforehand as in Karras and Aila 2013, "Fast Parallel Construction of High-Quality Bounding Volume
 * Hierarchies", section 4.3, but by how much area is needless: nothing is cut in a scene of even triangles. */
std::vector<Piece> cut_slanted(const BuildInput &input, Box scene, int threads);

}  // namespace isophote
