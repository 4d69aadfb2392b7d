/* The loops that fill planes beside Combined's (kernels/passes.h). Included once a variant. */
#pragma once
#include "../kernels/occlusion.h"
#include "value_loops.h"

namespace isophote {
namespace ISOPHOTE_VARIANT {

/* Whether some path has not been scattered yet: behind that nothing is told apart. */
static bool any_begins(Batch &b, Group g) {
  const uint *bounces = b.columns().uints + PATH_UINT_bounces * CAPACITY;
  return std::any_of(bounces + g.first, bounces + g.end, [](uint n) { return !(n & 255u); });
}

static void keep_value(Batch &__restrict b, Group g) {
  std::copy(b.fr + g.first, b.fr + g.end, b.before_r + g.first);
  std::copy(b.fg + g.first, b.fg + g.end, b.before_g + g.first);
  std::copy(b.fb + g.first, b.fb + g.end, b.before_b + g.first);
}

FN Shares load_parts(const Batch &b, uint i) {
  Shares parts;
  parts.diffuse = make_real3(b.diffuse_r[i], b.diffuse_g[i], b.diffuse_b[i]);
  parts.glossy = make_real3(b.glossy_r[i], b.glossy_g[i], b.glossy_b[i]);
  return parts;
}

/* What a closure of normal n has added since keep_value to the BSDF in direction d. */
static void add_parts(Batch &__restrict b, Group g, int diffuse, const real *nx, const real *ny, const real *nz,
                      const real *dx, const real *dy, const real *dz) {
  FOR_PATHS(i, g.first, g.end) {
    real cosine = dot3(make_real3(nx[i], ny[i], nz[i]), make_real3(dx[i], dy[i], dz[i]));
    Shares parts = add_part(load_parts(b, i), make_real3(b.before_r[i], b.before_g[i], b.before_b[i]),
                            make_real3(b.fr[i], b.fg[i], b.fb[i]), diffuse, cosine);
    b.diffuse_r[i] = parts.diffuse.x;
    b.diffuse_g[i] = parts.diffuse.y;
    b.diffuse_b[i] = parts.diffuse.z;
    b.glossy_r[i] = parts.glossy.x;
    b.glossy_g[i] = parts.glossy.y;
    b.glossy_b[i] = parts.glossy.z;
  }
}

/* Of the sampled direction only the height over the closure's horizon is asked for in its frame. */
FN BsdfSample load_sample(const Batch &b, uint i) {
  return make_sample(make_real3(REAL(0.0), REAL(0.0), b.height[i]), make_real3(b.sr[i], b.sg[i], b.sb[i]), b.delta[i],
                     b.label[i], b.valid[i]);
}

static void meet_catchers(Batch &__restrict b, Scene s, Params params, Group g) {
  Columns columns = b.columns();
  for (uint i = g.first; i < g.end; i++) {
    Path p = path_at(columns, i);
    Hit h = load_hit(b, i);
    if ((s.world[0].features & FEATURE_VOLUME) && is_alone(params) && is_being_caught(s, params, p, h)) {
      Volumes v;
      load_volumes(b.volumes.data(), CAPACITY, p.slot, &v);
      keep_those_of_catchers(s, &v);
      store_volumes(b.volumes.data(), CAPACITY, p.slot, &v);
    }
    columns.uints[PATH_UINT_status * CAPACITY + i] = meet_catcher(b.slot_columns.data(), CAPACITY, s, params, p, h).status;
  }
}

static void show_surfaces(Batch &__restrict b, Scene s, Params params, Material m, Group g) {
  Columns columns = b.columns();
  for (uint i = g.first; i < g.end; i++)
    show_surface(b.slot_columns.data(), CAPACITY, params.groups, s, m, load_surface(b, i, g.material), path_at(columns, i),
                 load_hit(b, i), registers_at(b, i));
}

/* Rays from surfaces that the camera sees to what is around them. */
static void show_occlusions(Batch &__restrict b, Scene s, Params params, Material m, Group g) {
  Columns columns = b.columns();
  uint count = 0;
  for (uint i = g.first; i < g.end; i++) {
    Path p = path_at(columns, i);
    Hit h = load_hit(b, i);
    if (!is_seen(p, h)) continue;
    Connection c = connect_surroundings(s, m, load_surface(b, i, g.material), p, h, registers_at(b, i));
    if (s.world[0].features & FEATURE_VOLUME) b.shadow_volumes[count] = volumes_from(b, s, g, p, i, c.ray);
    b.key[count] = p.slot;
    b.cr[count] = c.brought.light.x;
    b.cg[count] = c.brought.light.y;
    b.cb[count] = c.brought.light.z;
    b.shadows[count++] = make_shadow(c.ray, c.passed, c.bounces);
  }
  b.shadow += count;
  trace_shadows(b, s, params, count, s.world[0].features);
  for (uint i = 0; i < count; i++)
    show_occlusion(b.slot_columns.data(), CAPACITY, b.key[i], params.groups, make_real3(b.cr[i], b.cg[i], b.cb[i]), b.shadows[i]);
}

FN LightWalk load_walk(const Batch &b, uint i) {
  LightWalk w;
  w.at = b.walk_at[i];
  w.chance = b.walk_chance[i];
  w.u = b.walk_u[i];
  return w;
}

/* Light groups of the lights that walks have chosen. */
static void note_drawn_groups(Batch &__restrict b, Scene s, Params params, Group g) {
  Columns columns = b.columns();
  real *groups = b.slot_columns.data() + drawn_group_column(params) * CAPACITY;
  for (uint i = g.first; i < g.end; i++)
    groups[path_at(columns, i).slot] = real_of(drawn_light_group(s, load_walk(b, i)));
}

/* last_set, and where paths that are scattered get it. */
FN uint last_set_of(const Batch &b, Scene s, Params params, Path p) {
  return last_set(s, params, b.slot_columns.data(), CAPACITY, p.slot);
}
static void note_set(Batch &__restrict b, Scene s, Params params, Path p, Hit h) {
  b.slot_columns[link_column(params) * CAPACITY + p.slot] = real_of(receiver_set(s, h));
}
static void note_sets(Batch &__restrict b, Scene s, Params params, Group g) {
  for (uint i = g.first; i < g.end; i++)
    if (!(b.label[i] & LABEL_TRANSPARENT)) note_set(b, s, params, path_at(b.columns(), i), load_hit(b, i));
}

/* Of the light that comes to paths' first vertices. */
static void note_light_shares(Batch &__restrict b, Params params, Group g) {
  Columns columns = b.columns();
  for (uint i = g.first; i < g.end; i++) {
    Path p = path_at(columns, i);
    if (path_bounce(p) > 0) continue;
    Shares shares = make_shares(load_parts(b, i), make_real3(b.fr[i], b.fg[i], b.fb[i]));
    store_shares(b.slot_columns.data(), CAPACITY, p.slot, params.groups, SHARES_OF_LIGHT, shares);
  }
}
static void note_path_shares(Batch &__restrict b, Params params, Group g) {
  Columns columns = b.columns();
  for (uint i = g.first; i < g.end; i++) {
    Path p = path_at(columns, i);
    if (path_bounce(p) > 0) continue;
    Shares shares = path_shares(load_parts(b, i), make_real3(b.fr[i], b.fg[i], b.fb[i]), load_sample(b, i));
    store_shares(b.slot_columns.data(), CAPACITY, p.slot, params.groups, SHARES_OF_PATH, shares);
  }
}

}  // namespace ISOPHOTE_VARIANT
}  // namespace isophote
