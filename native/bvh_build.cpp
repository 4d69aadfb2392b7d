#include "bvh_build.h"

#include <omp.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace isophote {
namespace {

constexpr int BINS = 16;
constexpr int MAX_DEPTH = 44; /* kernels/bvh.h keeps a stack of 96 for two levels */
constexpr size_t SMALL_PART = 4096;
constexpr int PARTS_PER_THREAD = 8;
constexpr float NODE_COST = 1.0f, ITEM_COST = 1.0f;

struct Box {
  float lo[3], hi[3];
  Box() {
    for (int a = 0; a < 3; a++) {
      lo[a] = std::numeric_limits<float>::infinity();
      hi[a] = -std::numeric_limits<float>::infinity();
    }
  }
  void add(const float *l, const float *h) {
    for (int a = 0; a < 3; a++) {
      lo[a] = l[a] < lo[a] ? l[a] : lo[a];
      hi[a] = h[a] > hi[a] ? h[a] : hi[a];
    }
  }
  void add(const Box &b) { add(b.lo, b.hi); }
  float half_area() const {
    float x = hi[0] - lo[0], y = hi[1] - lo[1], z = hi[2] - lo[2];
    return x < 0.0f ? 0.0f : x * y + y * z + z * x;
  }
};

struct TempNode {
  Box box;
  uint32_t child[2]; /* of inner nodes */
  uint32_t first, count; /* items; count 0: inner */
};

/* Halved before adding, so that boxes at the edge of float's range do not overflow. */
float center(const BuildItem &i, int axis) { return 0.5f * i.lo[axis] + 0.5f * i.hi[axis]; }

struct Split {
  float cost = std::numeric_limits<float>::infinity();
  int axis = -1, bin = 0;
};

struct Binning {
  float low, scale;
  int operator()(const BuildItem &i, int axis) const {
    return std::clamp(int((center(i, axis) - low) * scale), 0, BINS - 1);
  }
};

Binning make_binning(const Box &centers, int axis) {
  float extent = centers.hi[axis] - centers.lo[axis];
  return {centers.lo[axis], extent > 0.0f ? float(BINS) * (1.0f - 1e-6f) / extent : 0.0f};
}

Split best_split(const BuildItem *items, size_t n, const Box &centers) {
  Box boxes[3][BINS];
  uint32_t counts[3][BINS] = {};
  Binning binning[3] = {make_binning(centers, 0), make_binning(centers, 1), make_binning(centers, 2)};
  for (size_t i = 0; i < n; i++)
    for (int axis = 0; axis < 3; axis++) {
      int bin = binning[axis](items[i], axis);
      boxes[axis][bin].add(items[i].lo, items[i].hi);
      counts[axis][bin]++;
    }
  Split best;
  for (int axis = 0; axis < 3; axis++) {
    if (binning[axis].scale == 0.0f) continue;
    float right_cost[BINS];
    Box right;
    uint32_t right_count = 0;
    for (int b = BINS - 1; b > 0; b--) {
      right.add(boxes[axis][b]);
      right_count += counts[axis][b];
      right_cost[b] = right.half_area() * float(right_count);
    }
    Box left;
    uint32_t left_count = 0;
    for (int b = 1; b < BINS; b++) {
      left.add(boxes[axis][b - 1]);
      left_count += counts[axis][b - 1];
      float cost = left.half_area() * float(left_count) + right_cost[b];
      if (left_count > 0 && left_count < n && cost < best.cost) best = {cost, axis, b};
    }
  }
  return best;
}

/* Items [first, end) that a node is to be made of. */
struct Part {
  uint32_t node;
  size_t first, end;
  int depth;
  size_t size() const { return end - first; }
};

class Builder {
 public:
  Builder(std::vector<BuildItem> &items, int max_leaf)
      : items_(items), max_leaf_(uint32_t(max_leaf)), nodes_(2 * items.size()) {}

  /* The largest parts are split one after the other until there are enough of them to share out; no OpenMP
   * tasks, because libomp 19 loses track of their memory when the threads that called it come and go. */
  void build(int threads) {
    used_ = 1;
    std::vector<Part> parts{{0, 0, items_.size(), 0}};
    auto smaller = [](const Part &a, const Part &b) { return a.size() < b.size(); };
    while (!parts.empty() && parts.size() < size_t(PARTS_PER_THREAD * threads) && parts.front().size() > SMALL_PART) {
      std::pop_heap(parts.begin(), parts.end(), smaller);
      Part part = parts.back(), halves[2];
      parts.pop_back();
      if (!split(part, halves)) continue;
      for (const Part &half : halves) {
        parts.push_back(half);
        std::push_heap(parts.begin(), parts.end(), smaller);
      }
    }
#pragma omp parallel for num_threads(threads) schedule(dynamic, 1)
    for (size_t i = 0; i < parts.size(); i++) subdivide(parts[i]);
  }

  const std::vector<TempNode> &nodes() const { return nodes_; }

 private:
  bool may_be_leaf(size_t first, size_t end) const {
    uint32_t kind = items_[first].kind();
    if (end - first > max_leaf_ || (kind == REF_INSTANCE && end - first > 1)) return false;
    for (size_t i = first + 1; i < end; i++)
      if (items_[i].kind() != kind) return false;
    return true;
  }

  /* Where to cut when no split by bins exists or the tree has become too deep. */
  size_t split_by_median(size_t first, size_t end, const Box &centers) {
    int axis = 0;
    for (int a = 1; a < 3; a++)
      if (centers.hi[a] - centers.lo[a] > centers.hi[axis] - centers.lo[axis]) axis = a;
    size_t middle = first + (end - first) / 2;
    std::nth_element(items_.begin() + long(first), items_.begin() + long(middle), items_.begin() + long(end),
                     [axis](const BuildItem &a, const BuildItem &b) {
                       float ca = center(a, axis), cb = center(b, axis);
                       return ca != cb ? ca < cb : a.kind() != b.kind() ? a.kind() < b.kind() : a.position < b.position;
                     });
    return middle;
  }

  void subdivide(const Part &part) {
    Part halves[2];
    if (!split(part, halves)) return;
    subdivide(halves[0]);
    subdivide(halves[1]);
  }

  /* Makes the part's node a leaf, or an inner node with two halves that are still to be done. */
  bool split(const Part &part, Part *halves) {
    TempNode &node = nodes_[part.node];
    size_t first = part.first, end = part.end, n = part.size();
    Box centers;
    for (size_t i = first; i < end; i++) {
      node.box.add(items_[i].lo, items_[i].hi);
      float c[3] = {center(items_[i], 0), center(items_[i], 1), center(items_[i], 2)};
      centers.add(c, c);
    }
    bool deep = MAX_DEPTH - part.depth <= 2 + int(std::ceil(std::log2(double(n) + 1.0)));
    Split best;
    if (n > 1 && !deep) best = best_split(&items_[first], n, centers);
    float area = node.box.half_area();
    bool worth = best.axis >= 0 && NODE_COST * area + ITEM_COST * best.cost < ITEM_COST * area * float(n);
    if (may_be_leaf(first, end) && (n == 1 || !worth)) {
      node.first = uint32_t(first);
      node.count = uint32_t(n);
      return false;
    }
    size_t middle;
    if (best.axis >= 0) {
      Binning binning = make_binning(centers, best.axis);
      auto cut = std::partition(items_.begin() + long(first), items_.begin() + long(end),
                                [&](const BuildItem &i) { return binning(i, best.axis) < best.bin; });
      middle = size_t(cut - items_.begin());
    } else {
      middle = split_by_median(first, end, centers);
    }
    node.count = 0;
    uint32_t left = used_.fetch_add(2);
    node.child[0] = left;
    node.child[1] = left + 1;
    halves[0] = {left, first, middle, part.depth + 1};
    halves[1] = {left + 1, middle, end, part.depth + 1};
    return true;
  }

  std::vector<BuildItem> &items_;
  uint32_t max_leaf_;
  std::vector<TempNode> nodes_;
  std::atomic<uint32_t> used_{0};
};

/* Lays the nodes out depth first; numbers follow from the shape of the tree alone. */
class Flattener {
 public:
  Flattener(const std::vector<TempNode> &from, const std::vector<BuildItem> &items, TreeBase base, Tree &tree)
      : from_(from), items_(items), base_(base), tree_(tree) {}

  uint32_t place(uint32_t index, int depth) {
    tree_.depth = std::max(tree_.depth, depth);
    const TempNode &node = from_[index];
    if (node.count) return place_leaf(node);
    uint32_t at = uint32_t(tree_.nodes.size());
    tree_.nodes.emplace_back();
    uint32_t refs[2] = {place(node.child[0], depth + 1), place(node.child[1], depth + 1)};
    Bvh2Node &out = tree_.nodes[at];
    for (int k = 0; k < 2; k++) {
      const Box &b = from_[node.child[k]].box;
      out.lo_x[k] = b.lo[0];
      out.lo_y[k] = b.lo[1];
      out.lo_z[k] = b.lo[2];
      out.hi_x[k] = b.hi[0];
      out.hi_y[k] = b.hi[1];
      out.hi_z[k] = b.hi[2];
      out.child[k] = refs[k];
      out.unused[k] = 0;
    }
    return base_.node + at; /* REF_NODE is 0 */
  }

 private:
  uint32_t place_leaf(const TempNode &node) {
    uint32_t kind = items_[node.first].kind(), ref = items_[node.first].reference;
    if (kind != REF_INSTANCE) {
      uint32_t &placed = kind == REF_TRIANGLES ? triangles_ : spheres_;
      ref = kind << 30 | (placed + (kind == REF_TRIANGLES ? base_.triangle : base_.sphere));
      placed += node.count;
    }
    for (uint32_t i = 0; i < node.count; i++) {
      tree_.order.push_back(items_[node.first + i].position);
      tree_.last.push_back(i + 1 == node.count);
    }
    return ref;
  }

  const std::vector<TempNode> &from_;
  const std::vector<BuildItem> &items_;
  TreeBase base_;
  Tree &tree_;
  uint32_t triangles_ = 0, spheres_ = 0;
};

}  // namespace

Tree build_tree(std::vector<BuildItem> &items, TreeBase base, int max_leaf, int threads) {
  Tree tree;
  tree.root = NONE;
  tree.depth = 0;
  if (items.empty()) return tree;
  Builder builder(items, max_leaf);
  builder.build(threads);
  tree.order.reserve(items.size());
  tree.last.reserve(items.size());
  tree.nodes.reserve(items.size());
  tree.root = Flattener(builder.nodes(), items, base, tree).place(0, 1);
  return tree;
}

}  // namespace isophote
