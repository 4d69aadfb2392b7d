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

/* A direction's reciprocal, finite, so that no slab test sees 0 * infinity. */
FN real finite_reciprocal(real d) {
  real tiny = REAL(1e-30);
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

/* Distance at which the ray enters the box, or a negative number where it does not before t_max. */
FN real enter_box(real lo_x, real hi_x, real lo_y, real hi_y, real lo_z, real hi_z, LocalRay r, real t_min,
                  real t_max) {
  real ax = (lo_x - r.origin.x) * r.inverse.x, bx = (hi_x - r.origin.x) * r.inverse.x;
  real ay = (lo_y - r.origin.y) * r.inverse.y, by = (hi_y - r.origin.y) * r.inverse.y;
  real az = (lo_z - r.origin.z) * r.inverse.z, bz = (hi_z - r.origin.z) * r.inverse.z;
  real enter = max_real(max_real(min_real(ax, bx), min_real(ay, by)), max_real(min_real(az, bz), t_min));
  real leave = min_real(min_real(max_real(ax, bx), max_real(ay, by)), min_real(max_real(az, bz), t_max));
  return enter <= leave * SLAB_SLACK ? enter : REAL(-1.0);
}

FN Hit keep_closer(Hit best, TriangleHit h, uint instance, uint primitive, uint index, Ray ray) {
  int take = h.hit && is_closer(h.t, instance, primitive, best) && is_wanted(h.t, instance, primitive, ray);
  best.t = take ? h.t : best.t;
  best.u = take ? h.u : best.u;
  best.v = take ? h.v : best.v;
  best.instance = take ? instance : best.instance;
  best.primitive = take ? primitive : best.primitive;
  best.index = take ? index : best.index;
  return best;
}

FN Hit hit_triangles(Scene s, uint index, uint instance, LocalRay space, Ray ray, Hit best) {
  uint last = 0u;
  while (!last) {
    GLOBAL const Triangle *t = &s.triangles[index];
    uint slot = t->slot;
    last = slot & LAST_IN_LEAF;
    /* Triangles in an instance inherit its visibility, tested when it was entered. */
    if (instance != NONE || ((slot >> 16) & ray.kind)) {
      TriangleHit h = triangle_hit(load3(t->v0), load3(t->v1), load3(t->v2), space.origin, space.direction,
                                   space.shear);
      best = keep_closer(best, h, instance != NONE ? instance : t->instance, t->primitive, index, ray);
    }
    index++;
  }
  return best;
}

FN Hit hit_spheres(Scene s, uint index, LocalRay space, Ray ray, Hit best) {
  uint last = 0u;
  while (!last) {
    GLOBAL const Sphere *sphere = &s.spheres[index];
    last = sphere->flags & LAST_IN_LEAF;
    if ((sphere->flags >> 16) & ray.kind) {
      SphereHit h = sphere_hit(load3(sphere->center), to_real(sphere->radius), space.origin, space.direction);
      TriangleHit candidate;
      candidate.hit = h.hit;
      candidate.u = REAL(0.0);
      candidate.v = REAL(0.0);
      candidate.t = h.t_near;
      best = keep_closer(best, candidate, SPHERE_INSTANCE, sphere->primitive, index | INDEX_SPHERE, ray);
      candidate.t = h.t_far;
      best = keep_closer(best, candidate, SPHERE_INSTANCE, sphere->primitive, index | INDEX_SPHERE, ray);
    }
    index++;
  }
  return best;
}

/* The closest hit along the ray; with any != 0 the first one found, which says only that there is one. */
FN Hit trace(Scene s, Ray ray, int any) {
  Hit best = no_hit(ray.t_max);
  uint stack[STACK_SIZE];
  int top = 0;
  uint instance = NONE;
  LocalRay world = make_local_ray(ray.origin, ray.direction);
  LocalRay space = world;
  real slack_t_min = ray.t_min * (REAL(1.0) - REAL(16.0) * ROUNDING);
  uint ref = s.world[0].root;
  if (ref == NONE) return best;
  for (;;) {
    uint kind = REF_KIND(ref);
    uint next = NONE;
    if (ref == REF_RETURN) {
      instance = NONE;
      space = world;
    } else if (kind == REF_NODE) {
      GLOBAL const Bvh2Node *n = &s.nodes[ref];
      real limit = best.t * LIMIT_SLACK;
      real t0 = enter_box(to_real(n->lo_x[0]), to_real(n->hi_x[0]), to_real(n->lo_y[0]), to_real(n->hi_y[0]),
                          to_real(n->lo_z[0]), to_real(n->hi_z[0]), space, slack_t_min, limit);
      real t1 = enter_box(to_real(n->lo_x[1]), to_real(n->hi_x[1]), to_real(n->lo_y[1]), to_real(n->hi_y[1]),
                          to_real(n->lo_z[1]), to_real(n->hi_z[1]), space, slack_t_min, limit);
      int in0 = t0 >= REAL(0.0), in1 = t1 >= REAL(0.0);
      if (in0 & in1) {
        int near = t1 < t0;
        stack[top++] = n->child[1 - near];
        next = n->child[near];
      } else if (in0 | in1) {
        next = n->child[in1];
      }
    } else if (kind == REF_TRIANGLES) {
      best = hit_triangles(s, REF_INDEX(ref), instance, space, ray, best);
      if (any && best.index != NONE) return best;
    } else if (kind == REF_SPHERES) {
      best = hit_spheres(s, REF_INDEX(ref), space, ray, best);
      if (any && best.index != NONE) return best;
    } else {
      uint i = REF_INDEX(ref);
      if (s.instances[i].visibility & ray.kind) {
        stack[top++] = REF_RETURN;
        instance = i;
        space = make_local_ray(transform_point(s.instances[i].to_object, ray.origin),
                               transform_vector(s.instances[i].to_object, ray.direction));
        next = s.instances[i].root;
      }
    }
    if (next == NONE) {
      if (top == 0) break;
      next = stack[--top];
    }
    ref = next;
  }
  return best;
}

#endif
