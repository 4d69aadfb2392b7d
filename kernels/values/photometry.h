/* Photometric tables, which say how bright a luminaire is in each direction (IES LM-63). */
#ifndef ISOPHOTE_VALUES_PHOTOMETRY_H
#define ISOPHOTE_VALUES_PHOTOMETRY_H
#include "value.h"

/* X(number, name, inputs, outputs) */
#define VALUES_PHOTOMETRY(X) X(208, photometry, 2, 1)

#define MOST_PHOTOMETRY_ANGLES 1024u /* of a kind: a power of 2, whose steps find one of them */

/* Of `count` ascending angles that begin at `first` of value_tables: number of the last one below x, or of the first. */
FN uint find_angle(Scene s, uint first, uint count, real x) {
  uint low = 0u;
  UNROLL
  for (uint step = MOST_PHOTOMETRY_ANGLES >> 1; step > 0u; step >>= 1) {
    uint next = low + step;
    real there = to_real(s.value_tables[first + min_uint(next, count - 1u)]);
    low = ((next < count - 1u) & (there < x)) ? next : low;
  }
  return low;
}

/* Catmull-Rom between b and c. */
FN real spline_between(real a, real b, real c, real d, real x) {
  real steep = c - a, bend = REAL(2.0) * a - REAL(5.0) * b + REAL(4.0) * c - d, twist = REAL(3.0) * (b - c) + d - a;
  return b + REAL(0.5) * x * (steep + x * (bend + x * twist));
}

/* Brightness at a horizontal and a vertical angle, radians. From o.data on value_tables hold how many of each there are,
 * at least two, the horizontal ones, the vertical ones, and the brightnesses, those of one horizontal angle together.
 * Between them it is as smooth as Cycles makes it (kernel/util/ies.h): going round where the table does, the poles taken
 * for even; nothing where there is no table. */
VALUE(photometry) {
  uint rows = uint_of(int_of(s.value_tables[o.data])), columns = uint_of(int_of(s.value_tables[o.data + 1u]));
  uint around = o.data + 2u, down = around + rows, table = down + columns;
  real h = IN(0), v = IN(1);
  real first_h = to_real(s.value_tables[around]), last_h = to_real(s.value_tables[down - 1u]);
  real first_v = to_real(s.value_tables[down]), last_v = to_real(s.value_tables[table - 1u]);
  int there = (h >= first_h) & (h < last_h) & (v >= first_v) & (v < last_v);
  uint row = find_angle(s, around, rows, h), column = find_angle(s, down, columns, v);
  real h0 = to_real(s.value_tables[around + row]), h1 = to_real(s.value_tables[around + row + 1u]);
  real v0 = to_real(s.value_tables[down + column]), v1 = to_real(s.value_tables[down + column + 1u]);
  real x = (h - h0) / (h1 - h0), y = (v - v0) / (v1 - v0);
  int ends = (first_h >= REAL(1e-7)) | (last_h <= TWO_PI - REAL(1e-6)); /* does not go round */
  int at_bottom = column == 0u, at_top = column + 2u >= columns, first_row = row == 0u, last_row = row + 2u >= rows;
  uint below = at_bottom ? 1u : column - 1u, above = at_top ? columns - 2u : column + 2u;
  real has_below = (at_bottom & (first_v > REAL(1e-7))) ? REAL(0.0) : REAL(1.0);
  real has_above = (at_top & (last_v < PI - REAL(1e-6))) ? REAL(0.0) : REAL(1.0);
  real four[4];
  UNROLL
  for (uint n = 0u; n < 4u; n++) {
    uint wanted = row + n - 1u;
    wanted = (n == 0u) & first_row ? rows - 2u : wanted;
    wanted = (n == 3u) & last_row ? 1u : wanted;
    uint at = table + wanted * columns;
    real of_row = spline_between(to_real(s.value_tables[at + below]) * has_below, to_real(s.value_tables[at + column]),
                                 to_real(s.value_tables[at + column + 1u]), to_real(s.value_tables[at + above]) * has_above, y);
    int missing = ends & (((n == 0u) & first_row) | ((n == 3u) & last_row));
    four[n] = missing ? REAL(0.0) : of_row;
  }
  OUT(0) = there ? max_real(spline_between(four[0], four[1], four[2], four[3], x), REAL(0.0)) : REAL(0.0);
}

#endif
