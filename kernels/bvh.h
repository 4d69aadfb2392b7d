/* Ordered traversal of the two-level BVH2 with a stack.
 *
 * A box test only decides what may be skipped and errs on the side of looking: Ize 2013, "Robust BVH
 * Ray Traversal", JCGT 2(2). The hit itself comes from triangle_hit, sphere_hit and hit_segment alone, so every
 * tree gives the same one. */
#ifndef ISOPHOTE_BVH_H
#define ISOPHOTE_BVH_H
#include "motion.h"
#include "sphere.h"
#include "strand.h"
#include "triangle.h"

#define STACK_SIZE 96 /* the builder keeps each of the two levels below 46 */
#define REF_RETURN 0xfffffffeu /* on the stack: back from an instance to the world */

/* What distances to a box, and a hit's against its box, may be off. */
#define SLAB_SLACK (REAL(1.0) + REAL(16.0) * ROUNDING)
#define LIMIT_SLACK (REAL(1.0) + REAL(16.0) * ROUNDING)

/* A direction's reciprocal, finite, so that no slab test sees 0 * infinity, and far enough from the largest
 * float that its product with a coordinate stays finite too. */
FN real finite_reciprocal(real d) {
  real tiny = REAL(1e-20);
  return REAL(1.0) / (fabs(d) < tiny ? (d < REAL(0.0) ? -tiny : tiny) : d);
}

/* A ray in the space of the tree that is being walked. */
typedef struct {
  real3 origin, inverse;
  Shear shear;
  real3 direction;
} LocalRay;

FN LocalRay make_local_ray(real3 origin, real3 direction) {
  LocalRay r;
  r.origin = origin;
  r.direction = direction;
  r.inverse = make_real3(finite_reciprocal(direction.x), finite_reciprocal(direction.y), finite_reciprocal(direction.z));
  r.shear = make_shear(direction);
  return r;
}

FN real3 transform_point(GLOBAL const float *m, real3 p) {
  return make_real3(to_real(m[0]) * p.x + to_real(m[1]) * p.y + to_real(m[2]) * p.z + to_real(m[3]),
                    to_real(m[4]) * p.x + to_real(m[5]) * p.y + to_real(m[6]) * p.z + to_real(m[7]),
                    to_real(m[8]) * p.x + to_real(m[9]) * p.y + to_real(m[10]) * p.z + to_real(m[11]));
}
FN real3 transform_vector(GLOBAL const float *m, real3 v) {
  return make_real3(to_real(m[0]) * v.x + to_real(m[1]) * v.y + to_real(m[2]) * v.z,
                    to_real(m[4]) * v.x + to_real(m[5]) * v.y + to_real(m[6]) * v.z,
                    to_real(m[8]) * v.x + to_real(m[9]) * v.y + to_real(m[10]) * v.z);
}
/* By the transpose: normals, given the inverse matrix. */
FN real3 transform_normal(GLOBAL const float *m, real3 n) {
  return make_real3(to_real(m[0]) * n.x + to_real(m[4]) * n.y + to_real(m[8]) * n.z,
                    to_real(m[1]) * n.x + to_real(m[5]) * n.y + to_real(m[9]) * n.z,
                    to_real(m[2]) * n.x + to_real(m[6]) * n.y + to_real(m[10]) * n.z);
}

/* Where the ray is in a box: it enters and leaves; outside, leave < enter. */
typedef struct {
  real enter, leave;
} Span;

/* The box is given by its center and half its size along each axis, not by its planes: which plane is the
 * nearer one then needs no comparison, and GPUs do additions and multiplications faster than minima. The middle's
 * distance has a relative error of three roundings. Where the box is large against it, half the size, which the
 * host rounds up by 16 roundings (native/bvh_node.h), covers that; else SLAB_SLACK does. */
FN Span span_of_box(real center_x, real half_x, real center_y, real half_y, real center_z, real half_z, LocalRay r,
                    real t_min, real t_max) {
  real x = (center_x - r.origin.x) * r.inverse.x, wide_x = fabs(r.inverse.x);
  real y = (center_y - r.origin.y) * r.inverse.y, wide_y = fabs(r.inverse.y);
  real z = (center_z - r.origin.z) * r.inverse.z, wide_z = fabs(r.inverse.z);
  Span s;
  s.enter = loose_max(loose_max(fma(-half_x, wide_x, x), fma(-half_y, wide_y, y)),
                      loose_max(fma(-half_z, wide_z, z), t_min));
  s.leave = loose_min(loose_min(fma(half_x, wide_x, x), fma(half_y, wide_y, y)),
                      loose_min(fma(half_z, wide_z, z), t_max)) * SLAB_SLACK;
  return s;
}

FN Hit keep_closer(Hit best, TriangleHit h, uint instance, uint primitive, Ray ray) {
  int take = h.hit && is_closer(h.t, instance, primitive, best) && is_wanted(h.t, instance, primitive, ray);
  best.t = take ? h.t : best.t;
  best.u = take ? h.u : best.u;
  best.v = take ? h.v : best.v;
  best.instance = take ? instance : best.instance;
  best.primitive = take ? primitive : best.primitive;
  return best;
}

FN Hit hit_triangles(Scene s, uint index, uint instance, LocalRay space, Ray ray, Hit best) {
  uint last = 0u;
  while (!last) {
    GLOBAL const Triangle *t = &s.triangles[index];
    float4 v0 = load_float4(t, 0), v1 = load_float4(t, 1), v2 = load_float4(t, 2); /* with what stands behind them */
    uint flags = bits_of_float(v2.w);
    last = flags & LAST_IN_LEAF;
    /* Triangles in an instance inherit its visibility, tested when it was entered. */
    if (!(SCENE_FEATURES & FEATURE_VISIBILITY) || instance != NONE || ((flags >> 16) & ray.kind)) {
      TriangleHit h = triangle_hit(load3(v0), load3(v1), load3(v2), space.origin, space.direction, space.shear);
      uint owner = instance != NONE ? instance : bits_of_float(v1.w);
      if (h.hit) best = keep_closer(best, h, owner, bits_of_float(v0.w), ray);
    }
    index++;
  }
  return best;
}

#if SCENE_FEATURES & (FEATURE_DEFORMATION | FEATURE_STRANDS)
/* What the tree of a mesh that deforms, or of strands, has in a leaf. Apart, as below, so that tracers of other scenes
 * stay as small as they are. */
FN_APART Hit hit_single(Scene s, uint primitive, uint instance, LocalRay space, Ray ray, Hit best) {
#if SCENE_FEATURES & FEATURE_STRANDS
  if (is_strand(s, instance))
    return keep_closer(best, hit_segment(s, primitive, instance, space.origin, space.direction, ray_time(ray)), instance,
                       primitive, ray);
#endif
#if SCENE_FEATURES & FEATURE_DEFORMATION
  GLOBAL const uint *corner = &s.indices[3u * primitive];
  Motion m = s.motions[instance];
  TriangleHit h = triangle_hit(shape_at(s, m, m.first_shape, corner[0], ray.time), shape_at(s, m, m.first_shape, corner[1], ray.time),
                               shape_at(s, m, m.first_shape, corner[2], ray.time), space.origin, space.direction, space.shear);
  return keep_closer(best, h, instance, primitive, ray);
#else
  return best;
#endif
}
#endif

FN Hit hit_sphere(Scene s, uint index, LocalRay space, Ray ray, Hit best) {
  GLOBAL const Sphere *sphere = &s.spheres[index];
  if (!(sphere->visibility & ray.kind)) return best;
  SphereHit h = sphere_hit(load3(sphere->center), to_real(sphere->radius), space.origin, space.direction);
  TriangleHit candidate;
  candidate.u = REAL(0.0);
  candidate.v = REAL(0.0);
  candidate.t = h.t_near;
  candidate.hit = h.hit & (h.t_near > REAL(0.0)); /* at 0 a ray leaves or touches it */
  best = keep_closer(best, candidate, SPHERE_INSTANCE, index, ray);
  candidate.t = h.t_far;
  candidate.hit = h.hit & (h.t_far > REAL(0.0));
  return keep_closer(best, candidate, SPHERE_INSTANCE, index, ray);
}

#if SCENE_FEATURES & FEATURE_MOTION
FN_APART LocalRay ray_in_moving(Scene s, uint instance, Ray ray) {
  Placement m = placement_at(s, s.motions[instance], ray.time);
  return make_local_ray(unplaced_point(m, ray.origin), unplaced_vector(m, ray.direction));
}
#endif

/* The ray in the space of an instance. */
FN LocalRay ray_in_instance(Scene s, uint instance, Ray ray) {
#if SCENE_FEATURES & FEATURE_MOTION
  if (in_motion(s, instance, SCENE_FEATURES & s.world[0].features)) return ray_in_moving(s, instance, ray);
#endif
  return make_local_ray(transform_point(s.instances[instance].to_object, ray.origin),
                        transform_vector(s.instances[instance].to_object, ray.direction));
}

/* A ray on its way through the trees. Functions change it in place: to copy structs with vectors in them makes NVIDIA's
 * compiler keep them in memory, which took 2.7 times as long. */
typedef struct {
  Ray ray;
  Hit best;
  LocalRay space; /* the ray in the space of the tree that is being walked */
  uint instance;  /* whose tree that is; NONE: the world's */
  uint ref;       /* what comes next; NONE: the walk is over */
  int top;        /* of the stack */
} Walk;

FN void begin_walk(Walk *w, uint *stack, Scene s, Ray ray) {
  w->ray = ray;
  w->best = no_hit(ray.t_max);
  w->space = make_local_ray(ray.origin, ray.direction);
  w->instance = NONE;
  w->ref = s.world[0].root;
  w->top = 0;
  stack[w->top++] = NONE;
}

/* From a node to the nearer of its children that the ray meets; the other goes on the stack. */
FN void pass_node(Walk *w, uint *stack, Scene s) {
  GLOBAL const Bvh2Node *n = &s.nodes[w->ref];
  float4 x = load_float4(n, 0), y = load_float4(n, 1), z = load_float4(n, 2), children = load_float4(n, 3);
  real t_min = w->ray.t_min * (REAL(1.0) - REAL(16.0) * ROUNDING), t_max = w->best.t * LIMIT_SLACK;
  Span s0 = span_of_box(to_real(x.x), to_real(x.z), to_real(y.x), to_real(y.z), to_real(z.x), to_real(z.z), w->space,
                        t_min, t_max);
  Span s1 = span_of_box(to_real(x.y), to_real(x.w), to_real(y.y), to_real(y.w), to_real(z.y), to_real(z.w), w->space,
                        t_min, t_max);
  uint child0 = bits_of_float(children.x), child1 = bits_of_float(children.y);
  int in0 = s0.enter <= s0.leave, in1 = s1.enter <= s1.leave;
  int second_first = in1 & (!in0 | (s1.enter < s0.enter));
  w->ref = second_first ? child1 : child0;
  if (in0 & in1) stack[w->top++] = second_first ? child0 : child1;
  if (!(in0 | in1)) w->ref = stack[--w->top];
}

/* What a leaf holds: tests triangles and spheres, goes into an instance or back from it. */
FN void pass_leaf(Walk *w, uint *stack, Scene s, int any) {
  uint kind = REF_KIND(w->ref), index = REF_INDEX(w->ref);
  if (kind == REF_TRIANGLES) {
    w->best = hit_triangles(s, index, w->instance, w->space, w->ray, w->best);
#if SCENE_FEATURES & (FEATURE_DEFORMATION | FEATURE_STRANDS)
  } else if (kind == REF_SINGLE && w->instance != NONE) {
    w->best = hit_single(s, index, w->instance, w->space, w->ray, w->best);
#endif
  } else if ((SCENE_FEATURES & FEATURE_SPHERES) && kind == REF_SPHERE) {
    w->best = hit_sphere(s, index, w->space, w->ray, w->best);
  } else if ((SCENE_FEATURES & FEATURE_INSTANCES) && w->ref == REF_RETURN) {
    w->instance = NONE;
    w->space = make_local_ray(w->ray.origin, w->ray.direction);
  } else if ((SCENE_FEATURES & FEATURE_INSTANCES) && (s.instances[index].visibility & w->ray.kind) &&
             (!(SCENE_FEATURES & FEATURE_SUBSURFACE) || is_within(index, w->ray))) {
    stack[w->top++] = REF_RETURN;
    w->instance = index;
    w->space = ray_in_instance(s, index, w->ray);
    w->ref = s.instances[index].root;
    return;
  }
  w->ref = stack[--w->top];
  if (any && w->best.instance != NONE) w->ref = NONE;
}

/* Lanes of a GPU that run together do each instruction for all of them or leave some idle. So all first go down to
 * a leaf each, then all test their triangles (Aila and Laine 2009, "Understanding the Efficiency of Ray Traversal on
 * GPUs", while-while). When only few are still on their way down, those that wait come first. Two nodes are passed
 * for each such look. */
#define FEW_LANES 12u

/* Goes on until the walk is over, or until fewer than `company` lanes that run together are still walking: it may be
 * worth to give the others new rays. With any != 0 the first hit that is found will do: there is one. */
FN void go_on(Walk *w, uint *stack, Scene s, int any, uint company) {
  while (w->ref != NONE) {
    while (REF_KIND(w->ref) == REF_NODE) {
      pass_node(w, stack, s);
      if (REF_KIND(w->ref) != REF_NODE) break;
      pass_node(w, stack, s);
      if (lanes_together() < FEW_LANES) break;
    }
    if (REF_KIND(w->ref) != REF_NODE && w->ref != NONE) pass_leaf(w, stack, s, any);
    if (lanes_together() < company) break;
  }
}

/* The closest hit along the ray, or with any != 0 some hit where there is one. */
FN Hit trace(Scene s, Ray ray, int any) {
  uint stack[STACK_SIZE];
  Walk w;
  begin_walk(&w, stack, s, ray);
  go_on(&w, stack, s, any, 0u);
  return w.best;
}

#endif
