/* Building of BVH2s: the interface. */
#pragma once
#include <cstdint>
#include <vector>

#include "../kernels/scene_records.h"

namespace isophote {

/* What a tree is built over: the box of one triangle, sphere or instance. */
struct BuildItem {
  float lo[3];
  uint32_t position; /* in the input */
  float hi[3];
  uint32_t reference; /* its kind; for instances the whole reference */
  uint32_t kind() const { return REF_KIND(reference); }
};

/* Numbers that the first node, triangle and sphere of a tree have in the scene's arrays. */
struct TreeBase {
  uint32_t node, triangle, sphere;
};

struct Tree {
  std::vector<Bvh2Node> nodes;
  std::vector<uint32_t> order; /* positions in the input, in the order of the leaves */
  std::vector<uint8_t> last;   /* whether the item ends its leaf */
  uint32_t root;               /* reference */
  int depth;
};

/* Binned SAH (Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies"), in parallel
 * by subtrees; the result does not depend on the number of threads. items are reordered. */
Tree build_tree(std::vector<BuildItem> &items, TreeBase base, int max_leaf, int threads);

}  // namespace isophote
