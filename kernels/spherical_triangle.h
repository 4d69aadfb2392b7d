/* A triangle as seen from a point: its solid angle, and directions drawn uniformly in it. */
#ifndef ISOPHOTE_SPHERICAL_TRIANGLE_H
#define ISOPHOTE_SPHERICAL_TRIANGLE_H
#include "elementary.h"

/* a, b, c: unit directions of the corners. tan(solid angle / 2) = height / (side + base) by Van Oosterom and
 * Strackee 1983, "The Solid Angle of a Plane Triangle", eq. 8. */
typedef struct {
  real3 a, b, c;
  real height; /* |a . (b x c)| */
  real side;   /* a . c + b . c */
  real base;   /* 1 + a . b */
  real solid_angle; /* sr; relative error some 1e-6 where it is below 6 sr */
} SphericalTriangle;

/* Corners relative to the viewer, m. volume: |pa . (pb x pc)|, m^3, which the caller knows from the plane: as a
 * determinant of unit vectors it would lose its digits for small triangles. */
FN SphericalTriangle make_spherical_triangle(real3 pa, real3 pb, real3 pc, real volume) {
  SphericalTriangle t;
  real scale_a = REAL(1.0) / sqrt(max_real(dot3(pa, pa), REAL(1e-30)));
  real scale_b = REAL(1.0) / sqrt(max_real(dot3(pb, pb), REAL(1e-30)));
  real scale_c = REAL(1.0) / sqrt(max_real(dot3(pc, pc), REAL(1e-30)));
  t.a = pa * scale_a;
  t.b = pb * scale_b;
  t.c = pc * scale_c;
  t.height = volume * scale_a * scale_b * scale_c;
  /* a . c + b . c and 1 + a . b, without cancellation where the viewer is close to the edge a b. */
  real3 middle = t.a + t.b;
  t.side = dot3(middle, t.c);
  t.base = REAL(0.5) * dot3(middle, middle);
  t.solid_angle = REAL(2.0) * atan2_real(t.height, t.side + t.base);
  return t;
}

/* The unit direction that cuts off `part` of the solid angle (sr) on the side of a, and the fraction v of the
 * height of what lies beyond. Peters 2021, "BRDF Importance Sampling for Polygonal Lights", section 4: the
 * cut runs from b to d on the arc a c. The last step is written with 1 - cos of the arc b d as |b - d|^2 / 2,
 * so that small triangles keep their digits. */
FN real3 sample_spherical_triangle(SphericalTriangle t, real part, real v) {
  real2 half_angle = sin_cos_real(REAL(0.5) * part);
  real3 middle = t.a * (t.height * half_angle.y - t.side * half_angle.x) + t.c * (t.base * half_angle.x);
  real3 d = middle * (REAL(2.0) * dot3(t.a, middle) / max_real(dot3(middle, middle), REAL(1e-30))) - t.a;
  real3 chord = d - t.b;
  real q = REAL(0.5) * dot3(chord, chord);
  real h = v * q; /* 1 - cos of the angle from b */
  real3 across = chord + t.b * q; /* of d, at a right angle to b: its length would lose its digits in 2 - q */
  real sine = sqrt(h * max_real(REAL(2.0) - h, REAL(0.0)) / max_real(dot3(across, across), REAL(1e-30)));
  return normalize3(t.b * (REAL(1.0) - h) + across * sine);
}

#endif
