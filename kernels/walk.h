/* The way of light below a surface: free flights between scatterings, until one of them ends at the surface again.
 *
 * Directions and lengths are drawn for one of the three channels and one of three strategies, and weighed against all of
 * them (balance heuristic): by the phase function, or guided outward or to the surface opposite (Dwivedi's slab after
 * Krivanek and d'Eon 2014, "A Zero-Variance-Based Sampling Scheme for Monte Carlo Subsurface Scattering"; Meng, Hanika and
 * Dachsbacher 2016, "Improving the Dwivedi Sampling Scheme"). Which strategy how often follows Cycles 4.5. */
#ifndef ISOPHOTE_WALK_H
#define ISOPHOTE_WALK_H
#include "bsdf/bsdf.h"
#include "path.h"
#include "sampler.h"
#include "surface.h"

/* Flights of a way. What is left then is mostly white, and would be missed: the last flight goes straight out, as much of
 * it as diffusion would bring to the surface from that depth. */
#define MOST_FLIGHTS 256u
#define EXACT_FLIGHTS 10u /* later ones may as well be isotropic: Wyman, Patterson and Wilson 1989, similarity relations */
#define FAINT REAL(0.1) /* weight below which roulette thins out walks */

/* Pairs of random numbers for each flight; their seeds differ from those of the path around them. */
#define PAIR_FLIGHT 0u
#define PAIR_TURN 1u
#define PAIR_STRATEGY 2u /* and roulette */
#define PAIRS_PER_FLIGHT 3u
#define SEED_INSIDE 0x3c6ef372u
#define SEED_OUTSIDE 0xa54ff53au

/* Columns of a path's medium, behind those of the path where the scene has FEATURE_SUBSURFACE. */
#define MEDIUM_REALS(X)                                                       \
  X(extinction.x) X(extinction.y) X(extinction.z)                             \
  X(scattering.x) X(scattering.y) X(scattering.z)                             \
  X(normal.x) X(normal.y) X(normal.z) X(anisotropy) X(guiding)
#define MEDIUM_COLUMNS 11

FN void store_medium(GLOBAL real *reals, uint stride, uint i, Medium m) {
  uint at = i;
#define X(field)         \
  reals[at] = m.field;   \
  at += stride;
  MEDIUM_REALS(X)
#undef X
}

FN Medium load_medium(GLOBAL const real *reals, uint stride, uint i) {
  Medium m;
  uint at = i;
#define X(field)         \
  m.field = reals[at];   \
  at += stride;
  MEDIUM_REALS(X)
#undef X
  return m;
}

/* Where light is, and where it goes next. */
typedef struct {
  real3 origin, direction, weight;
  real depth;    /* below the plane in which it has entered */
  real opposite; /* depth of the surface on the other side; 0: none is near */
} Walker;

/* How far it flies, unless the surface comes first. */
typedef struct {
  real3 direction;
  real length;
  real phase; /* density of the direction by the phase function */
  real roulette; /* number that decides survival */
} Flight;

FN Walker start_walker(Path p) {
  Walker w;
  w.origin = make_real3(p.ox, p.oy, p.oz);
  w.direction = make_real3(p.dx, p.dy, p.dz);
  w.weight = path_throughput(p);
  w.depth = REAL(0.0);
  w.opposite = REAL(0.0);
  return w;
}

/* The medium for a flight: similar, but isotropic, for late ones. */
FN Medium medium_of_flight(Medium m, uint number) {
  int similar = number >= EXACT_FLIGHTS;
  real kept = similar ? m.anisotropy : REAL(0.0);
  real3 left = make_real3(REAL(1.0) - m.scattering.x * kept, REAL(1.0) - m.scattering.y * kept, REAL(1.0) - m.scattering.z * kept);
  real3 scattered = m.scattering * (REAL(1.0) - kept);
  m.extinction = m.extinction * left;
  m.scattering = make_real3(scattered.x / left.x, scattered.y / left.y, scattered.z / left.z);
  m.anisotropy = similar ? REAL(0.0) : m.anisotropy;
  return m;
}

/* How often a flight is guided. The first one has its direction from the surface. */
FN real guided_share(Medium original, uint number) {
  real share = REAL(1.0) - max_real(REAL(0.5), pow_real(original.anisotropy, REAL(0.125)));
  share = number >= EXACT_FLIGHTS ? REAL(0.75) : share;
  return number == 0u ? REAL(0.0) : share;
}

/* Of guided flights, the share that goes to the opposite side. */
FN real backward_share(Medium m, Walker w) {
  real x = min_real(max_real(w.depth, REAL(0.0)), w.opposite);
  real way = (w.opposite - REAL(2.0) * x) * min_of3(m.extinction);
  return w.opposite > REAL(0.0) ? REAL(1.0) / (REAL(1.0) + exp_real(min_real(way * m.guiding, REAL(80.0)))) : REAL(0.0);
}

/* ln((1 + k) / (1 - k)), k the guiding: by a series where it is small. */
FN real guiding_norm(real k) {
  real z = k * k;
  real series = REAL(2.0) * k * (REAL(1.0) + z * (REAL(0.33333333333333333) + z * (REAL(0.2) + z * (REAL(0.14285714285714286) + z * REAL(0.11111111111111111)))));
  return k < REAL(0.25) ? series : log_real((REAL(1.0) + k) / (REAL(1.0) - k));
}

FN real phase_density(real cosine, real g) {
  real width = REAL(1.0) + g * (g - REAL(2.0) * cosine);
  return REAL(0.25) * INV_PI * (REAL(1.0) - g * g) / (width * sqrt(width));
}

/* Chances of the channels: of the light that they may yet bring. */
FN real3 channel_chances(Medium m, Walker w) {
  real3 share = abs3(w.weight * m.scattering);
  real sum = share.x + share.y + share.z;
  int some = sum > REAL(1e-30);
  return select3(some, share * (REAL(1.0) / (some ? sum : REAL(1.0))), splat3(REAL(0.33333333333333333)));
}

FN Flight draw_flight(Medium original, Walker w, uint number, uint seed, uint index) {
  Flight f;
  Medium m = medium_of_flight(original, number);
  uint pair = number * PAIRS_PER_FLIGHT;
  seed = hash_uint(seed ^ SEED_INSIDE);
  real2 u = sample_pair(seed, index, pair + PAIR_FLIGHT);
  real2 turn = sample_pair(seed, index, pair + PAIR_TURN);
  real2 chance = sample_pair(seed, index, pair + PAIR_STRATEGY);
  real strategy = chance.x;
  f.roulette = chance.y;
  real share = guided_share(original, number);
  int guided = strategy < share, backward = strategy < share * backward_share(m, w);

  real g = m.anisotropy, k = m.guiding;
  real even = REAL(1.0) - REAL(2.0) * turn.x;
  int isotropic = g < REAL(1e-3);
  real bent = (REAL(1.0) - g * g) / (REAL(1.0) - g * even);
  real cosine = isotropic ? even : (REAL(1.0) + g * g - bent * bent) / (REAL(2.0) * (isotropic ? REAL(1.0) : g));
  real outward = (REAL(1.0) - (REAL(1.0) + k) * exp_real(-turn.x * guiding_norm(k))) / k;
  cosine = guided ? (backward ? -outward : outward) : cosine;
  cosine = min_real(max_real(cosine, REAL(-1.0)), REAL(1.0));
  real sine = sqrt((REAL(1.0) - cosine) * (REAL(1.0) + cosine));
  real2 phi = sin_cos_real(TWO_PI * turn.y);
  Frame frame = make_frame(select3(guided, m.normal, w.direction));
  real3 turned = normalize3(to_world(frame, make_real3(sine * phi.y, sine * phi.x, cosine)));
  f.direction = select3(number == 0u, w.direction, turned);
  f.phase = phase_density(dot3(w.direction, f.direction), isotropic ? REAL(0.0) : g);

  real3 chances = channel_chances(m, w);
  real extinction = u.x < chances.x ? m.extinction.x : (u.x < chances.x + chances.y ? m.extinction.y : m.extinction.z);
  real stretch = REAL(1.0) - k * (backward ? -dot3(f.direction, m.normal) : dot3(f.direction, m.normal));
  extinction = extinction * (guided ? stretch : REAL(1.0));
  f.length = -log_real(REAL(1.0) - u.y) / extinction;
  f.length = number + 1u == MOST_FLIGHTS ? FAR_AWAY : f.length;
  return f;
}

/* The ray of a flight inside the object that has been hit by the path. The first looks ten mean free paths ahead for the
 * opposite side. */
FN Ray ray_of_flight(Path p, Medium m, Walker w, Flight f, uint number) {
  real least = min_of3(m.extinction);
  Ray ray = free_ray(w.origin, f.direction, REAL(0.0), number == 0u ? max_real(f.length, REAL(10.0) / least) : f.length);
  ray = ray_at(ray, path_time(p));
  ray.within_instance = p.after_instance;
  ray.within_primitive = p.after_primitive;
  return ray;
}

FN real3 exp3(real3 x) { return make_real3(exp_real(x.x), exp_real(x.y), exp_real(x.z)); }

#define WALK_ON 0
#define WALK_OUT 1  /* the surface is reached */
#define WALK_LOST 2 /* absorbed */

typedef struct {
  Walker walker;
  int state;
} Flown;

/* After the flight's ray has found the surface or not. */
FN Flown fly(Medium original, Walker w, Flight f, Hit h, uint number) {
  Flown r;
  Medium m = medium_of_flight(original, number);
  int last = number + 1u == MOST_FLIGHTS, found = h.instance != NONE;
  int hit = found & (h.t < f.length);
  real t = hit ? h.t : f.length;
  t = (last & !hit) ? REAL(0.0) : t;

  real k = m.guiding, cosine = dot3(f.direction, m.normal), scale = REAL(0.5) * INV_PI * k / (guiding_norm(k) * f.phase);
  real ahead = REAL(1.0) - k * cosine, back = REAL(1.0) + k * cosine; /* stretch of each strategy */
  real share = guided_share(original, number), backward = backward_share(m, w);
  real3 depth = m.extinction * t;
  real3 passed = exp3(depth * REAL(-1.0));
  real3 plain = passed, forth = exp3(depth * -ahead), turned = exp3(depth * -back);
  if (!hit) {
    plain = plain * m.extinction;
    forth = forth * m.extinction * ahead;
    turned = turned * m.extinction * back;
  }
  real3 density = plain * (REAL(1.0) - share) + forth * (share * (REAL(1.0) - backward) * scale / ahead) +
                  turned * (share * backward * scale / back);
  real drawn = dot3(channel_chances(m, w), density);
  real3 brought = hit ? passed : passed * m.extinction * m.scattering;
  real3 factor = brought * (REAL(1.0) / max_real(drawn, REAL(1e-37)));
  real3 below = m.extinction * min_real(max_real(w.depth, REAL(0.0)), t), lost = splat3(REAL(1.0)) - m.scattering;
  real3 straight = exp3(make_real3(-below.x * sqrt(REAL(3.0) * lost.x), -below.y * sqrt(REAL(3.0) * lost.y),
                                   -below.z * sqrt(REAL(3.0) * lost.z)));
  r.walker = w;
  r.walker.weight = w.weight * select3(last, straight, factor);
  r.walker.direction = f.direction;
  r.walker.origin = hit ? w.origin : w.origin + f.direction * t;
  r.walker.depth = w.depth - cosine * t;
  if (number == 0u) r.walker.opposite = found ? max_real(-cosine * h.t, REAL(0.0)) : REAL(0.0);

  real brightest = max_of3(r.walker.weight);
  real survival = hit ? REAL(1.0) : min_real(brightest / FAINT, REAL(1.0));
  int survives = f.roulette < survival;
  r.walker.weight = r.walker.weight * (REAL(1.0) / max_real(survival, REAL(1e-30)));
  r.state = hit ? WALK_OUT : ((survives & !last) ? WALK_ON : WALK_LOST);
  return r;
}

/* The path at the surface where its walk has ended, as if it came from outside; black where it never arrives. What is
 * left of it has other random numbers than the part before. */
FN Path path_at_exit(Path p, Walker w, Hit h, int state) {
  real3 origin = w.origin + w.direction * (REAL(2.0) * h.t);
  Path q = with_throughput(p, select3(state == WALK_OUT, w.weight, zero3()));
  if (state == WALK_OUT) {
    q.ox = origin.x;
    q.oy = origin.y;
    q.oz = origin.z;
  }
  q.dx = -w.direction.x;
  q.dy = -w.direction.y;
  q.dz = -w.direction.z;
  q.seed = hash_uint(p.seed ^ SEED_OUTSIDE);
  return q;
}

#endif
