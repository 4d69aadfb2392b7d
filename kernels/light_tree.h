/* Which light to sample: a stochastic walk down a binary tree of clusters of lights, each step in proportion to
 * bounds of what the two clusters bring to the point. After Conty Estevez and Kulla 2018, "Importance Sampling
 * of Many Lights with Adaptive Tree Splitting", with the importance of pbrt-v4, section 12.6.3. */
#ifndef ISOPHOTE_LIGHT_TREE_H
#define ISOPHOTE_LIGHT_TREE_H
#include "light_linking.h"

/* Where light arrives: a point, and the side of its surface if light comes from one side only. */
typedef struct {
  real3 p;
  real3 normal;
  int has_normal;
  uint set; /* of its object, where lights are linked; else NONE */
} Receiver;

/* A normal in 14 bits, 7 for each octahedral coordinate (Cigolle et al. 2014); paths carry it in their status, so
 * that the density of a light that they run into is that with which the last vertex would have drawn it. */
#define RECEIVER_BITS 7u
#define RECEIVER_STEPS REAL(126.0)
#define RECEIVER_ALL 0x3fffu /* no normal: light from all sides counts */

FN uint pack_normal(real3 n) {
  real scale = REAL(1.0) / (fabs(n.x) + fabs(n.y) + fabs(n.z));
  real x = n.x * scale, y = n.y * scale;
  real folded_x = (REAL(1.0) - fabs(y)) * (x < REAL(0.0) ? REAL(-1.0) : REAL(1.0));
  real folded_y = (REAL(1.0) - fabs(x)) * (y < REAL(0.0) ? REAL(-1.0) : REAL(1.0));
  x = n.z < REAL(0.0) ? folded_x : x;
  y = n.z < REAL(0.0) ? folded_y : y;
  uint column = uint_of((x * REAL(0.5) + REAL(0.5)) * RECEIVER_STEPS + REAL(0.5));
  uint row = uint_of((y * REAL(0.5) + REAL(0.5)) * RECEIVER_STEPS + REAL(0.5));
  return column | (row << RECEIVER_BITS);
}

FN Receiver make_receiver(real3 p, uint packed) {
  Receiver r;
  real x = real_of(packed & 127u) * (REAL(2.0) / RECEIVER_STEPS) - REAL(1.0);
  real y = real_of(packed >> RECEIVER_BITS) * (REAL(2.0) / RECEIVER_STEPS) - REAL(1.0);
  real z = REAL(1.0) - fabs(x) - fabs(y);
  real fold = max_real(-z, REAL(0.0));
  x = x + (x < REAL(0.0) ? fold : -fold);
  y = y + (y < REAL(0.0) ? fold : -fold);
  r.p = p;
  r.normal = normalize3(make_real3(x, y, z));
  r.has_normal = packed != RECEIVER_ALL;
  r.set = NONE;
  return r;
}

FN real sine_of(real cosine) { return safe_sqrt(REAL(1.0) - cosine * cosine); }
/* cos(max(0, a - b)), given cosines and sines. */
FN real cos_of_rest(real cos_a, real sin_a, real cos_b, real sin_b) {
  return cos_a > cos_b ? REAL(1.0) : cos_a * cos_b + sin_a * sin_b;
}

/* Close to the largest irradiance that the cluster may bring to the receiver; never 0 where it brings light. */
FN real cluster_importance(LightCluster c, Receiver at) {
  int distant = (c.flags & CLUSTER_DISTANT) != 0u;
  real3 axis = load3(c.axis);
  real3 to = load3(c.center) - at.p;
  real radius = to_real(c.radius);
  real d2 = max_real(dot3(to, to), REAL(1e-30));
  int inside = !distant & (d2 <= radius * radius);
  real3 toward = select3(distant, zero3() - axis, to * (REAL(1.0) / sqrt(d2)));
  /* Half angle under which the cluster is seen, and that of the cone of its axes. */
  real cos_o = to_real(c.cos_axes), sin_o = sine_of(cos_o);
  real sin2_b = min_real(radius * radius / d2, REAL(1.0));
  real cos_b = distant ? cos_o : sqrt(REAL(1.0) - sin2_b), sin_b = distant ? sin_o : sqrt(sin2_b);

  real cos_w = -dot3(toward, axis);
  cos_w = min_real((c.flags & CLUSTER_TWO_SIDED) ? fabs(cos_w) : cos_w, REAL(1.0));
  real cos_x = cos_of_rest(cos_w, sine_of(cos_w), cos_o, sin_o);
  real leaving = cos_of_rest(cos_x, sine_of(cos_x), cos_b, sin_b);
  int shines = inside | distant | (leaving > to_real(c.cos_edge));
  leaving = (inside | distant) ? REAL(1.0) : max_real(leaving, REAL(0.0));

  real cos_i = min_real(dot3(toward, at.normal), REAL(1.0));
  real arriving = cos_of_rest(cos_i, sine_of(cos_i), cos_b, sin_b);
  arriving = (inside | !at.has_normal) ? REAL(1.0) : max_real(arriving, REAL(0.0));
  real spread = distant ? REAL(1.0) : max_real(d2, radius * radius);
  /* A rest for what the rounding of the normal, up to 1.9 degrees, puts below the horizon. */
  real bound = to_real(c.intensity) * leaving * (arriving + REAL(0.02)) / spread;
  return shines ? bound : REAL(0.0);
}

/* Where a walk has come to: a pair of clusters, or with CLUSTER_LIGHT set a light. */
typedef struct {
  uint at;
  real chance; /* with which it came here */
  real u;      /* what is left of the random number: uniform again */
} LightWalk;

FN LightWalk start_walk(real u) {
  LightWalk w;
  w.at = 0u;
  w.chance = REAL(1.0);
  w.u = u;
  return w;
}

#define LIT_WHOLE REAL(65535.0) /* in lit_shares */

/* Chance of the second of a pair. */
FN real chance_of_second(Scene s, uint pair, Receiver at) {
  real first = cluster_importance(s.light_tree[2u * pair], at);
  real second = cluster_importance(s.light_tree[2u * pair + 1u], at);
  if ((SCENE_FEATURES & FEATURE_LINKING) && at.set != NONE) {
    uint sets = s.world[0].receiver_sets;
    first = first * (real_of(s.lit_shares[2u * pair * sets + at.set]) * (REAL(1.0) / LIT_WHOLE));
    second = second * (real_of(s.lit_shares[(2u * pair + 1u) * sets + at.set]) * (REAL(1.0) / LIT_WHOLE));
  }
  real sum = first + second;
  return sum > REAL(0.0) ? second / sum : REAL(0.5);
}

/* One step down; a walk that has arrived stays. */
FN LightWalk step_walk(Scene s, LightWalk w, Receiver at) {
  int arrived = (w.at & CLUSTER_LIGHT) != 0u;
  uint pair = arrived ? 0u : w.at;
  real second = chance_of_second(s, pair, at);
  real first = REAL(1.0) - second;
  int right = w.u >= first;
  LightWalk r;
  r.at = s.light_tree[2u * pair + (right ? 1u : 0u)].child;
  r.chance = w.chance * (right ? second : first);
  r.u = min_real(right ? (w.u - first) / second : w.u / first, REAL(0.99999994));
  r.at = arrived ? w.at : r.at;
  r.chance = arrived ? w.chance : r.chance;
  r.u = arrived ? w.u : r.u;
  return r;
}

/* With which chance the walk ends at a light. */
FN real light_chance(Scene s, Light l, Receiver at) {
  real chance = REAL(1.0);
  uint pair = 0u;
  for (uint depth = 0u; depth < s.world[0].light_depth && !(pair & CLUSTER_LIGHT); depth++) {
    uint right = (l.trail >> depth) & 1u;
    real second = chance_of_second(s, pair, at);
    chance = chance * (right ? second : REAL(1.0) - second);
    pair = s.light_tree[2u * pair + right].child;
  }
  return chance;
}

#endif
