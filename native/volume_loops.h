/* Paths in volumes: on their way to what they have hit, scattered there, and through surfaces. Included once a variant.
 * Values and arithmetic are those of kernels/volume.h. */
#pragma once
#include "light_loops.h"

namespace isophote {
namespace ISOPHOTE_VARIANT {

static Volumes volumes_of(const Batch &b, Path p) {
  Volumes v;
  load_volumes(b.volumes.data(), CAPACITY, p.slot, &v);
  return v;
}

static void keep_volumes(Batch &b, Path p, const Volumes &v) { store_volumes(b.volumes.data(), CAPACITY, p.slot, &v); }

/* A type of this variant's own: of kernels' types the linker would take one variant's vectors for all. */
struct PathProbe {
  Probe probe;
};

struct ProbeRays {
  Batch &b;
  Scene s;
  std::vector<PathProbe> &probes;
  Ray ray(uint i) const { return probes[b.order[i]].probe.ray; }
  void store(uint i, const Hit &h) {
    uint at = b.order[i];
    Path p = path_at(b.columns(), at);
    Volumes v = volumes_of(b, p);
    b.alive[at] = uint(pass_probe(s, &probes[at].probe, &v, h, s.world[0].features));
    keep_volumes(b, p, v);
  }
};

/* Keeps those of the first `count` paths in order that live. */
static uint keep_living(Batch &b, uint count) {
  uint left = 0;
  for (uint i = 0; i < count; i++) {
    b.order[left] = b.order[i];
    left += b.alive[b.order[i]] != 0;
  }
  return left;
}

/* The volumes in which the batch's new paths begin; leaves `alive` to be set. */
static void begin_in_volumes(Batch &b, Scene s) {
  Volumes v;
  start_volumes(s, &v);
  std::vector<PathProbe> probes;
  for (uint i = 0; i < b.count; i++) {
    Path p = path_at(b.columns(), i);
    keep_volumes(b, p, v);
    if (s.world[0].camera_enclosed) probes.push_back({start_probe(p)});
    b.order[i] = i;
  }
  ProbeRays rays{b, s, probes};
  for (uint count = uint(probes.size()); count > 0; count = keep_living(b, count)) trace_all(s, rays, count, 0);
}

/* One way of a path; whether it goes on behind what its ray has hit. */
static int travel_path(Batch &b, Scene s, Params params, uint i) {
  Columns columns = b.columns();
  uint features = s.world[0].features;
  Path p = path_at(columns, i);
  Hit h = load_hit(b, i);
  Volumes v = volumes_of(b, p);
  Track k = track_of_path(p);
  real *registers = b.shadow_registers.data();
  Segment g = make_segment(s, k, p.t_min, h, &v, registers);
  for (uint l = 0; l < s.world[0].lamp_count; l++) {
    if (!(s.lights[l].size_u > 0.0f)) continue;
    LightHit seen = find_lamp(s.lights[l], p, h, features);
    if (seen.hit)
      add_light(b, params, i,
                see_lamp(s, params, l, path_to_lamp(s, k, g, p, seen, &v, registers), last_set_of(b, s, params, p), seen, registers),
                seen_from(p, GROUP_emission, LIGHT_GROUP(s.lights[l].flags)));
  }
  if (is_held_back(g, p)) count_limits(b, reached_limits(params, p.bounces, uint_of(path_passed(p))));
  Travelled r = travel_segment(s, k, g, p, h, &v, registers);
  if (!is_dark(r.emitted)) {
    uint light_group = has_any(params.groups, GROUPS_LIGHT_GROUPS) ? volume_light_group(s, &v) : 0u;
    add_light(b, params, i, clamp_light(params, r.emitted, path_bounce(p) - 1), seen_from(p, GROUP_emission, light_group));
  }
  int crosses = crosses_boundary(s, &r.path, r.hit, &v, features);
  store_path(columns.reals, columns.uints, CAPACITY, i, r.path);
  store_hit(b, i, r.hit);
  keep_volumes(b, p, v);
  return crosses;
}

/* Takes all living paths to a surface, or to where a volume scatters them. */
static void travel_batch(Batch &b, Scene s, Params params) {
  PathRays rays{b, params, b.columns()};
  uint count = 0;
  for (uint i = 0; i < b.count; i++) {
    b.order[count] = i;
    count += b.alive[i] && !is_inside(path_at(b.columns(), i));
  }
  while (count > 0) {
    uint left = 0;
    for (uint i = 0; i < count; i++) {
      uint at = b.order[i];
      b.order[left] = at;
      left += travel_path(b, s, params, at) != 0;
    }
    b.closest += left;
    trace_all(s, rays, left, 0);
    count = left;
  }
}

/* Paths that are scattered by volumes. What their phase functions say is asked for once, towards the light and along the
 * new direction, which waits in columns of surfaces meanwhile. */
static void shade_volumes(Batch &__restrict b, Scene s, Params params, Group g) {
  Columns columns = b.columns();
  bool lit = s.world[0].light_count > 0;
  for (uint i = g.first; i < g.end; i++) {
    Path p = path_at(columns, i);
    store_surface(b, i, volume_vertex(p, load_hit(b, i)));
    show_volume(b.slot_columns.data(), CAPACITY, p, params.groups);
    b.light_fine[i] = sample_bounce(p.seed, p.index, path_vertex(p), PAIR_CHOICE).x;
  }
  if (lit) draw_group_lights(b, s, params, MATERIAL_TRANSMITS, g);
  for (uint i = g.first; i < g.end; i++) {
    Path p = path_at(columns, i);
    Volumes v = volumes_of(b, p);
    Lobes lobes;
    find_lobes(s, &v, track_of_path(p), b.hit_t[i], &lobes, b.shadow_registers.data());
    real3 before = make_real3(p.dx, p.dy, p.dz);
    if (lit) {
      LightSample light;
      light.direction = make_real3(b.ldx[i], b.ldy[i], b.ldz[i]);
      light.hidden = b.light_hidden[i];
      BsdfValue towards = phases_towards(&lobes, before, light);
      b.fr[i] = towards.f.x;
      b.fg[i] = towards.f.y;
      b.fb[i] = towards.f.z;
      b.pdf[i] = towards.pdf;
    }
    int vertex = path_vertex(p);
    real u_choice = sample_bounce(p.seed, p.index, vertex, PAIR_CHOICE).y;
    real3 direction = sample_phases(&lobes, before, u_choice, sample_bounce(p.seed, p.index, vertex, PAIR_BSDF));
    BsdfValue along = eval_phases(&lobes, before, direction);
    b.wix[i] = direction.x;
    b.wiy[i] = direction.y;
    b.wiz[i] = direction.z;
    b.sr[i] = along.f.x;
    b.sg[i] = along.f.y;
    b.sb[i] = along.f.z;
    b.total[i] = along.pdf;
  }
  if (lit) connect_group(b, s, params, g);
  for (uint i = g.first; i < g.end; i++) {
    Path p = path_at(columns, i);
    if (s.world[0].features & FEATURE_LINKING) note_set(b, s, params, p, load_hit(b, i));
    BsdfValue along = make_value(make_real3(b.sr[i], b.sg[i], b.sb[i]), b.total[i]);
    Scattered r = scatter_in_volume(params, load_surface(b, i, g.material), p, make_real3(b.wix[i], b.wiy[i], b.wiz[i]), along,
                                    sample_bounce(p.seed, p.index, path_vertex(p), PAIR_ROULETTE).x);
    store_path(columns.reals, columns.uints, CAPACITY, i, r.path);
    b.alive[i] = uint(r.alive);
  }
}

/* The group's paths have been shaded at surfaces of material m: which volumes they are in now. */
static void cross_surfaces(Batch &b, Material m, Group g) {
  if (m.volume == NONE) return;
  for (uint i = g.first; i < g.end; i++) {
    Path p = path_at(b.columns(), i);
    if (!b.alive[i] || is_inside(p)) continue;
    Volumes v = volumes_of(b, p);
    cross_towards(&v, m, load_hit(b, i), load_surface(b, i, g.material), make_real3(p.dx, p.dy, p.dz));
    keep_volumes(b, p, v);
  }
}

}  // namespace ISOPHOTE_VARIANT
}  // namespace isophote
