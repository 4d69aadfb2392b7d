/* Eight quantised boxes a node; the stack holds a node and a mask of its children that are still to be visited, in
 * the order of the ray's octant. Ylitie, Karras and Laine 2017, sections 3 and 4 (without postponed triangles). */
#ifndef ISOPHOTE_STUDY_WIDE8_H
#define ISOPHOTE_STUDY_WIDE8_H
#include "wide.h"

/* Mask of the children that the ray enters; bit k is the child at place k exclusive-or octant. Words hold four
 * children each: first those of places 0 to 3, then the others. */
FN uint enter_children8(GLOBAL const QuantisedNode8 *n, WideSlabs w, real t_min, real t_max) {
  float4 corner = load_float4(n, 0), x = load_float4(n, 3), y = load_float4(n, 4), z = load_float4(n, 5);
  WideSlabs in_steps = make_node_slabs(load3(corner), bits_of_float(corner.w), w);
  uint there = bits_of_float(corner.w) >> 24, mask = 0u;
  for (uint side = 0u; side < 2u; side++) {
    real lo_x = side ? x.y : x.x, hi_x = side ? x.w : x.z;
    real lo_y = side ? y.y : y.x, hi_y = side ? y.w : y.z;
    real lo_z = side ? z.y : z.x, hi_z = side ? z.w : z.z;
    uint x0 = bits_of_float(w.octant & 1u ? hi_x : lo_x), x1 = bits_of_float(w.octant & 1u ? lo_x : hi_x);
    uint y0 = bits_of_float(w.octant & 2u ? hi_y : lo_y), y1 = bits_of_float(w.octant & 2u ? lo_y : hi_y);
    uint z0 = bits_of_float(w.octant & 4u ? hi_z : lo_z), z1 = bits_of_float(w.octant & 4u ? lo_z : hi_z);
    for (uint k = 0u; k < 4u; k++) {
      real t = enter_planes(BYTE(x0, k), BYTE(x1, k), BYTE(y0, k), BYTE(y1, k), BYTE(z0, k), BYTE(z1, k), in_steps,
                            t_min, t_max);
      uint place = 4u * side + k;
      if (t < MISSED && ((there >> place) & 1u)) mask |= 1u << (place ^ w.octant);
    }
  }
  return mask;
}

FN Hit trace_wide8(Scene s, Ray ray, int any) {
  Hit best = no_hit(ray.t_max);
  GLOBAL const QuantisedNode8 *nodes = (GLOBAL const QuantisedNode8 *)s.nodes;
  LocalRay world = make_local_ray(ray.origin, ray.direction);
  LocalRay space = world;
  WideSlabs slabs = make_wide_slabs(space);
  real slack_t_min = ray.t_min * (REAL(1.0) - REAL(16.0) * ROUNDING);
  uint stack_node[STUDY_STACK], stack_mask[STUDY_STACK];
  int top = 0;
  uint node = NONE, mask = 0u; /* the node being visited and its children to come */
  uint instance = NONE, ref = s.world[0].root;
  if (ref == NONE) return best;
  for (;;) {
    int enters = 0;
    if (REF_KIND(ref) == REF_TRIANGLES) {
      best = hit_triangles(s, REF_INDEX(ref), instance, space, ray, best);
      if (any && best.instance != NONE) return best;
    } else if ((SCENE_FEATURES & FEATURE_SPHERES) && REF_KIND(ref) == REF_SPHERE) {
      best = hit_sphere(s, REF_INDEX(ref), space, ray, best);
      if (any && best.instance != NONE) return best;
    } else if ((SCENE_FEATURES & FEATURE_INSTANCES) && REF_KIND(ref) == REF_INSTANCE) {
      enters = (s.instances[REF_INDEX(ref)].visibility & ray.kind) != 0u;
    }
    if (mask && (enters || REF_KIND(ref) == REF_NODE)) {
      stack_node[top] = node;
      stack_mask[top++] = mask;
      mask = 0u;
    }
    if (enters) {
      instance = REF_INDEX(ref);
      space = make_local_ray(transform_point(s.instances[instance].to_object, ray.origin),
                             transform_vector(s.instances[instance].to_object, ray.direction));
      slabs = make_wide_slabs(space);
      stack_node[top] = REF_RETURN;
      stack_mask[top++] = 0u;
      ref = s.instances[instance].root;
      if (REF_KIND(ref) != REF_NODE) continue;
    }
    if (REF_KIND(ref) == REF_NODE) {
      node = ref;
      mask = enter_children8(&nodes[node], slabs, slack_t_min, best.t * LIMIT_SLACK);
    }
    while (mask == 0u) {
      if (top == 0) return best;
      node = stack_node[--top];
      mask = stack_mask[top];
      if ((SCENE_FEATURES & FEATURE_INSTANCES) && node == REF_RETURN) {
        instance = NONE;
        space = world;
        slabs = make_wide_slabs(space);
      }
    }
    uint k = 31u - clz(mask & (0u - mask));
    mask &= mask - 1u;
    ref = nodes[node].child[k ^ slabs.octant];
  }
}

#endif
