#include "bvh_build.h"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "bvh_node.h"
#include "bvh_split.h"
#include "presplit.h"

namespace isophote {
namespace {

constexpr int MAX_DEPTH = 44; /* kernels/bvh.h keeps a stack of 96 for two levels */
constexpr size_t CHUNK = 4096; /* items that one thread bins or moves at a time */
constexpr size_t PARTS = 256;  /* about how many subtrees are shared out */
constexpr float NODE_COST = 1.0f;

/* Items [first, end) that a subtree is to be made of, and the bounds of their boxes and centers. They lie
 * in one of two arrays, between which they go to and fro as parts are split. */
struct Part {
  size_t first, end;
  int depth, array;
  Box box, centers;
  size_t size() const { return end - first; }
};

void set_child(Bvh2Node &node, int k, uint32_t ref, Box box) {
  node.child[k] = ref;
  const float lo[3] = {box[0], box[1], box[2]}, hi[3] = {-box[4], -box[5], -box[6]};
  set_box(node, k, lo, hi);
}

struct Subtree {
  std::vector<Bvh2Node> nodes; /* depth first; REF_NODE counts from 0 */
  uint32_t root = NONE;
  int depth = 0;
};

class Builder {
 public:
  Builder(BuildInput input, int max_leaf, int threads)
      : input_(std::move(input)), max_leaf_(size_t(max_leaf)), n_(input_.size()), large_(std::max(4 * CHUNK, n_ / PARTS)),
        threads_(n_ > CHUNK ? threads : 1) /* waking others takes longer than a small tree */ {
    items_[0] = std::make_unique_for_overwrite<Item[]>(n_);
  }

  Tree build() {
    double started = omp_get_wtime();
    Part whole = make_items();
    if (input_.triangles()) add_pieces(whole);
    items_[1] = std::make_unique_for_overwrite<Item[]>(n_);
    tree_.order.resize(n_);
    tree_.last.resize(n_);
    double made = omp_get_wtime();
    std::vector<Bins> bins;
    split_large(whole, bins);
#pragma omp parallel num_threads(threads_)
    {
      Bins own;
#pragma omp for schedule(dynamic, 1)
      for (size_t i = 0; i < parts_.size(); i++) {
        subtrees_[i].nodes.reserve(parts_[i].size());
        subtrees_[i].root = subdivide(parts_[i], subtrees_[i], own);
      }
    }
    for (auto &array : items_) array.reset();
    double split = omp_get_wtime();
    join();
    double seconds[3] = {made - started, split - made, omp_get_wtime() - split};
    std::copy(seconds, seconds + 3, tree_.seconds);
    return std::move(tree_);
  }

 private:
  /* An inner node above the subtrees that are shared out; at the end of a path, the subtree's number. */
  struct TopNode {
    Box box;
    uint32_t left, right, part;
  };

  size_t chunks(size_t n) const { return n > large_ ? (n + CHUNK - 1) / CHUNK : 1; }

  Item make_item_of(size_t i) const {
    Box box{};
    uint32_t position = input_.position_of(i);
    if (i < input_.triangles()) {
      const float *p = input_.meshes.corner(position, 0), *q = input_.meshes.corner(position, 1);
      const float *r = input_.meshes.corner(position, 2);
      for (int a = 0; a < 3; a++) {
        box[a] = std::min({p[a], q[a], r[a]});
        box[4 + a] = -std::max({p[a], q[a], r[a]});
      }
    } else {
      for (int a = 0; a < 3; a++) {
        box[a] = input_.lo[3 * (i - input_.triangles()) + size_t(a)];
        box[4 + a] = -input_.hi[3 * (i - input_.triangles()) + size_t(a)];
      }
    }
    return make_item(widened(box, input_.margin), position, input_.reference_of(position));
  }

  static Box widened(Box box, float margin) {
    float largest = 0.0f;
    for (int a = 0; a < 3; a++) largest = std::max({largest, fabs(box[a]), fabs(box[4 + a])});
    return box - largest * margin;
  }

  /* Puts a piece in the place of each triangle that is cut, and the others at the end. */
  void add_pieces(Part &whole) {
    std::vector<Piece> pieces = cut_slanted(input_, whole.box, threads_);
    if (pieces.empty()) return;
    std::vector<Item> items(items_[0].get(), items_[0].get() + n_);
    uint32_t before = NONE;
    for (const Piece &piece : pieces) {
      /* Twice as wide, because cutting rounds too. */
      Item item = make_item(widened(piece.box, 2.0f * input_.margin), input_.position_of(piece.triangle), REF_TRIANGLES << 30);
      if (piece.triangle != before)
        items[piece.triangle] = item;
      else
        items.push_back(item);
      before = piece.triangle;
    }
    n_ = items.size();
    items_[0] = std::make_unique_for_overwrite<Item[]>(n_);
    std::copy(items.begin(), items.end(), items_[0].get());
    whole = bounded(items_[0].get(), 0, n_, whole);
    whole.depth = 1;
  }

  Part make_items() {
    std::vector<Box> boxes(n_ / CHUNK + 1, no_box()), centers(boxes);
#pragma omp parallel for num_threads(threads_) schedule(static)
    for (size_t chunk = 0; chunk < boxes.size(); chunk++)
      for (size_t i = chunk * CHUNK; i < std::min(n_, (chunk + 1) * CHUNK); i++) {
        Item item = items_[0][i] = make_item_of(i);
        Float4 center = half_center(item);
        boxes[chunk] = unite(boxes[chunk], item);
        centers[chunk] = unite(centers[chunk], twice(center, -center));
      }
    Part whole{0, n_, 1, 0, no_box(), no_box()};
    for (Box b : boxes) whole.box = unite(whole.box, b);
    for (Box b : centers) whole.centers = unite(whole.centers, b);
    return whole;
  }

  /* Splits what is large with all threads; no OpenMP tasks, because libomp 19 loses track of their memory
   * when the threads that called it come and go. Returns the number of the part's node in top_. */
  uint32_t split_large(const Part &part, std::vector<Bins> &bins) {
    uint32_t at = uint32_t(top_.size());
    top_.push_back({part.box, NONE, NONE, uint32_t(parts_.size())});
    Part halves[2];
    if (bins.size() < 1 + chunks(part.size())) bins.resize(1 + chunks(part.size()));
    if (part.size() <= large_ || !split(part, bins.data(), halves)) {
      parts_.push_back(part);
      subtrees_.emplace_back();
      return at;
    }
    uint32_t left = split_large(halves[0], bins), right = split_large(halves[1], bins);
    top_[at].left = left;
    top_[at].right = right;
    return at;
  }

  /* Returns the reference to the part's root. */
  uint32_t subdivide(const Part &part, Subtree &tree, Bins &bins) {
    Part halves[2];
    tree.depth = std::max(tree.depth, part.depth);
    if (part.size() <= SMALLEST) return subdivide_smallest(part, tree);
    if (!split(part, &bins, halves)) return place_leaf(part);
    uint32_t at = uint32_t(tree.nodes.size());
    tree.nodes.emplace_back();
    for (int k = 0; k < 2; k++) {
      uint32_t ref = subdivide(halves[k], tree, bins);
      set_child(tree.nodes[at], k, ref, halves[k].box);
    }
    return at; /* REF_NODE is 0 */
  }

  uint32_t subdivide_smallest(const Part &part, Subtree &tree) {
    const Item *items = &items_[part.array][part.first];
    Subsets sets;
    uint32_t may_be_leaf = 0;
    for (uint32_t set = 1; set < 1u << part.size(); set++) {
      uint32_t kinds = 0, count = uint32_t(std::popcount(set));
      for (uint32_t rest = set; rest; rest &= rest - 1) kinds |= 1u << REF_KIND(reference(items[std::countr_zero(rest)]));
      bool fits = count == 1 || (count <= max_leaf_ && kinds == 1u << REF_TRIANGLES);
      may_be_leaf |= uint32_t(fits) << set;
    }
    sets.solve(items, part.size(), may_be_leaf, NODE_COST, input_.item_cost);
    size_t used = part.first;
    return place_subset(items, sets, (1u << part.size()) - 1, part.depth, used, tree);
  }

  uint32_t place_subset(const Item *items, const Subsets &sets, uint32_t set, int depth, size_t &used, Subtree &tree) {
    tree.depth = std::max(tree.depth, depth);
    if (!sets.left[set]) {
      size_t first = used;
      for (uint32_t rest = set; rest; rest &= rest - 1) {
        tree_.order[used] = position(items[std::countr_zero(rest)]);
        tree_.last[used++] = !(rest & (rest - 1));
      }
      uint32_t ref = reference(items[std::countr_zero(set)]);
      return REF_KIND(ref) == REF_TRIANGLES ? ref | uint32_t(first) : ref;
    }
    uint32_t at = uint32_t(tree.nodes.size());
    tree.nodes.emplace_back();
    uint32_t halves[2] = {sets.left[set], set ^ sets.left[set]};
    for (int k = 0; k < 2; k++) {
      uint32_t ref = place_subset(items, sets, halves[k], depth + 1, used, tree);
      set_child(tree.nodes[at], k, ref, sets.box[halves[k]]);
    }
    return at;
  }

  bool may_be_leaf(const Part &part) const {
    const Item *items = &items_[part.array][part.first];
    if (part.size() == 1) return true;
    if (part.size() > max_leaf_) return false;
    for (size_t i = 0; i < part.size(); i++)
      if (REF_KIND(reference(items[i])) != REF_TRIANGLES) return false;
    return true;
  }

  /* False where the part shall be a leaf, else its halves. */
  bool split(const Part &part, Bins *bins, Part *halves) {
    size_t n = part.size();
    bool leaf = may_be_leaf(part);
    if (leaf && n == 1) return false;
    bool deep = MAX_DEPTH - part.depth < 2 + int(std::bit_width(n));
    int used = bins_for(n);
    Binning binning(part.centers, used);
    Split best;
    if (!deep) {
      bin(part, binning, used, bins);
      best = best_split(bins[0]);
    }
    float area = half_area(part.box);
    float item = input_.item_cost;
    if (leaf && (best.axis < 0 || NODE_COST * area + item * best.cost >= item * area * float(n))) return false;
    if (best.axis < 0)
      split_by_median(part, halves);
    else
      split_by_bins(part, binning, best, bins, halves);
    return true;
  }

  /* bins[0] becomes the sum; bins[1] and following keep what each chunk has. */
  void bin(const Part &part, const Binning &binning, int used, Bins *bins) {
    const Item *items = &items_[part.array][part.first];
    size_t count = chunks(part.size());
    if (count == 1) {
      bins[0].clear(used);
      bins[0].add(items, part.size(), binning);
      return;
    }
#pragma omp parallel for num_threads(threads_) schedule(static)
    for (size_t chunk = 0; chunk < count; chunk++) {
      bins[1 + chunk].clear(used);
      bins[1 + chunk].add(items + chunk * CHUNK, std::min(CHUNK, part.size() - chunk * CHUNK), binning);
    }
    bins[0].clear(used);
    for (size_t chunk = 0; chunk < count; chunk++) bins[0].add(bins[1 + chunk]);
  }

  void split_by_bins(const Part &part, const Binning &binning, const Split &split, const Bins *bins, Part *halves) {
    size_t middle = part.first + bins[0].count_below(split.axis, split.bin), count = chunks(part.size());
    const Item *from = &items_[part.array][part.first];
    Item *to = items_[1 - part.array].get();
    halves[0] = {part.first, middle, part.depth + 1, 1 - part.array, bins[0].box_of(split.axis, 0, split.bin), no_box()};
    halves[1] = {middle, part.end, part.depth + 1, 1 - part.array, bins[0].box_of(split.axis, split.bin, bins[0].used), no_box()};
    Box centers[2] = {no_box(), no_box()};
    if (count == 1) {
      partition(from, part.size(), binning, split, to + part.first, to + middle, centers);
    } else {
      std::vector<size_t> left(count + 1, 0);
      for (size_t chunk = 0; chunk < count; chunk++)
        left[chunk + 1] = left[chunk] + bins[1 + chunk].count_below(split.axis, split.bin);
      std::vector<Box> all(2 * count, no_box());
#pragma omp parallel for num_threads(threads_) schedule(static)
      for (size_t chunk = 0; chunk < count; chunk++)
        partition(from + chunk * CHUNK, std::min(CHUNK, part.size() - chunk * CHUNK), binning, split,
                  to + part.first + left[chunk], to + middle + chunk * CHUNK - left[chunk], &all[2 * chunk]);
      for (size_t k = 0; k < all.size(); k++) centers[k & 1] = unite(centers[k & 1], all[k]);
    }
    for (int k = 0; k < 2; k++) halves[k].centers = centers[k];
  }

  /* Where no split by bins separates anything or the tree has become too deep. */
  void split_by_median(const Part &part, Part *halves) {
    Item *items = items_[part.array].get();
    Float4 e = extent(part.centers);
    int axis = e[1] > e[0] ? 1 : 0;
    if (e[2] > e[axis]) axis = 2;
    size_t middle = part.first + part.size() / 2;
    std::nth_element(items + part.first, items + middle, items + part.end, [axis](const Item &a, const Item &b) {
      float ca = half_center(a)[axis], cb = half_center(b)[axis];
      uint32_t ka = REF_KIND(reference(a)), kb = REF_KIND(reference(b));
      return ca != cb ? ca < cb : ka != kb ? ka < kb : position(a) < position(b);
    });
    halves[0] = bounded(items, part.first, middle, part);
    halves[1] = bounded(items, middle, part.end, part);
  }

  static Part bounded(const Item *items, size_t first, size_t end, const Part &parent) {
    Part part{first, end, parent.depth + 1, parent.array, no_box(), no_box()};
    for (size_t i = first; i < end; i++) {
      Float4 center = half_center(items[i]);
      part.box = unite(part.box, items[i]);
      part.centers = unite(part.centers, twice(center, -center));
    }
    return part;
  }

  /* Items of a leaf are numbered by their place in the order of all, until the whole tree is there. */
  uint32_t place_leaf(const Part &part) {
    const Item *items = &items_[part.array][part.first];
    for (size_t i = 0; i < part.size(); i++) {
      tree_.order[part.first + i] = position(items[i]);
      tree_.last[part.first + i] = i + 1 == part.size();
    }
    uint32_t ref = reference(items[0]);
    return REF_KIND(ref) == REF_TRIANGLES ? ref | uint32_t(part.first) : ref;
  }

  /* Lays the subtrees and the nodes above them out depth first. */
  void join() {
    std::vector<uint32_t> places(parts_.size()), numbers = number_triangles();
    uint32_t used = 0;
    tree_.nodes.resize(count_nodes());
    tree_.root = place(0, used, places, numbers);
    tree_.depth = 0;
    for (const Subtree &s : subtrees_) tree_.depth = std::max(tree_.depth, s.depth);
#pragma omp parallel for num_threads(threads_) schedule(dynamic, 1)
    for (size_t i = 0; i < subtrees_.size(); i++) {
      Bvh2Node *to = tree_.nodes.data() + places[i];
      for (const Bvh2Node &node : subtrees_[i].nodes) {
        *to = node;
        for (uint32_t &child : to->child) child = final_reference(child, places[i], numbers);
        to++;
      }
      subtrees_[i].nodes = {};
    }
  }

  size_t count_nodes() const {
    size_t count = subtrees_.size() - 1;
    for (const Subtree &s : subtrees_) count += s.nodes.size();
    return count;
  }

  uint32_t place(uint32_t at, uint32_t &used, std::vector<uint32_t> &places, const std::vector<uint32_t> &numbers) {
    const TopNode &node = top_[at];
    if (node.left == NONE) {
      places[node.part] = used;
      used += uint32_t(subtrees_[node.part].nodes.size());
      return final_reference(subtrees_[node.part].root, places[node.part], numbers);
    }
    uint32_t placed = used++;
    set_child(tree_.nodes[placed], 0, place(node.left, used, places, numbers), top_[node.left].box);
    set_child(tree_.nodes[placed], 1, place(node.right, used, places, numbers), top_[node.right].box);
    return placed; /* REF_NODE is 0 */
  }

  uint32_t final_reference(uint32_t ref, uint32_t place, const std::vector<uint32_t> &numbers) const {
    if (REF_KIND(ref) == REF_NODE) return place + ref;
    if (REF_KIND(ref) != REF_TRIANGLES || numbers.empty()) return ref;
    return REF_TRIANGLES << 30 | numbers[REF_INDEX(ref)];
  }

  /* How many triangles come before each item in the order; nothing where there are only triangles. */
  std::vector<uint32_t> number_triangles() const {
    std::vector<uint32_t> numbers(input_.others ? n_ : 0);
    uint32_t count = 0;
    for (size_t i = 0; i < numbers.size(); i++) {
      numbers[i] = count;
      count += REF_KIND(input_.reference_of(tree_.order[i])) == REF_TRIANGLES;
    }
    return numbers;
  }

  BuildInput input_;
  size_t max_leaf_, n_, large_;
  int threads_;
  std::unique_ptr<Item[]> items_[2];
  std::vector<TopNode> top_;
  std::vector<Part> parts_;
  std::vector<Subtree> subtrees_;
  Tree tree_;
};

}  // namespace

Tree build_tree(BuildInput input, int max_leaf, int threads) {
  input.set_starts();
  if (input.size() == 0) return {{}, {}, {}, NONE, 0, {}};
  return Builder(std::move(input), max_leaf, threads).build();
}

}  // namespace isophote
