/* What the report's tracers ask of a box. */
#ifndef ISOPHOTE_STUDY_BOX_H
#define ISOPHOTE_STUDY_BOX_H
#include "../bvh.h"

/* Distance at which the ray enters the box, or a negative number where it does not before t_max. */
FN real enter_box(real center_x, real half_x, real center_y, real half_y, real center_z, real half_z, LocalRay r,
                  real t_min, real t_max) {
  Span s = span_of_box(center_x, half_x, center_y, half_y, center_z, half_z, r, t_min, t_max);
  return s.enter <= s.leave ? s.enter : REAL(-1.0);
}

#endif
