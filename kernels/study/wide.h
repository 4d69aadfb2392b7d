/* What the tracers of wide nodes share: planes ordered by the signs of the direction, and quantised boxes.
 *
 * A quantised plane lies at corner + q step. Its distance is q (step / d) + (corner / d + offset), one fma a plane
 * (Ylitie et al. 2017, section 4.1); the rounding of the bracket is below 2^-15 of a step, and the host leaves 2^-12
 * of one, so boxes only ever grow. */
#ifndef ISOPHOTE_STUDY_WIDE_H
#define ISOPHOTE_STUDY_WIDE_H
#include "../bvh.h"
#include "wide_nodes.h"

/* The distance of a plane is plane * inverse + offset in one rounding. The origin stands as an interval of a few
 * roundings, which covers that of origin * inverse. octant: bit per axis along which the direction is negative, where a
 * box's high planes come first. */
typedef struct {
  real3 inverse, near_offset, far_offset;
  uint octant;
} WideSlabs;

FN WideSlabs make_wide_slabs(LocalRay r) {
  WideSlabs w;
  w.octant = (r.inverse.x < REAL(0.0) ? 1u : 0u) | (r.inverse.y < REAL(0.0) ? 2u : 0u) | (r.inverse.z < REAL(0.0) ? 4u : 0u);
  real3 width = abs3(r.origin) * (REAL(4.0) * ROUNDING) * abs3(r.inverse), middle = (zero3() - r.origin) * r.inverse;
  w.inverse = r.inverse;
  w.near_offset = middle - width;
  w.far_offset = middle + width;
  return w;
}

/* The same for planes that are counted in steps of a node. */
FN WideSlabs make_node_slabs(real3 corner, uint exponents, WideSlabs w) {
  WideSlabs n;
  n.octant = w.octant;
  n.near_offset = make_real3(fma(corner.x, w.inverse.x, w.near_offset.x), fma(corner.y, w.inverse.y, w.near_offset.y),
                             fma(corner.z, w.inverse.z, w.near_offset.z));
  n.far_offset = make_real3(fma(corner.x, w.inverse.x, w.far_offset.x), fma(corner.y, w.inverse.y, w.far_offset.y),
                            fma(corner.z, w.inverse.z, w.far_offset.z));
  n.inverse = make_real3(float_of_bits((exponents & 255u) << 23) * w.inverse.x,
                         float_of_bits(((exponents >> 8) & 255u) << 23) * w.inverse.y,
                         float_of_bits(((exponents >> 16) & 255u) << 23) * w.inverse.z);
  return n;
}

#define MISSED REAL(3e38)

/* Distance at which a box is entered through its near planes, or MISSED. */
FN real enter_planes(real near_x, real far_x, real near_y, real far_y, real near_z, real far_z, WideSlabs w, real t_min,
                     real t_max) {
  real ax = fma(near_x, w.inverse.x, w.near_offset.x), bx = fma(far_x, w.inverse.x, w.far_offset.x);
  real ay = fma(near_y, w.inverse.y, w.near_offset.y), by = fma(far_y, w.inverse.y, w.far_offset.y);
  real az = fma(near_z, w.inverse.z, w.near_offset.z), bz = fma(far_z, w.inverse.z, w.far_offset.z);
  real enter = loose_max(loose_max(ax, ay), loose_max(az, t_min));
  real leave = loose_min(loose_min(bx, by), loose_min(bz, t_max));
  return enter <= leave * SLAB_SLACK ? enter : MISSED;
}

#define BYTE(word, k) real_of(((word) >> (8u * (k))) & 255u)

#endif
