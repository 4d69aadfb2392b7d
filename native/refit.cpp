#include "refit.h"

#include <algorithm>
#include <unordered_map>
#include <vector>

#include "bvh_node.h"

namespace isophote {
namespace {

constexpr uint32_t SMALL = 1024; /* nodes or blocks for which no other thread is woken */
constexpr int SHARED_LEVELS = 8; /* of the tree, above the subtrees that threads take */

struct Box {
  float lo[3], hi[3];
  void add(const Box &b) {
    for (int a = 0; a < 3; a++) {
      lo[a] = std::min(lo[a], b.lo[a]);
      hi[a] = std::max(hi[a], b.hi[a]);
    }
  }
  /* Wider by the roundings of a hit, as when the tree was built (isophote/geometry.py). */
  void widen(float margin) {
    float largest = 0.0f;
    for (int a = 0; a < 3; a++) largest = std::max(largest, std::max(-lo[a], hi[a]));
    for (int a = 0; a < 3; a++) {
      lo[a] -= largest * margin;
      hi[a] += largest * margin;
    }
  }
  double half_area() const {
    double x = double(hi[0] - lo[0]), y = double(hi[1] - lo[1]), z = double(hi[2] - lo[2]);
    return x * y + y * z + z * x;
  }
};

Box child_box(const Bvh2Node &n, int k) {
  Box box;
  get_box(n, k, box.lo, box.hi);
  return box;
}

/* The box below a reference, and areas times costs of all nodes there, with the boxes before and now. */
struct Below {
  Box box;
  double before, after;
};

Box widened(Box box, const Leaves &leaves) {
  box.widen(leaves.margin);
  return box;
}

Box triangle_box(uint32_t primitive, const Leaves &leaves) {
  Box box;
  for (int k = 0; k < 3; k++) {
    const float *v = leaves.triangles.meshes.corner(primitive, k);
    Box point{{v[0], v[1], v[2]}, {v[0], v[1], v[2]}};
    if (k)
      box.add(point);
    else
      box = point;
  }
  return widened(box, leaves);
}

/* Of what is no triangle. */
Box other_box(uint32_t ref, const Leaves &leaves) {
  size_t k = size_t(std::lower_bound(leaves.reference, leaves.reference + leaves.others, ref) - leaves.reference);
  const float *lo = leaves.lo + 3 * k, *hi = leaves.hi + 3 * k;
  return widened({{lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}}, leaves);
}

class Refitter {
 public:
  Refitter(Bvh2Node *nodes, const Leaves &leaves) : nodes_(nodes), leaves_(leaves) {}

  void collect(uint32_t ref, int level, std::vector<uint32_t> &subtrees) const {
    if (REF_KIND(ref) != REF_NODE) return;
    if (level == SHARED_LEVELS) {
      subtrees.push_back(ref);
      return;
    }
    for (uint32_t child : nodes_[ref].child) collect(child, level + 1, subtrees);
  }

  void keep(uint32_t ref, const Below &below) { done_.emplace(ref, below); }

  /* Fits what lies below; `count` is set to the number of items if it is a leaf, else to 0. */
  Below fit(uint32_t ref, uint32_t &count) {
    if (REF_KIND(ref) != REF_NODE) return {leaf_box(ref, count), 0.0, 0.0};
    count = 0;
    if (auto found = done_.find(ref); found != done_.end()) return found->second;
    Bvh2Node &node = nodes_[ref];
    Below all{};
    for (int k = 0; k < 2; k++) {
      uint32_t items;
      double before = child_box(node, k).half_area();
      Below below = fit(node.child[k], items);
      double cost = items ? double(items) : 1.0;
      all.before += below.before + before * cost;
      all.after += below.after + below.box.half_area() * cost;
      set_box(node, k, below.box.lo, below.box.hi);
      if (k)
        all.box.add(below.box);
      else
        all.box = below.box;
    }
    return all;
  }

 private:
  Box leaf_box(uint32_t ref, uint32_t &count) const {
    uint32_t at = REF_INDEX(ref);
    count = 1;
    if (REF_KIND(ref) != REF_TRIANGLES) return other_box(ref, leaves_);
    Box box = triangle_box(leaves_.triangles.order[at], leaves_);
    for (; !leaves_.triangles.last[at]; count++) box.add(triangle_box(leaves_.triangles.order[++at], leaves_));
    return box;
  }

  Bvh2Node *nodes_;
  const Leaves &leaves_;
  std::unordered_map<uint32_t, Below> done_;
};

Box leaf_box(const WideTree &tree, uint32_t ref, const Leaves &leaves) {
  if (REF_KIND(ref) != REF_TRIANGLES) return other_box(ref, leaves);
  Box box{};
  for (uint32_t at = REF_INDEX(ref), last = 0, first = 1; !last; at++) {
    const TriangleBlock &b = tree.blocks[at];
    for (uint32_t k = 0; k < (b.count & ~LAST_IN_LEAF); k++, first = 0) {
      Box one = triangle_box(b.primitive[k], leaves);
      if (first)
        box = one;
      else
        box.add(one);
    }
    last = b.count & LAST_IN_LEAF;
  }
  return box;
}

void set_child_box(WideNode &n, size_t k, const Box &box) {
  for (size_t axis = 0; axis < 3; axis++) {
    n.bounds[2 * axis][k] = box.lo[axis];
    n.bounds[2 * axis + 1][k] = box.hi[axis];
  }
}

/* Of all children: empty places have boxes that do not count. */
Box whole_box(const WideNode &n) {
  Box box;
  for (size_t axis = 0; axis < 3; axis++) {
    box.lo[axis] = *std::min_element(n.bounds[2 * axis], n.bounds[2 * axis] + WIDTH);
    box.hi[axis] = *std::max_element(n.bounds[2 * axis + 1], n.bounds[2 * axis + 1] + WIDTH);
  }
  return box;
}

}  // namespace

double refit_part(WideTree &tree, size_t part, const Leaves &leaves, int threads) {
  uint32_t first = tree.parts[part].node, end = tree.node_end(part), block_end = tree.block_end(part);
#pragma omp parallel for num_threads(threads) schedule(static) if (block_end - tree.parts[part].block > SMALL)
  for (uint32_t i = tree.parts[part].block; i < block_end; i++) {
    TriangleBlock &b = tree.blocks[i];
    for (uint32_t k = 0; k < (b.count & ~LAST_IN_LEAF); k++)
      set_triangle(b, k, leaves.triangles.meshes.record(b.primitive[k]));
  }
#pragma omp parallel for num_threads(threads) schedule(static) if (end - first > SMALL)
  for (uint32_t i = first; i < end; i++)
    for (size_t k = 0; k < WIDTH; k++) {
      uint32_t ref = tree.nodes[i].child[k];
      if (ref != NONE && REF_KIND(ref) != REF_NODE) set_child_box(tree.nodes[i], k, leaf_box(tree, ref, leaves));
    }
  for (uint32_t i = end; i-- > first;) /* children follow their parents */
    for (size_t k = 0; k < WIDTH; k++) {
      uint32_t ref = tree.nodes[i].child[k];
      if (ref != NONE && REF_KIND(ref) == REF_NODE) set_child_box(tree.nodes[i], k, whole_box(tree.nodes[ref]));
    }
  return part_cost(tree, part);
}

TreeCost refit_tree(Bvh2Node *nodes, uint32_t root, const Leaves &leaves, int threads) {
  if (root == NONE || REF_KIND(root) != REF_NODE) return {1.0, 1.0};
  Box old = child_box(nodes[root], 0);
  old.add(child_box(nodes[root], 1));
  Refitter refitter(nodes, leaves);
  std::vector<uint32_t> subtrees;
  refitter.collect(root, 0, subtrees);
  std::vector<Below> below(subtrees.size());
  uint32_t count;
#pragma omp parallel for num_threads(threads) schedule(dynamic, 1) private(count) if (subtrees.size() > 1)
  for (size_t i = 0; i < subtrees.size(); i++) below[i] = refitter.fit(subtrees[i], count);
  for (size_t i = 0; i < subtrees.size(); i++) refitter.keep(subtrees[i], below[i]);
  Below all = refitter.fit(root, count);
  return {all.before / old.half_area(), all.after / all.box.half_area()};
}

}  // namespace isophote
