/* The founding report's own traversal: pop a node, test both children, push those that are hit. ORDERED pushes the
 * nearer child last, so that it comes next; PRUNED skips boxes behind the closest hit so far. */
#ifndef ISOPHOTE_STUDY_STACK_H
#define ISOPHOTE_STUDY_STACK_H
#include "box.h"

FN Hit trace_stack(Scene s, Ray ray, int any) {
  Hit best = no_hit(ray.t_max);
  LocalRay world = make_local_ray(ray.origin, ray.direction);
  LocalRay space = world;
  real slack_t_min = ray.t_min * (REAL(1.0) - REAL(16.0) * ROUNDING);
  uint stack[STUDY_STACK]; /* the host has looked how deep the tree is */
  int top = 0;
  uint instance = NONE;
  if (s.world[0].root == NONE) return best;
  stack[top++] = s.world[0].root;
  while (top > 0) {
    uint ref = stack[--top], kind = REF_KIND(ref);
    if ((SCENE_FEATURES & FEATURE_INSTANCES) && ref == REF_RETURN) {
      instance = NONE;
      space = world;
    } else if (kind == REF_NODE) {
      GLOBAL const Bvh2Node *n = &s.nodes[ref];
      real limit = (PRUNED ? best.t : ray.t_max) * LIMIT_SLACK;
      float4 x = load_float4(n, 0), y = load_float4(n, 1), z = load_float4(n, 2), children = load_float4(n, 3);
      real t0 = enter_box(x.x, x.z, y.x, y.z, z.x, z.z, space, slack_t_min, limit);
      real t1 = enter_box(x.y, x.w, y.y, y.w, z.y, z.w, space, slack_t_min, limit);
      uint child0 = bits_of_float(children.x), child1 = bits_of_float(children.y);
      int first = ORDERED && t1 < t0 && t1 >= REAL(0.0); /* the one that is visited first */
      if ((first ? t0 : t1) >= REAL(0.0)) stack[top++] = first ? child0 : child1;
      if ((first ? t1 : t0) >= REAL(0.0)) stack[top++] = first ? child1 : child0;
    } else if (kind == REF_TRIANGLES) {
      best = hit_triangles(s, REF_INDEX(ref), instance, space, ray, best);
      if (any && best.instance != NONE) return best;
    } else if ((SCENE_FEATURES & FEATURE_SPHERES) && kind == REF_SPHERE) {
      best = hit_sphere(s, REF_INDEX(ref), space, ray, best);
      if (any && best.instance != NONE) return best;
    } else if ((SCENE_FEATURES & FEATURE_INSTANCES) && (s.instances[REF_INDEX(ref)].visibility & ray.kind)) {
      instance = REF_INDEX(ref);
      space = make_local_ray(transform_point(s.instances[instance].to_object, ray.origin),
                             transform_vector(s.instances[instance].to_object, ray.direction));
      stack[top++] = REF_RETURN;
      stack[top++] = s.instances[instance].root;
    }
  }
  return best;
}

#endif
