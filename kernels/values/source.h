/* Where values come from: constants, the point that is shaded, the ray that met it, attributes of meshes. */
#ifndef ISOPHOTE_VALUES_SOURCE_H
#define ISOPHOTE_VALUES_SOURCE_H
#include "attribute.h"
#include "object_space.h"
#include "value.h"

/* X(number, name, inputs, outputs) */
#define VALUES_SOURCE(X)      \
  X(0, constant, 0, 1)        \
  X(1, position, 0, 3)        \
  X(2, shading_normal, 0, 3)  \
  X(3, true_normal, 0, 3)     \
  X(4, incoming, 0, 3)        \
  X(5, attribute, 0, 4)       \
  X(6, object_point, 0, 3)    \
  X(7, backfacing, 0, 1)      \
  X(8, barycentric, 0, 2)     \
  X(9, ray_is, 0, 1)          \
  X(10, ray_bounces, 0, 1)    \
  X(11, ray_passed, 0, 1)     \
  X(12, ray_length, 0, 1)     \
  X(13, instance_value, 0, 1) \
  X(14, object_location, 0, 3) \
  X(15, camera_point, 0, 3)   \
  X(16, mirrored_view, 0, 3)  \
  X(17, facing_normal, 0, 3)

FN int is_mirrored(Scene s, Point at) {
  uint instance = at.instance == SPHERE_INSTANCE ? 0u : at.instance;
  return (s.instances[instance].visibility & INSTANCE_MIRRORED) != 0u;
}

VALUE(constant) { OUT(0) = to_real(o.number); }
/* Blender's world, not relative to the scene's origin. */
VALUE(position) { OUT3(0, at.p + load3(s.world[0].origin)) }
VALUE(shading_normal) { OUT3(0, unbent_normal(s, at)) }
VALUE(true_normal) { OUT3(0, at.ng) }
VALUE(incoming) { OUT3(0, -at.direction) }
/* Attribute o.data, 0 where the mesh has none. */
VALUE(attribute) {
  Attribute a = read_attribute(s, o.data, at);
  OUT(0) = a.x;
  OUT(1) = a.y;
  OUT(2) = a.z;
  OUT(3) = a.w;
}
/* The point in the space of its object. */
VALUE(object_point) {
  OUT3(0, select3(at.instance == SPHERE_INSTANCE, at.p, point_into_object(s, at, at.p)))
}
VALUE(backfacing) { OUT(0) = at.backfacing ? REAL(1.0) : REAL(0.0); }
/* Weights of the triangle's second and third corner, in the mesh's own order. */
VALUE(barycentric) {
  int swapped = is_mirrored(s, at);
  OUT(0) = swapped ? at.v : at.u;
  OUT(1) = swapped ? at.u : at.v;
}
/* Whether the ray is of one of the kinds o.data: RAY_ bits. */
VALUE(ray_is) { OUT(0) = (at.kind & o.data) ? REAL(1.0) : REAL(0.0); }
/* A count of bounces: eight bits from o.data on. */
VALUE(ray_bounces) { OUT(0) = real_of((at.bounces >> o.data) & 255u); }
VALUE(ray_passed) { OUT(0) = real_of(at.passed); }
VALUE(ray_length) { OUT(0) = at.length; }
/* Column o.data of what is known of the instance. */
VALUE(instance_value) {
  int there = at.instance != SPHERE_INSTANCE;
  uint row = there ? at.instance * s.world[0].instance_columns : 0u;
  real known = to_real(s.instance_values[row + o.data]);
  OUT(0) = there ? known : REAL(0.0);
}
/* Where the object's own origin lies in Blender's world. */
VALUE(object_location) {
  real3 place = point_out_of_object(s, at, zero3()) + load3(s.world[0].origin);
  OUT3(0, select3(at.instance == SPHERE_INSTANCE, zero3(), place))
}
/* The point in the camera's space; z is how far it lies before it. */
VALUE(camera_point) {
  Camera c = s.camera[0];
  OUT3(0, turned_to_camera(c, at.p - load3(c.position)))
}
/* What closures have where no node makes them another: the shading normal, bent to the viewer. */
VALUE(facing_normal) { OUT3(0, at.ns) }
/* Where a mirror would send the viewer's look. */
VALUE(mirrored_view) { OUT3(0, at.direction - at.ns * (REAL(2.0) * dot3(at.direction, at.ns))) }

#endif
