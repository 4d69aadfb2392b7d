/* Volumes: which of them a path is in, what they do to light along a way, and where they scatter it.
 *
 * A volume is a material of its own (Material.volume of the surface around it, World.volume): its transparency holds the
 * extinction, its emission what it sends out per metre, its instructions are OP_SCATTERING. Where volumes overlap their
 * coefficients add up. Of a material that is nothing but a volume the surface does not count (MATERIAL_BOUNDARY). Volumes
 * that differ from point to point have a majorant: tracking.h. */
#ifndef ISOPHOTE_VOLUME_H
#define ISOPHOTE_VOLUME_H
#include "phase.h"
#include "shadow_catcher.h"

#define MOST_LOBES 16u /* phase functions that count at a point */
#define SCATTERING_ANISOTROPY 0 /* parameters of OP_SCATTERING */
#define SCATTERING_ALPHA 1
#define SEED_VOLUME 0x510e527fu
#define RAY_OF_VOLUME RAY_DIFFUSE /* the kind of a ray that volumes have scattered */

/* What a path is in, in the order in which it has come in; functions change it in place. */
typedef struct {
  uint around[MOST_VOLUMES]; /* what encloses it: volume_key */
  uint material[MOST_VOLUMES];
  uint count;
  uint draws; /* pairs of random numbers that ways have used */
} Volumes;

/* Columns of a path's volumes, at its slot. */
#define VOLUME_COLUMNS (2u * MOST_VOLUMES + 2u)

FN void store_volumes(GLOBAL uint *columns, uint stride, uint i, const Volumes *v) {
  for (uint k = 0u; k < v->count; k++) {
    columns[2u * k * stride + i] = v->around[k];
    columns[(2u * k + 1u) * stride + i] = v->material[k];
  }
  columns[2u * MOST_VOLUMES * stride + i] = v->count;
  columns[(2u * MOST_VOLUMES + 1u) * stride + i] = v->draws;
}

FN void load_volumes(GLOBAL const uint *columns, uint stride, uint i, Volumes *v) {
  v->count = columns[2u * MOST_VOLUMES * stride + i];
  v->draws = columns[(2u * MOST_VOLUMES + 1u) * stride + i];
  for (uint k = 0u; k < v->count; k++) {
    v->around[k] = columns[2u * k * stride + i];
    v->material[k] = columns[(2u * k + 1u) * stride + i];
  }
}

/* What tells the instance or the sphere that is hit from all others; NONE stands for the world. */
#define AROUND_SPHERE 0x80000000u
FN uint volume_key(Hit h) { return h.instance == SPHERE_INSTANCE ? AROUND_SPHERE | h.primitive : h.instance; }

FN uint find_volume(const Volumes *v, uint around, uint material) {
  uint k = 0u;
  while (k < v->count && !(v->around[k] == around && v->material[k] == material)) k++;
  return k;
}
/* No volume is entered twice, as in Cycles: surfaces of one mesh that lie in each other count once. */
FN void enter_volume(Volumes *v, uint around, uint material) {
  if (v->count == MOST_VOLUMES || find_volume(v, around, material) < v->count) return;
  v->around[v->count] = around;
  v->material[v->count++] = material;
}
FN void leave_volume(Volumes *v, uint around, uint material) {
  uint found = find_volume(v, around, material);
  if (found == v->count) return;
  v->count--;
  for (uint k = found; k < v->count; k++) {
    v->around[k] = v->around[k + 1u];
    v->material[k] = v->material[k + 1u];
  }
}

/* Among catchers of shadows alone there are their volumes and no others, nor the world's, as in Cycles. */
FN void keep_those_of_catchers(Scene s, Volumes *v) {
  for (uint k = v->count; k-- > 0u;) {
    uint around = v->around[k];
    int sphere = (around & AROUND_SPHERE) != 0u;
    if (around == NONE || !is_catcher(s, sphere ? SPHERE_INSTANCE : around, around & ~AROUND_SPHERE))
      leave_volume(v, around, v->material[k]);
  }
}

/* Light goes through a surface of material m: into its volume, or out of it where it came from behind. */
FN void cross_surface(Volumes *v, Material m, Hit h, int backfacing) {
  if (m.volume == NONE) return;
  if (backfacing) leave_volume(v, volume_key(h), m.volume);
  else enter_volume(v, volume_key(h), m.volume);
}

/* The same for light that leaves the surface in a direction: it stays on its side, or it does not. */
FN void cross_towards(Volumes *v, Material m, Hit h, Surface at, real3 direction) {
  if (dot3(at.ng, direction) < REAL(0.0)) cross_surface(v, m, h, at.backfacing);
}

/* ---------------------------------------------------------------- beginning */

/* Looks up from where a path begins, for the volumes that it begins in: those whose surface is first met from behind. */
typedef struct {
  Ray ray;
  Volumes ahead; /* met from the front: what is met from behind afterwards does not enclose the path */
} Probe;

FN void start_volumes(Scene s, Volumes *v) {
  v->count = 0u;
  v->draws = 0u;
  if (s.world[0].volume != NONE) enter_volume(v, NONE, s.world[0].volume);
}

FN Probe start_probe(Path p) {
  Probe probe;
  probe.ray = path_ray(p);
  probe.ray.direction = make_real3(REAL(0.0), REAL(0.0), REAL(1.0));
  probe.ray.t_max = FAR_AWAY;
  probe.ray.kind = RAY_ALL;
  probe.ahead.count = 0u;
  return probe;
}

/* Whether there may be more behind what the probe has hit. */
FN int pass_probe(Scene s, Probe *probe, Volumes *v, Hit h, uint features) {
  if (h.instance == NONE) return 0;
  Surface at = make_surface(s, probe->ray, h, features);
  uint volume = s.materials[at.material].volume, around = volume_key(h);
  if (volume != NONE && !at.backfacing) enter_volume(&probe->ahead, around, volume);
  if (volume != NONE && at.backfacing && find_volume(&probe->ahead, around, volume) == probe->ahead.count)
    enter_volume(v, around, volume);
  probe->ray.t_min = h.t;
  probe->ray.after_instance = h.instance;
  probe->ray.after_primitive = h.primitive;
  return 1;
}

/* ------------------------------------------------------------------- values */

/* What values and random numbers along a ray depend on. */
typedef struct {
  Ray ray;
  uint bounces, passed;
  uint seed, index;
} Track;

FN Track track_of_path(Path p) {
  Track k;
  k.ray = path_ray(p);
  k.bounces = p.bounces;
  k.passed = uint_of(path_passed(p));
  k.seed = hash_uint(p.seed ^ SEED_VOLUME);
  k.index = p.index;
  return k;
}

/* Computes the values of a volume's material at distance t: its first `steps`. */
FN void compute_volume(Scene s, Material m, uint steps, uint around, Track k, real t, real *r) {
  if (!(SCENE_FEATURES & FEATURE_VALUES) || !steps) return;
  Surface at;
  at.p = k.ray.origin + k.ray.direction * t;
  at.offset = REAL(0.0);
  at.ng = zero3() - k.ray.direction;
  at.ns = at.ng;
  at.backfacing = 0;
  at.material = NONE;
  Hit h = background_hit(t);
  h.instance = around & AROUND_SPHERE ? h.instance : around;
  h.primitive = 0u; /* nothing that is asked for lies on a triangle (isophote/volumes.py) */
  compute_values(s, m, steps, at, k.ray, h, k.bounces, k.passed, r);
}

/* What volumes have at a point, all together, 1/m; emission in W/(m^3 sr). */
typedef struct {
  real3 extinction, scattering, emission;
} Mixture;

FN Mixture mix_volumes(Scene s, const Volumes *v, Track k, real t, real *r) {
  Mixture x;
  x.extinction = zero3();
  x.scattering = zero3();
  x.emission = zero3();
  for (uint n = 0u; n < v->count; n++) {
    Material m = s.materials[v->material[n]];
    compute_volume(s, m, m.steps, v->around[n], k, t, r);
    x.extinction = x.extinction + material_transparency(m, r);
    x.emission = x.emission + material_emission(m, r);
    for (uint c = 0u; c < m.count; c++) x.scattering = x.scattering + closure_of(s.instructions[m.first + c], r).weight;
  }
  return x;
}

/* The extinction alone. */
FN real3 extinction_at(Scene s, const Volumes *v, Track k, real t, real *r) {
  real3 sum = zero3();
  for (uint n = 0u; n < v->count; n++) {
    Material m = s.materials[v->material[n]];
    compute_volume(s, m, m.shadow_steps, v->around[n], k, t, r);
    sum = sum + material_transparency(m, r);
  }
  return sum;
}

/* Where one of them differs from point to point: an extinction that all together hardly exceed; else 0. */
FN real majorant_of(Scene s, const Volumes *v) {
  if (!(SCENE_FEATURES & FEATURE_VALUES)) return REAL(0.0);
  int uneven = 0;
  real sum = REAL(0.0);
  for (uint n = 0u; n < v->count; n++) {
    Material m = s.materials[v->material[n]];
    uneven = uneven | (m.majorant > 0.0f);
    sum = sum + (m.majorant > 0.0f ? to_real(m.majorant) : max_of3(load3(m.transparency)));
  }
  return uneven ? sum : REAL(0.0);
}

/* ---------------------------------------------------------------- segments */

/* A way to what a path's ray has hit. */
typedef struct {
  Mixture mixture; /* where volumes are even */
  real majorant;   /* else; 0 where they are */
  real length;     /* metres; of a ray that hits nothing FAR_AWAY */
} Segment;

FN Segment make_segment(Scene s, Track k, real t_min, Hit h, const Volumes *v, real *r) {
  Segment g;
  g.majorant = majorant_of(s, v);
  if (!(g.majorant > REAL(0.0))) g.mixture = mix_volumes(s, v, k, t_min, r);
  g.length = h.instance == NONE ? FAR_AWAY : max_real(h.t - t_min, REAL(0.0));
  return g;
}

/* What is left of light after a way, Beer and Lambert. */
FN real3 kept_by_volumes(Mixture x, real length) { return exp3(x.extinction * -length); }

/* The integral of exp(-extinction t) over a way: by a series where little is lost. */
FN real way_integral(real extinction, real length) {
  real depth = extinction * length;
  real series = length * (REAL(1.0) - depth * (REAL(0.5) - depth * (REAL(0.16666666666666667) - depth * REAL(0.041666666666666667))));
  real whole = (REAL(1.0) - exp_real(-depth)) / max_real(extinction, REAL(1e-37));
  return depth < REAL(0.03) ? series : whole;
}

/* Light that even volumes send along the whole way, in parts of the path's throughput. */
FN real3 glow_of_way(Segment g) {
  real3 e = g.mixture.extinction;
  return g.mixture.emission *
         make_real3(way_integral(e.x, g.length), way_integral(e.y, g.length), way_integral(e.z, g.length));
}

/* The light group of the first of them that emits. */
FN uint volume_light_group(Scene s, const Volumes *v) {
  World w = s.world[0];
  for (uint k = 0u; k < v->count; k++) {
    uint around = v->around[k];
    if (!(s.materials[v->material[k]].flags & MATERIAL_EMITS)) continue;
    if (around == NONE) return w.light_group;
    if (w.sphere_groups == NONE) return 0u;
    return s.light_groups[around & AROUND_SPHERE ? w.sphere_groups + (around & ~AROUND_SPHERE) : around];
  }
  return 0u;
}

FN real3 quotient3(real3 a, real b) { return a * (REAL(1.0) / max_real(b, REAL(1e-37))); }

/* The path at the end of the way, or where volumes have scattered it before.
 *
 * A channel is chosen in proportion to the path's throughput, its extinction gives the distance, and all channels are
 * weighed by the balance heuristic (spectral MIS: Wilkie et al. 2014, "Hero Wavelength Spectral Sampling"): no channel then
 * weighs more than all had together. Past its last bounce a path is not scattered, its light grows weaker instead. */
typedef struct {
  Path path;
  Hit hit;       /* as before, or IN_VOLUME */
  real3 emitted; /* that volumes bring on the way */
} Travelled;

FN int is_scattering(Mixture x) { return (x.scattering.x > REAL(0.0)) | (x.scattering.y > REAL(0.0)) | (x.scattering.z > REAL(0.0)); }

/* Whether volumes would scatter a path that may not be scattered any more. */
FN int is_held_back(Segment g, Path p) {
  return (p.status & PATH_LAST_HIT) && (g.majorant > REAL(0.0) || is_scattering(g.mixture));
}

FN Travelled travel_even(Segment g, Path p, Hit h, real2 u) {
  Travelled r;
  Mixture x = g.mixture;
  real3 throughput = path_throughput(p), e = x.extinction;
  real sum = sum_of3(abs3(throughput)); /* some are negative where a majorant was exceeded */
  real3 chances = quotient3(abs3(throughput), sum);
  int samples = is_scattering(x) & !is_held_back(g, p) & (sum > REAL(0.0));
  real drawn = u.x < chances.x ? e.x : (u.x < chances.x + chances.y ? e.y : e.z);
  int thick = drawn > REAL(1e-37);
  real distance = thick ? -log_real(REAL(1.0) - u.y) / drawn : FAR_AWAY;
  int scattered = samples & (distance < g.length);
  real t = scattered ? distance : g.length;
  real3 kept = kept_by_volumes(x, t);
  real3 factor = quotient3(kept, dot3(chances, kept));
  factor = select3(scattered, quotient3(kept * x.scattering, dot3(chances, kept * e)), factor);
  factor = select3(samples, factor, kept);
  r.path = with_throughput(p, throughput * factor);
  r.emitted = throughput * glow_of_way(g);
  r.hit = h;
  r.hit.t = scattered ? p.t_min + t : h.t;
  r.hit.instance = scattered ? IN_VOLUME : h.instance;
  return r;
}

/* Whether a path goes on behind what it has hit, since that is only the boundary of a volume. */
FN int crosses_boundary(Scene s, Path *p, Hit h, Volumes *v, uint features) {
  if (h.instance == NONE || h.instance == IN_VOLUME) return 0;
  Material m = s.materials[hit_material(s, h, features)];
  if (!(m.flags & MATERIAL_BOUNDARY)) return 0;
  cross_surface(v, m, h, make_surface(s, path_ray(*p), h, features).backfacing);
  p->t_min = h.t;
  p->after_instance = h.instance;
  p->after_primitive = h.primitive;
  return 1;
}

/* ----------------------------------------------------------------- scattering */

FN Surface volume_vertex(Path p, Hit h) {
  Surface at;
  at.p = make_real3(p.ox, p.oy, p.oz) + make_real3(p.dx, p.dy, p.dz) * h.t;
  at.offset = REAL(0.0);
  at.ng = make_real3(-p.dx, -p.dy, -p.dz);
  at.ns = at.ng;
  at.backfacing = 0;
  at.material = NONE;
  return at;
}

/* What scatters at a point: phase functions, and how much each does. */
typedef struct {
  real3 weight[MOST_LOBES];
  real anisotropy[MOST_LOBES], alpha[MOST_LOBES];
  uint count;
} Lobes;

FN void find_lobes(Scene s, const Volumes *v, Track k, real t, Lobes *lobes, real *r) {
  lobes->count = 0u;
  for (uint n = 0u; n < v->count; n++) {
    Material m = s.materials[v->material[n]];
    compute_volume(s, m, m.steps, v->around[n], k, t, r);
    for (uint c = 0u; c < m.count && lobes->count < MOST_LOBES; c++) {
      Closure one = closure_of(s.instructions[m.first + c], r);
      lobes->weight[lobes->count] = one.weight;
      lobes->anisotropy[lobes->count] = bounded_anisotropy(param(one, SCATTERING_ANISOTROPY));
      lobes->alpha[lobes->count++] = param(one, SCATTERING_ALPHA);
    }
  }
}

/* The mean of the phase functions in a direction, as the scattering of each channel has it; its density is that of their
 * parts by Henyey and Greenstein, which are drawn. */
FN BsdfValue eval_phases(const Lobes *lobes, real3 before, real3 after) {
  real3 f = zero3(), sum = zero3();
  real pdf = REAL(0.0), total = REAL(0.0);
  for (uint n = 0u; n < lobes->count; n++) {
    real3 weight = lobes->weight[n];
    real g = lobes->anisotropy[n], phase = henyey_greenstein(before, after, g);
    f = f + weight * (phase * draine_ratio(dot3(before, after), g, lobes->alpha[n]));
    sum = sum + weight;
    pdf = pdf + sum_of3(weight) * phase;
    total = total + sum_of3(weight);
  }
  f = make_real3(f.x / max_real(sum.x, REAL(1e-37)), f.y / max_real(sum.y, REAL(1e-37)), f.z / max_real(sum.z, REAL(1e-37)));
  return make_value(f, pdf / max_real(total, REAL(1e-37)));
}

/* The same towards a light, which may be hidden from rays that volumes send. */
FN BsdfValue phases_towards(const Lobes *lobes, real3 before, LightSample light) {
  BsdfValue value = eval_phases(lobes, before, light.direction);
  if ((SCENE_FEATURES & FEATURE_LIGHT_LIMITS) && is_hidden(light.hidden, RAY_OF_VOLUME)) value.f = zero3();
  return value;
}

FN real3 sample_phases(const Lobes *lobes, real3 before, real u_choice, real2 u) {
  Choice choice = make_choice(u_choice);
  real g = REAL(0.0);
  for (uint n = 0u; n < lobes->count; n++) {
    choice = consider(choice, int_of(n), sum_of3(lobes->weight[n]));
    g = choice.chosen == int_of(n) ? lobes->anisotropy[n] : g;
  }
  return sample_henyey_greenstein(before, g, u);
}

/* Passes of a path that a volume scatters before anything else: no surface guides a denoiser, and light of such a path is
 * told apart from that of all closures. */
FN void show_volume(GLOBAL real *columns, uint stride, Path p, uint groups) {
  if (has_any(groups, GROUPS_DENOISING)) columns[(first_guide(groups) + 3u) * stride + p.slot] = REAL(0.0);
  if (has_any(groups, GROUPS_SPLIT) && path_bounce(p) == 0) {
    store_shares(columns, stride, p.slot, groups, SHARES_OF_PATH, shares_of_volume());
    store_shares(columns, stride, p.slot, groups, SHARES_OF_LIGHT, shares_of_volume());
  }
}

/* The path goes on in the sampled direction, of which `value` are the phase functions. */
FN Scattered scatter_in_volume(Params params, Surface at, Path p, real3 direction, BsdfValue value, real u_roulette) {
  Scattered r;
  real3 throughput = path_throughput(p) * value.f * (REAL(1.0) / max_real(value.pdf, REAL(1e-37)));
  uint bounces = p.bounces + 1u, passed = uint_of(path_passed(p));
  int last = reached_limits(params, bounces, passed) != 0u;
  real brightest = max_of3(abs3(throughput)); /* negative where a majorant was exceeded */
  real survival = last ? REAL(1.0) : min_real(REAL(1.0), REAL(2.0) * brightest);
  Path q = with_throughput(p, throughput * (REAL(1.0) / max_real(survival, REAL(1e-30))));
  q.ox = at.p.x;
  q.oy = at.p.y;
  q.oz = at.p.z;
  q.dx = direction.x;
  q.dy = direction.y;
  q.dz = direction.z;
  q.t_min = REAL(0.0);
  q.t_max = FAR_AWAY;
  q.after_instance = NONE;
  q.after_primitive = NONE;
  q.pdf = value.pdf;
  q.bounces = bounces;
  q.status = RAY_OF_VOLUME | (p.status & (RAY_AFTER_DIFFUSE | PATH_CAUGHT)) | passed << 8 | (last ? PATH_LAST_HIT : 0u) |
             RECEIVER_ALL << PATH_RECEIVER_SHIFT;
  r.path = q;
  r.alive = (u_roulette < survival) & (brightest > REAL(0.0)) & (value.pdf > REAL(0.0));
  return r;
}

#endif
