#include "wide_tree.h"

#include <omp.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>

#include "bvh_node.h"

namespace isophote {
namespace {

constexpr float NODE_COST = 1.0f, BLOCK_COST = 0.6f; /* of testing eight boxes, and four triangles */
constexpr uint32_t MAX_LEAF = 2 * BLOCK;             /* triangles */
constexpr uint32_t SMALL = 4096;                     /* nodes of the BVH2 that one thread takes at a time */
constexpr uint32_t SEVERAL = 0xffffffffu;

struct ChildBox {
  float lo[3], hi[3];
  float half_area() const {
    float x = hi[0] - lo[0], y = hi[1] - lo[1], z = hi[2] - lo[2];
    return x * y + y * z + z * x;
  }
};

ChildBox box_of(const Bvh2Node &n, int k) {
  ChildBox box;
  get_box(n, k, box.lo, box.hi);
  return box;
}

/* How the subtree below a node of the BVH2 is laid out best. */
struct Choice {
  float cost[WIDTH - 1]; /* as at most 1 + i children of a wide node */
  uint8_t left[WIDTH];   /* children of 1 + i that the left half gets, 0: one child less is as good; [0]: is a leaf */
  uint32_t first, count; /* triangles below; SEVERAL where there are too many for a leaf, or other things */
};

struct Size {
  uint32_t nodes, blocks;
};

/* Nodes [first, end) of the BVH2: a node and all below it. */
struct Range {
  uint32_t first, end;
};

/* A part of the wide tree that one thread fills in, and where. */
struct Part {
  uint32_t ref;
  Size at, size;
};

/* Children of a wide node. */
struct Opened {
  int count = 0;
  std::array<ChildBox, WIDTH> boxes;
  std::array<uint32_t, WIDTH> refs;
};

class Collapser {
 public:
  Collapser(const WideSource &source, int threads)
      : nodes_(source.nodes), node_count_(uint32_t(source.node_count)), leaves_(source.leaves), root_(source.root),
        threads_(threads), choices_(std::make_unique_for_overwrite<Choice[]>(source.node_count)) {}

  /* Decides what becomes of the tree. Returns its size. */
  Size choose() {
    if (root_ == NONE) return {};
    if (REF_KIND(root_) == REF_NODE) choose_all();
    find_parts(root_);
#pragma omp parallel for num_threads(threads_) schedule(dynamic, 1) if (parts_.size() > 1)
    for (size_t i = 0; i < parts_.size(); i++) parts_[i].size = measure(parts_[i].ref);
    Size total{above_, 0};
    for (const Part &part : parts_) total = {total.nodes + part.size.nodes, total.blocks + part.size.blocks};
    return total;
  }

  /* Fills its places of the wide tree, from `at` on. Returns the reference to its root. */
  uint32_t collapse(Size at, WideTree &tree) {
    if (root_ == NONE) return NONE;
    size_t part = 0;
    uint32_t placed = place_above(root_, at, part, tree);
#pragma omp parallel for num_threads(threads_) schedule(dynamic, 1) if (parts_.size() > 1)
    for (size_t i = 0; i < parts_.size(); i++) place(parts_[i].ref, parts_[i].at, tree);
    return placed;
  }

 private:
  /* ------------------------------------------------------------ choosing */

  void choose_all() {
    cut({root_, node_count_});
#pragma omp parallel for num_threads(threads_) schedule(dynamic, 1) if (ranges_.size() > 1)
    for (size_t i = 0; i < ranges_.size(); i++)
      for (uint32_t at = ranges_[i].end; at-- > ranges_[i].first;) choose(at);
    for (size_t i = top_.size(); i-- > 0;) choose(top_[i]);
  }

  /* Cuts a tree into small ranges and the nodes above them. */
  void cut(Range range) {
    if (range.end - range.first <= SMALL) return ranges_.push_back(range);
    top_.push_back(range.first);
    const uint32_t *child = nodes_[range.first].child;
    if (REF_KIND(child[0]) == REF_NODE) cut({child[0], REF_KIND(child[1]) == REF_NODE ? child[1] : range.end});
    if (REF_KIND(child[1]) == REF_NODE) cut({child[1], range.end});
  }

  Choice choice_of(const Bvh2Node &n, int k) const {
    uint32_t ref = n.child[k];
    if (REF_KIND(ref) == REF_NODE) return choices_[ref];
    Choice c;
    c.first = 0;
    c.count = REF_KIND(ref) == REF_TRIANGLES ? count_run(ref) : SEVERAL;
    if (c.count != SEVERAL) c.first = REF_INDEX(ref);
    for (float &cost : c.cost) cost = box_of(n, k).half_area() * leaf_cost(c.count);
    return c;
  }

  void choose(uint32_t at) {
    const Bvh2Node &n = nodes_[at];
    Choice l = choice_of(n, 0), r = choice_of(n, 1);
    Choice &c = choices_[at];
    ChildBox box = box_of(n, 0), other = box_of(n, 1);
    for (int axis = 0; axis < 3; axis++) {
      box.lo[axis] = std::min(box.lo[axis], other.lo[axis]);
      box.hi[axis] = std::max(box.hi[axis], other.hi[axis]);
    }
    float spread[WIDTH]; /* as exactly 1 + i children */
    for (int i = 1; i < WIDTH; i++) {
      spread[i] = std::numeric_limits<float>::infinity();
      c.left[i] = 1;
      for (int k = 0; k < i; k++) {
        float cost = l.cost[k] + r.cost[i - 1 - k];
        if (cost < spread[i]) {
          spread[i] = cost;
          c.left[i] = uint8_t(k + 1);
        }
      }
    }
    float area = box.half_area();
    bool fits = l.count != SEVERAL && r.count != SEVERAL && l.count + r.count <= MAX_LEAF;
    c.first = l.first; /* of the lower half, because the BVH2 lies depth first */
    c.count = fits ? l.count + r.count : SEVERAL;
    c.cost[0] = area * NODE_COST + spread[WIDTH - 1];
    c.left[0] = fits && area * leaf_cost(c.count) <= c.cost[0];
    if (c.left[0]) c.cost[0] = area * leaf_cost(c.count);
    for (int i = 1; i < WIDTH - 1; i++) {
      c.cost[i] = std::min(spread[i], c.cost[i - 1]);
      if (c.cost[i - 1] <= spread[i]) c.left[i] = 0;
    }
  }

  static uint32_t blocks_of(uint32_t count) { return (count + BLOCK - 1) / BLOCK; }
  static float leaf_cost(uint32_t count) { return BLOCK_COST * (count == SEVERAL ? 1.0f : float(blocks_of(count))); }

  uint32_t count_run(uint32_t ref) const {
    uint32_t last = REF_INDEX(ref);
    while (!leaves_.last[last]) last++;
    return last - REF_INDEX(ref) + 1;
  }

  /* ------------------------------------------------------------- placing */

  bool is_leaf(uint32_t ref) const { return REF_KIND(ref) != REF_NODE || choices_[ref].left[0]; }

  Opened open(uint32_t ref) const {
    Opened opened;
    open(ref, WIDTH, opened);
    return opened;
  }

  void open(uint32_t ref, int share, Opened &opened) const {
    int left = choices_[ref].left[share - 1];
    for (int k = 0; k < 2; k++) {
      uint32_t below = nodes_[ref].child[k];
      int own = REF_KIND(below) != REF_NODE ? 1 : k ? share - left : left;
      while (own > 1 && !choices_[below].left[own - 1]) own--;
      if (own > 1) {
        open(below, own, opened);
      } else {
        opened.boxes[size_t(opened.count)] = box_of(nodes_[ref], k);
        opened.refs[size_t(opened.count++)] = below;
      }
    }
  }

  bool is_above(uint32_t ref) const { return !is_leaf(ref) && std::binary_search(top_.begin(), top_.end(), ref); }

  /* The parts below a reference, depth first; counts the nodes above them. */
  void find_parts(uint32_t ref) {
    if (!is_above(ref)) return parts_.push_back({ref, {}, {}});
    above_++;
    Opened opened = open(ref);
    for (int k = 0; k < opened.count; k++) find_parts(opened.refs[size_t(k)]);
  }

  Size measure(uint32_t ref) const {
    if (REF_KIND(ref) == REF_TRIANGLES) return {0, blocks_of(count_run(ref))};
    if (is_leaf(ref)) return {0, REF_KIND(ref) == REF_NODE ? blocks_of(choices_[ref].count) : 0};
    Size size{1, 0};
    Opened opened = open(ref);
    for (int k = 0; k < opened.count; k++) {
      Size below = measure(opened.refs[size_t(k)]);
      size = {size.nodes + below.nodes, size.blocks + below.blocks};
    }
    return size;
  }

  /* Places the nodes above the parts and says where these will lie. Returns the new reference. */
  uint32_t place_above(uint32_t ref, Size &used, size_t &next, WideTree &tree) {
    if (!is_above(ref)) {
      Part &part = parts_[next++];
      part.at = used;
      used = {used.nodes + part.size.nodes, used.blocks + part.size.blocks};
      return new_reference(ref, part.at);
    }
    uint32_t at = used.nodes++;
    Opened opened = open(ref);
    for (int k = 0; k < opened.count; k++)
      opened.refs[size_t(k)] = place_above(opened.refs[size_t(k)], used, next, tree);
    fill(tree.nodes[at], opened);
    return at;
  }

  /* Moves `used` on. */
  uint32_t place(uint32_t ref, Size &used, WideTree &tree) const {
    uint32_t made = new_reference(ref, used);
    if (REF_KIND(made) == REF_TRIANGLES) {
      bool run = REF_KIND(ref) == REF_TRIANGLES;
      place_blocks(run ? REF_INDEX(ref) : choices_[ref].first, run ? count_run(ref) : choices_[ref].count, used, tree);
    } else if (REF_KIND(made) == REF_NODE) {
      used.nodes++;
      Opened opened = open(ref);
      for (int k = 0; k < opened.count; k++) opened.refs[size_t(k)] = place(opened.refs[size_t(k)], used, tree);
      fill(tree.nodes[made], opened);
    }
    return made;
  }

  uint32_t new_reference(uint32_t ref, Size at) const {
    if (REF_KIND(ref) == REF_NODE && !is_leaf(ref)) return at.nodes; /* REF_NODE is 0 */
    return REF_KIND(ref) == REF_NODE || REF_KIND(ref) == REF_TRIANGLES ? REF_TRIANGLES << 30 | at.blocks : ref;
  }

  static void fill(WideNode &node, const Opened &opened) {
    for (size_t k = 0; k < WIDTH; k++) {
      bool there = k < size_t(opened.count);
      for (size_t axis = 0; axis < 3; axis++) {
        node.bounds[2 * axis][k] = there ? opened.boxes[k].lo[axis] : std::numeric_limits<float>::infinity();
        node.bounds[2 * axis + 1][k] = there ? opened.boxes[k].hi[axis] : -std::numeric_limits<float>::infinity();
      }
      node.child[k] = there ? opened.refs[k] : NONE;
    }
  }

  void place_blocks(uint32_t first, uint32_t count, Size &used, WideTree &tree) const {
    for (uint32_t done = 0; done < count; done += BLOCK) {
      TriangleBlock &b = tree.blocks[used.blocks++];
      b = {};
      b.count = std::min(count - done, uint32_t(BLOCK));
      for (uint32_t k = 0; k < b.count; k++) set_triangle(b, k, leaves_.meshes.record(leaves_.order[first + done + k]));
      if (done + BLOCK >= count) b.count |= LAST_IN_LEAF;
    }
  }

  const Bvh2Node *nodes_;
  uint32_t node_count_;
  const LeafTriangles &leaves_;
  uint32_t root_;
  int threads_;
  std::unique_ptr<Choice[]> choices_;
  std::vector<Range> ranges_;
  std::vector<uint32_t> top_; /* nodes above the ranges, rising */
  std::vector<Part> parts_;
  uint32_t above_ = 0; /* wide nodes above the parts */
};

Size size_of(const WideTree &tree, size_t part) {
  return {tree.node_end(part) - tree.parts[part].node, tree.block_end(part) - tree.parts[part].block};
}

/* Copies a part of another tree to where `to` says, with its references. */
void copy_part(const WideTree &from, size_t part, WidePart &to, WideTree &tree, int threads) {
  WidePart old = from.parts[part];
  uint32_t moved[4] = {to.node - old.node, to.block - old.block, 0, 0}; /* by kind of reference */
  Size size = size_of(from, part);
#pragma omp parallel for num_threads(threads) schedule(static) if (size.nodes > SMALL)
  for (uint32_t i = 0; i < size.nodes; i++) {
    WideNode &node = tree.nodes[to.node + i] = from.nodes[old.node + i];
    for (uint32_t &child : node.child) child += child == NONE ? 0 : moved[REF_KIND(child)];
  }
#pragma omp parallel for num_threads(threads) schedule(static) if (size.blocks > SMALL)
  for (uint32_t i = 0; i < size.blocks; i++) tree.blocks[to.block + i] = from.blocks[old.block + i];
  to.root = old.root == NONE ? NONE : old.root + moved[REF_KIND(old.root)];
  to.triangles = old.triangles;
  to.built_cost = old.built_cost;
}

}  // namespace

void set_triangle(TriangleBlock &b, uint32_t k, const Triangle &t) {
  const packed3 *corners[3] = {&t.v0, &t.v1, &t.v2};
  for (int c = 0; c < 3; c++) {
    b.corner[c][0][k] = corners[c]->x;
    b.corner[c][1][k] = corners[c]->y;
    b.corner[c][2][k] = corners[c]->z;
  }
  b.primitive[k] = t.primitive;
  b.instance[k] = t.instance;
  constexpr uint32_t kinds = RAY_ALL | RAY_ALL << CATCHER_SHIFT;
  b.visibility[k] = uint16_t(t.instance == NONE ? kinds : t.flags >> 16 & kinds);
}

double part_cost(const WideTree &tree, size_t part) {
  double sum = 0.0, whole = 0.0;
  for (uint32_t i = tree.parts[part].node; i < tree.node_end(part); i++) {
    const WideNode &n = tree.nodes[i];
    ChildBox all;
    for (size_t axis = 0; axis < 3; axis++) {
      all.lo[axis] = *std::min_element(n.bounds[2 * axis], n.bounds[2 * axis] + WIDTH);
      all.hi[axis] = *std::max_element(n.bounds[2 * axis + 1], n.bounds[2 * axis + 1] + WIDTH);
    }
    if (i == tree.parts[part].node) whole = double(all.half_area());
    sum += double(all.half_area() * NODE_COST);
    for (size_t k = 0; k < WIDTH; k++) {
      uint32_t ref = n.child[k], blocks = 1;
      if (ref == NONE || REF_KIND(ref) == REF_NODE) continue;
      if (REF_KIND(ref) == REF_TRIANGLES)
        while (!(tree.blocks[REF_INDEX(ref) + blocks - 1].count & LAST_IN_LEAF)) blocks++;
      ChildBox box{{n.bounds[0][k], n.bounds[2][k], n.bounds[4][k]}, {n.bounds[1][k], n.bounds[3][k], n.bounds[5][k]}};
      sum += double(box.half_area() * BLOCK_COST * float(blocks));
    }
  }
  return whole > 0.0 ? sum / whole : 1.0;
}

WideTree make_wide_tree(const std::vector<WideSource> &sources, const uint32_t *tree_of, size_t instance_count, int threads) {
  WideTree tree;
  std::vector<std::unique_ptr<Collapser>> collapsers;
  Size used{};
  for (const WideSource &source : sources) {
    tree.parts.push_back({NONE, used.nodes, used.blocks, uint32_t(source.leaves.count), 0.0});
    collapsers.push_back(source.kept ? nullptr : std::make_unique<Collapser>(source, threads));
    Size size = source.kept ? size_of(*source.kept, source.part) : collapsers.back()->choose();
    used = {used.nodes + size.nodes, used.blocks + size.blocks};
  }
  tree.nodes.resize(used.nodes);
  tree.blocks.resize(used.blocks);
  for (size_t k = 0; k < sources.size(); k++) {
    WidePart &part = tree.parts[k];
    if (sources[k].kept) {
      copy_part(*sources[k].kept, sources[k].part, part, tree, threads);
    } else {
      part.root = collapsers[k]->collapse({part.node, part.block}, tree);
      part.built_cost = part_cost(tree, k);
    }
    collapsers[k].reset();
  }
  tree.root = tree.parts.back().root;
  for (size_t i = 0; i < instance_count; i++) tree.roots.push_back(tree_of[i] == NONE ? NONE : tree.parts[tree_of[i]].root);
  return tree;
}

}  // namespace isophote
