/* The loops over a group's lights: what rays see of lamps, drawing lights, connections to them. Included once a
 * variant. */
#pragma once
#include "pass_loops.h"

namespace isophote {
namespace ISOPHOTE_VARIANT {

/* What few scenes' lights have: one loop for all of it. */
constexpr uint RARE = FEATURE_LAMP_SHAPES | FEATURE_LIGHT_LIMITS | FEATURE_LAMP_PROGRAMS;

template <uint FEATURES>
static void shade_lamps(Batch &__restrict b, Scene s, Params params) {
  Columns columns = b.columns();
  uint count = b.count;
  for (uint l = 0; l < s.world[0].lamp_count; l++) {
    Light lamp = s.lights[l];
    if (!(lamp.size_u > 0.0f)) continue;
    FOR_PATHS(i, 0, count) {
      LightHit seen = find_lamp(lamp, path_at(columns, i), load_hit(b, i), FEATURES);
      b.fr[i] = seen.radiance.x;
      b.fg[i] = seen.radiance.y;
      b.fb[i] = seen.radiance.z;
      b.light_pdf[i] = seen.pdf;
      b.distance[i] = seen.t;
      b.valid[i] = seen.hit;
    }
    for (uint i = 0; i < b.count; i++) {
      if (!b.valid[i]) continue;
      LightHit seen;
      seen.hit = 1;
      seen.radiance = make_real3(b.fr[i], b.fg[i], b.fb[i]);
      seen.pdf = b.light_pdf[i];
      seen.t = b.distance[i];
      Path p = path_at(columns, i);
      add_light(b, params, i, see_lamp(s, params, l, p, last_set_of(b, s, params, p), seen, b.shadow_registers.data()),
                seen_from(p, GROUP_emission, LIGHT_GROUP(lamp.flags)));
    }
  }
}

FN void store_walk(Batch &__restrict b, uint i, LightWalk w) {
  b.walk_at[i] = w.at;
  b.walk_chance[i] = w.chance;
  b.walk_u[i] = w.u;
}

/* All paths of the group go down the light tree together, a step a loop. LINKED: lights do not light all objects. */
template <bool LINKED>
static void choose_lights(Batch &__restrict b, Scene s, uint material_flags, Group g) {
  Columns columns = b.columns();
  FOR_PATHS(i, g.first, g.end) {
    Path p = path_at(columns, i);
    real2 u = sample_bounce(p.seed, p.index, path_vertex(p), PAIR_LIGHT);
    store_walk(b, i, start_walk(u.x));
    b.light_u[i] = u.y;
  }
  for (uint depth = 0; depth < s.world[0].light_depth; depth++) {
    FOR_PATHS(i, g.first, g.end) {
      Surface at = load_surface(b, i, g.material);
      Receiver receiver = make_receiver(at.p, receiver_normal(at, material_flags));
      if (LINKED) receiver.set = receiver_set(s, load_hit(b, i));
      store_walk(b, i, step_walk(s, load_walk(b, i), receiver));
    }
  }
}

FN void draw_light(Batch &__restrict b, Scene s, Columns columns, uint i, uint features) {
  Path path = path_at(columns, i);
  LightSample l = finish_light(s, load_walk(b, i), make_real3(b.px[i], b.py[i], b.pz[i]), b.light_u[i], b.light_fine[i],
                               (path.bounces & 255u) + 1u, path_time(path), features);
  b.ldx[i] = l.direction.x;
  b.ldy[i] = l.direction.y;
  b.ldz[i] = l.direction.z;
  b.distance[i] = l.distance;
  b.lr[i] = l.radiance.x;
  b.lg[i] = l.radiance.y;
  b.lb[i] = l.radiance.z;
  b.light_pdf[i] = l.pdf;
  b.can_be_hit[i] = l.can_be_hit;
  b.light_hidden[i] = l.hidden;
  b.light_instance[i] = l.instance;
  b.light_primitive[i] = l.primitive;
}

/* A function of its own: inlined, the loop does not vectorise everywhere. */
template <uint FEATURES>
FN_APART void draw_lights(Batch &__restrict b, Scene s, Group g) {
  Columns columns = b.columns();
  FOR_PATHS(i, g.first, g.end) draw_light(b, s, columns, i, FEATURES);
}

/* Once more those that are triangles on what moves, where they are at their paths' times. */
static void draw_moving_lights(Batch &__restrict b, Scene s, Group g) {
  Columns columns = b.columns();
  uint features = s.world[0].features;
  for (uint i = g.first; i < g.end; i++) {
    uint instance = b.light_instance[i];
    if (is_moving(s, instance, features)) draw_light(b, s, columns, i, features);
  }
}

/* Drops lights drawn that are not there. */
static void drop_away(Batch &__restrict b, Scene s, Params params, Group g) {
  for (uint i = g.first; i < g.end; i++) {
    LightSample l;
    l.instance = b.light_instance[i];
    l.primitive = b.light_primitive[i];
    if (is_away(s, params, l)) b.light_pdf[i] = REAL(0.0);
  }
}

/* The lights drawn as objects have them that are linked to some. */
static void link_samples(Batch &__restrict b, Scene s, Group g) {
  for (uint i = g.first; i < g.end; i++) {
    LightSample l;
    l.pdf = b.light_pdf[i];
    l.can_be_hit = b.can_be_hit[i];
    l.primitive = b.light_primitive[i];
    l = link_sample(s, l, b.walk_at[i] & ~CLUSTER_LIGHT, receiver_set(s, load_hit(b, i)));
    b.light_pdf[i] = l.pdf;
    b.can_be_hit[i] = l.can_be_hit;
    b.light_primitive[i] = l.primitive;
  }
}

/* The weights of closure k towards the lights drawn, 0 where these are hidden from the rays that it would send there. A
 * function of its own: inlined, the loop does not vectorise. */
FN_APART void find_seen_weights(Batch &__restrict b, Group g, int op, uint k) {
  uint before = kind_towards(op, 0), beyond = kind_towards(op, 1);
  FOR_PATHS(i, g.first, g.end) {
    real3 ng = make_real3(b.ngx[i], b.ngy[i], b.ngz[i]);
    int behind = dot3(ng, make_real3(b.ldx[i], b.ldy[i], b.ldz[i])) < REAL(0.0);
    int hidden = is_hidden(b.light_hidden[i], behind ? beyond : before);
    b.seen_r[i] = hidden ? REAL(0.0) : b.weight_r[k][i];
    b.seen_g[i] = hidden ? REAL(0.0) : b.weight_g[k][i];
    b.seen_b[i] = hidden ? REAL(0.0) : b.weight_b[k][i];
  }
}

template <bool CLAMPED>
static void connect_lights(Batch &__restrict b, Params params, Group g) {
  if (!CLAMPED) params.cut_plane = 0;
  Columns columns = b.columns();
  FOR_PATHS(i, g.first, g.end) {
    LightSample l;
    l.direction = make_real3(b.ldx[i], b.ldy[i], b.ldz[i]);
    l.distance = b.distance[i];
    l.radiance = make_real3(b.lr[i], b.lg[i], b.lb[i]);
    l.pdf = b.light_pdf[i];
    l.can_be_hit = b.can_be_hit[i];
    l.instance = b.light_instance[i];
    l.primitive = b.light_primitive[i];
    BsdfValue value = make_value(make_real3(b.fr[i], b.fg[i], b.fb[i]), b.pdf[i]);
    Connection c = connect_light(params, load_surface(b, i, g.material), l, value, path_at(columns, i));
    b.cox[i] = c.ray.origin.x;
    b.coy[i] = c.ray.origin.y;
    b.coz[i] = c.ray.origin.z;
    b.cr[i] = c.brought.light.x;
    b.cg[i] = c.brought.light.y;
    b.cb[i] = c.brought.light.z;
    if (CLAMPED) b.connection_cut[i] = c.brought.cut;
  }
}

/* Lets the group's surfaces have the normals that tell the sides of lights; the geometric ones wait in another column. */
static void turn_to_lights(Batch &__restrict b, Scene s, Group g) {
  FOR_PATHS(i, g.first, g.end) {
    real3 side = light_side(s, load_surface(b, i, g.material), b.hit_instance[i]);
    b.cox[i] = b.ngx[i];
    b.coy[i] = b.ngy[i];
    b.coz[i] = b.ngz[i];
    b.ngx[i] = side.x;
    b.ngy[i] = side.y;
    b.ngz[i] = side.z;
  }
}
static void turn_back(Batch &__restrict b, Group g) {
  FOR_PATHS(i, g.first, g.end) {
    b.ngx[i] = b.cox[i];
    b.ngy[i] = b.coy[i];
    b.ngz[i] = b.coz[i];
  }
}

/* Lifts the rays of the group's connections that bring light. */
static void lift_rays(Batch &__restrict b, Scene s, Group g) {
  Columns columns = b.columns();
  for (uint i = g.first; i < g.end; i++) {
    if (is_dark(make_real3(b.cr[i], b.cg[i], b.cb[i]))) continue;
    Ray ray = lifted_ray(s, load_surface(b, i, g.material), load_hit(b, i), light_ray(b, columns, i));
    b.cox[i] = ray.origin.x;
    b.coy[i] = ray.origin.y;
    b.coz[i] = ray.origin.z;
    b.ldx[i] = ray.direction.x;
    b.ldy[i] = ray.direction.y;
    b.ldz[i] = ray.direction.z;
    b.distance[i] = ray.t_max;
  }
}

/* Completes the group's connections where their lights' radiance is computed. */
static void shine_lights(Batch &__restrict b, Scene s, Params params, Group g) {
  Columns columns = b.columns();
  for (uint i = g.first; i < g.end; i++) {
    Connection c;
    c.brought.light = make_real3(b.cr[i], b.cg[i], b.cb[i]);
    if (is_dark(c.brought.light)) continue;
    Path p = path_at(columns, i);
    c.brought.indirect = path_bounce(p) > 0;
    c.passed = uint_of(path_passed(p));
    c.bounces = p.bounces;
    c.ray = light_ray(b, columns, i);
    c = shine(s, params, c, s.world[0].features, b.shadow_registers.data());
    b.cr[i] = c.brought.light.x;
    b.cg[i] = c.brought.light.y;
    b.cb[i] = c.brought.light.z;
    b.connection_cut[i] = c.brought.cut;
  }
}

/* Chooses and draws a light for each path of the group. */
static void draw_group_lights(Batch &__restrict b, Scene s, Params params, uint material_flags, Group g) {
  uint features = s.world[0].features;
  features & FEATURE_LINKING ? choose_lights<true>(b, s, material_flags, g) : choose_lights<false>(b, s, material_flags, g);
  if (has_any(params.groups, GROUPS_LIGHT_GROUPS)) note_drawn_groups(b, s, params, g);
  constexpr uint LAMPS = FEATURE_LAMPS | FEATURE_SHINES, WORLD = LAMPS | FEATURE_WORLD_LIGHT;
  constexpr uint SUN = WORLD | FEATURE_WORLD_SUN;
  bool rare = features & RARE;
  if (features & FEATURE_WORLD_SUN) rare ? draw_lights<SUN | RARE>(b, s, g) : draw_lights<SUN>(b, s, g);
  else if (features & FEATURE_WORLD_LIGHT) rare ? draw_lights<WORLD | RARE>(b, s, g) : draw_lights<WORLD>(b, s, g);
  else if (rare) draw_lights<LAMPS | RARE>(b, s, g);
  else if (features & FEATURE_SHINES) draw_lights<LAMPS>(b, s, g);
  else if (s.world[0].lamp_count) draw_lights<FEATURE_LAMPS>(b, s, g);
  else draw_lights<0>(b, s, g);
  if (features & FEATURE_MOTION) draw_moving_lights(b, s, g);
  if (is_alone(params)) drop_away(b, s, params, g);
  if (features & FEATURE_LINKING) link_samples(b, s, g);
}

/* Adds the light of the lights drawn, once the group's values towards them are known. */
static void connect_group(Batch &__restrict b, Scene s, Params params, Group g) {
  uint features = s.world[0].features;
  if (params.cut_plane && !(features & FEATURE_SHINES)) connect_lights<true>(b, params, g);
  else connect_lights<false>(b, params, g);
  if ((features & FEATURE_TERMINATOR) && g.material != SCATTERED_BY_VOLUMES) lift_rays(b, s, g);
  if (features & FEATURE_SHINES) shine_lights(b, s, params, g);
  connect_batch(b, s, params, g, features);
}

}  // namespace ISOPHOTE_VARIANT
}  // namespace isophote
