/* The builder's inner loops: boxes, and how items of a part fall into bins along three axes. */
#pragma once
#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include <bit>
#include <cstdint>
#include <limits>

#include "../kernels/scene_records.h"
#include "wide_tree.h"

/* Vectors wider than the target's registers only pass between functions that are inlined. */
#pragma GCC diagnostic ignored "-Wpsabi"

namespace isophote {

typedef float Float4 __attribute__((vector_size(16)));
typedef float Float8 __attribute__((vector_size(32)));
typedef int32_t Int4 __attribute__((vector_size(16)));
typedef int32_t Int8 __attribute__((vector_size(32)));

constexpr int MAX_BINS = 64;
constexpr float SMALLEST_EXTENT = 1e-36f; /* whose reciprocal times the number of bins is still finite */

/* A part's number of bins: many where it holds much, and a good cut costs little in comparison. */
constexpr int bins_for(size_t items) {
  return items <= 32 ? 8 : items <= 512 ? 16 : items <= 4096 ? 32 : MAX_BINS;
}

/* Low corner, anything, negated high corner, anything: so a union is one minimum. */
typedef Float8 Box;

inline Box no_box() { return Box{} + std::numeric_limits<float>::infinity(); }
inline Box unite(Box a, Box b) { return a < b ? a : b; }
inline Float4 low(Box b) { return __builtin_shufflevector(b, b, 0, 1, 2, 3); }
inline Float4 negated_high(Box b) { return __builtin_shufflevector(b, b, 4, 5, 6, 7); }
inline Float4 extent(Box b) { return -negated_high(b) - low(b); }
inline Box twice(Float4 a, Float4 b) { return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7); }
inline float half_area(Box b) {
  Float4 e = extent(b), p = e * __builtin_shufflevector(e, e, 1, 2, 0, 3);
  return p[0] + p[1] + p[2];
}

/* A box whose free places hold the item's position in the input and its reference. Both are the bits of
 * normal numbers (see make_item), because arithmetic runs over them too and is slow with denormal ones. */
typedef Box Item;

inline Item make_item(Box box, uint32_t position, uint32_t reference) {
  box[3] = std::bit_cast<float>(0x40000000u | position);
  box[7] = std::bit_cast<float>(reference);
  return box;
}
inline uint32_t position(const Item &i) { return std::bit_cast<uint32_t>(float(i[3])) & 0x3fffffffu; }
inline uint32_t reference(const Item &i) { return std::bit_cast<uint32_t>(float(i[7])); }

/* Half the center, so that neither it nor differences overflow at the edge of float's range. */
inline Float4 half_center(Box b) { return 0.25f * low(b) - 0.25f * negated_high(b); }

/* The bins of an item, one an axis; 0 along axes that are too thin to split. */
struct Binning {
  Float4 low, scale;
  Binning(Box centers, int bins) : low(isophote::low(centers)) {
    Float4 e = extent(centers);
    scale = e > SMALLEST_EXTENT ? float(bins) * (1.0f - 1e-6f) / e : Float4{};
  }
  Int4 operator()(Float4 center) const {
#if defined(__SSE2__) /* else clang leaves vectors for scalars, because the fourth is not used */
    return Int4(_mm_cvttps_epi32(__m128((center - low) * scale)));
#else
    return __builtin_convertvector((center - low) * scale, Int4);
#endif
  }
};

struct Bins {
  int used;
  Box boxes[MAX_BINS][3];
  Int4 counts[MAX_BINS]; /* of the three axes */

  void clear(int bins) {
    used = bins;
    for (int b = 0; b < bins; b++) {
      for (Box &box : boxes[b]) box = no_box();
      counts[b] = Int4{};
    }
  }
  void add(const Item *items, size_t n, const Binning &binning) {
    for (size_t i = 0; i < n; i++) {
      Item item = items[i];
      Int4 bin = binning(half_center(item));
      for (int axis = 0; axis < 3; axis++) {
        Box &box = boxes[bin[axis]][axis];
        box = unite(box, item);
        reinterpret_cast<int32_t *>(&counts[bin[axis]])[axis]++;
      }
    }
  }
  void add(const Bins &other) {
    for (int b = 0; b < used; b++) {
      for (int axis = 0; axis < 3; axis++) boxes[b][axis] = unite(boxes[b][axis], other.boxes[b][axis]);
      counts[b] += other.counts[b];
    }
  }
  uint32_t count_below(int axis, int bin) const {
    uint32_t count = 0;
    for (int b = 0; b < bin; b++) count += uint32_t(counts[b][axis]);
    return count;
  }
  Box box_of(int axis, int first, int end) const {
    Box box = no_box();
    for (int b = first; b < end; b++) box = unite(box, boxes[b][axis]);
    return box;
  }
};

/* Items in bins below `bin` along `axis` go left; axis -1 where no split separates anything. */
struct Split {
  float cost = std::numeric_limits<float>::infinity(); /* sum of area times number of items, in full blocks */
  int axis = -1, bin = 0;
};

/* The boxes of the three axes grow bin by bin; their areas are found side by side. */
struct Sweep {
  Box box[3] = {no_box(), no_box(), no_box()};
  Int4 count{};
  Float4 cost; /* not a number where there is no item yet */

  void add(const Bins &bins, int bin) {
    for (int axis = 0; axis < 3; axis++) box[axis] = unite(box[axis], bins.boxes[bin][axis]);
    count += bins.counts[bin];
    Float4 a = extent(box[0]), b = extent(box[1]), c = extent(box[2]);
    Float4 ab = __builtin_shufflevector(a, b, 0, 4, 1, 5), abz = __builtin_shufflevector(a, b, 2, 6, 2, 6);
    Float4 x = __builtin_shufflevector(ab, c, 0, 1, 4, 4), y = __builtin_shufflevector(ab, c, 2, 3, 5, 5);
    Float4 z = __builtin_shufflevector(abz, c, 0, 1, 6, 6);
    cost = (x * y + y * z + z * x) * __builtin_convertvector((count + (BLOCK - 1)) & -BLOCK, Float4);
  }
};

inline Split best_split(const Bins &bins) {
  Float4 right_cost[MAX_BINS];
  Sweep right, left;
  for (int b = bins.used - 1; b > 0; b--) {
    right.add(bins, b);
    right_cost[b] = right.cost;
  }
  Float4 best_cost = Float4{} + std::numeric_limits<float>::infinity();
  Int4 best_bin{};
  for (int b = 1; b < bins.used; b++) {
    left.add(bins, b - 1);
    Float4 cost = left.cost + right_cost[b];
    Int4 better = cost < best_cost;
    best_cost = better ? cost : best_cost;
    best_bin = better ? Int4{} + b : best_bin;
  }
  Split best;
  for (int axis = 0; axis < 3; axis++)
    if (best_cost[axis] < best.cost) best = {best_cost[axis], axis, best_bin[axis]};
  return best;
}

/* The best of all trees over at most SMALLEST items, found subset by subset; subsets are masks. */
constexpr int SMALLEST = 4;
struct Subsets {
  Box box[1 << SMALLEST];
  float cost[1 << SMALLEST];
  uint8_t left[1 << SMALLEST] = {}; /* half of an inner node; 0 for leaves */

  /* may_be_leaf says which subsets, a bit each, may become leaves. */
  void solve(const Item *items, size_t n, uint32_t may_be_leaf, float node_cost, float item_cost) {
    for (uint32_t set = 1; set < 1u << n; set++) {
      uint32_t rest = set & (set - 1);
      box[set] = items[std::countr_zero(set)];
      if (rest) box[set] = unite(box[set], box[rest]);
      float area = half_area(box[set]), best = std::numeric_limits<float>::infinity();
      left[set] = uint8_t(set & -set);
      /* Every way to cut the set in two, the lowest item always on the right. */
      for (uint32_t half = rest; half; half = (half - 1) & rest) {
        float halves = cost[half] + cost[set ^ half];
        if (halves < best) {
          best = halves;
          left[set] = uint8_t(half);
        }
      }
      cost[set] = area * node_cost + best;
      float leaf = area * item_cost * float(std::popcount(set));
      if (may_be_leaf >> set & 1 && leaf <= cost[set]) {
        cost[set] = leaf;
        left[set] = 0;
      }
    }
  }
};

/* Moves items to where left and right point, keeping their order, and bounds the centers of either side. */
inline void partition(const Item *items, size_t n, const Binning &binning, const Split &split, Item *left, Item *right,
                      Box *centers) {
  Box left_centers = centers[0], right_centers = centers[1];
  for (size_t i = 0; i < n; i++) {
    Item item = items[i];
    Float4 center = half_center(item);
    bool goes_left = binning(center)[split.axis] < split.bin;
    Box both = twice(center, -center);
    Int8 mask = Int8{} - int32_t(goes_left);
    left_centers = unite(mask ? both : no_box(), left_centers);
    right_centers = unite(mask ? no_box() : both, right_centers);
    *(goes_left ? left : right) = item;
    left += goes_left;
    right += !goes_left;
  }
  centers[0] = left_centers;
  centers[1] = right_centers;
}

}  // namespace isophote
