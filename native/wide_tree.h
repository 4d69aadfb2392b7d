/* The CPU's tree: eight children a node, four triangles a block, for one SIMD test each. */
#pragma once
#include <cstdint>
#include <vector>

#include "../kernels/scene_records.h"
#include "huge_pages.h"

namespace isophote {

constexpr int WIDTH = 8, BLOCK = 4;

/* Boxes of eight children, bound by bound; empty places have a box that no ray meets. */
struct alignas(64) WideNode {
  float bounds[6][WIDTH]; /* low x, high x, low y, high y, low z, high z */
  uint32_t child[WIDTH];  /* references; REF_NODE counts wide nodes, REF_TRIANGLES blocks */
};

/* Up to four triangles that lie side by side in the scene's array, with all that a hit needs: their records are
 * not touched while a ray is on its way. Three cache lines. */
struct alignas(64) TriangleBlock {
  float corner[3][3][BLOCK]; /* corner, axis, triangle */
  uint32_t first;            /* in the scene's triangles */
  uint32_t count;            /* | LAST_IN_LEAF on the last block of a leaf */
  uint32_t primitive[BLOCK], instance[BLOCK];
  uint16_t visibility[BLOCK]; /* kinds of rays; all of them in object space, where the instance decides */
};

struct WideTree {
  HugeVector<WideNode> nodes;
  HugeVector<TriangleBlock> blocks;
  uint32_t root;               /* of the world */
  std::vector<uint32_t> roots; /* of each instance that has a tree of its own, else NONE */
};

/* Collapses a scene's BVH2s: from the root down the child with the largest surface is opened until
 * eight are there (Wald, Benthin and Boulos 2008, "Getting Rid of Packets", section 4.2), and
 * subtrees of at most four triangles become one block. */
WideTree make_wide_tree(const Bvh2Node *nodes, const Triangle *triangles, const Instance *instances,
                        size_t instance_count, uint32_t root);

}  // namespace isophote
