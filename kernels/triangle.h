/* Whether and where a ray hits a triangle: the one function that decides it. */
#ifndef ISOPHOTE_TRIANGLE_H
#define ISOPHOTE_TRIANGLE_H
#include "ray.h"

/* What is constant along a ray: the axes permuted so that z is the largest component of the
 * direction, and the shear that turns it into (0, 0, 1). Woop, Benthin and Wald 2013,
 * "Watertight Ray/Triangle Intersection", JCGT 2(1), section 3. */
typedef struct {
  int axis; /* the axis that became z */
  real shear_x, shear_y, scale;
} Shear;

FN real3 permute(real3 v, int axis) {
  return make_real3(axis == 0 ? v.y : (axis == 1 ? v.z : v.x), axis == 0 ? v.z : (axis == 1 ? v.x : v.y),
                    axis == 0 ? v.x : (axis == 1 ? v.y : v.z));
}

FN int largest_axis(real3 v) {
  real3 a = abs3(v);
  return a.x > a.y ? (a.x > a.z ? 0 : 2) : (a.y > a.z ? 1 : 2);
}

FN Shear make_shear(real3 direction) {
  STRICT_FP
  Shear s;
  s.axis = largest_axis(direction);
  real3 d = permute(direction, s.axis);
  s.shear_x = d.x / d.z;
  s.shear_y = d.y / d.z;
  s.scale = REAL(1.0) / d.z;
  return s;
}

typedef struct {
  int hit;
  real t, u, v; /* of hits only */
} TriangleHit;

/* Which side of the triangle's plane the ray starts on decides whether it is in front: for rays that leave
 * a large triangle, or one beside it in the same plane, t is too inexact to tell 0 from a bit more than 0.
 * The plane passes through v0; make_surface bounds how far hit points lie off it. A function of its own
 * because it is asked for likely hits only. */
FN int is_in_front(real3 v0, real3 v1, real3 v2, real3 origin, real3 direction) {
  STRICT_FP
  real3 a = v1 - v0, b = v2 - v0, to = v0 - origin;
  real nx = a.y * b.z - a.z * b.y, ny = a.z * b.x - a.x * b.z, nz = a.x * b.y - a.y * b.x;
  real distance = nx * to.x + ny * to.y + nz * to.z;
  real toward = nx * direction.x + ny * direction.y + nz * direction.z;
  return ((distance > REAL(0.0)) & (toward > REAL(0.0))) | ((distance < REAL(0.0)) & (toward < REAL(0.0)));
}

/* Edges are tested with the signs of U, V, W; equal products of shared edges make neighbours agree,
 * so no ray slips through between them, and an edge on the ray counts as hit from both sides.
 * t is a difference of numbers as large as the triangle. Just in front of a long one it may come out below 0: its
 * size is then as good, and its sign would lose the hit. */
FN TriangleHit triangle_hit(real3 v0, real3 v1, real3 v2, real3 origin, real3 direction, Shear s) {
  STRICT_FP
  real3 a = permute(v0 - origin, s.axis);
  real3 b = permute(v1 - origin, s.axis);
  real3 c = permute(v2 - origin, s.axis);
  real ax = a.x - s.shear_x * a.z, ay = a.y - s.shear_y * a.z;
  real bx = b.x - s.shear_x * b.z, by = b.y - s.shear_y * b.z;
  real cx = c.x - s.shear_x * c.z, cy = c.y - s.shear_y * c.z;
  real u = cx * by - cy * bx;
  real v = ax * cy - ay * cx;
  real w = bx * ay - by * ax;
  int negative = (u < REAL(0.0)) | (v < REAL(0.0)) | (w < REAL(0.0));
  int positive = (u > REAL(0.0)) | (v > REAL(0.0)) | (w > REAL(0.0));
  real det = u + v + w;
  real t = u * (s.scale * a.z) + v * (s.scale * b.z) + w * (s.scale * c.z);
  real inverse = REAL(1.0) / det;
  TriangleHit h;
  h.hit = !(negative & positive) & (det != REAL(0.0));
  if (h.hit) h.hit = is_in_front(v0, v1, v2, origin, direction);
  h.t = fabs(t * inverse);
  h.u = v * inverse;
  h.v = w * inverse;
  return h;
}

#endif
