/* Brute force: every primitive of the scene, one after the other, as in the founding report's version without a BVH.
 *
 * The host makes the tree a chain (bench/study/trees.py): child 0 of a node is a run of triangles, a sphere or
 * an instance of one run, child 1 is the rest. trace_list lets each work-item read on its own; with
 * trace_list_together the work-group reads a chunk of triangles into local memory and all its rays test that. */
#ifndef ISOPHOTE_STUDY_LIST_H
#define ISOPHOTE_STUDY_LIST_H
#include "../bvh.h"

FN Hit trace_list(Scene s, Ray ray, int any) {
  Hit best = no_hit(ray.t_max);
  LocalRay world = make_local_ray(ray.origin, ray.direction);
  for (uint rest = s.world[0].root; rest != NONE;) {
    uint ref = rest;
    rest = NONE;
    if (REF_KIND(ref) == REF_NODE) {
      rest = s.nodes[ref].child[1];
      ref = s.nodes[ref].child[0];
    }
    uint i = REF_INDEX(ref);
    if (REF_KIND(ref) == REF_TRIANGLES) {
      best = hit_triangles(s, i, NONE, world, ray, best);
    } else if ((SCENE_FEATURES & FEATURE_SPHERES) && REF_KIND(ref) == REF_SPHERE) {
      best = hit_sphere(s, i, world, ray, best);
    } else if ((SCENE_FEATURES & FEATURE_INSTANCES) && (s.instances[i].visibility & ray.kind)) {
      LocalRay space = make_local_ray(transform_point(s.instances[i].to_object, ray.origin),
                                      transform_vector(s.instances[i].to_object, ray.direction));
      best = hit_triangles(s, REF_INDEX(s.instances[i].root), i, space, ray, best);
    }
    if (any && best.instance != NONE) return best;
  }
  return best;
}

/* A run of triangles, in chunks of the work-group's size. TRIANGLE_COUNT is that of the whole array. */
FN Hit hit_run_together(Scene s, uint first, uint instance, LocalRay space, Ray ray, Hit best, int wanted,
                        __local Triangle *chunk) {
  uint lane = get_local_id(0), last = 0u;
  for (; !last; first += GROUP_SIZE) {
    barrier(CLK_LOCAL_MEM_FENCE); /* the chunk before has been read by all */
    if (first + lane < TRIANGLE_COUNT) chunk[lane] = s.triangles[first + lane];
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint k = 0u; k < GROUP_SIZE && !last; k++) {
      uint flags = chunk[k].flags;
      last = flags & LAST_IN_LEAF;
      int sees = !(SCENE_FEATURES & FEATURE_VISIBILITY) || instance != NONE || ((flags >> 16) & ray.kind);
      if (wanted && sees) {
        TriangleHit h = triangle_hit(load3(chunk[k].v0), load3(chunk[k].v1), load3(chunk[k].v2), space.origin,
                                     space.direction, space.shear);
        uint owner = instance != NONE ? instance : chunk[k].instance;
        if (h.hit) best = keep_closer(best, h, owner, chunk[k].primitive, ray);
      }
    }
  }
  return best;
}

/* All of a work-group call it together; those that are not wanted only help to read. */
FN Hit trace_list_together(Scene s, Ray ray, int any, int wanted, __local Triangle *chunk) {
  Hit best = no_hit(ray.t_max);
  LocalRay world = make_local_ray(ray.origin, ray.direction);
  for (uint rest = s.world[0].root; rest != NONE;) {
    uint ref = rest;
    rest = NONE;
    if (REF_KIND(ref) == REF_NODE) {
      rest = s.nodes[ref].child[1];
      ref = s.nodes[ref].child[0];
    }
    uint i = REF_INDEX(ref);
    if (REF_KIND(ref) == REF_TRIANGLES) {
      best = hit_run_together(s, i, NONE, world, ray, best, wanted, chunk);
    } else if ((SCENE_FEATURES & FEATURE_SPHERES) && REF_KIND(ref) == REF_SPHERE) {
      if (wanted) best = hit_sphere(s, i, world, ray, best);
    } else if (SCENE_FEATURES & FEATURE_INSTANCES) {
      LocalRay space = make_local_ray(transform_point(s.instances[i].to_object, ray.origin),
                                      transform_vector(s.instances[i].to_object, ray.direction));
      int sees = wanted && (s.instances[i].visibility & ray.kind);
      best = hit_run_together(s, REF_INDEX(s.instances[i].root), i, space, ray, best, sees, chunk);
    }
    if (any && best.instance != NONE) wanted = 0;
  }
  return best;
}

#endif
