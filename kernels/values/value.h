/* What every operation on values takes: the scene, the step that is run, the point that is shaded, registers, and how
 * often the step has run before.
 *
 * Registers are the one thing that kernels change in place: a program may name any of them. A path's are REGISTER_STRIDE
 * apart: OpenCL has an array for its path, OpenMP a column for each register, so that one step runs over many
 * paths. Operations read IN(k), the step's k-th input, and write OUT(k); outputs are never inputs of the same step, and
 * a step that is repeated finds in its outputs what it wrote before. */
#ifndef ISOPHOTE_VALUES_VALUE_H
#define ISOPHOTE_VALUES_VALUE_H
#include "../camera_space.h"
#include "../elementary.h"
#include "../surface.h"

/* The point that is shaded, as textures and inputs see it. */
typedef struct {
  real3 p, ng, ns;    /* as Surface has them: normals on the viewer's side */
  real3 direction;    /* of the ray that met it */
  real length;        /* of that ray, metres */
  real u, v;          /* weights of the triangle's second and third corner */
  uint instance, primitive;
  int backfacing;
  uint kind, bounces, passed; /* of the ray: RAY_ bits, counts by kind as paths have them, transparent surfaces */
  real time;                  /* of the shutter, */
  uint in_time;               /* and which of FEATURE_MOTION and FEATURE_DEFORMATION are to be minded */
} Point;

#define VALUE(name) FN void value_##name(Scene s, ValueStep o, Point at, real *r, uint k)
#define REGISTER(n) r[(n) * REGISTER_STRIDE]
#define IN(n) REGISTER(o.from[n])
#define OUT(n) REGISTER(o.to + (n))
#define IN3(n) make_real3(IN(n), IN((n) + 1), IN((n) + 2))
#define OUT3(n, v)           \
  {                          \
    real3 out_value = (v);   \
    OUT(n) = out_value.x;    \
    OUT((n) + 1) = out_value.y; \
    OUT((n) + 2) = out_value.z; \
  }

#endif
