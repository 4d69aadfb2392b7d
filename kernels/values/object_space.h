/* Between the world and the space of the shaded object, which may move. What is no instance has none of its own: these
 * are then of the first one, and nobody takes them. */
#ifndef ISOPHOTE_VALUES_OBJECT_SPACE_H
#define ISOPHOTE_VALUES_OBJECT_SPACE_H
#include "value.h"

FN uint instance_at(Point at) { return at.instance == SPHERE_INSTANCE ? 0u : at.instance; }
FN GLOBAL const Instance *instance_of(Scene s, Point at) { return &s.instances[instance_at(at)]; }

/* Operations that ask where the object is, by their numbers: all that call what stands below. */
#define OBJECT_VALUES(X)                                                                                     \
  X(2) /* shading_normal */ X(6) /* object_point */ X(14) /* object_location */ X(198) /* box_sides */       \
  X(219) /* to_object */ X(220) /* from_object */ X(224) /* footprint */ X(226) /* to_object_vector */       \
  X(227) /* to_world_vector */ X(228) /* to_object_normal */ X(229) /* to_world_normal */                    \
  X(230) /* wireframe */ X(231) /* smooth_normal */ X(242) /* frame_tangent */ X(244) /* tangent_space */

/* `moved` where the object moves; OpenMP's loops over many paths have no such branch (value_loops.h). */
#if SCENE_FEATURES & FEATURE_MOTION
#define WHERE_MOVING(moved)                                             \
  if (at.in_time && in_motion(s, at.instance, at.in_time)) {            \
    Placement m = placement_at(s, s.motions[at.instance], at.time);     \
    return moved;                                                       \
  }
#else
#define WHERE_MOVING(moved)
#endif

FN real3 point_into_object(Scene s, Point at, real3 p) {
  WHERE_MOVING(unplaced_point(m, p))
  return transform_point(instance_of(s, at)->to_object, p);
}
FN real3 point_out_of_object(Scene s, Point at, real3 p) {
  WHERE_MOVING(placed_point(m, p))
  return transform_point(instance_of(s, at)->to_world, p);
}
FN real3 vector_into_object(Scene s, Point at, real3 v) {
  WHERE_MOVING(unplaced_vector(m, v))
  return transform_vector(instance_of(s, at)->to_object, v);
}
FN real3 vector_out_of_object(Scene s, Point at, real3 v) {
  WHERE_MOVING(placed_vector(m, v))
  return transform_vector(instance_of(s, at)->to_world, v);
}
FN real3 normal_into_object(Scene s, Point at, real3 n) {
  WHERE_MOVING(unplaced_normal(m, n))
  return transform_normal(instance_of(s, at)->to_world, n);
}
FN real3 normal_out_of_object(Scene s, Point at, real3 n) {
  WHERE_MOVING(placed_normal(m, n))
  return transform_normal(instance_of(s, at)->to_object, n);
}
#undef WHERE_MOVING

/* A vertex's normal, in the space of the vertices; any where the mesh has none. */
FN real3 stored_normal(Scene s, Point at, uint vertex) {
  GLOBAL const Instance *instance = instance_of(s, at);
  int smooth = (at.instance != SPHERE_INSTANCE) & ((instance->visibility & INSTANCE_SMOOTH) != 0u);
  return normal_at(s, at.instance, smooth ? instance->first_normal : 0u, smooth ? vertex : 0u, at.time, smooth ? at.in_time : 0u);
}

#endif
