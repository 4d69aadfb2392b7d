/* What happens to one path: generate, extend, shade, connect, accumulate. Values in, values out. */
#ifndef ISOPHOTE_STAGES_H
#define ISOPHOTE_STAGES_H
#include "camera_motion.h"
#include "light.h"
#include "params.h"
#include "path.h"
#include "sampler.h"
#include "scatter.h"
#include "terminator.h"
#include "walk.h"

/* ---------------------------------------------------------------- generate */

/* A new path for pixel (column, row) of the item's region and one of its samples; its throughput is 0 where the camera
 * sees nothing. `kind` is the camera's: OpenMP's loops have a copy for each. */
FN Path generate_path(Scene s, Params params, int kind, int column, int row, uint sample, uint slot) {
  Camera camera = s.camera[0];
  int x = params.x0 + column, y = params.y0 + row;
  uint seed = pixel_seed(uint_of(x), uint_of(y), sample & 1u, params.seed);
  real2 u = sample_pair(seed, sample >> 1, PAIR_FILTER);
  real width = to_real(params.filter_width);
  real fx = real_of(x) + REAL(0.5) + width * sample_filter(s.filter_table, u.x);
  real fy = real_of(y) + REAL(0.5) + width * sample_filter(s.filter_table, u.y);
  Path p;
  real2 on_lens = make_real2(REAL(0.0), REAL(0.0));
  if (has_lens(camera)) on_lens = sample_lens(camera, sample_pair(seed, sample >> 1, PAIR_LENS));
  p = with_ray(p, make_camera_ray(camera, kind, fx, fy, on_lens));
  p = with_throughput(p, splat3(is_panorama(kind) && !(p.t_max > REAL(0.0)) ? REAL(0.0) : REAL(1.0)));
  p.pdf = REAL(0.0);
  p.slot = slot;
  p.seed = seed;
  p.index = sample >> 1;
  p.bounces = 0u;
  p.status = RAY_CAMERA;
  return path_at_time(p, REAL(0.0));
}

/* ------------------------------------------------------------------- shade */

/* OpenCL programs are compiled for settings that clamp light, or for those that do not. */
#ifndef CLAMPS
#define CLAMPS 1
#endif

/* Light for a path's pixel, and what clamping has taken from it, for the ledger. */
typedef struct {
  real3 light;
  real cut; /* what was cut off, in parts of what is left */
  int indirect;
} Brought;

/* Cycles' clamp: light whose channels add up to more than the limit is scaled down. Off where 0. */
FN Brought clamp_light(Params params, real3 light, int bounce) {
  Brought b;
  b.light = light;
  b.cut = REAL(0.0);
  b.indirect = bounce > 0;
  if (CLAMPS && params.cut_plane) {
    real limit = to_real(bounce > 0 ? params.clamp_indirect : params.clamp_direct);
    real sum = fabs(light.x) + fabs(light.y) + fabs(light.z);
    int over = (limit > REAL(0.0)) & (sum > limit);
    b.light = light * (over ? limit / sum : REAL(1.0));
    b.cut = over ? sum / limit - REAL(1.0) : REAL(0.0);
  }
  return b;
}

/* Luminance cut off: with the picture's own it is that of the picture without clamping. */
FN real cut_luminance(Brought b) { return luminance(b.light) * b.cut; }

/* What the path's last vertex knew when it chose a light; `set`: of its object, NONE where lights are not linked. */
FN Receiver path_receiver(Path p, uint set) {
  Receiver r = make_receiver(make_real3(p.ox, p.oy, p.oz), p.status >> PATH_RECEIVER_SHIFT);
  r.set = set;
  return r;
}

/* Whether light that a path has run into counts for its last vertex. The camera sees all. */
FN int is_lit_by(Scene s, uint link, Path p, uint set) {
  if (!(SCENE_FEATURES & FEATURE_LINKING) || set == NONE || (path_kind(p) & RAY_CAMERA)) return 1;
  return !is_in_mask(s.links[link].unlit, set);
}

/* How much it counts beside light that is drawn: nothing where some objects do not stop the light, for only shadow rays
 * pass them (link_sample). */
FN real weight_of_hit(Scene s, uint link, Path p, uint set, real light_pdf) {
  real weight = mis_weight(p.pdf, light_pdf);
  if (!(SCENE_FEATURES & FEATURE_LINKING) || set == NONE || !is_shadow_linked(s, link)) return weight;
  return light_pdf > REAL(0.0) ? REAL(0.0) : REAL(1.0);
}

/* Transparent surfaces that the path has passed. */
FN int path_passed(Path p) { return int_of((p.status >> 8) & 255u); }

FN LightHit find_lamp(Light l, Path p, Hit h, uint features) {
  return hit_lamp(l, path_ray(p), h.t, h.instance == NONE, p.bounces & 255u, features);
}

/* What a computed lamp's material emits towards who sees it along a ray, at distance t. To the program no ray has come:
 * as in Cycles, which tells it PATH_RAY_EMISSION alone. */
FN real3 lamp_emission(Scene s, Light l, Ray ray, real t, uint bounces, uint passed, real *r) {
  ray.kind = 0u;
  Surface at = make_lamp_surface(l, ray, t);
  Material m = s.materials[at.material];
  compute_values(s, m, m.steps, at, ray, background_hit(t), bounces, passed, r);
  return material_emission(m, r);
}

/* Light that reaches the path's ray from a lamp, which find_lamp has found; `set` as in path_receiver. */
FN Brought see_lamp(Scene s, Params params, uint lamp, Path p, uint set, LightHit seen, real *r) {
  Light l = s.lights[lamp];
  uint link = link_of_lamp(s, lamp);
  real weight = is_lit_by(s, link, p, set) ? REAL(1.0) : REAL(0.0);
  if ((SCENE_FEATURES & FEATURE_LAMP_PROGRAMS) && (l.flags & LIGHT_COMPUTED)) {
    uint bounces = p.bounces ? p.bounces : 1u; /* what a drawn lamp is told, one more than its receiver, is never 0 */
    seen.radiance = seen.radiance * lamp_emission(s, l, path_ray(p), seen.t, bounces, uint_of(path_passed(p)), r);
  }
  if (p.pdf > REAL(0.0))
    weight = weight * weight_of_hit(s, link, p, set, seen.pdf * light_chance(s, l, path_receiver(p, set)));
  return clamp_light(params, path_throughput(p) * seen.radiance * weight, path_bounce(p) - 1);
}

/* Light from the world where nothing is hit; transparent film leaves it to the compositor. */
FN Brought see_world(Scene s, Params params, Path p, uint set, const real *r) {
  World w = s.world[0];
  real3 radiance = load3(w.radiance);
  real weight = REAL(1.0);
  uint features = SCENE_FEATURES & w.features;
  if (features & FEATURE_WORLD) radiance = material_emission(s.materials[w.material], r);
  if ((features & FEATURE_WORLD_LIGHT) && p.pdf > REAL(0.0)) {
    Light as_light = s.lights[w.lamp_count - 1u];
    real drawn = pdf_world(s, make_real3(p.dx, p.dy, p.dz), features);
    weight = mis_weight(p.pdf, drawn * light_chance(s, as_light, path_receiver(p, set)));
  }
  real3 light = path_throughput(p) * radiance * weight;
  int hidden = params.film_transparent & ((p.status & PATH_FROM_CAMERA) != 0u);
  hidden = hidden | is_hidden(w.hidden, path_kind(p));
  return clamp_light(params, select3(hidden, zero3(), light), path_bounce(p) - 1);
}

/* What a path takes away from the pixel's alpha where it shows nothing: with a transparent film beyond the scene. */
FN real lost_alpha(int shows_nothing, Path p) {
  int seen = shows_nothing & ((p.status & PATH_FROM_CAMERA) != 0u);
  return seen ? (p.red + p.green + p.blue) * REAL(0.33333334) : REAL(0.0);
}

/* What part of a surface is held out. */
FN real3 held_share(Scene s, Material m, const real *r) {
  real3 share = zero3();
  for (uint k = 0u; k < m.count; k++) {
    Instruction i = s.instructions[m.first + k];
    if (i.op == OP_HOLDOUT) share = share + closure_of(i, r).weight;
  }
  return share;
}

/* What that takes of the pixel's alpha, with an opaque film too, as in Cycles. */
FN real held_alpha(Scene s, Material m, Path p, const real *r) {
  return lost_alpha(1, with_throughput(p, path_throughput(p) * held_share(s, m, r)));
}

/* Light that the surface itself emits, weighted against drawing the same point as a light. */
FN Brought see_emission(Scene s, Params params, Material m, Path p, uint set, Hit h, const real *r) {
  int compete = (p.pdf > REAL(0.0)) & (h.instance != SPHERE_INSTANCE);
  real light_pdf = REAL(0.0);
  if (compete) light_pdf = emission_pdf(s, h, path_receiver(p, set), make_real3(p.dx, p.dy, p.dz), path_time(p));
  uint link = link_of_object(s, h.instance, h.primitive);
  real weight = compete ? weight_of_hit(s, link, p, set, light_pdf) : REAL(1.0);
  real3 light = path_throughput(p) * material_emission(m, r) * weight;
  if ((SCENE_FEATURES & FEATURE_LIGHT_LIMITS) && h.instance != SPHERE_INSTANCE)
    light = select3(is_hidden(RAY_INDIRECT & ~s.instances[h.instance].visibility, path_kind(p)), zero3(), light);
  if (!is_lit_by(s, link, p, set)) light = zero3();
  return clamp_light(params, light, path_bounce(p) - 1);
}

/* Random numbers are counted by vertex, so that transparent surfaces draw fresh ones. */
FN int path_vertex(Path p) { return path_bounce(p) + path_passed(p); }

/* The normal that counts when a vertex chooses a light. */
FN uint receiver_normal(Surface at, uint material_flags) {
  /* Closures with normals of their own look to the side of ng, each another way. */
  if ((SCENE_FEATURES & FEATURE_BUMP) && (material_flags & MATERIAL_BUMPS)) at.ns = at.ng;
  return (material_flags & MATERIAL_TRANSMITS) ? RECEIVER_ALL : pack_normal(at.ns);
}

/* A ray towards a light and what it brings if nothing stands in between. */
typedef struct {
  Ray ray;
  Brought brought;
  uint passed;  /* path_passed: shadow rays count on from there */
  uint bounces; /* the path's */
} Connection;

FN int is_dark(real3 light) { return (light.x == REAL(0.0)) & (light.y == REAL(0.0)) & (light.z == REAL(0.0)); }

FN Ray shadow_ray(real3 origin, real3 direction, real distance, uint instance, uint primitive, real time) {
  Ray r = ray_at(free_ray(origin, direction, REAL(0.0), distance), time);
  r.skip_instance = instance;
  r.skip_primitive = primitive;
  r.kind = RAY_SHADOW;
  return r;
}

/* value: the whole BSDF towards the light. */
FN Connection connect_light(Params params, Surface at, LightSample light, BsdfValue value, Path p) {
  Connection c;
  real weight = light.can_be_hit ? mis_weight(light.pdf, value.pdf) : REAL(1.0);
  real3 brought = path_throughput(p) * value.f * light.radiance * (weight / light.pdf);
  int useful = (light.pdf > REAL(0.0)) & (value.pdf > REAL(0.0));
  c.brought = clamp_light(params, select3(useful, brought, zero3()), path_bounce(p));
  c.passed = uint_of(path_passed(p));
  c.bounces = p.bounces;
  c.ray = shadow_ray(offset_origin(at, light.direction), light.direction, light.distance, light.instance, light.primitive,
                     path_time(p));
  return c;
}

/* Whether paths have reached the bounce limits: bit k for the k-th of LIMITS. */
FN uint reached_limits(Params params, uint bounces, uint passed) {
  int in_volumes = 0; /* no other kind has counted them */
  if (SCENE_FEATURES & FEATURE_VOLUME)
    in_volumes = int_of((bounces & 255u) - ((bounces >> 8) & 255u) - ((bounces >> 16) & 255u) - (bounces >> 24));
  return uint_of(int_of(bounces & 255u) >= params.max_bounces) |
         uint_of(int_of((bounces >> 8) & 255u) >= params.diffuse_bounces) << 1 |
         uint_of(int_of((bounces >> 16) & 255u) >= params.glossy_bounces) << 2 |
         uint_of(int_of(bounces >> 24) >= params.transmission_bounces) << 3 |
         uint_of(in_volumes >= params.volume_bounces) << 4 |
         uint_of(int_of(passed) >= params.transparent_bounces) << 5;
}

typedef struct {
  Path path;
  int alive;
} Scattered;

/* The path goes on in the sampled direction. weight and share are those of the chosen closure, value
 * is the whole BSDF in that direction, u_roulette decides survival. */
FN Scattered scatter_path(Params params, Surface at, uint material_flags, Path p, Hit h, BsdfSample sample, real3 direction, real3 weight,
                          Choice choice, BsdfValue value, real u_roulette) {
  Scattered r;
  int delta = sample.delta;
  int transparent = (sample.label & LABEL_TRANSPARENT) != 0;
  real3 factor = select3(delta, sample.f * weight * (choice.total / choice.share), value.f * (REAL(1.0) / value.pdf));
  int valid = sample.valid & (choice.chosen >= 0) & (delta | (value.pdf > REAL(0.0)));
  real3 throughput = path_throughput(p) * factor;

  int reflect = (sample.label & LABEL_REFLECT) != 0;
  int diffuse = (sample.label & LABEL_DIFFUSE) != 0;
  uint kind = reflect ? (diffuse ? RAY_DIFFUSE : RAY_GLOSSY) : RAY_TRANSMISSION;
  kind |= (delta ? RAY_SINGULAR : 0u) | ((diffuse & !reflect) ? RAY_SOFT : 0u);
  int enters = 0;
  if (SCENE_FEATURES & FEATURE_SUBSURFACE) {
    enters = (sample.label & LABEL_SUBSURFACE) != 0;
    kind = enters ? 0u : kind | (diffuse ? RAY_AFTER_DIFFUSE : p.status & RAY_AFTER_DIFFUSE);
  }
  uint count = 1u + (reflect ? (diffuse ? 0x100u : 0x10000u) : 0x1000000u);
  uint bounces = transparent | enters ? p.bounces : p.bounces + count;
  uint passed = ((p.status >> 8) & 255u) + (transparent ? 1u : 0u);
  int last = reached_limits(params, bounces, passed) != 0u;

  /* Roulette in proportion to the throughput, so that those who survive weigh alike; twice as many as that
   * alone would leave, by measurement (docs/study-sampling.md). */
  real brightest = max_of3(throughput);
  real survival = min_real(REAL(1.0), REAL(2.0) * max_real(brightest, REAL(0.0)));
  survival = transparent | last ? REAL(1.0) : survival;
  int survives = (u_roulette < survival) & (brightest > REAL(0.0));
  throughput = throughput * (REAL(1.0) / max_real(survival, REAL(1e-30)));

  real3 origin = offset_origin(at, direction);
  Path q = with_throughput(p, throughput);
  q.ox = transparent ? p.ox : origin.x;
  q.oy = transparent ? p.oy : origin.y;
  q.oz = transparent ? p.oz : origin.z;
  q.dx = transparent ? p.dx : direction.x;
  q.dy = transparent ? p.dy : direction.y;
  q.dz = transparent ? p.dz : direction.z;
  q.t_min = transparent ? h.t : REAL(0.0);
  q.t_max = transparent ? p.t_max : FAR_AWAY;
  q.after_instance = transparent | enters ? h.instance : NONE;
  q.after_primitive = transparent | enters ? h.primitive : NONE;
  q.pdf = transparent ? p.pdf : (delta ? REAL(0.0) : value.pdf);
  q.bounces = bounces;
  uint flags = (p.status & PATH_CAUGHT) | (last ? PATH_LAST_HIT : 0u);
  uint receiver = transparent ? p.status >> PATH_RECEIVER_SHIFT : receiver_normal(at, material_flags);
  q.status = (transparent ? path_kind(p) : kind) | (passed << 8) | flags | (receiver << PATH_RECEIVER_SHIFT);
  r.path = q;
  r.alive = valid & survives;
  return r;
}

/* Past the last bounce only transparent surfaces let a path on, as long as their own limit allows. */
FN Scattered pass_transparent(Params params, Material m, Path p, Hit h, const real *registers) {
  Scattered r;
  uint passed = ((p.status >> 8) & 255u) + 1u;
  r.alive = ((m.flags & MATERIAL_TRANSPARENT) != 0u) & (int_of(passed) < params.transparent_bounces);
  r.path = with_throughput(p, path_throughput(p) * material_transparency(m, registers));
  r.path.t_min = h.t;
  r.path.after_instance = h.instance;
  r.path.after_primitive = h.primitive;
  r.path.status = (p.status & ~0xff00u) | (passed << 8);
  return r;
}

/* The limits, as of reached_limits, for which a path past its last bounce does not scatter at a surface that it hits;
 * 0 where no path would. */
FN uint ending_limits(Params params, Material m, Path p) {
  uint passed = uint_of(path_passed(p)) + ((m.flags & MATERIAL_TRANSPARENT) ? 1u : 0u);
  return m.count ? reached_limits(params, p.bounces, passed) : 0u;
}

/* ------------------------------------------------------------------- trace */

/* Whether paths begin a second time (shadow_catcher.h), and rays of those that see catchers of shadows alone. */
FN int is_alone(Params params) { return (SCENE_FEATURES & FEATURE_CATCHERS) && params.catching == CATCHING_ALONE; }
FN Ray among_catchers(Ray r, int alone) {
  r.kind = alone ? (r.kind & RAY_ALL) << CATCHER_SHIFT : r.kind;
  return r;
}
FN Ray traced_ray(Params params, Path p) {
  return among_catchers(path_ray(p), is_alone(params) && (p.status & PATH_CAUGHT));
}

/* ----------------------------------------------------------------- connect */

/* A shadow ray on its way in a scene with transparent surfaces. */
typedef struct {
  Ray ray;
  real3 kept; /* the part of the light that they let through */
  uint passed; /* how many there were, with those of the path */
  uint bounces; /* the path's */
  int going;
  int limited; /* only the limit has stopped it */
} Shadow;

FN Shadow make_shadow(Ray ray, uint passed, uint bounces) {
  Shadow d;
  d.bounces = bounces;
  d.ray = ray;
  d.kept = splat3(REAL(1.0));
  d.passed = passed;
  d.going = 1;
  d.limited = 0;
  return d;
}

/* The link of the light to which a shadow ray goes, NONE where it has none. */
FN uint aimed_link(Scene s, Ray ray) {
  return is_to_lamp(ray) ? link_of_lamp(s, ray.skip_primitive - TO_LAMP) : ray.skip_instance;
}

FN Shadow behind_hit(Shadow d, Hit h) {
  d.ray.t_min = h.t;
  d.ray.after_instance = h.instance;
  d.ray.after_primitive = h.primitive;
  return d;
}

/* The closest hit stops the shadow ray, or it goes on behind it. The limit is the user's own, one less than that
 * of paths, as Cycles counts (integrate_shadow_max_transparent_hits). */
FN Shadow pass_shadow(Scene s, Params params, Shadow d, Hit h, uint features, real *r) {
  d.going = 0;
  if (h.instance == NONE) return d;
  uint link = features & FEATURE_LINKING ? aimed_link(s, d.ray) : NONE;
  if (link != NONE && is_shadow_linked(s, link)) {
    d.going = is_in_mask(s.links[link].unblocked, s.links[link_of_object(s, h.instance, h.primitive)].blocker);
    if (d.going) return behind_hit(d, h);
  }
  Surface at = make_surface(s, d.ray, h, features);
  Material m = s.materials[at.material];
  int transparent = (m.flags & MATERIAL_TRANSPARENT) != 0u;
  d.going = transparent & (int_of(d.passed) + 1 < params.transparent_bounces);
  d.limited = transparent & !d.going;
  if (d.going) compute_values(s, m, m.shadow_steps, at, d.ray, h, d.bounces + 1u, d.passed, r);
  d.kept = d.going ? d.kept * material_transparency(m, r) : zero3();
  d.passed++;
  return behind_hit(d, h);
}

/* A shadow ray's whole way: in scenes without transparent surfaces all of the light arrives or none. */
FN Shadow trace_connection(Scene s, Params params, Connection c, uint features, real *r) {
  Ray ray = c.ray;
  Shadow d = make_shadow(ray, c.passed, c.bounces);
  if (!(features & FEATURE_TRANSPARENT)) {
    Hit h = trace(s, among_catchers(ray, is_alone(params)), 1);
    d.kept = select3(h.instance == NONE, splat3(REAL(1.0)), zero3());
    return d;
  }
  while (d.going) d = pass_shadow(s, params, d, trace(s, among_catchers(d.ray, is_alone(params)), 0), features, r);
  return d;
}

FN Brought behind_shadow(Brought b, Shadow d) {
  b.light = b.light * d.kept;
  return b;
}

/* -------------------------------------------------------------- accumulate */

/* Whether a sample's value may be added to the film: a number, and so small that a block of 64 stays one in float32.
 * Looks at the exponent, which no compiler that takes all numbers for finite can do without. */
FN int is_addable(real x) { return (bits_of_float(to_float(x)) & 0x7f800000u) < 0x7b800000u; }

#endif
