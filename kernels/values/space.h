/* Points, vectors and normals between the spaces of the world, of the shaded object and of the camera (Blender's Vector
 * Transform). A step's `data` is the kind. The camera's space has z along the view, as in Cycles; what is no instance has
 * the world's. */
#ifndef ISOPHOTE_VALUES_SPACE_H
#define ISOPHOTE_VALUES_SPACE_H
#include "object_space.h"

#define KIND_POINT 0u
#define KIND_VECTOR 1u
#define KIND_NORMAL 2u /* unit in the end */

/* X(number, name, inputs, outputs) */
#define VALUES_SPACE(X)      \
  X(219, to_object, 3, 3)    \
  X(220, from_object, 3, 3)  \
  X(221, to_camera, 3, 3)    \
  X(222, from_camera, 3, 3)

FN real3 normalize_or_0(real3 v) {
  real square = dot3(v, v);
  return v * (REAL(1.0) / sqrt(square > REAL(0.0) ? square : REAL(1.0)));
}
FN real3 where_point(ValueStep o, real3 moved) { return select3(o.data == KIND_POINT, moved, zero3()); }

FN real3 of_kind(ValueStep o, real3 point, real3 vector, real3 normal) {
  return select3(o.data == KIND_NORMAL, normalize_or_0(normal), select3(o.data == KIND_POINT, point, vector));
}

VALUE(to_object) {
  real3 v = IN3(0), from_origin = v - where_point(o, load3(s.world[0].origin));
  real3 found = of_kind(o, point_into_object(s, at, from_origin), vector_into_object(s, at, from_origin),
                        normal_into_object(s, at, from_origin));
  OUT3(0, select3(at.instance == SPHERE_INSTANCE, v, found))
}
VALUE(from_object) {
  real3 v = IN3(0), from_origin = of_kind(o, point_out_of_object(s, at, v), vector_out_of_object(s, at, v),
                                          normal_out_of_object(s, at, v));
  real3 found = from_origin + where_point(o, load3(s.world[0].origin));
  OUT3(0, select3(at.instance == SPHERE_INSTANCE, v, found))
}
VALUE(to_camera) {
  Camera c = s.camera[0];
  real3 v = IN3(0) - where_point(o, load3(s.world[0].origin) + load3(c.position));
  v = turned_to_camera(c, v);
  OUT3(0, select3(o.data == KIND_NORMAL, normalize_or_0(v), v))
}
VALUE(from_camera) {
  Camera c = s.camera[0];
  real3 v = turned_from_camera(c, IN3(0)) + where_point(o, load3(c.position) + load3(s.world[0].origin));
  OUT3(0, select3(o.data == KIND_NORMAL, normalize_or_0(v), v))
}

#endif
