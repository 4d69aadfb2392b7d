/* The CPU's tree: eight children a node, four triangles a block, for one SIMD test each. */
#pragma once
#include <cstdint>
#include <vector>

#include "huge_pages.h"
#include "triangles.h"

namespace isophote {

constexpr int WIDTH = 8, BLOCK = 4;

/* Boxes of eight children, bound by bound; empty places have a box that no ray meets. */
struct alignas(64) WideNode {
  float bounds[6][WIDTH]; /* low x, high x, low y, high y, low z, high z */
  uint32_t child[WIDTH];  /* references; REF_NODE counts wide nodes, REF_TRIANGLES blocks */
};

/* Up to four triangles, with all that a hit needs: the mesh is not touched while a ray is on its way. Three cache
 * lines. */
struct alignas(64) TriangleBlock {
  float corner[3][3][BLOCK]; /* corner, axis, triangle */
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

/* Collapses a scene's BVH2s, laid out depth first one after the other, so that the expected cost of a ray
 * is least: for each node the best way to be a leaf, a wide node, or at most 2 to 7 children of the wide
 * node above is found from those of its halves (Ylitie, Karras and Laine 2017, "Efficient Incoherent Ray
 * Traversal on GPUs Through Compressed Wide BVHs", section 3.1). The result does not depend on threads. */
WideTree make_wide_tree(const Bvh2Node *nodes, size_t node_count, const LeafTriangles &leaves, const Instance *instances,
                        size_t instance_count, uint32_t root, int threads);

}  // namespace isophote
