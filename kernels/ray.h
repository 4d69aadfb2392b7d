/* Rays, hits, and the order among hits that every tracer keeps to. */
#ifndef ISOPHOTE_RAY_H
#define ISOPHOTE_RAY_H
#include "scene_buffers.h"

#define FAR_AWAY REAL(3.0e38)

/* Half the distance from 1 to the next number: the unit of rounding errors (Higham 2002, 2.2), of the
 * arithmetic and of what is stored in the scene's arrays. */
#define STORAGE_ROUNDING REAL(5.9604644775390625e-8)
#if REAL_IS_DOUBLE
#define ROUNDING 1.1102230246251565e-16
#else
#define ROUNDING STORAGE_ROUNDING
#endif

/* Hits count where (t, instance, primitive) lies behind (t_min, after_instance, after_primitive) in
 * lexicographic order and t < t_max; so a path can go on behind a transparent surface without
 * missing or repeating one at the same distance. after_instance NONE: nothing was passed, t >= t_min. Just in front of
 * a long triangle t may come out as 0, where is_in_front still knows on which side the ray begins. */
typedef struct {
  real3 origin, direction; /* direction is unit length in the world */
  real t_min, t_max;
  uint after_instance, after_primitive;
  uint skip_instance, skip_primitive; /* never hit: the light that a shadow ray goes to; NONE otherwise */
  uint within_instance, within_primitive; /* inside an object nothing else is hit; of spheres the second says which */
  uint kind;                          /* one RAY_ bit of RAY_ALL, and how it was made */
#if SCENE_FEATURES & FEATURE_MOTION
  real time; /* 0 when the shutter opens, 1 when it closes */
#endif
} Ray;

FN Ray free_ray(real3 origin, real3 direction, real t_min, real t_max) {
  Ray r;
  r.origin = origin;
  r.direction = direction;
  r.t_min = t_min;
  r.t_max = t_max;
  r.after_instance = NONE;
  r.after_primitive = NONE;
  r.skip_instance = NONE;
  r.skip_primitive = NONE;
  r.within_instance = NONE;
  r.within_primitive = NONE;
  r.kind = RAY_ALL;
#if SCENE_FEATURES & FEATURE_MOTION
  r.time = REAL(0.0);
#endif
  return r;
}

FN Ray ray_at(Ray r, real time) {
#if SCENE_FEATURES & FEATURE_MOTION
  r.time = time;
#endif
  return r;
}
FN real ray_time(Ray r) {
#if SCENE_FEATURES & FEATURE_MOTION
  return r.time;
#else
  return REAL(0.0);
#endif
}

typedef struct {
  real t;
  real u, v; /* barycentric weights of v1 and v2 */
  uint instance, primitive; /* numbers in the scene's order; SPHERE_INSTANCE and the sphere's; NONE: no hit */
} Hit;

#define SPHERE_INSTANCE (NONE - 1u)
#define IN_VOLUME (NONE - 2u) /* of a path that is scattered by a volume on the way */

FN Hit no_hit(real t_max) {
  Hit h;
  h.t = t_max;
  h.u = REAL(0.0);
  h.v = REAL(0.0);
  h.instance = NONE;
  h.primitive = NONE;
  return h;
}

FN int is_within(uint instance, Ray r) { return (r.within_instance == NONE) | (r.within_instance == instance); }

FN int is_wanted(real t, uint instance, uint primitive, Ray r) {
  int later = (instance + 1u > r.after_instance + 1u) | ((instance == r.after_instance) & (primitive > r.after_primitive));
  int skipped = (instance == r.skip_instance) & (primitive == r.skip_primitive);
  if (SCENE_FEATURES & FEATURE_SUBSURFACE)
    skipped = skipped | !is_within(instance, r) | ((r.within_instance == SPHERE_INSTANCE) & (primitive != r.within_primitive));
  return ((t > r.t_min) | ((t == r.t_min) & later)) & !skipped;
}

/* Ties go to the lowest instance, then to the lowest primitive: the result does not depend on the
 * order in which a tree visits them. */
FN int is_closer(real t, uint instance, uint primitive, Hit best) {
  int lower = (instance < best.instance) | ((instance == best.instance) & (primitive < best.primitive));
  return (t < best.t) | ((t == best.t) & lower);
}

#endif
