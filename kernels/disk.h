/* Points of disks and regular polygons from two random numbers. */
#ifndef ISOPHOTE_DISK_H
#define ISOPHOTE_DISK_H
#include "elementary.h"

/* Shirley and Chiu 1997, "A Low Distortion Map Between Disk and Square". */
FN real2 sample_disk(real2 u) {
  real a = REAL(2.0) * u.x - REAL(1.0), b = REAL(2.0) * u.y - REAL(1.0);
  int wide = fabs(a) > fabs(b);
  real r = wide ? a : b;
  real ratio = wide ? b / a : a / (b != REAL(0.0) ? b : REAL(1.0));
  real quarter = REAL(0.25) * PI * ratio;
  real2 phi = sin_cos_real(wide ? quarter : REAL(0.5) * PI - quarter);
  return make_real2(r * phi.y, r * phi.x);
}

/* Uniform in the regular polygon of `corners` corners on the unit circle, the first at `rotation` radians less half a
 * side: u.x takes a side, and the rest of it and u.y a point of the triangle between that side and the center. */
FN real2 sample_polygon(int corners, real rotation, real2 u) {
  real scaled = u.x * real_of(corners), side = floor(scaled);
  real half_angle = PI / real_of(corners);
  real2 at = sin_cos_real(half_angle), turn = sin_cos_real(rotation + side * (REAL(2.0) * half_angle));
  real outward = sqrt(scaled - side);
  real x = outward * at.y, y = outward * (REAL(2.0) * u.y - REAL(1.0)) * at.x;
  return make_real2(x * turn.y - y * turn.x, x * turn.x + y * turn.y);
}

#endif
