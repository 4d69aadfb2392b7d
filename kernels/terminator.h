/* Where rays to lights start on triangles that are smooth: where the light is about to set, above the flat triangle, so that
 * those beside it do not cast hard shadows on what looks round. As in Cycles (kernel/light/sample.h, shadow_ray_offset),
 * after Hanika 2021, "Hacking the Shadow Terminator", Ray Tracing Gems II, chapter 4. */
#ifndef ISOPHOTE_TERMINATOR_H
#define ISOPHOTE_TERMINATOR_H
#include "surface.h"

/* How much of the lift counts, 0 to 1: all of it where the light stands less than `cutoff` above the surface, measured
 * by the cosines to both normals, on whichever side it is. */
FN real lift_share(Surface at, real3 light, real cutoff) {
  real height = dot3(at.ns, light);
  real flat = height < REAL(0.0) ? -dot3(at.ng, light) : dot3(at.ng, light);
  height = fabs(height);
  real low = height < cutoff ? REAL(2.0) - (flat + height) / cutoff : REAL(1.0) - flat / cutoff;
  return clamp01(low);
}

/* From a point of a smooth triangle, on the side of the normal ng, to a surface that the corners' normals stand for: at
 * least half of what a parabola has, and the lowest of the corners' tangent planes, each raised until it has no other
 * corner above it. */
FN real3 smooth_lift(Scene s, Hit h, real3 ng, real time) {
  uint features = SCENE_FEATURES & s.world[0].features;
  GLOBAL const Instance *instance = &s.instances[h.instance];
  GLOBAL const uint *corner = &s.indices[3u * h.primitive];
  uint swap = (instance->visibility & INSTANCE_MIRRORED) ? 1u : 0u, first = instance->first_normal;
  uint i0 = corner[0], i1 = corner[1u + swap], i2 = corner[2u - swap];
  real3 v0 = vertex_at(s, h.instance, i0, time, features), n0 = normal_at(s, h.instance, first, i0, time, features);
  real3 v1 = vertex_at(s, h.instance, i1, time, features), n1 = normal_at(s, h.instance, first, i1, time, features);
  real3 v2 = vertex_at(s, h.instance, i2, time, features), n2 = normal_at(s, h.instance, first, i2, time, features);
  real b0 = REAL(1.0) - h.u - h.v, b1 = h.u, b2 = h.v;
  real3 p = v0 * b0 + v1 * b1 + v2 * b2, n = n0 * b0 + n1 * b1 + n2 * b2;
  int moves = 0;
#if SCENE_FEATURES & FEATURE_MOTION
  moves = in_motion(s, h.instance, features);
  if (moves) n = placed_vector(placement_at(s, s.motions[h.instance], time), n);
#endif
  if (!moves && instance->root != NONE) n = transform_vector(instance->to_world, n);
  real a = dot3(n2 - n0, v0 - v2), b = dot3(n2 - n1, v1 - v2), c = dot3(n1 - n0, v1 - v0);
  real curved = a * b0 * (b0 - REAL(1.0)) + (a + b + c) * b0 * b1 + b * b1 * (b1 - REAL(1.0));
  real side = dot3(n, ng) > REAL(0.0) ? REAL(1.0) : REAL(-1.0);
  n0 = n0 * side;
  n1 = n1 * side;
  n2 = n2 * side;
  real h0 = dot3(v0 - p, n0) + max_real(max_real(dot3(v1 - v0, n0), dot3(v2 - v0, n0)), REAL(0.0));
  real h1 = dot3(v1 - p, n1) + max_real(max_real(dot3(v0 - v1, n1), dot3(v2 - v1, n1)), REAL(0.0));
  real h2 = dot3(v2 - p, n2) + max_real(max_real(dot3(v0 - v2, n2), dot3(v1 - v2, n2)), REAL(0.0));
  real lowest = max_real(min_real(min_real(h0, h1), h2), REAL(0.0));
  return n * (side * max_real(lowest, side * curved * REAL(0.5)));
}

FN real terminator_cutoff(Scene s, uint instance) {
  real cutoff = to_real(s.terminators[instance == SPHERE_INSTANCE ? 0u : instance]);
  return instance == SPHERE_INSTANCE ? REAL(0.0) : cutoff;
}

/* The normal that says on which side of a surface light stands that is drawn: where rays to it are lifted the shading
 * normal, and the ray finds out whether the surface itself is in its way. */
FN real3 light_side(Scene s, Surface at, uint instance) {
  return select3(terminator_cutoff(s, instance) > REAL(0.0), at.ns, at.ng);
}

/* A ray from a hit to a light, begun higher where it has to be; rays of no length are those of lamps without shadows. */
FN Ray lifted_ray(Scene s, Surface at, Hit h, Ray ray) {
  real cutoff = terminator_cutoff(s, h.instance);
  real share = cutoff > REAL(0.0) ? lift_share(at, ray.direction, cutoff) : REAL(0.0);
  if (!(share > REAL(0.0)) || !(ray.t_max > REAL(0.0))) return ray;
  real3 ng = dot3(at.ns, ray.direction) < REAL(0.0) ? zero3() - at.ng : at.ng;
  real3 origin = at.p + ng * at.offset + smooth_lift(s, h, ng, ray_time(ray)) * share;
  if (ray.t_max < FAR_AWAY) {
    real3 way = ray.origin + ray.direction * ray.t_max - origin;
    real length = sqrt(dot3(way, way));
    if (!(length > REAL(0.0))) return ray;
    ray.direction = way * (REAL(1.0) / length);
    ray.t_max = length;
  }
  ray.origin = origin;
  return ray;
}

#endif
