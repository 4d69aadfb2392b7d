/* Eight quantised boxes a node; the stack holds a node and a mask of its children that are still to be visited, in
 * the order of the ray's octant. Ylitie, Karras and Laine 2017, sections 3 and 4 (without postponed triangles). */
#ifndef ISOPHOTE_STUDY_WIDE8_H
#define ISOPHOTE_STUDY_WIDE8_H
#include "../bvh.h"
#include "wide_nodes.h"

FN uint octant_of(real3 d) {
  return (d.x < REAL(0.0) ? 1u : 0u) | (d.y < REAL(0.0) ? 2u : 0u) | (d.z < REAL(0.0) ? 4u : 0u);
}

FN real bound8(real corner, GLOBAL const uint *steps, uint k, real step) {
  return corner + real_of((steps[k >> 2] >> (8u * (k & 3u))) & 255u) * step;
}

/* Mask of the children that the ray enters; bit k is the child at place k exclusive-or octant. */
FN uint enter_children8(GLOBAL const QuantisedNode8 *n, uint octant, LocalRay space, real t_min, real t_max) {
  uint mask = 0u, e = n->exponents;
  real3 step = make_real3(float_of_bits((e & 255u) << 23), float_of_bits(((e >> 8) & 255u) << 23),
                          float_of_bits(((e >> 16) & 255u) << 23));
  real3 corner = load3(n->corner);
  for (uint k = 0u; k < 8u; k++) {
    real t = enter_box(bound8(corner.x, n->lo_x, k, step.x), bound8(corner.x, n->hi_x, k, step.x),
                       bound8(corner.y, n->lo_y, k, step.y), bound8(corner.y, n->hi_y, k, step.y),
                       bound8(corner.z, n->lo_z, k, step.z), bound8(corner.z, n->hi_z, k, step.z), space, t_min, t_max);
    if (t >= REAL(0.0) && n->child[k] != NONE) mask |= 1u << (k ^ octant);
  }
  return mask;
}

FN Hit trace_wide8(Scene s, Ray ray, int any) {
  Hit best = no_hit(ray.t_max);
  GLOBAL const QuantisedNode8 *nodes = (GLOBAL const QuantisedNode8 *)s.nodes;
  LocalRay world = make_local_ray(ray.origin, ray.direction);
  LocalRay space = world;
  real slack_t_min = ray.t_min * (REAL(1.0) - REAL(16.0) * ROUNDING);
  uint stack_node[STUDY_STACK], stack_mask[STUDY_STACK];
  int top = 0;
  uint instance = NONE, octant = octant_of(world.direction);
  uint node = NONE, mask = 0u; /* the node being visited and its children to come */
  uint ref = s.world[0].root;
  if (ref == NONE) return best;
  for (;;) {
    uint kind = REF_KIND(ref);
    int enters = kind == REF_INSTANCE && (s.instances[REF_INDEX(ref)].visibility & ray.kind);
    if ((kind == REF_NODE || enters) && mask) {
      stack_node[top] = node;
      stack_mask[top++] = mask;
    }
    if (kind == REF_NODE) {
      node = ref;
      mask = enter_children8(&nodes[node], octant, space, slack_t_min, best.t * LIMIT_SLACK);
    } else if (kind == REF_TRIANGLES) {
      best = hit_triangles(s, REF_INDEX(ref), instance, space, ray, best);
      if (any && best.index != NONE) return best;
    } else if (kind == REF_SPHERES) {
      best = hit_spheres(s, REF_INDEX(ref), space, ray, best);
      if (any && best.index != NONE) return best;
    } else if (enters) {
      instance = REF_INDEX(ref);
      space = make_local_ray(transform_point(s.instances[instance].to_object, ray.origin),
                             transform_vector(s.instances[instance].to_object, ray.direction));
      octant = octant_of(space.direction);
      stack_node[top] = REF_RETURN;
      stack_mask[top++] = 0u;
      mask = 0u;
      ref = s.instances[instance].root;
      continue;
    }
    while (mask == 0u) {
      if (top == 0) return best;
      node = stack_node[--top];
      mask = stack_mask[top];
      if (node == REF_RETURN) {
        instance = NONE;
        space = world;
        octant = octant_of(world.direction);
      }
    }
    uint k = 31u - clz(mask & (0u - mask));
    mask &= mask - 1u;
    ref = nodes[node].child[k ^ octant];
  }
}

#endif
