/* Strands: hair, fur, grass. A strand is a row of segments, and a segment the hull of two balls, which neighbours share,
 * so that strands are round where they bend; their ends are open. A segment stands among the triangles: its first two
 * corners are the balls' centres, the third is the first again, and radii go by vertices.
 *
 * Only fronts are hit, and of these no part that lies within the strand: what light does in there is its closure's
 * matter. All is computed around the place where the ray is nearest to the segment, because strands are thin and cameras
 * far. Cones between balls: Han, Wald, Usher et al. 2019, "Ray Tracing Generalized Tube Primitives". */
#ifndef ISOPHOTE_STRAND_H
#define ISOPHOTE_STRAND_H
#include "motion.h"
#include "triangle.h"

/* Of a radius: what lies less deep in a neighbour counts as its surface. Else rays would slip through between them. */
#define SKIN REAL(1e-4)
#define MOST_NEIGHBOURS 4u /* to either side, that are asked whether a hit lies in them */

/* What is constant along a segment: unit axis, length, sine of half the angle between the sides, its cosine squared. */
typedef struct {
  real3 axis;
  real length, sine, squared; /* squared <= 0: one ball holds the other */
} Cone;

FN Cone make_cone(real3 edge, real r0, real r1) {
  STRICT_FP
  Cone c;
  c.length = sqrt(dot3(edge, edge));
  real inverse = c.length > REAL(0.0) ? REAL(1.0) / c.length : REAL(0.0);
  c.axis = edge * inverse;
  c.sine = (r0 - r1) * inverse;
  c.squared = c.length > REAL(0.0) ? REAL(1.0) - c.sine * c.sine : REAL(0.0);
  return c;
}

/* How far along the axis the ball has its centre that touches the hull nearest to a point at y. */
FN real center_at(Cone c, real r0, real y) { return (y - r0 * c.sine) / c.squared; }

/* Segments of which one ball holds the other have no cone: they are not there, and cover nothing.
 *
 * Whether a neighbour, from the common ball to its other one, covers a point relative to the common ball's centre. Of
 * that ball it is what lies beyond the circle where the neighbour's cone begins; of a cone, what is deep in the other. */
FN int is_covered(real3 p, int on_ball, real3 edge, real r0, real r1) {
  STRICT_FP
  Cone c = make_cone(edge, r0, r1);
  real z = center_at(c, r0, dot3(p, c.axis)), radius = (r0 - z * c.sine) * (REAL(1.0) - SKIN);
  real3 off = p - c.axis * z;
  int inside = on_ball | ((z < c.length) & (dot3(off, off) < radius * radius));
  return (c.squared > REAL(0.0)) & (z > SKIN * r0) & inside;
}

typedef struct {
  int on_ball; /* the second, else on the cone */
  real u;   /* which ball between the two touches the hull at the hit: 0 the first, 1 the second */
  real t;   /* FAR_AWAY: no hit */
  real3 at; /* the hit, relative to the first ball's centre */
} SegmentHit;

/* The front of the cone, and of the second ball where the strand goes on there. Cone: with axis a, w and v the parts of
 * the ray's place and direction that are perpendicular to it, and w perpendicular to v because the place is where the
 * ray is nearest to the axis, |w + s v|^2 = (c0 - s c1)^2. The root with the minus is where the ray enters, whatever the
 * sign of |v|^2 - c1^2. */
FN SegmentHit segment_hit(real3 p0, real3 edge, real r0, real r1, int goes_on, real3 origin, real3 direction) {
  STRICT_FP
  real square = dot3(direction, direction), scale = REAL(1.0) / sqrt(square);
  real t = dot3(p0 + edge * REAL(0.5) - origin, direction) / square; /* the ray is near the segment's middle */
  real3 d = direction * scale, from = (origin - p0) + direction * t;
  Cone c = make_cone(edge, r0, r1);
  real along = dot3(from, c.axis), slope = dot3(d, c.axis);
  real3 w = from - c.axis * along, v = d - c.axis * slope;
  real vv = dot3(v, v), shift = vv > REAL(0.0) ? -dot3(w, v) / vv : REAL(0.0);
  w = w + v * shift;
  along = along + slope * shift;
  real cosine = sqrt(max_real(c.squared, REAL(0.0)));
  real ww = dot3(w, w), c0 = (r0 - along * c.sine) / cosine, c1 = slope * c.sine / cosine;
  real root = vv * (c0 * c0 - ww) + c1 * c1 * ww;
  real s = (-c0 * c1 - sqrt(max_real(root, REAL(0.0)))) / (vv - c1 * c1);
  real z = center_at(c, r0, along + slope * s);
  int on_cone = (root >= REAL(0.0)) & (c.squared > REAL(0.0)) & (z >= REAL(0.0)) & (z <= c.length);
  s = shift + s;
  /* The ball, by where the ray is nearest to its centre. */
  real3 to = from - edge;
  real b = -dot3(to, d);
  real3 nearest = to + d * b;
  real rest = r1 * r1 - dot3(nearest, nearest);
  real enter = b - sqrt(max_real(rest, REAL(0.0)));
  int beyond = center_at(c, r0, dot3(from + d * enter, c.axis)) >= c.length - SKIN * r1;
  int on_ball = (!on_cone) & goes_on & (c.squared > REAL(0.0)) & (rest >= REAL(0.0)) & beyond;
  s = on_ball ? enter : s;
  SegmentHit h;
  h.on_ball = on_ball;
  h.u = on_ball ? REAL(1.0) : z / c.length;
  h.at = from + d * s;
  h.t = (on_cone | on_ball) ? t + s * scale : FAR_AWAY;
  return h;
}

FN int is_strand(Scene s, uint instance) {
  if (!(SCENE_FEATURES & FEATURE_STRANDS) || instance >= SPHERE_INSTANCE) return 0;
  return (s.instances[instance].visibility & INSTANCE_STRANDS) != 0u;
}
FN real radius_at(Scene s, uint instance, uint vertex) {
  return fabs(to_real(s.radii[s.instances[instance].first_normal + vertex]));
}
/* Ends of strands have negative radii, or negative zeros. */
FN int is_end(Scene s, uint instance, uint vertex) {
  return (int)(bits_of_float(s.radii[s.instances[instance].first_normal + vertex]) >> 31);
}

/* Whether some of the segments that follow a vertex, or with step -1 come before it, covers a hit next to it: `at` is
 * relative to the vertex. */
FN int is_in_neighbours(Scene s, uint instance, uint vertex, uint step, real3 at, int on_ball, real time, uint features) {
  int covered = 0;
  real3 p = vertex_at(s, instance, vertex, time, features);
  for (uint n = 0u; n < MOST_NEIGHBOURS && !covered && !is_end(s, instance, vertex); n++) {
    real3 next = vertex_at(s, instance, vertex + step, time, features);
    real r0 = radius_at(s, instance, vertex), r1 = radius_at(s, instance, vertex + step);
    covered = is_covered(at, on_ball & (n == 0u), next - p, r0, r1);
    at = at - (next - p);
    p = next;
    vertex += step;
  }
  return covered;
}

FN TriangleHit hit_segment(Scene s, uint primitive, uint instance, real3 origin, real3 direction, real time) {
  GLOBAL const uint *corner = &s.indices[3u * primitive];
  uint features = SCENE_FEATURES & s.world[0].features, i0 = corner[0], i1 = corner[1];
  real3 p0 = vertex_at(s, instance, i0, time, features), edge = vertex_at(s, instance, i1, time, features) - p0;
  real r0 = radius_at(s, instance, i0), r1 = radius_at(s, instance, i1);
  SegmentHit found = segment_hit(p0, edge, r0, r1, !is_end(s, instance, i1), origin, direction);
  TriangleHit h;
  h.t = found.t;
  h.u = found.u;
  h.v = REAL(0.0);
  h.hit = (found.t < FAR_AWAY) & (found.t > REAL(0.0));
  if (h.hit) h.hit = !is_in_neighbours(s, instance, i1, 1u, found.at - edge, found.on_ball, time, features);
  if (h.hit) h.hit = !is_in_neighbours(s, instance, i0, 0xffffffffu, found.at, 0, time, features);
  return h;
}

#endif
