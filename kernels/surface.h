/* The point that a ray has hit, ready for shading. */
#ifndef ISOPHOTE_SURFACE_H
#define ISOPHOTE_SURFACE_H
#include "bvh.h"

typedef struct {
  real3 p;
  real offset;     /* metres along ng that a ray must start off the surface */
  real3 ng, ns;    /* geometric and shading normal, unit, on the viewer's side */
  int backfacing;  /* the viewer is behind the surface */
  uint material;
} Surface;

/* |M| applied to a non-negative vector: how errors grow through a transform. */
FN real3 transform_error(GLOBAL const float *m, real3 e) {
  return make_real3(fabs(to_real(m[0])) * e.x + fabs(to_real(m[1])) * e.y + fabs(to_real(m[2])) * e.z,
                    fabs(to_real(m[4])) * e.x + fabs(to_real(m[5])) * e.y + fabs(to_real(m[6])) * e.z,
                    fabs(to_real(m[8])) * e.x + fabs(to_real(m[9])) * e.y + fabs(to_real(m[10])) * e.z);
}
FN real3 translation_error(GLOBAL const float *m) {
  return make_real3(fabs(to_real(m[3])), fabs(to_real(m[7])), fabs(to_real(m[11])));
}

/* Bends a shading normal that looks away from the viewer back to just above his horizon. */
FN real3 face_viewer(real3 ns, real3 wo) {
  real lift = REAL(1e-3) - dot3(ns, wo);
  real3 bent = normalize3(ns + wo * max_real(lift, REAL(0.0)));
  return select3(lift > REAL(0.0), bent, ns);
}

#if SCENE_FEATURES & FEATURE_MOTION
/* How much a placement makes of errors, which are not negative. */
FN Placement error_placement(Placement m) {
  m.x = abs3(m.x);
  m.y = abs3(m.y);
  m.z = abs3(m.z);
  m.stretch = abs_stretch(m.stretch);
  m.back = abs_stretch(m.back);
  return m;
}

/* How far off in the world the point p of a moving instance is, which was off by `error` in its own space and was hit at
 * t. The ray there is off by the roundings of its way; how well the stretch's inverse is one says p's way to and fro. */
FN real3 placed_error(Placement m, Placement size, real3 error, real3 p, Ray ray, real t) {
  real3 reach = abs3(ray.origin) + abs3(m.place) + abs3(ray.direction) * t;
  real3 again = abs3(unplaced_vector(m, placed_vector(m, p)) - p) * REAL(2.0);
  error = error + again + (unplaced_vector(size, reach) + abs3(p) * REAL(2.0)) * (REAL(8.0) * ROUNDING);
  return placed_vector(size, error) + abs3(m.place) * (REAL(4.0) * ROUNDING);
}
#endif

/* Of a hit. */
FN uint hit_material(Scene s, Hit h, uint features) {
  if ((features & FEATURE_SPHERES) && h.instance == SPHERE_INSTANCE) return s.spheres[h.primitive].material;
  uint slot = (features & FEATURE_SLOTS) ? s.slots[h.primitive] : 0u;
  return s.slot_materials[s.instances[h.instance].first_slot + slot];
}

FN real sum_of3(real3 a) { return a.x + a.y + a.z; }

#if SCENE_FEATURES & FEATURE_STRANDS
/* Where a ray is at t, in the space of an instance with a tree of its own. */
FN real3 point_in_object(Scene s, uint instance, Ray ray, real t, uint features) {
  real3 p = ray.origin + ray.direction * t;
#if SCENE_FEATURES & FEATURE_MOTION
  if (in_motion(s, instance, features)) return unplaced_point(placement_at(s, s.motions[instance], ray.time), p);
#endif
  return transform_point(s.instances[instance].to_object, p);
}
#endif

/* A point of the triangle with edges e1, e2 and weights b0, b1, b2 of its corners, moved inside where it is nearer to
 * an edge than `reach`: rounding could put it beyond a wall that meets the triangle there, and light would leak in. */
FN real3 keep_inside(real3 p, real3 e1, real3 e2, real b0, real b1, real b2, real reach) {
  real3 n = cross3(e1, e2), e0 = e2 - e1;
  real square0 = dot3(e0, e0), square1 = dot3(e2, e2), square2 = dot3(e1, e1);
  real area = sqrt(dot3(n, n)), l0 = sqrt(square0), l1 = sqrt(square1), l2 = sqrt(square2); /* area: twice */
  reach = min_real(reach, area / (l0 + l1 + l2)); /* the middle is no farther from the edges */
  /* What is missing at an edge, reach - b area / l, over the length area l of n's product with the edge. */
  real tiny = REAL(1e-37);
  real m0 = max_real(reach * l0 - b0 * area, REAL(0.0)) / max_real(area * square0, tiny);
  real m1 = max_real(reach * l1 - b1 * area, REAL(0.0)) / max_real(area * square1, tiny);
  real m2 = max_real(reach * l2 - b2 * area, REAL(0.0)) / max_real(area * square2, tiny);
  return p + cross3(n, e0 * m0 - e2 * m1 + e1 * m2);
}

/* Error bounds of the point after Pharr, Jakob and Humphreys 2016, PBR 3rd ed., section 3.9.4 to 3.9.5,
 * doubled for the roundings of the offset itself. h must be a hit. */
FN Surface make_surface(Scene s, Ray ray, Hit h, uint features) {
  Surface r;
  real3 error;
  real3 ng, ns;
  r.material = hit_material(s, h, features);
  if ((features & FEATURE_SPHERES) && h.instance == SPHERE_INSTANCE) {
    GLOBAL const Sphere *sphere = &s.spheres[h.primitive];
    real3 center = load3(sphere->center);
    real radius = to_real(sphere->radius);
    ng = normalize3(ray.origin + ray.direction * h.t - center);
    ns = ng;
    r.p = center + ng * radius;
    error = (abs3(center) + splat3(radius)) * (REAL(8.0) * ROUNDING);
  } else {
    GLOBAL const Instance *instance = &s.instances[h.instance];
    GLOBAL const uint *corner = &s.indices[3u * h.primitive];
    uint swap = (instance->visibility & INSTANCE_MIRRORED) ? 1u : 0u;
    uint i0 = corner[0], i1 = corner[1u + swap], i2 = corner[2u - swap];
    real time = ray_time(ray);
    real3 v0 = vertex_at(s, h.instance, i0, time, features), v1 = vertex_at(s, h.instance, i1, time, features);
    real3 v2 = vertex_at(s, h.instance, i2, time, features);
    real b0 = REAL(1.0) - h.u - h.v;
    r.p = v0 * b0 + v1 * h.u + v2 * h.v;
    error = (abs3(v0) * fabs(b0) + abs3(v1) * fabs(h.u) + abs3(v2) * fabs(h.v)) * (REAL(8.0) * ROUNDING);
    real3 e1 = v1 - v0, e2 = v2 - v0, off_plane = zero3();
#if SCENE_FEATURES & FEATURE_STRANDS
    int strand = (features & FEATURE_INSTANCES) && is_strand(s, h.instance); /* they have trees of their own */
    if (strand) { /* p is the centre of the ball whose surface was hit */
      real radius = radius_at(s, h.instance, i0) * b0 + radius_at(s, h.instance, i1) * h.u;
      ng = normalize3(point_in_object(s, h.instance, ray, h.t, features) - r.p);
      r.p = r.p + ng * radius;
      error = error + (splat3(radius) + abs3(e1)) * (REAL(8.0) * ROUNDING);
      /* As in Cycles light does not know that strands are pointed; between segments (u = 1) they are round. */
      real square = h.u < REAL(1.0) ? dot3(e1, e1) : REAL(0.0);
      ns = ng - e1 * (square > REAL(0.0) ? dot3(ng, e1) / square : REAL(0.0));
    }
#else
    int strand = 0;
#endif
    if (!strand) {
      /* is_in_front: how far p lies off the plane, and the rounding of its test here and for a neighbour. */
      ng = cross3(e1, e2);
      real3 across = normalize3(ng);
      error = error + (abs3(e1) + abs3(e2)) * (REAL(4.0) * ROUNDING);
      off_plane = abs3(across) * fabs(dot3(across, r.p - v0));
      ns = ng;
    }
    if (features & FEATURE_SMOOTH) {
      uint first = instance->first_normal;
      if (instance->visibility & INSTANCE_SMOOTH)
        ns = normal_at(s, h.instance, first, i0, time, features) * b0 +
             normal_at(s, h.instance, first, i1, time, features) * h.u +
             normal_at(s, h.instance, first, i2, time, features) * h.v;
    }
#if SCENE_FEATURES & FEATURE_MOTION
    int moves = in_motion(s, h.instance, features);
    if (moves) {
      Placement m = placement_at(s, s.motions[h.instance], time);
      Placement size = error_placement(m);
      error = placed_error(m, size, error, r.p, ray, h.t);
      off_plane = placed_vector(size, off_plane);
      r.p = placed_point(m, r.p);
      e1 = placed_vector(m, e1);
      e2 = placed_vector(m, e2);
      ng = placed_normal(m, ng);
      ns = placed_normal(m, ns);
    }
#else
    int moves = 0;
#endif
    if ((features & FEATURE_INSTANCES) && !moves && instance->root != NONE) {
      GLOBAL const float *out = instance->to_world;
      GLOBAL const float *in = instance->to_object;
      /* The object-space ray was off by the rounding of its own transform, and the two matrices, as they
       * are stored, are not exactly each other's inverse. */
      real3 ray_error = transform_error(in, abs3(ray.origin) + abs3(ray.direction) * h.t) + translation_error(in);
      error = transform_error(out, error + (ray_error + abs3(r.p)) * (REAL(4.0) * STORAGE_ROUNDING)) +
              translation_error(out) * (REAL(4.0) * STORAGE_ROUNDING);
      off_plane = transform_error(out, off_plane);
      r.p = transform_point(out, r.p);
      e1 = transform_vector(out, e1);
      e2 = transform_vector(out, e2);
      ng = transform_normal(in, ng);
      ns = transform_normal(in, ns);
    }
    r.p = keep_inside(r.p, e1, e2, b0, h.u, h.v, sum_of3(error));
    error = error + off_plane;
    ng = normalize3(ng);
    ns = normalize3(ns);
  }
  real3 wo = zero3() - ray.direction;
  r.backfacing = dot3(ng, wo) < REAL(0.0);
  real side = r.backfacing ? REAL(-1.0) : REAL(1.0);
  r.ng = ng * side;
  r.ns = face_viewer(ns * side, wo);
  r.offset = REAL(2.0) * dot3(abs3(ng), error + abs3(r.p) * (REAL(2.0) * ROUNDING));
  return r;
}

/* Waechter and Binder 2019 start rays off the surface by a fixed number of float steps; here the step is
 * the error bound of the hit, so it scales with the scene. */
FN real3 offset_origin(Surface s, real3 direction) {
  STRICT_FP
  real side = dot3(s.ng, direction) < REAL(0.0) ? -s.offset : s.offset;
  return s.p + s.ng * side;
}

#endif
