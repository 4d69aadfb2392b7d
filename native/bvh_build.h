/* Building of BVH2s: the interface. */
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include "triangles.h"

namespace isophote {

/* What a tree is built over: triangles of meshes, then other things by their boxes. Positions of triangles are their
 * numbers in the scene, those of the others follow the last triangle of the scene. */
struct BuildInput {
  Meshes meshes;
  std::vector<uint32_t> members; /* of the meshes, ascending */
  const float *lo, *hi;          /* 3 of each of the others */
  const uint32_t *reference;     /* the whole reference of each */
  size_t others;
  float margin;    /* by which boxes are wider, relative to the largest coordinate of each */
  float item_cost; /* of testing a triangle, where a node costs 1 */

  std::vector<size_t> starts = {}; /* number of triangles before each member's, and of all: set_starts */
  void set_starts() {
    starts.assign(1, 0);
    for (uint32_t m : members) starts.push_back(starts.back() + meshes.first[m + 1] - meshes.first[m]);
  }
  size_t triangles() const { return starts.back(); }
  size_t size() const { return triangles() + others; }
  uint32_t position_of(size_t item) const {
    if (item >= triangles()) return uint32_t(meshes.triangle_count() + item - triangles());
    size_t k = size_t(std::upper_bound(starts.begin(), starts.end(), item) - starts.begin()) - 1;
    return uint32_t(meshes.first[members[k]] + item - starts[k]);
  }
  uint32_t reference_of(uint32_t position) const {
    size_t count = meshes.triangle_count();
    return position < count ? REF_TRIANGLES << 30 : reference[position - count];
  }
};

struct Tree {
  std::vector<Bvh2Node> nodes; /* depth first */
  std::vector<uint32_t> order; /* positions, in the order of the leaves; some triangles are in several */
  std::vector<uint8_t> last;   /* whether the item ends its leaf */
  uint32_t root;               /* reference */
  int depth;
  double seconds[3]; /* of making boxes, of splitting, of laying the subtrees out */
};

/* Binned SAH (Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies"). Large parts are
 * split by all threads together, small ones by one each; the result does not depend on their number. */
Tree build_tree(BuildInput input, int max_leaf, int threads);

}  // namespace isophote
