/* The loops that shade a group of paths of one material, one instruction at a time. Included once a
 * variant. Values and arithmetic are those of kernels/stages.h; only the order of loops is here. */
#pragma once
#include "volume_loops.h"

namespace isophote {
namespace ISOPHOTE_VARIANT {

static void make_backgrounds(Batch &__restrict b, Scene s, Group g) {
  Columns columns = b.columns();
  FOR_PATHS(i, g.first, g.end) {
    Path p = path_at(columns, i);
    store_surface(b, i, make_background(s, make_real3(p.dx, p.dy, p.dz)));
    b.hit_instance[i] = background_hit(p.t_max).instance;
  }
}

static void shade_misses(Batch &__restrict b, Scene s, Params params, Group g) {
  if (s.world[0].features & FEATURE_WORLD) {
    make_backgrounds(b, s, g);
    run_values(b, s, s.materials[s.world[0].material], g);
  }
  Columns columns = b.columns();
  for (uint i = g.first; i < g.end; i++) {
    Path p = path_at(columns, i);
    add_light(b, params, i, see_world(s, params, p, last_set_of(b, s, params, p), registers_at(b, i)), seen_from(p, GROUP_environment, s.world[0].light_group));
    lose_alpha(b, params, p.slot, lost_alpha(params.film_transparent, p));
    b.alive[i] = 0;
  }
}

template <uint FEATURES>
static void make_surfaces(Batch &__restrict b, Scene s, Group g) {
  Columns columns = b.columns();
  FOR_PATHS(i, g.first, g.end) {
    Surface at = make_surface(s, path_ray(path_at(columns, i)), load_hit(b, i), FEATURES);
    store_surface(b, i, at);
  }
}

/* Those on what moves once more, where it is at their paths' times: one by one, so that other scenes' loop stays as it
 * is. */
static void make_moving_surfaces(Batch &__restrict b, Scene s, Group g) {
  Columns columns = b.columns();
  uint features = s.world[0].features;
  for (uint i = g.first; i < g.end; i++) {
    Hit h = load_hit(b, i);
    if (is_moving(s, h.instance, features))
      store_surface(b, i, make_surface(s, path_ray(path_at(columns, i)), h, features));
  }
}

static void shade_emission(Batch &__restrict b, Scene s, Params params, Material m, Group g) {
  Columns columns = b.columns();
  for (uint i = g.first; i < g.end; i++) {
    Path p = path_at(columns, i);
    Hit h = load_hit(b, i);
    uint light_group = has_any(params.groups, GROUPS_LIGHT_GROUPS) ? object_light_group(s, h) : 0u;
    Brought seen = see_emission(s, params, m, p, last_set_of(b, s, params, p), h, registers_at(b, i));
    add_light(b, params, i, seen, seen_from(p, GROUP_emission, light_group));
  }
}

FN Choice load_choice(const Batch &b, uint i) {
  Choice c;
  c.layer = make_real3(b.layer_r[i], b.layer_g[i], b.layer_b[i]);
  c.total = b.total[i];
  c.u = b.choice_u[i];
  c.chosen = b.chosen[i];
  c.share = b.chosen_share[i];
  return c;
}

FN void store_choice(Batch &__restrict b, uint i, Choice c) {
  b.layer_r[i] = c.layer.x;
  b.layer_g[i] = c.layer.y;
  b.layer_b[i] = c.layer.z;
  b.total[i] = c.total;
  b.choice_u[i] = c.u;
  b.chosen[i] = c.chosen;
  b.chosen_share[i] = c.share;
}

static void start_choice(Batch &__restrict b, Group g) {
  Columns columns = b.columns();
  FOR_PATHS(i, g.first, g.end) {
    Path p = path_at(columns, i);
    real2 u = sample_bounce(p.seed, p.index, path_vertex(p), PAIR_CHOICE);
    store_choice(b, i, make_choice(u.y));
    b.light_fine[i] = u.x;
  }
}

/* An instruction for a whole group: where its closure's parameters and its frame come from. */
struct Bound {
  Instruction i;
  const real *nx, *ny, *nz; /* columns of the normal */
  const real *tx, *ty, *tz; /* and of the tangent; nullptr: none */
};

static Bound bind_instruction(const Batch &b, Instruction i) {
  Bound bound{i, b.nsx, b.nsy, b.nsz, nullptr, nullptr, nullptr};
  auto column = [&](uint number) { return b.registers.data() + number * CAPACITY; };
  if (!has_own_frame(i)) return bound;
  uint normal = INSTRUCTION_NORMAL(i.flags), tangent = INSTRUCTION_TANGENT(i.flags);
  bound.nx = column(normal);
  bound.ny = column(normal + 1);
  bound.nz = column(normal + 2);
  if (tangent) {
    bound.tx = column(tangent - 1);
    bound.ty = column(tangent);
    bound.tz = column(tangent + 1);
  }
  return bound;
}

template <bool VARIES>
FN Closure closure_at(const Batch &b, const Bound &c, const real *registers, uint n) {
  return VARIES ? bind_closure(c.i, registers + n) : make_closure(c.i);
}
template <bool VARIES>
FN Frame frame_at(const Batch &b, const Bound &c, uint n) {
  if (!VARIES) return make_frame(shading_normal(b, n));
  real3 normal = make_real3(c.nx[n], c.ny[n], c.nz[n]);
  return c.tx ? make_frame_along(normal, make_real3(c.tx[n], c.ty[n], c.tz[n])) : make_frame(normal);
}

/* The loops below run one instruction; CLOSURES and LAYERS expand each into a loop of its own, once for constant
 * parameters and once for those that vary. */
#define CLOSURE_LOOPS(number, name, class_)                                                              \
  template <bool VARIES>                                                                                 \
  static void consider_##name(Batch &__restrict b, Group g, Bound c, uint k, const float *tables) {      \
    Columns columns = b.columns();                                                                       \
    const real *registers = b.registers.data();                                                          \
    FOR_PATHS(i, g.first, g.end) {                                                                       \
      Closure one = closure_at<VARIES>(b, c, registers, i);                                              \
      Frame frame = frame_at<VARIES>(b, c, i);                                                           \
      real3 albedo = albedo_##name(one, b.backfacing[i], tables, local_wo(columns, frame, i));           \
      Choice choice = load_choice(b, i);                                                                 \
      real3 weight = closure_weight(one, choice);                                                        \
      real share = closure_share(weight, albedo);                                                        \
      store_choice(b, i, consider(choice, int(k), share));                                               \
      b.weight_r[k][i] = weight.x;                                                                       \
      b.weight_g[k][i] = weight.y;                                                                       \
      b.weight_b[k][i] = weight.z;                                                                       \
      b.share[k][i] = share;                                                                             \
    }                                                                                                    \
  }                                                                                                      \
  template <bool VARIES>                                                                                 \
  static void evaluate_##name(Batch &__restrict b, Group g, Bound c, uint k, const float *tables,        \
                              const real *dx, const real *dy, const real *dz,                            \
                              const real *wr, const real *wg, const real *wb) {                          \
    Columns columns = b.columns();                                                                       \
    const real *registers = b.registers.data();                                                          \
    FOR_PATHS(i, g.first, g.end) {                                                                       \
      Closure closure = closure_at<VARIES>(b, c, registers, i);                                          \
      Frame frame = frame_at<VARIES>(b, c, i);                                                           \
      real3 direction = make_real3(dx[i], dy[i], dz[i]);                                                 \
      real3 wi = to_local(frame, direction);                                                             \
      BsdfValue one = eval_##name(closure, b.backfacing[i], tables, local_wo(columns, frame, i), wi);    \
      if (VARIES) one = one_sided_closure(make_real3(b.ngx[i], b.ngy[i], b.ngz[i]), direction, wi, one); \
      if (VARIES && ((class_) & LABEL_DIFFUSE) && (c.i.flags & INSTRUCTION_SOFTENED))                    \
        one = soften_bump(shading_normal(b, i), frame.z, direction, one);                                \
      BsdfValue sum = make_value(make_real3(b.fr[i], b.fg[i], b.fb[i]), b.pdf[i]);                        \
      real3 weight = make_real3(wr[i], wg[i], wb[i]);                                                    \
      sum = add_closure(sum, one, weight, b.share[k][i], b.total[i]);                                    \
      b.fr[i] = sum.f.x;                                                                                 \
      b.fg[i] = sum.f.y;                                                                                 \
      b.fb[i] = sum.f.z;                                                                                 \
      b.pdf[i] = sum.pdf;                                                                                \
    }                                                                                                    \
  }                                                                                                      \
  template <bool VARIES>                                                                                 \
  static void sample_all_##name(Batch &__restrict b, Group g, Bound c, uint k, const float *tables) {    \
    Columns columns = b.columns();                                                                       \
    const real *registers = b.registers.data();                                                          \
    FOR_PATHS(i, g.first, g.end) {                                                                       \
      Path p = path_at(columns, i);                                                                      \
      Closure closure = closure_at<VARIES>(b, c, registers, i);                                          \
      Frame frame = frame_at<VARIES>(b, c, i);                                                           \
      real2 u = sample_bounce(p.seed, p.index, path_vertex(p), PAIR_BSDF);                               \
      real3 wo = local_wo(columns, frame, i);                                                            \
      BsdfSample one = sample_##name(closure, b.backfacing[i], tables, wo, b.choice_u[i], u);            \
      real3 wi = to_world(frame, one.wi);                                                                \
      int mine = b.chosen[i] == int(k);                                                                  \
      b.wix[i] = mine ? wi.x : b.wix[i];                                                                 \
      b.wiy[i] = mine ? wi.y : b.wiy[i];                                                                 \
      b.wiz[i] = mine ? wi.z : b.wiz[i];                                                                 \
      b.height[i] = mine ? one.wi.z : b.height[i];                                                       \
      b.sr[i] = mine ? one.f.x : b.sr[i];                                                                \
      b.sg[i] = mine ? one.f.y : b.sg[i];                                                                \
      b.sb[i] = mine ? one.f.z : b.sb[i];                                                                \
      b.delta[i] = mine ? one.delta : b.delta[i];                                                        \
      b.label[i] = mine ? one.label : b.label[i];                                                        \
      b.valid[i] = mine ? one.valid : b.valid[i];                                                        \
    }                                                                                                    \
  }
CLOSURES(CLOSURE_LOOPS)
#undef CLOSURE_LOOPS

#define LAYER_LOOPS(number, name)                                                                        \
  template <bool VARIES>                                                                                 \
  static void apply_##name(Batch &__restrict b, Group g, Bound c, const float *tables) {                 \
    Columns columns = b.columns();                                                                       \
    const real *registers = b.registers.data();                                                          \
    FOR_PATHS(i, g.first, g.end) {                                                                       \
      Closure closure = closure_at<VARIES>(b, c, registers, i);                                          \
      Frame frame = frame_at<VARIES>(b, c, i);                                                           \
      real3 layer = make_real3(b.layer_r[i], b.layer_g[i], b.layer_b[i]);                                \
      layer = layer_##name(closure, b.backfacing[i], tables, local_wo(columns, frame, i), layer);        \
      b.layer_r[i] = layer.x;                                                                            \
      b.layer_g[i] = layer.y;                                                                            \
      b.layer_b[i] = layer.z;                                                                            \
    }                                                                                                    \
  }
LAYERS(LAYER_LOOPS)
#undef LAYER_LOOPS

/* Calls one of an instruction's two loops. */
#define RUN(loop, ...) \
  if (c.i.flags & INSTRUCTION_VARIES) loop<true>(__VA_ARGS__); \
  else loop<false>(__VA_ARGS__)

static Bound bind_met(const Batch &b, Scene s, Material m, Group g, uint k) {
  return bind_instruction(b, met_instruction(s.instructions[m.first + k], g.meeting == MEETS_DIFFUSE));
}

static void choose_closures(Batch &__restrict b, Scene s, Material m, Group g) {
  start_choice(b, g);
  for (uint k = 0; k < m.count; k++) {
    Bound c = bind_met(b, s, m, g, k);
    switch (c.i.op) {
#define X(number, name, class_) \
  case number: RUN(consider_##name, b, g, c, k, s.albedo_tables); break;
      CLOSURES(X)
#undef X
#define X(number, name) \
  case number: RUN(apply_##name, b, g, c, s.albedo_tables); break;
      LAYERS(X)
#undef X
    }
  }
}

/* Value of the whole BSDF of the group towards the given world directions, into fr, fg, fb and pdf; where `split` also
 * its parts. `limited`: they are those of lights some of which are hidden from kinds of rays. */
static void evaluate_closures(Batch &__restrict b, Scene s, Material m, Group g, const real *dx, const real *dy, const real *dz,
                              bool limited, bool split) {
  for (real *column : {b.fr, b.fg, b.fb, b.pdf}) std::fill(column + g.first, column + g.end, REAL(0.0));
  if (split)
    for (real *column : {b.diffuse_r, b.diffuse_g, b.diffuse_b, b.glossy_r, b.glossy_g, b.glossy_b})
      std::fill(column + g.first, column + g.end, REAL(0.0));
  for (uint k = 0; k < m.count; k++) {
    Bound c = bind_met(b, s, m, g, k);
    if (!is_closure(c.i.op)) continue;
    if (split) keep_value(b, g);
    if (limited) find_seen_weights(b, g, c.i.op, k);
    const real *wr = limited ? b.seen_r : b.weight_r[k], *wg = limited ? b.seen_g : b.weight_g[k];
    const real *wb = limited ? b.seen_b : b.weight_b[k];
    switch (c.i.op) {
#define X(number, name, class_) \
  case number: RUN(evaluate_##name, b, g, c, k, s.albedo_tables, dx, dy, dz, wr, wg, wb); break;
      CLOSURES(X)
#undef X
    }
    if (split) add_parts(b, g, is_diffuse(c.i.op), c.nx, c.ny, c.nz, dx, dy, dz);
  }
  if (m.flags & MATERIAL_BUMPS) return; /* each closure was one-sided */
  FOR_PATHS(i, g.first, g.end) {
    BsdfValue v = make_value(make_real3(b.fr[i], b.fg[i], b.fb[i]), b.pdf[i]);
    v = one_sided(load_surface(b, i, g.material), make_real3(dx[i], dy[i], dz[i]), v);
    b.fr[i] = v.f.x;
    b.fg[i] = v.f.y;
    b.fb[i] = v.f.z;
    b.pdf[i] = v.pdf;
  }
}

static void sample_closures(Batch &__restrict b, Scene s, Material m, Group g) {
  for (real *column : {b.wix, b.wiy, b.wiz, b.height, b.sr, b.sg, b.sb}) std::fill(column + g.first, column + g.end, REAL(0.0));
  for (int *column : {b.delta, b.label, b.valid}) std::fill(column + g.first, column + g.end, 0);
  for (uint k = 0; k < m.count; k++) {
    Bound c = bind_met(b, s, m, g, k);
    switch (c.i.op) {
#define X(number, name, class_) \
  case number: RUN(sample_all_##name, b, g, c, k, s.albedo_tables); break;
      CLOSURES(X)
#undef X
    }
  }
  FOR_PATHS(i, g.first, g.end) {
    real3 wi = make_real3(b.wix[i], b.wiy[i], b.wiz[i]);
    b.valid[i] = one_sided_sample(load_surface(b, i, g.material), wi, load_sample(b, i)).valid;
  }
}

static void scatter_paths(Batch &__restrict b, Params params, Material m, Group g) {
  Columns columns = b.columns();
  FOR_PATHS(i, g.first, g.end) {
    Path p = path_at(columns, i);
    Choice choice = load_choice(b, i);
    uint k = uint(max_int(choice.chosen, 0));
    BsdfValue value = make_value(make_real3(b.fr[i], b.fg[i], b.fb[i]), b.pdf[i]);
    real u = sample_bounce(p.seed, p.index, path_vertex(p), PAIR_ROULETTE).x;
    Scattered r = scatter_path(params, load_surface(b, i, g.material), m.flags, p, load_hit(b, i), load_sample(b, i),
                               make_real3(b.wix[i], b.wiy[i], b.wiz[i]),
                               make_real3(b.weight_r[k][i], b.weight_g[k][i], b.weight_b[k][i]), choice, value, u);
    store_path(columns.reals, columns.uints, CAPACITY, i, r.path);
    b.alive[i] = uint(r.alive);
  }
}

/* Paths whose last bounce lies behind them go on through transparent surfaces only. */
static void pass_last(Batch &__restrict b, Params params, Material m, Group g) {
  Columns columns = b.columns();
  for (uint i = g.first; i < g.end; i++) {
    count_limits(b, ending_limits(params, m, path_at(columns, i)));
    Scattered r = pass_transparent(params, m, path_at(columns, i), load_hit(b, i), registers_at(b, i));
    store_path(columns.reals, columns.uints, CAPACITY, i, r.path);
    b.alive[i] = uint(r.alive);
  }
}

static void shade_holdouts(Batch &__restrict b, Scene s, Params params, Material m, Group g) {
  Columns columns = b.columns();
  for (uint i = g.first; i < g.end; i++) {
    Path p = path_at(columns, i);
    lose_alpha(b, params, p.slot, held_alpha(s, m, p, registers_at(b, i)));
  }
}

template <uint FEATURES>
static void shade_group(Batch &__restrict b, Scene s, Params params, Group g) {
  Material m = met_material(s.materials[g.material], g.meeting == MEETS_DIFFUSE);
  if (g.meeting == COMES_OUT) m = exit_material(s, m);
  if (catches(params)) meet_catchers(b, s, params, g);
  make_surfaces<FEATURES>(b, s, g);
  if (s.world[0].features & FEATURE_MOTION) make_moving_surfaces(b, s, g);
  run_values(b, s, m, g);
  if (m.flags & MATERIAL_EMITS) shade_emission(b, s, params, m, g);
  if (!is_alone(params)) {
    if (has_any(params.groups, GROUPS_SURFACE)) show_surfaces(b, s, params, m, g);
    if (has_group(params.groups, GROUP_ambient_occlusion)) show_occlusions(b, s, params, m, g);
  }
  if (m.flags & MATERIAL_HOLDS_OUT) shade_holdouts(b, s, params, m, g);
  bool in_volumes = s.world[0].features & FEATURE_VOLUME;
  if (g.meeting == LAST) {
    pass_last(b, params, m, g);
    if (in_volumes) cross_surfaces(b, m, g);
    return;
  }
  choose_closures(b, s, m, g);
  bool split = has_any(params.groups, GROUPS_SPLIT) && any_begins(b, g);
  bool lit = s.world[0].light_count > 0 && !(m.flags & MATERIAL_DELTA_ONLY);
  if (lit) {
    uint features = s.world[0].features;
    draw_group_lights(b, s, params, m.flags, g);
    if (features & FEATURE_TERMINATOR) turn_to_lights(b, s, g);
    evaluate_closures(b, s, m, g, b.ldx, b.ldy, b.ldz, features & FEATURE_LIGHT_LIMITS, split);
    if (features & FEATURE_TERMINATOR) turn_back(b, g);
    if (split) note_light_shares(b, params, g);
    connect_group(b, s, params, g);
  }
  sample_closures(b, s, m, g);
  evaluate_closures(b, s, m, g, b.wix, b.wiy, b.wiz, false, split);
  if (split) note_path_shares(b, params, g);
  if (s.world[0].features & FEATURE_LINKING) note_sets(b, s, params, g);
  scatter_paths(b, params, m, g);
  if (in_volumes) cross_surfaces(b, m, g);
}

static void shade_batch(Batch &__restrict b, Scene s, Params params, const std::vector<Group> &groups) {
  uint features = s.world[0].features;
  if (features & FEATURE_VOLUME) {} /* paths have seen lamps on their way through volumes */
  else if (features & RARE) shade_lamps<RARE>(b, s, params);
  else shade_lamps<0>(b, s, params);
  for (Group g : groups) {
    if (g.material == MISS)
      shade_misses(b, s, params, g);
    else if (g.material == SCATTERED_BY_VOLUMES)
      shade_volumes(b, s, params, g);
    else if (features & (FEATURE_INSTANCES | FEATURE_SPHERES))
      shade_group<FEATURE_INSTANCES | FEATURE_SPHERES | FEATURE_SMOOTH>(b, s, params, g);
    else if (features & FEATURE_SMOOTH)
      shade_group<FEATURE_SMOOTH>(b, s, params, g);
    else
      shade_group<0>(b, s, params, g);
  }
}

}  // namespace ISOPHOTE_VARIANT
}  // namespace isophote
