/* Four boxes a node, plain or quantised (wide_nodes.h), children sorted by distance, a stack of references.
 * Wald, Benthin and Boulos 2008, "Getting Rid of Packets"; quantised: Ylitie et al. 2017. */
#ifndef ISOPHOTE_STUDY_WIDE4_H
#define ISOPHOTE_STUDY_WIDE4_H
#include "wide.h"

typedef struct {
  real t[4];
  uint child[4];
} Entered4;

#if QUANTISED
typedef QuantisedNode4 WideNode4;
FN Entered4 enter_children4(GLOBAL const WideNode4 *n, WideSlabs w, real t_min, real t_max) {
  float4 corner = load_float4(n, 0), a = load_float4(n, 2), b = load_float4(n, 3);
  WideSlabs in_steps = make_node_slabs(load3(corner), bits_of_float(corner.w), w);
  uint x0 = bits_of_float(w.octant & 1u ? a.y : a.x), x1 = bits_of_float(w.octant & 1u ? a.x : a.y);
  uint y0 = bits_of_float(w.octant & 2u ? a.w : a.z), y1 = bits_of_float(w.octant & 2u ? a.z : a.w);
  uint z0 = bits_of_float(w.octant & 4u ? b.y : b.x), z1 = bits_of_float(w.octant & 4u ? b.x : b.y);
  Entered4 e;
  for (uint k = 0u; k < 4u; k++)
    e.t[k] = enter_planes(BYTE(x0, k), BYTE(x1, k), BYTE(y0, k), BYTE(y1, k), BYTE(z0, k), BYTE(z1, k), in_steps, t_min,
                          t_max);
  return e;
}
#else
typedef PlainNode4 WideNode4;
FN Entered4 enter_children4(GLOBAL const WideNode4 *n, WideSlabs w, real t_min, real t_max) {
  uint x = w.octant & 1u, y = (w.octant >> 1) & 1u, z = w.octant >> 2;
  float4 x0 = load_float4(n, x), x1 = load_float4(n, 1u - x), y0 = load_float4(n, 2u + y), y1 = load_float4(n, 3u - y);
  float4 z0 = load_float4(n, 4u + z), z1 = load_float4(n, 5u - z);
  Entered4 e;
  e.t[0] = enter_planes(x0.x, x1.x, y0.x, y1.x, z0.x, z1.x, w, t_min, t_max);
  e.t[1] = enter_planes(x0.y, x1.y, y0.y, y1.y, z0.y, z1.y, w, t_min, t_max);
  e.t[2] = enter_planes(x0.z, x1.z, y0.z, y1.z, z0.z, z1.z, w, t_min, t_max);
  e.t[3] = enter_planes(x0.w, x1.w, y0.w, y1.w, z0.w, z1.w, w, t_min, t_max);
  return e;
}
#endif

/* The children that are entered, nearest first; NONE in place of the others. */
#define SORT_TWO(a, b)                     \
  if (e.t[b] < e.t[a]) {                   \
    real nearer = e.t[b];                  \
    uint reference = e.child[b];           \
    e.t[b] = e.t[a], e.t[a] = nearer;      \
    e.child[b] = e.child[a], e.child[a] = reference; \
  }
FN Entered4 sorted_children4(GLOBAL const WideNode4 *n, WideSlabs w, real t_min, real t_max) {
  Entered4 e = enter_children4(n, w, t_min, t_max);
  float4 refs = load_float4(n, QUANTISED ? 1 : 6);
  e.child[0] = bits_of_float(refs.x);
  e.child[1] = bits_of_float(refs.y);
  e.child[2] = bits_of_float(refs.z);
  e.child[3] = bits_of_float(refs.w);
  for (uint k = 0u; k < 4u; k++) {
    if (e.child[k] == NONE) e.t[k] = MISSED;
    if (e.t[k] == MISSED) e.child[k] = NONE;
  }
  SORT_TWO(0, 2)
  SORT_TWO(1, 3)
  SORT_TWO(0, 1)
#if ORDERED /* else only the nearest is known to be it */
  SORT_TWO(2, 3)
  SORT_TWO(1, 2)
#endif
  return e;
}

FN Hit trace_wide4(Scene s, Ray ray, int any) {
  Hit best = no_hit(ray.t_max);
  GLOBAL const WideNode4 *nodes = (GLOBAL const WideNode4 *)s.nodes;
  LocalRay world = make_local_ray(ray.origin, ray.direction);
  LocalRay space = world;
  WideSlabs slabs = make_wide_slabs(space);
  real slack_t_min = ray.t_min * (REAL(1.0) - REAL(16.0) * ROUNDING);
  uint stack[STUDY_STACK];
  int top = 0;
  uint instance = NONE, ref = s.world[0].root;
  stack[top++] = NONE;
  for (;;) {
    while (REF_KIND(ref) == REF_NODE) {
      Entered4 e = sorted_children4(&nodes[ref], slabs, slack_t_min, best.t * LIMIT_SLACK);
      for (uint k = 3u; k > 0u; k--)
        if (e.child[k] != NONE) stack[top++] = e.child[k];
      ref = e.child[0] != NONE ? e.child[0] : stack[--top];
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
      slabs = make_wide_slabs(space);
    } else if ((SCENE_FEATURES & FEATURE_INSTANCES) && (s.instances[REF_INDEX(ref)].visibility & ray.kind)) {
      stack[top++] = REF_RETURN;
      instance = REF_INDEX(ref);
      space = make_local_ray(transform_point(s.instances[instance].to_object, ray.origin),
                             transform_vector(s.instances[instance].to_object, ray.direction));
      slabs = make_wide_slabs(space);
      ref = s.instances[instance].root;
      continue;
    }
    ref = stack[--top];
  }
}

#endif
