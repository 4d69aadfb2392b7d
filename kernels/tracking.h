/* Ways of paths and of shadow rays through volumes, which may differ from point to point.
 *
 * Such volumes are filled up to a majorant with what does nothing to light; then collisions are as frequent everywhere
 * (Woodcock et al. 1965). Paths: spectral tracking, Kutz et al. 2017, "Spectral and Decomposition Tracking for Rendering
 * Heterogeneous Volumes", section 4; what is absorbed makes them weaker. Shadow rays: ratio tracking, Novak, Selle and
 * Jarosz 2014, "Residual Ratio Tracking for Estimating Attenuation in Participating Media". Where the majorant is exceeded
 * after all, weights are negative, and means stay true. */
#ifndef ISOPHOTE_TRACKING_H
#define ISOPHOTE_TRACKING_H
#include "volume.h"

#define MOST_COLLISIONS 2048u /* of a way: behind them it counts as empty, as what is left of a world's fog */
#define FAINT_TRACK REAL(0.1)  /* what is left when roulette begins to thin out ways */

FN real next_collision(Segment g, real t, real u) { return t - log_real(REAL(1.0) - u) / g.majorant; }

/* What is left of light after a way from t_min on. */
FN real3 kept_on_way(Scene s, const Volumes *v, Track k, Segment g, real t_min, real length, uint *draws, real *r) {
  if (!(g.majorant > REAL(0.0))) return kept_by_volumes(g.mixture, length);
  real3 kept = splat3(REAL(1.0));
  real t = REAL(0.0);
  for (uint n = 0u; n < MOST_COLLISIONS; n++) {
    real2 u = sample_pair(k.seed, k.index, (*draws)++);
    t = next_collision(g, t, u.x);
    if (!(t < length)) return kept;
    kept = kept * (splat3(REAL(1.0)) - extinction_at(s, v, k, t_min + t, r) * (REAL(1.0) / g.majorant));
    real survival = min_real(max_of3(abs3(kept)) / FAINT_TRACK, REAL(1.0));
    if (u.y >= survival) return zero3();
    kept = kept * (REAL(1.0) / survival);
  }
  return kept;
}

/* The path at the end of a way through what differs from point to point, or where it is scattered. */
FN Travelled travel_uneven(Scene s, Track k, Segment g, Path p, Hit h, Volumes *v, real *r) {
  Travelled made;
  real3 weight = path_throughput(p);
  real first = max_of3(abs3(weight)), t = REAL(0.0);
  int held = is_held_back(g, p);
  made.hit = h;
  made.emitted = zero3();
  for (uint n = 0u; n < MOST_COLLISIONS; n++) {
    real2 u = sample_pair(k.seed, k.index, v->draws++);
    t = next_collision(g, t, u.x);
    if (!(t < g.length)) break;
    Mixture x = mix_volumes(s, v, k, p.t_min + t, r);
    made.emitted = made.emitted + weight * x.emission * (REAL(1.0) / g.majorant);
    real3 nothing = splat3(g.majorant) - x.extinction;
    real scatters = held ? REAL(0.0) : sum_of3(abs3(weight * x.scattering)), passes = sum_of3(abs3(weight * nothing));
    real chance = scatters / max_real(scatters + passes, REAL(1e-37));
    int scattered = u.y < chance;
    real3 factor = select3(scattered, x.scattering * (REAL(1.0) / max_real(chance, REAL(1e-30))),
                           nothing * (REAL(1.0) / max_real(REAL(1.0) - chance, REAL(1e-30))));
    weight = weight * factor * (REAL(1.0) / g.majorant);
    if (scattered) {
      made.hit.t = p.t_min + t;
      made.hit.instance = IN_VOLUME;
      break;
    }
    real survival = min_real(max_of3(abs3(weight)) / max_real(FAINT_TRACK * first, REAL(1e-37)), REAL(1.0));
    int survives = 1;
    if (survival < REAL(1.0)) survives = sample_pair(k.seed, k.index, v->draws++).x < survival;
    weight = select3(survives, weight * (REAL(1.0) / max_real(survival, REAL(1e-30))), zero3());
    if (!survives) break;
  }
  made.path = with_throughput(p, weight);
  return made;
}

FN Travelled travel_segment(Scene s, Track k, Segment g, Path p, Hit h, Volumes *v, real *r) {
  if (g.majorant > REAL(0.0)) return travel_uneven(s, k, g, p, h, v, r);
  return travel_even(g, p, h, sample_pair(k.seed, k.index, v->draws++));
}

/* The path as it comes to a lamp in the way, at the distance at which find_lamp has seen it. */
FN Path path_to_lamp(Scene s, Track k, Segment g, Path p, LightHit seen, Volumes *v, real *r) {
  return with_throughput(p, path_throughput(p) * kept_on_way(s, v, k, g, p.t_min, seen.t - p.t_min, &v->draws, r));
}

/* A shadow ray has no numbers of its own: they come from its place and direction. */
FN Track track_of_shadow(Shadow d) {
  Track k;
  real3 o = d.ray.origin, w = d.ray.direction;
  k.ray = d.ray;
  k.bounces = d.bounces + 1u;
  k.passed = d.passed;
  k.seed = hash_uint(bits_of_float(to_float(o.x)) ^ hash_uint(bits_of_float(to_float(o.y)) ^ hash_uint(bits_of_float(to_float(o.z)))));
  k.index = hash_uint(bits_of_float(to_float(w.x)) ^ hash_uint(bits_of_float(to_float(w.y)) ^ hash_uint(bits_of_float(to_float(w.z)))));
  return k;
}

/* After a shadow ray has hit something or not: what volumes take of its light up to there, and whether it goes on. */
FN Shadow shade_shadow(Scene s, Params params, Shadow d, Volumes *v, Hit h, uint features, real *r) {
  int missed = h.instance == NONE;
  Surface at;
  Material m;
  d.going = 0;
  if (!missed) {
    at = make_surface(s, d.ray, h, features);
    m = s.materials[at.material];
    if (!(m.flags & (MATERIAL_BOUNDARY | MATERIAL_TRANSPARENT)) && !(features & FEATURE_LINKING)) {
      d.kept = zero3();
      return d;
    }
  }
  Track k = track_of_shadow(d);
  Segment g;
  g.majorant = majorant_of(s, v);
  g.mixture.extinction = g.majorant > REAL(0.0) ? zero3() : extinction_at(s, v, k, d.ray.t_min, r);
  real length = max_real((missed ? d.ray.t_max : h.t) - d.ray.t_min, REAL(0.0));
  d.kept = d.kept * kept_on_way(s, v, k, g, d.ray.t_min, length, &v->draws, r);
  if (missed) return d;
  if (m.flags & MATERIAL_BOUNDARY) {
    d.going = 1;
    d = behind_hit(d, h);
  } else {
    d = pass_shadow(s, params, d, h, features, r);
  }
  cross_surface(v, m, h, at.backfacing);
  return d;
}

#endif
