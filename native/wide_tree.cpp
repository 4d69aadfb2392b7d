#include "wide_tree.h"

#include <algorithm>
#include <limits>
#include <unordered_map>

namespace isophote {
namespace {

constexpr uint32_t SEVERAL = 0xffffffffu;

/* A child to be placed: its reference in the BVH2 and its box. */
struct Child {
  uint32_t ref;
  float lo[3], hi[3];
  float half_area() const {
    float x = hi[0] - lo[0], y = hi[1] - lo[1], z = hi[2] - lo[2];
    return x * y + y * z + z * x;
  }
};

Child child_of(const Bvh2Node &n, int k) {
  return {n.child[k], {n.lo_x[k], n.lo_y[k], n.lo_z[k]}, {n.hi_x[k], n.hi_y[k], n.hi_z[k]}};
}

class Collapser {
 public:
  Collapser(const Bvh2Node *nodes, const Triangle *triangles, WideTree &tree)
      : nodes_(nodes), triangles_(triangles), tree_(tree) {}

  uint32_t place(uint32_t ref) {
    uint32_t first = 0, count = triangles_below(ref, first);
    if (REF_KIND(ref) == REF_TRIANGLES || count <= BLOCK) return place_blocks(first, count);
    if (REF_KIND(ref) != REF_NODE) return ref;
    Child open[WIDTH];
    int n = gather(ref, open);
    uint32_t at = uint32_t(tree_.nodes.size());
    tree_.nodes.emplace_back();
    for (int k = 0; k < WIDTH; k++) {
      uint32_t below = k < n ? place(open[k].ref) : NONE;
      WideNode &node = tree_.nodes[at]; /* may have moved */
      for (int axis = 0; axis < 3; axis++) {
        node.bounds[2 * axis][k] = k < n ? open[k].lo[axis] : std::numeric_limits<float>::infinity();
        node.bounds[2 * axis + 1][k] = k < n ? open[k].hi[axis] : -std::numeric_limits<float>::infinity();
      }
      node.child[k] = below;
    }
    return at;
  }

 private:
  /* Number of triangles below a reference, SEVERAL where there are more than a block holds or other
   * things among them; first is that of the lowest number. */
  uint32_t triangles_below(uint32_t ref, uint32_t &first) const {
    if (REF_KIND(ref) == REF_TRIANGLES) {
      first = REF_INDEX(ref);
      uint32_t last = first;
      while (!(triangles_[last].slot & LAST_IN_LEAF)) last++;
      return last - first + 1;
    }
    if (REF_KIND(ref) != REF_NODE) return SEVERAL;
    uint32_t left_first = 0, right_first = 0;
    uint32_t left = triangles_below_shallow(nodes_[ref].child[0], left_first);
    uint32_t right = triangles_below_shallow(nodes_[ref].child[1], right_first);
    if (left == SEVERAL || right == SEVERAL || left + right > BLOCK) return SEVERAL;
    first = std::min(left_first, right_first);
    return left + right;
  }

  /* The same for a child: four triangles make a tree of at most three inner nodes. */
  uint32_t triangles_below_shallow(uint32_t ref, uint32_t &first) const {
    if (REF_KIND(ref) != REF_NODE) return triangles_below(ref, first);
    for (uint32_t child : nodes_[ref].child)
      if (REF_KIND(child) == REF_NODE) {
        for (uint32_t grandchild : nodes_[child].child)
          if (REF_KIND(grandchild) == REF_NODE) return SEVERAL;
      }
    return triangles_below(ref, first);
  }

  int gather(uint32_t ref, Child *open) const {
    open[0] = child_of(nodes_[ref], 0);
    open[1] = child_of(nodes_[ref], 1);
    int n = 2;
    while (n < WIDTH) {
      int widest = -1;
      for (int k = 0; k < n; k++) {
        uint32_t first;
        if (REF_KIND(open[k].ref) != REF_NODE || triangles_below(open[k].ref, first) <= BLOCK) continue;
        if (widest < 0 || open[k].half_area() > open[widest].half_area()) widest = k;
      }
      if (widest < 0) break;
      const Bvh2Node &node = nodes_[open[widest].ref];
      open[widest] = child_of(node, 0);
      open[n++] = child_of(node, 1);
    }
    return n;
  }

  uint32_t place_blocks(uint32_t first, uint32_t count) {
    uint32_t at = uint32_t(tree_.blocks.size());
    for (uint32_t done = 0; done < count; done += BLOCK) {
      TriangleBlock b{};
      b.first = first + done;
      b.count = std::min(count - done, uint32_t(BLOCK));
      for (uint32_t k = 0; k < b.count; k++) {
        const Triangle &t = triangles_[b.first + k];
        const packed3 *corners[3] = {&t.v0, &t.v1, &t.v2};
        for (int c = 0; c < 3; c++) {
          b.corner[c][0][k] = corners[c]->x;
          b.corner[c][1][k] = corners[c]->y;
          b.corner[c][2][k] = corners[c]->z;
        }
        b.primitive[k] = t.primitive;
        b.instance[k] = t.instance;
        b.visibility[k] = t.instance == NONE ? RAY_ALL : uint16_t(t.slot >> 16 & RAY_ALL);
      }
      if (done + BLOCK >= count) b.count |= LAST_IN_LEAF;
      tree_.blocks.push_back(b);
    }
    return REF_TRIANGLES << 30 | at;
  }

  const Bvh2Node *nodes_;
  const Triangle *triangles_;
  WideTree &tree_;
};

}  // namespace

WideTree make_wide_tree(const Bvh2Node *nodes, const Triangle *triangles, const Instance *instances,
                        size_t instance_count, uint32_t root) {
  WideTree tree;
  Collapser collapser(nodes, triangles, tree);
  tree.root = root == NONE ? NONE : collapser.place(root);
  std::unordered_map<uint32_t, uint32_t> placed;
  tree.roots.assign(instance_count, NONE);
  for (size_t i = 0; i < instance_count; i++) {
    uint32_t from = instances[i].root;
    if (from == NONE) continue;
    auto [entry, fresh] = placed.try_emplace(from, NONE);
    if (fresh) entry->second = collapser.place(from);
    tree.roots[i] = entry->second;
  }
  return tree;
}

}  // namespace isophote
