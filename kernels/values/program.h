/* The values of a material at a point: all of its steps for one path. native/value_loops.h runs the same steps, each over
 * many paths. */
#ifndef ISOPHOTE_VALUES_PROGRAM_H
#define ISOPHOTE_VALUES_PROGRAM_H
#include "../path.h"
#include "../surface.h"

/* Registers of a program: those of the scene at hand where code is compiled for one scene. */
#ifndef REGISTERS
#define REGISTERS MOST_REGISTERS
#endif

#if SCENE_FEATURES & FEATURE_VALUES
#include "values.h"

FN Point make_point(Surface at, Ray ray, Hit h, uint bounces, uint passed) {
  Point p;
  p.p = at.p;
  p.ng = at.ng;
  p.ns = at.ns;
  p.direction = ray.direction;
  p.length = h.t;
  p.u = h.u;
  p.v = h.v;
  p.instance = h.instance;
  p.primitive = h.primitive;
  p.backfacing = at.backfacing;
  p.kind = ray.kind;
  p.bounces = bounces;
  p.passed = passed;
  p.time = ray_time(ray);
  p.in_time = 0u;
  return p;
}

FN Point in_its_time(Scene s, Point p) {
  p.in_time = SCENE_FEATURES & s.world[0].features & (FEATURE_MOTION | FEATURE_DEFORMATION);
  return p;
}

FN void run_step(Scene s, ValueStep o, Point at, real *r, uint k) {
  switch (o.op) {
#define X(number, name, inputs, outputs) \
  case number: if (IS_VALUE_USED(number)) value_##name(s, o, at, r, k); break;
    VALUES(X)
#undef X
    default: break;
  }
}

/* Runs the first `count` steps of a material's program. */
FN_APART void run_steps(Scene s, uint first, uint count, Point at, real *r) {
  for (uint n = 0u; n < count; n++) {
    ValueStep o = s.steps[first + n];
    for (uint k = 0u; k < o.repeat; k++) run_step(s, o, at, r, k);
  }
}

FN void compute_values(Scene s, Material m, uint count, Surface at, Ray ray, Hit h, uint bounces, uint passed, real *r) {
  if (count) run_steps(s, m.first_step, count, in_its_time(s, make_point(at, ray, h, bounces, passed)), r);
}
#else
FN void compute_values(Scene s, Material m, uint count, Surface at, Ray ray, Hit h, uint bounces, uint passed, real *r) {}
#endif

/* A weight, or what registers hold where it varies. */
FN real3 weight_of(packed3 weight, int varies, const real *r) {
  if (!(SCENE_FEATURES & FEATURE_VALUES) || !varies) return load3(weight);
  return make_real3(r[uint_of(weight.x) * REGISTER_STRIDE], r[uint_of(weight.y) * REGISTER_STRIDE],
                    r[uint_of(weight.z) * REGISTER_STRIDE]);
}
FN real3 material_emission(Material m, const real *r) {
  return weight_of(m.emission, (m.flags & MATERIAL_EMISSION_VARIES) != 0u, r);
}
FN real3 material_transparency(Material m, const real *r) {
  return weight_of(m.transparency, (m.flags & MATERIAL_TRANSPARENCY_VARIES) != 0u, r);
}

#endif
