/* A tree whose things have moved: the same nodes with new boxes. */
#pragma once
#include <cstddef>
#include <cstdint>

#include "wide_tree.h"

namespace isophote {

/* What a tree's leaves refer to; references to triangles count from 0. */
struct Leaves {
  LeafTriangles triangles;
  const uint32_t *reference; /* of the other things below the tree, ascending */
  const float *lo, *hi;      /* their boxes, 3 each */
  size_t others;
  float margin; /* by which boxes are wider, relative to the largest coordinate of each */
};

/* Expected cost of a random line through the tree, by the surface area heuristic, over that of its root's box. */
struct TreeCost {
  double before, after;
};

/* Gives all nodes, from the root on, the boxes of what lies below them now. Trees stay correct whatever has moved;
 * how good they still are, the costs tell. Lauterbach et al. 2006, "RT-DEFORM". */
TreeCost refit_tree(Bvh2Node *nodes, uint32_t root, const Leaves &leaves, int threads);

/* The same for a part of a wide tree: its triangles too come from the meshes anew. Of `leaves`, order and last are not
 * looked at. Returns the part's cost. */
double refit_part(WideTree &tree, size_t part, const Leaves &leaves, int threads);

}  // namespace isophote
