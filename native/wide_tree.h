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

/* One of the trees of a wide tree, which lie one after the other, each depth first. */
struct WidePart {
  uint32_t root;        /* reference */
  uint32_t node, block; /* its first */
  uint32_t triangles;   /* in its blocks */
  double built_cost;    /* by the surface area heuristic (part_cost) when it was built */
};

struct WideTree {
  HugeVector<WideNode> nodes;
  HugeVector<TriangleBlock> blocks;
  std::vector<WidePart> parts; /* of shared meshes; the world's is the last */
  uint32_t root;               /* of the world */
  std::vector<uint32_t> roots; /* of each instance that has a tree of its own, else NONE */

  uint32_t node_end(size_t part) const { return part + 1 < parts.size() ? parts[part + 1].node : uint32_t(nodes.size()); }
  uint32_t block_end(size_t part) const { return part + 1 < parts.size() ? parts[part + 1].block : uint32_t(blocks.size()); }
};

/* What a tree is made of: a BVH2, laid out depth first, and its leaves; or a part of another wide tree. */
struct WideSource {
  const Bvh2Node *nodes;
  size_t node_count;
  LeafTriangles leaves;
  uint32_t root;
  const WideTree *kept; /* or null */
  size_t part;
};

/* Collapses BVH2s so that the expected cost of a ray is least: for each node the best way to be a leaf, a wide
 * node, or at most 2 to 7 children of the wide node above is found from those of its halves (Ylitie, Karras and Laine
 * 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", section 3.1). The last source is the
 * world; tree_of has for each instance the number of its tree, or NONE. The result does not depend on threads. */
WideTree make_wide_tree(const std::vector<WideSource> &sources, const uint32_t *tree_of, size_t instance_count, int threads);

/* Expected cost of a random line that meets the part's root. */
double part_cost(const WideTree &tree, size_t part);

/* Triangle k of a block. */
void set_triangle(TriangleBlock &block, uint32_t k, const Triangle &t);

}  // namespace isophote
