/* What moves while the shutter is open: when a path is, and where instances and vertices are then.
 *
 * An instance that moves has poses, evenly over that time, between which it turns along the shortest arc, and its place
 * and its stretch change linearly (Shoemake and Duff 1992, "Matrix Animation and Polar Decomposition"), as in Cycles. A
 * mesh that deforms has shapes, between which its vertices go straight. */
#ifndef ISOPHOTE_MOTION_H
#define ISOPHOTE_MOTION_H
#include "elementary.h"
#include "params.h"
#include "ray.h"
#include "sampler.h"

#if (SCENE_FEATURES & (FEATURE_MOTION | FEATURE_CAMERA_MOTION)) || VECTORS_USED
/* 0 when the shutter opens, 1 when it closes. */
FN real shutter_time(Scene s, uint seed, uint index) {
  return sample_filter(s.filter_table + SHUTTER_TABLE, sample_pair(seed, index, PAIR_TIME).x);
}

/* Between quaternions along the shorter arc (Shoemake 1985, "Animating Rotation with Quaternion Curves"), linear where
 * it is short, as in Cycles. */
FN real4 slerp(real4 a, real4 b, real t) {
  STRICT_FP
  real cosine = a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
  b = b * (cosine < REAL(0.0) ? REAL(-1.0) : REAL(1.0));
  cosine = fabs(cosine);
  int near = cosine > REAL(0.9995);
  real angle = acos_real(cosine);
  real sine = near ? REAL(1.0) : sin_real(angle);
  real4 q = a * (near ? REAL(1.0) - t : sin_real((REAL(1.0) - t) * angle) / sine) +
            b * (near ? t : sin_real(t * angle) / sine);
  return q * (REAL(1.0) / sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w));
}

FN real4 load_turn(GLOBAL const float *q) { return make_real4(to_real(q[0]), to_real(q[1]), to_real(q[2]), to_real(q[3])); }

FN real3 turned_by(real4 q, real3 v) {
  real3 axis = make_real3(q.x, q.y, q.z);
  real3 across = cross3(axis, v) * REAL(2.0);
  return v + across * q.w + cross3(axis, across);
}

/* Between two of several that lie evenly over the shutter's time: the first, and how far it is to the next. */
typedef struct {
  uint first;
  real part;
} Between;

FN Between between_keys(uint count, real time) {
  Between b;
  real at = time * real_of(count - 1u);
  b.first = uint_of(min_int(int_of(at), int_of(count) - 2));
  b.part = at - real_of(b.first);
  return b;
}
#endif

#if (SCENE_FEATURES & FEATURE_MOTION) || VECTORS_USED
/* A symmetric matrix: its diagonal; xy, xz, yz. */
typedef struct {
  real3 diagonal, mixed;
} Stretch;

FN real3 stretched(Stretch m, real3 v) {
  STRICT_FP
  return make_real3(m.diagonal.x * v.x + m.mixed.x * v.y + m.mixed.y * v.z,
                    m.mixed.x * v.x + m.diagonal.y * v.y + m.mixed.z * v.z,
                    m.mixed.y * v.x + m.mixed.z * v.y + m.diagonal.z * v.z);
}

FN Stretch abs_stretch(Stretch m) {
  m.diagonal = abs3(m.diagonal);
  m.mixed = abs3(m.mixed);
  return m;
}

/* Where an instance is: points are stretched, turned by the rows x, y, z, and moved. Parts and not one matrix, because
 * the inverse of each is as exact as itself, however unlike the sizes along the axes are. */
typedef struct {
  real3 x, y, z, place;
  Stretch stretch, back; /* and its inverse; zeros at a moment when nothing is left to hit */
} Placement;

FN real3 turned(Placement m, real3 v) {
  STRICT_FP
  return make_real3(dot3(m.x, v), dot3(m.y, v), dot3(m.z, v));
}
FN real3 turned_back(Placement m, real3 v) {
  STRICT_FP
  return m.x * v.x + m.y * v.y + m.z * v.z;
}

FN real3 placed_vector(Placement m, real3 v) { return turned(m, stretched(m.stretch, v)); }
FN real3 placed_point(Placement m, real3 p) {
  STRICT_FP
  return placed_vector(m, p) + m.place;
}
FN real3 placed_normal(Placement m, real3 n) { return turned(m, stretched(m.back, n)); }
FN real3 unplaced_vector(Placement m, real3 v) { return stretched(m.back, turned_back(m, v)); }
FN real3 unplaced_point(Placement m, real3 p) {
  STRICT_FP
  return unplaced_vector(m, p - m.place);
}
FN real3 unplaced_normal(Placement m, real3 n) { return stretched(m.stretch, turned_back(m, n)); }

/* By its minors; zeros where there is none. */
FN Stretch inverse_stretch(Stretch m) {
  STRICT_FP
  Stretch r;
  real3 d = m.diagonal, o = m.mixed;
  r.diagonal = make_real3(d.y * d.z - o.z * o.z, d.x * d.z - o.y * o.y, d.x * d.y - o.x * o.x);
  r.mixed = make_real3(o.y * o.z - o.x * d.z, o.x * o.z - o.y * d.y, o.x * o.y - o.z * d.x);
  real determinant = d.x * r.diagonal.x + o.x * r.mixed.x + o.y * r.mixed.y;
  int flat = determinant == REAL(0.0);
  real scale = flat ? REAL(0.0) : REAL(1.0) / (flat ? REAL(1.0) : determinant);
  r.diagonal = r.diagonal * scale;
  r.mixed = r.mixed * scale;
  return r;
}

/* Of an instance that moves. */
FN Placement placement_at(Scene s, Motion motion, real time) {
  STRICT_FP
  Placement m;
  Between k = between_keys(motion.poses, time);
  GLOBAL const Pose *a = &s.poses[motion.first_pose + k.first], *b = a + 1;
  real t = k.part, rest = REAL(1.0) - t;
  real4 q = slerp(load_turn(a->turn), load_turn(b->turn), t);
  real x = q.x * REAL(2.0), y = q.y * REAL(2.0), z = q.z * REAL(2.0);
  m.x = make_real3(REAL(1.0) - (y * q.y + z * q.z), x * q.y - z * q.w, x * q.z + y * q.w);
  m.y = make_real3(x * q.y + z * q.w, REAL(1.0) - (x * q.x + z * q.z), y * q.z - x * q.w);
  m.z = make_real3(x * q.z - y * q.w, y * q.z + x * q.w, REAL(1.0) - (x * q.x + y * q.y));
  m.place = load3(a->place) * rest + load3(b->place) * t;
  m.stretch.diagonal = load3(a->diagonal) * rest + load3(b->diagonal) * t;
  m.stretch.mixed = load3(a->mixed) * rest + load3(b->mixed) * t;
  m.back = inverse_stretch(m.stretch);
  return m;
}

FN int in_motion(Scene s, uint instance, uint features) {
  return (features & FEATURE_MOTION) && instance < SPHERE_INSTANCE && s.motions[instance].poses > 0u;
}
FN int in_deformation(Scene s, uint instance, uint features) {
  return (features & FEATURE_DEFORMATION) && instance < SPHERE_INSTANCE && s.motions[instance].shapes > 0u;
}

FN int is_moving(Scene s, uint instance, uint features) {
  return in_motion(s, instance, features) || in_deformation(s, instance, features);
}

/* What has the number `first + vertex` in the first shape of a mesh that deforms. */
FN real3 shape_at(Scene s, Motion motion, uint first, uint vertex, real time) {
  STRICT_FP
  Between k = between_keys(motion.shapes, time);
  uint at = first + k.first * motion.vertices + vertex;
  return load3(s.shapes[at]) * (REAL(1.0) - k.part) + load3(s.shapes[at + motion.vertices]) * k.part;
}
#endif

FN real3 vertex_at(Scene s, uint instance, uint vertex, real time, uint features) {
#if SCENE_FEATURES & FEATURE_DEFORMATION
  if (in_deformation(s, instance, features)) return shape_at(s, s.motions[instance], s.motions[instance].first_shape, vertex, time);
#endif
  return load3(s.vertices[vertex]);
}
/* Of a vertex of a smooth mesh, whose numbers and `first` add up to those of its normals. */
FN real3 normal_at(Scene s, uint instance, uint first, uint vertex, real time, uint features) {
#if SCENE_FEATURES & FEATURE_DEFORMATION
  if (in_deformation(s, instance, features)) return shape_at(s, s.motions[instance], s.motions[instance].first_normal, vertex, time);
#endif
  return load3(s.normals[first + vertex]);
}

#endif
