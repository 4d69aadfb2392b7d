/* Where values come from: constants, the point that is shaded, the ray that met it, attributes of meshes. */
#ifndef ISOPHOTE_VALUES_SOURCE_H
#define ISOPHOTE_VALUES_SOURCE_H
#include "attribute.h"
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
  X(7, backfacing, 0, 1)

VALUE(constant) { OUT(0) = to_real(o.number); }
/* Blender's world, not relative to the scene's origin. */
VALUE(position) { OUT3(0, at.p + load3(s.world[0].origin)) }
VALUE(shading_normal) { OUT3(0, at.ns) }
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
  int is_sphere = at.instance == SPHERE_INSTANCE;
  GLOBAL const Instance *instance = &s.instances[is_sphere ? 0u : at.instance];
  OUT3(0, select3(is_sphere, at.p, transform_point(instance->to_object, at.p)))
}
VALUE(backfacing) { OUT(0) = at.backfacing ? REAL(1.0) : REAL(0.0); }

#endif
