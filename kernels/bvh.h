/* Ordered traversal of the two-level BVH2 with a stack.
 *
 * A box test only decides what may be skipped and errs on the side of looking: Ize 2013, "Robust BVH
 * Ray Traversal", JCGT 2(2). The hit itself comes from triangle_hit and sphere_hit alone, so every
 * tree gives the same one. */
#ifndef ISOPHOTE_BVH_H
#define ISOPHOTE_BVH_H
#include "sphere.h"
#include "triangle.h"

#define STACK_SIZE 96 /* the builder keeps each of the two levels below 46 */
#define REF_RETURN 0xfffffffeu /* on the stack: back from an instance to the world */

/* 1 + 2 gamma(3), and what a hit's distance may be off against its box. */
#define SLAB_SLACK (REAL(1.0) + REAL(8.0) * ROUNDING)
#define LIMIT_SLACK (REAL(1.0) + REAL(16.0) * ROUNDING)

/* A direction's reciprocal, finite, so that no slab test sees 0 * infinity, and far enough from the largest
 * float that its product with a coordinate stays finite too. */
FN real finite_reciprocal(real d) {
  real tiny = REAL(1e-20);
  return REAL(1.0) / (fabs(d) < tiny ? (d < REAL(0.0) ? -tiny : tiny) : d);
}

/* A ray in the space of the tree that is being walked. */
typedef struct {
  real3 origin, inverse;
  Shear shear;
  real3 direction;
} LocalRay;

FN LocalRay make_local_ray(real3 origin, real3 direction) {
  LocalRay r;
  r.origin = origin;
  r.direction = direction;
  r.inverse = make_real3(finite_reciprocal(direction.x), finite_reciprocal(direction.y), finite_reciprocal(direction.z));
  r.shear = make_shear(direction);
  return r;
}

FN real3 transform_point(GLOBAL const float *m, real3 p) {
  return make_real3(to_real(m[0]) * p.x + to_real(m[1]) * p.y + to_real(m[2]) * p.z + to_real(m[3]),
                    to_real(m[4]) * p.x + to_real(m[5]) * p.y + to_real(m[6]) * p.z + to_real(m[7]),
                    to_real(m[8]) * p.x + to_real(m[9]) * p.y + to_real(m[10]) * p.z + to_real(m[11]));
}
FN real3 transform_vector(GLOBAL const float *m, real3 v) {
  return make_real3(to_real(m[0]) * v.x + to_real(m[1]) * v.y + to_real(m[2]) * v.z,
                    to_real(m[4]) * v.x + to_real(m[5]) * v.y + to_real(m[6]) * v.z,
                    to_real(m[8]) * v.x + to_real(m[9]) * v.y + to_real(m[10]) * v.z);
}
/* By the transpose: normals, given the inverse matrix. */
FN real3 transform_normal(GLOBAL const float *m, real3 n) {
  return make_real3(to_real(m[0]) * n.x + to_real(m[4]) * n.y + to_real(m[8]) * n.z,
                    to_real(m[1]) * n.x + to_real(m[5]) * n.y + to_real(m[9]) * n.z,
                    to_real(m[2]) * n.x + to_real(m[6]) * n.y + to_real(m[10]) * n.z);
}

/* What the tests of boxes need of a ray: t = bound * inverse + offset in one rounding each. The origin stands
 * as an interval of a few roundings, which covers that of origin * inverse: the offsets of low bounds belong
 * to its upper end, those of high bounds to its lower, so boxes only ever grow. */
typedef struct {
  real3 inverse, low_offset, high_offset;
} Slabs;

FN Slabs make_slabs(LocalRay r) {
  Slabs s;
  real3 width = abs3(r.origin) * (REAL(4.0) * ROUNDING);
  s.inverse = r.inverse;
  s.low_offset = (zero3() - r.origin - width) * r.inverse;
  s.high_offset = (width - r.origin) * r.inverse;
  return s;
}

/* Distance at which the ray enters the box, or a negative number where it does not before t_max. */
FN real enter_box(real lo_x, real hi_x, real lo_y, real hi_y, real lo_z, real hi_z, Slabs s, real t_min,
                  real t_max) {
  real ax = fma(lo_x, s.inverse.x, s.low_offset.x), bx = fma(hi_x, s.inverse.x, s.high_offset.x);
  real ay = fma(lo_y, s.inverse.y, s.low_offset.y), by = fma(hi_y, s.inverse.y, s.high_offset.y);
  real az = fma(lo_z, s.inverse.z, s.low_offset.z), bz = fma(hi_z, s.inverse.z, s.high_offset.z);
  real enter = loose_max(loose_max(loose_min(ax, bx), loose_min(ay, by)), loose_max(loose_min(az, bz), t_min));
  real leave = loose_min(loose_min(loose_max(ax, bx), loose_max(ay, by)), loose_min(loose_max(az, bz), t_max));
  return enter <= leave * SLAB_SLACK ? enter : REAL(-1.0);
}

FN Hit keep_closer(Hit best, TriangleHit h, uint instance, uint primitive, Ray ray) {
  int take = h.hit && is_closer(h.t, instance, primitive, best) && is_wanted(h.t, instance, primitive, ray);
  best.t = take ? h.t : best.t;
  best.u = take ? h.u : best.u;
  best.v = take ? h.v : best.v;
  best.instance = take ? instance : best.instance;
  best.primitive = take ? primitive : best.primitive;
  return best;
}

FN Hit hit_triangles(Scene s, uint index, uint instance, LocalRay space, Ray ray, Hit best) {
  uint last = 0u;
  while (!last) {
    GLOBAL const Triangle *t = &s.triangles[index];
    float4 v0 = load_float4(t, 0), v1 = load_float4(t, 1), v2 = load_float4(t, 2); /* with what stands behind them */
    uint flags = bits_of_float(v2.w);
    last = flags & LAST_IN_LEAF;
    /* Triangles in an instance inherit its visibility, tested when it was entered. */
    if (!(SCENE_FEATURES & FEATURE_VISIBILITY) || instance != NONE || ((flags >> 16) & ray.kind)) {
      TriangleHit h = triangle_hit(load3(v0), load3(v1), load3(v2), space.origin, space.direction, space.shear);
      uint owner = instance != NONE ? instance : bits_of_float(v1.w);
      if (h.hit) best = keep_closer(best, h, owner, bits_of_float(v0.w), ray);
    }
    index++;
  }
  return best;
}

FN Hit hit_sphere(Scene s, uint index, LocalRay space, Ray ray, Hit best) {
  GLOBAL const Sphere *sphere = &s.spheres[index];
  if (!(sphere->visibility & ray.kind)) return best;
  SphereHit h = sphere_hit(load3(sphere->center), to_real(sphere->radius), space.origin, space.direction);
  TriangleHit candidate;
  candidate.hit = h.hit;
  candidate.u = REAL(0.0);
  candidate.v = REAL(0.0);
  candidate.t = h.t_near;
  best = keep_closer(best, candidate, SPHERE_INSTANCE, index, ray);
  candidate.t = h.t_far;
  return keep_closer(best, candidate, SPHERE_INSTANCE, index, ray);
}

/* The closest hit along the ray; with any != 0 the first one found, which says only that there is one.
 *
 * Rays of a work-group first all go down to a leaf each, then all test their triangles (Aila and Laine 2009,
 * "Understanding the Efficiency of Ray Traversal on GPUs", while-while). */
FN Hit trace(Scene s, Ray ray, int any) {
  Hit best = no_hit(ray.t_max);
  uint stack[STACK_SIZE];
  int top = 0;
  uint instance = NONE;
  LocalRay world = make_local_ray(ray.origin, ray.direction);
  LocalRay space = world;
  Slabs slabs = make_slabs(space);
  real slack_t_min = ray.t_min * (REAL(1.0) - REAL(16.0) * ROUNDING);
  uint ref = s.world[0].root;
  stack[top++] = NONE;
  for (;;) {
    while (REF_KIND(ref) == REF_NODE) {
      GLOBAL const Bvh2Node *n = &s.nodes[ref];
      float4 x = load_float4(n, 0), y = load_float4(n, 1), z = load_float4(n, 2), children = load_float4(n, 3);
      real limit = best.t * LIMIT_SLACK;
      real t0 = enter_box(to_real(x.x), to_real(x.z), to_real(y.x), to_real(y.z), to_real(z.x), to_real(z.z), slabs,
                          slack_t_min, limit);
      real t1 = enter_box(to_real(x.y), to_real(x.w), to_real(y.y), to_real(y.w), to_real(z.y), to_real(z.w), slabs,
                          slack_t_min, limit);
      uint child0 = bits_of_float(children.x), child1 = bits_of_float(children.y);
      int in0 = t0 >= REAL(0.0), in1 = t1 >= REAL(0.0);
      int second_first = in0 & in1 ? t1 < t0 : in1;
      ref = second_first ? child1 : child0;
      if (in0 & in1) stack[top++] = second_first ? child0 : child1;
      if (!(in0 | in1)) ref = stack[--top];
    }
    if (ref == NONE) return best;
    uint kind = REF_KIND(ref);
    if (kind == REF_TRIANGLES) {
      best = hit_triangles(s, REF_INDEX(ref), instance, space, ray, best);
      if (any && best.instance != NONE) return best;
    } else if ((SCENE_FEATURES & FEATURE_SPHERES) && kind == REF_SPHERE) {
      best = hit_sphere(s, REF_INDEX(ref), space, ray, best);
      if (any && best.instance != NONE) return best;
    } else if ((SCENE_FEATURES & FEATURE_INSTANCES) && ref == REF_RETURN) {
      instance = NONE;
      space = world;
      slabs = make_slabs(space);
    } else if ((SCENE_FEATURES & FEATURE_INSTANCES) && (s.instances[REF_INDEX(ref)].visibility & ray.kind)) {
      stack[top++] = REF_RETURN;
      instance = REF_INDEX(ref);
      space = make_local_ray(transform_point(s.instances[instance].to_object, ray.origin),
                             transform_vector(s.instances[instance].to_object, ray.direction));
      slabs = make_slabs(space);
      ref = s.instances[instance].root;
      continue;
    }
    ref = stack[--top];
  }
}

#endif
