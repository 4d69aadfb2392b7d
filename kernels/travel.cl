/* What the OpenCL device does in scenes with volumes: a stage between `extend` and `shade`, in which paths come to what they
 * have hit or are scattered on the way, and what shading and shadow rays have to do with volumes.
 *
 * The volumes that a path is in lie behind its uints, those of its shadow ray behind those of the connection. */
#include "tracking.h"

FN GLOBAL uint *volumes_of_paths(GLOBAL uint *uints, uint stride) { return uints + PATH_UINT_COUNT * stride; }
FN GLOBAL uint *volumes_of_connections(GLOBAL uint *light_uints, uint stride) {
  return light_uints + (CONNECTION_BOUNCES + 1u) * stride;
}

/* Those in which a path begins. */
FN void begin_in_volumes(Scene s, Path p, GLOBAL uint *uints, uint stride, uint i) {
  Volumes v;
  start_volumes(s, &v);
  if (s.world[0].camera_enclosed) {
    Probe probe = start_probe(p);
    while (pass_probe(s, &probe, &v, trace(s, probe.ray, 0), SCENE_FEATURES)) {}
  }
  store_volumes(volumes_of_paths(uints, stride), stride, i, &v);
}

__kernel void travel(SCENE_PARAMETERS, PATH_PARAMETERS, HIT_PARAMETERS, RESULT_PARAMETERS, GLOBAL const uint *queue,
                     GLOBAL const uint *counts, uint bounce) {
  MAKE_SCENE
  uint number = get_global_id(0);
  if (number >= counts[2u * bounce]) return;
  uint i = queue[number];
  Path p = load_whole_path(reals, uints, stride, i);
  if (is_inside(p)) return;
  Hit h = load_hit(hit_reals, hit_uints, stride, i);
  Volumes v;
  load_volumes(volumes_of_paths(uints, stride), stride, i, &v);
  real registers[REGISTERS];
  int grouped = has_any(film_groups(params), GROUPS_LIGHT_GROUPS);
  for (int crosses = 1; crosses;) {
    Track k = track_of_path(p);
    Segment g = make_segment(s, k, p.t_min, h, &v, registers);
    if (SCENE_FEATURES & FEATURE_VISIBLE_LIGHTS) {
      for (uint l = 0u; l < s.world[0].lamp_count; l++) {
        if (!(s.lights[l].size_u > 0.0f)) continue;
        LightHit seen = find_lamp(s.lights[l], p, h, SCENE_FEATURES);
        if (seen.hit)
          add_result(results, columns, stride, p.slot, params,
                     see_lamp(s, params, l, path_to_lamp(s, k, g, p, seen, &v, registers),
                              last_set(s, params, columns, stride, p.slot), seen, registers),
                     seen_from(p, GROUP_emission, LIGHT_GROUP(s.lights[l].flags)));
      }
    }
    if (is_held_back(g, p)) count_limits(limits, reached_limits(params, p.bounces, uint_of(path_passed(p))));
    Travelled r = travel_segment(s, k, g, p, h, &v, registers);
    if (!is_dark(r.emitted))
      add_result(results, columns, stride, p.slot, params, clamp_light(params, r.emitted, path_bounce(p) - 1),
                 seen_from(p, GROUP_emission, grouped ? volume_light_group(s, &v) : 0u));
    p = r.path;
    h = r.hit;
    crosses = crosses_boundary(s, &p, h, &v, SCENE_FEATURES);
    if (crosses) h = trace(s, traced_ray(params, p), 0);
  }
  store_path(reals, uints, stride, i, p);
  store_hit(hit_reals, hit_uints, stride, i, h);
  store_volumes(volumes_of_paths(uints, stride), stride, i, &v);
}

/* A path that a volume scatters. */
FN Shaded shade_volume(Scene s, Params params, Path p, Hit h, GLOBAL const uint *uints, GLOBAL real *columns, uint stride) {
  Shaded r;
  Volumes v;
  load_volumes(uints + PATH_UINT_COUNT * stride, stride, p.slot, &v);
  uint groups = film_groups(params);
  real registers[REGISTERS];
  Lobes lobes;
  find_lobes(s, &v, track_of_path(p), h.t, &lobes, registers);
  Surface at = volume_vertex(p, h);
  show_volume(columns, stride, p, groups);
  int vertex = path_vertex(p);
  real3 before = make_real3(p.dx, p.dy, p.dz);
  real2 u_choice = sample_bounce(p.seed, p.index, vertex, PAIR_CHOICE);
  r.connected = 0;
  if (SCENE_FEATURES & FEATURE_LIGHTS) {
    LightSample light = draw_light(s, params, p, h, at.p, RECEIVER_ALL, u_choice.x, columns, stride);
    if (SCENE_FEATURES & FEATURE_SHINES) params.cut_plane = 0; /* clamped where its radiance is computed */
    r.connection = connect_light(params, at, light, phases_towards(&lobes, before, light), p);
    r.connected = !is_dark(r.connection.brought.light);
  }
  real3 direction = sample_phases(&lobes, before, u_choice.y, sample_bounce(p.seed, p.index, vertex, PAIR_BSDF));
  Scattered on = scatter_in_volume(params, at, p, direction, eval_phases(&lobes, before, direction),
                                   sample_bounce(p.seed, p.index, vertex, PAIR_ROULETTE).x);
  if (SCENE_FEATURES & FEATURE_LINKING) columns[link_column(params) * stride + p.slot] = real_of(receiver_set(s, h));
  r.path = on.path;
  r.alive = on.alive;
  return r;
}

/* Which volumes the next ray and the shadow ray of a vertex are in; p and h are those that have led to it. */
FN void move_in_volumes(Scene s, Params params, Path p, Hit h, Shaded r, GLOBAL uint *uints, GLOBAL uint *light_uints, uint stride,
                        uint i) {
  Volumes v;
  load_volumes(volumes_of_paths(uints, stride), stride, i, &v);
  int at_surface = h.instance != NONE && h.instance != IN_VOLUME, changes = 0, crosses = 0;
  Material m;
  Surface at;
  if (at_surface) {
    changes = is_alone(params) && is_being_caught(s, params, p, h);
    if (changes) keep_those_of_catchers(s, &v);
    m = s.materials[hit_material(s, h, SCENE_FEATURES)];
    crosses = m.volume != NONE;
    if (crosses) at = make_surface(s, path_ray(p), h, SCENE_FEATURES);
  }
  if (r.connected) {
    Volumes lit = v;
    if (crosses) cross_towards(&lit, m, h, at, r.connection.ray.origin - at.p);
    store_volumes(volumes_of_connections(light_uints, stride), stride, i, &lit);
  }
  if (r.alive && crosses && !is_inside(r.path)) {
    cross_towards(&v, m, h, at, make_real3(r.path.dx, r.path.dy, r.path.dz));
    changes = 1;
  }
  if (changes) store_volumes(volumes_of_paths(uints, stride), stride, i, &v);
}

/* A shadow ray's whole way through surfaces and volumes. */
FN Shadow trace_in_volumes(Scene s, Params params, Shadow d, Volumes *v, real *r) {
  while (d.going) d = shade_shadow(s, params, d, v, trace(s, among_catchers(d.ray, is_alone(params)), 0), SCENE_FEATURES, r);
  return d;
}

FN Shadow connect_in_volumes(Scene s, Params params, Connection c, GLOBAL uint *light_uints, uint stride, uint i, real *r) {
  Volumes v;
  load_volumes(volumes_of_connections(light_uints, stride), stride, i, &v);
  return trace_in_volumes(s, params, make_shadow(c.ray, c.passed, c.bounces), &v, r);
}
