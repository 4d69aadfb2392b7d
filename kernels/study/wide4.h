/* Four boxes a node, plain or quantised (wide_nodes.h), children sorted by distance, a stack of references.
 * Wald, Benthin and Boulos 2008, "Getting Rid of Packets"; quantised: Ylitie et al. 2017. */
#ifndef ISOPHOTE_STUDY_WIDE4_H
#define ISOPHOTE_STUDY_WIDE4_H
#include "../bvh.h"
#include "wide_nodes.h"

/* A bound is corner + steps * step with one rounding, as the host has checked it: boxes stay conservative. */
FN real step_size(uint exponents, uint axis) { return float_of_bits(((exponents >> (8u * axis)) & 255u) << 23); }
FN real bound(real corner, uint steps, uint k, real step) { return corner + real_of((steps >> (8u * k)) & 255u) * step; }

#if QUANTISED
typedef QuantisedNode4 WideNode4;
FN real enter_child4(GLOBAL const WideNode4 *n, uint k, LocalRay space, real t_min, real t_max) {
  real3 step = make_real3(step_size(n->exponents, 0u), step_size(n->exponents, 1u), step_size(n->exponents, 2u));
  return enter_box(bound(n->corner.x, n->lo_x, k, step.x), bound(n->corner.x, n->hi_x, k, step.x),
                   bound(n->corner.y, n->lo_y, k, step.y), bound(n->corner.y, n->hi_y, k, step.y),
                   bound(n->corner.z, n->lo_z, k, step.z), bound(n->corner.z, n->hi_z, k, step.z), space, t_min, t_max);
}
#else
typedef PlainNode4 WideNode4;
FN real enter_child4(GLOBAL const WideNode4 *n, uint k, LocalRay space, real t_min, real t_max) {
  return enter_box(n->lo_x[k], n->hi_x[k], n->lo_y[k], n->hi_y[k], n->lo_z[k], n->hi_z[k], space, t_min, t_max);
}
#endif

/* Brings the nearer of two children to the front; those that are missed are infinitely far. */
#define MISSED REAL(3e38)
#define SORT_TWO(a, b)                          \
  if (t[b] < t[a]) {                            \
    real nearer = t[b];                         \
    uint reference = child[b];                  \
    t[b] = t[a], child[b] = child[a];           \
    t[a] = nearer, child[a] = reference;        \
  }

FN Hit trace_wide4(Scene s, Ray ray, int any) {
  Hit best = no_hit(ray.t_max);
  GLOBAL const WideNode4 *nodes = (GLOBAL const WideNode4 *)s.nodes;
  LocalRay world = make_local_ray(ray.origin, ray.direction);
  LocalRay space = world;
  real slack_t_min = ray.t_min * (REAL(1.0) - REAL(16.0) * ROUNDING);
  uint stack[STUDY_STACK];
  int top = 0;
  uint instance = NONE, ref = s.world[0].root;
  if (ref == NONE) return best;
  for (;;) {
    uint kind = REF_KIND(ref), next = NONE;
    if (ref == REF_RETURN) {
      instance = NONE;
      space = world;
    } else if (kind == REF_NODE) {
      real t[4];
      uint child[4];
      for (uint k = 0u; k < 4u; k++) {
        child[k] = nodes[ref].child[k];
        real entered = enter_child4(&nodes[ref], k, space, slack_t_min, best.t * LIMIT_SLACK);
        t[k] = child[k] != NONE && entered >= REAL(0.0) ? entered : MISSED;
        if (t[k] == MISSED) child[k] = NONE;
      }
      SORT_TWO(0, 2)
      SORT_TWO(1, 3)
      SORT_TWO(0, 1)
      SORT_TWO(2, 3)
      SORT_TWO(1, 2)
      for (uint k = 3u; k > 0u; k--)
        if (child[k] != NONE) stack[top++] = child[k];
      next = child[0];
    } else if (kind == REF_TRIANGLES) {
      best = hit_triangles(s, REF_INDEX(ref), instance, space, ray, best);
      if (any && best.index != NONE) return best;
    } else if (kind == REF_SPHERES) {
      best = hit_spheres(s, REF_INDEX(ref), space, ray, best);
      if (any && best.index != NONE) return best;
    } else if (s.instances[REF_INDEX(ref)].visibility & ray.kind) {
      instance = REF_INDEX(ref);
      space = make_local_ray(transform_point(s.instances[instance].to_object, ray.origin),
                             transform_vector(s.instances[instance].to_object, ray.direction));
      stack[top++] = REF_RETURN;
      next = s.instances[instance].root;
    }
    if (next == NONE) {
      if (top == 0) return best;
      next = stack[--top];
    }
    ref = next;
  }
}

#endif
