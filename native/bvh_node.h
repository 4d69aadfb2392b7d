/* Boxes of BVH2 nodes, which hold them as center and half the size (kernels/bvh.h says why). */
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "../kernels/scene_records.h"

namespace isophote {

/* Half the size is wider by this, relative: for the roundings of span_of_box (kernels/bvh.h). */
constexpr float HALF_MARGIN = 0x1p-20f;

/* The middle of [low, high] and a half that covers it from there, also when it is added to the middle in float32. */
inline void set_interval(float low, float high, float &center, float &half) {
  center = 0.5f * low + 0.5f * high;
  half = std::max(high - center, center - low) * (1.0f + HALF_MARGIN);
  while (center - half > low || center + half < high) half = std::nextafter(half, std::numeric_limits<float>::infinity());
}

inline void set_box(Bvh2Node &node, int k, const float *lo, const float *hi) {
  set_interval(lo[0], hi[0], node.center_x[k], node.half_x[k]);
  set_interval(lo[1], hi[1], node.center_y[k], node.half_y[k]);
  set_interval(lo[2], hi[2], node.center_z[k], node.half_z[k]);
}

inline void get_box(const Bvh2Node &node, int k, float *lo, float *hi) {
  lo[0] = node.center_x[k] - node.half_x[k], hi[0] = node.center_x[k] + node.half_x[k];
  lo[1] = node.center_y[k] - node.half_y[k], hi[1] = node.center_y[k] + node.half_y[k];
  lo[2] = node.center_z[k] - node.half_z[k], hi[2] = node.center_z[k] + node.half_z[k];
}

}  // namespace isophote
