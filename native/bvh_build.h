/* Building of BVH2s: the interface. */
#pragma once
#include <cstdint>
#include <vector>

#include "../kernels/scene_records.h"

namespace isophote {

/* What a tree is built over: triangles by their corners, then other things by their boxes. */
struct BuildInput {
  const float *corners; /* of each triangle, 9 */
  size_t triangles;
  const float *lo, *hi;      /* 3 of each of the others */
  const uint32_t *reference; /* its kind; for instances the whole reference */
  size_t others;
  float margin; /* by which boxes are wider, relative to the largest coordinate of each */

  size_t size() const { return triangles + others; }
  uint32_t reference_of(size_t position) const {
    return position < triangles ? REF_TRIANGLES << 30 : reference[position - triangles];
  }
};

/* Numbers that the first node, triangle and sphere of a tree have in the scene's arrays. */
struct TreeBase {
  uint32_t node, triangle, sphere;
};

struct Tree {
  std::vector<Bvh2Node> nodes; /* depth first */
  std::vector<uint32_t> order; /* positions in the input, in the order of the leaves; some triangles are in several */
  std::vector<uint8_t> last;   /* whether the item ends its leaf */
  uint32_t root;               /* reference */
  int depth;
  double seconds[3]; /* of making boxes, of splitting, of laying the subtrees out */
};

/* Binned SAH (Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies"). Large parts are
 * split by all threads together, small ones by one each; the result does not depend on their number. */
Tree build_tree(const BuildInput &input, TreeBase base, int max_leaf, int threads);

}  // namespace isophote
