/* Traversal without a stack: a state machine that knows where it came from and climbs by parent links.
 * Hapala, Davidovic, Wald, Havran and Slusallek 2011, "Efficient Stack-less BVH Traversal for Ray Tracing", SCCG,
 * section 3.
 *
 * The host (bench/study/trees.py) writes into a node's first unused word its parent and which child it is of it, and
 * into the second the axis that parts its children and which of them is the lower one: the order of children must be
 * the same on the way down and up, so it follows from the ray's direction alone. Every root is a node. */
#ifndef ISOPHOTE_STUDY_STACKLESS_H
#define ISOPHOTE_STUDY_STACKLESS_H
#include "box.h"

#define FROM_PARENT 0
#define FROM_SIBLING 1
#define FROM_CHILD 2

/* Which child of a node the ray visits first. */
FN uint near_child(GLOBAL const Bvh2Node *n, real3 direction) {
  uint axis = n->unused[1] & 3u, upper_first = n->unused[1] >> 2;
  real d = axis == 0u ? direction.x : (axis == 1u ? direction.y : direction.z);
  return ORDERED ? upper_first ^ (d < REAL(0.0) ? 1u : 0u) : 0u;
}

FN Hit trace_stackless(Scene s, Ray ray, int any) {
  Hit best = no_hit(ray.t_max);
  LocalRay world = make_local_ray(ray.origin, ray.direction);
  LocalRay space = world;
  real slack_t_min = ray.t_min * (REAL(1.0) - REAL(16.0) * ROUNDING);
  uint node = s.world[0].root, instance = NONE, outer_node = NONE, outer_child = 0u;
  if (node == NONE) return best;
  uint child = near_child(&s.nodes[node], space.direction);
  int state = FROM_PARENT;
  for (;;) {
    GLOBAL const Bvh2Node *n = &s.nodes[node];
    if (state == FROM_CHILD) { /* both children are done */
      uint parent = n->unused[0];
      if (parent == NONE && (!(SCENE_FEATURES & FEATURE_INSTANCES) || instance == NONE)) return best;
      node = parent == NONE ? outer_node : parent >> 1;
      child = parent == NONE ? outer_child : parent & 1u;
      if (parent == NONE) {
        instance = NONE;
        space = world;
      }
      if (child == near_child(&s.nodes[node], space.direction)) {
        child = 1u - child;
        state = FROM_SIBLING;
      }
      continue;
    }
    uint ref = n->child[child], kind = REF_KIND(ref);
    float4 x = load_float4(n, 0), y = load_float4(n, 1), z = load_float4(n, 2);
    real limit = (PRUNED ? best.t : ray.t_max) * LIMIT_SLACK;
    real t = ref == NONE ? REAL(-1.0)
                         : enter_box(child ? x.y : x.x, child ? x.w : x.z, child ? y.y : y.x, child ? y.w : y.z,
                                     child ? z.y : z.x, child ? z.w : z.z, space, slack_t_min, limit);
    if (t >= REAL(0.0)) {
      if (kind == REF_TRIANGLES) best = hit_triangles(s, REF_INDEX(ref), instance, space, ray, best);
      if ((SCENE_FEATURES & FEATURE_SPHERES) && kind == REF_SPHERE)
        best = hit_sphere(s, REF_INDEX(ref), space, ray, best);
      if (any && best.instance != NONE) return best;
      int enters = (SCENE_FEATURES & FEATURE_INSTANCES) && kind == REF_INSTANCE &&
                   (s.instances[REF_INDEX(ref)].visibility & ray.kind);
      if (enters) {
        instance = REF_INDEX(ref);
        space = make_local_ray(transform_point(s.instances[instance].to_object, ray.origin),
                               transform_vector(s.instances[instance].to_object, ray.direction));
        outer_node = node;
        outer_child = child;
        ref = s.instances[instance].root;
      }
      if (enters || kind == REF_NODE) {
        node = ref;
        child = near_child(&s.nodes[node], space.direction);
        state = FROM_PARENT;
        continue;
      }
    }
    if (state == FROM_PARENT) child = 1u - child;
    state = state == FROM_PARENT ? FROM_SIBLING : FROM_CHILD;
  }
}

#endif
