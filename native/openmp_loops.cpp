/* The OpenMP device: a wavefront of some hundred paths a thread.
 *
 * Each thread owns a batch of paths in structures of arrays and runs the stages of kernels/stages.h
 * over it. Before shading, paths are sorted by material, so that every loop over paths runs one
 * instruction of one material: its constants are the same for all paths of the loop, which therefore
 * vectorises. Compiled once for each precision and instruction set, as ISOPHOTE_VARIANT. */
#include <omp.h>
#if defined(__SSE__)
#include <immintrin.h>
#endif

#include <algorithm>
#include <memory>
#include <numeric>
#include <vector>

#include "render.h"
#include "../kernels/stages.h"

namespace isophote {
namespace ISOPHOTE_VARIANT {

constexpr uint CAPACITY = 1024;
constexpr uint MISS = NONE;

/* Hosts set flush-to-zero in their threads; bits must not depend on it (MXCSR on x86). */
struct FlushGuard {
#if defined(__SSE__)
  unsigned before = _mm_getcsr();
  FlushGuard() { _mm_setcsr(before & ~0x8040u); }
  ~FlushGuard() { _mm_setcsr(before); }
#endif
};

/* The path columns that are being read, fetched before a loop so that the loop sees plain arrays. */
struct Columns {
  real *reals;
  uint *uints;
};

/* Scratch memory of one thread; every array is a column of CAPACITY values. */
struct Batch {
  alignas(64) real path_reals[2][PATH_REAL_COUNT * CAPACITY];
  alignas(64) uint path_uints[2][PATH_UINT_COUNT * CAPACITY];
  alignas(64) real hit_t[CAPACITY], hit_u[CAPACITY], hit_v[CAPACITY];
  alignas(64) uint hit_instance[CAPACITY], hit_primitive[CAPACITY], hit_index[CAPACITY];
  alignas(64) uint key[CAPACITY], order[CAPACITY], alive[CAPACITY];
  /* surfaces */
  alignas(64) real px[CAPACITY], py[CAPACITY], pz[CAPACITY], offset[CAPACITY];
  alignas(64) real ngx[CAPACITY], ngy[CAPACITY], ngz[CAPACITY], nsx[CAPACITY], nsy[CAPACITY], nsz[CAPACITY];
  alignas(64) int backfacing[CAPACITY];
  /* light samples */
  alignas(64) real ldx[CAPACITY], ldy[CAPACITY], ldz[CAPACITY], distance[CAPACITY], light_pdf[CAPACITY];
  alignas(64) real lr[CAPACITY], lg[CAPACITY], lb[CAPACITY];
  alignas(64) int can_be_hit[CAPACITY];
  alignas(64) uint light_instance[CAPACITY], light_primitive[CAPACITY];
  /* choice of a closure; weights and shares of each closure */
  alignas(64) real layer_r[CAPACITY], layer_g[CAPACITY], layer_b[CAPACITY];
  alignas(64) real total[CAPACITY], choice_u[CAPACITY], chosen_share[CAPACITY];
  alignas(64) int chosen[CAPACITY];
  alignas(64) real weight_r[MAX_CLOSURES][CAPACITY], weight_g[MAX_CLOSURES][CAPACITY], weight_b[MAX_CLOSURES][CAPACITY];
  alignas(64) real share[MAX_CLOSURES][CAPACITY];
  /* value of the BSDF towards the light or the next direction */
  alignas(64) real fr[CAPACITY], fg[CAPACITY], fb[CAPACITY], pdf[CAPACITY];
  /* sampled direction, in the world and in the frame */
  alignas(64) real wix[CAPACITY], wiy[CAPACITY], wiz[CAPACITY], lix[CAPACITY], liy[CAPACITY], liz[CAPACITY];
  alignas(64) real sr[CAPACITY], sg[CAPACITY], sb[CAPACITY];
  alignas(64) int delta[CAPACITY], label[CAPACITY], valid[CAPACITY];
  /* connections */
  alignas(64) real cox[CAPACITY], coy[CAPACITY], coz[CAPACITY], cr[CAPACITY], cg[CAPACITY], cb[CAPACITY];
  /* results by slot */
  alignas(64) real red[CAPACITY], green[CAPACITY], blue[CAPACITY], alpha[CAPACITY];
  alignas(64) real aov[PLANES_ALL - PLANES_COMBINED][CAPACITY];

  uint current = 0; /* which of the two halves of the path arrays is read */
  uint count = 0;
  std::vector<uint> bins;

  Columns columns() { return {path_reals[current], path_uints[current]}; }
};

/* Paths of one material, all of which scatter, or all of which have had their last bounce. */
struct Group {
  uint material;
  bool last;
  uint first, end;
};

FN Hit load_hit(const Batch &b, uint i) {
  Hit h;
  h.t = b.hit_t[i];
  h.u = b.hit_u[i];
  h.v = b.hit_v[i];
  h.instance = b.hit_instance[i];
  h.primitive = b.hit_primitive[i];
  h.index = b.hit_index[i];
  return h;
}

FN Surface load_surface(const Batch &b, uint i, uint material) {
  Surface s;
  s.p = make_real3(b.px[i], b.py[i], b.pz[i]);
  s.offset = b.offset[i];
  s.ng = make_real3(b.ngx[i], b.ngy[i], b.ngz[i]);
  s.ns = make_real3(b.nsx[i], b.nsy[i], b.nsz[i]);
  s.backfacing = b.backfacing[i];
  s.material = material;
  return s;
}

FN real3 shading_normal(const Batch &b, uint i) { return make_real3(b.nsx[i], b.nsy[i], b.nsz[i]); }


FN Path path_at(Columns c, uint i) { return load_path(c.reals, c.uints, CAPACITY, i); }
FN real3 local_wo(Columns c, Frame frame, uint i) {
  return to_local(frame, make_real3(-c.reals[PATH_REAL_dx * CAPACITY + i], -c.reals[PATH_REAL_dy * CAPACITY + i],
                                    -c.reals[PATH_REAL_dz * CAPACITY + i]));
}

/* The loop over the paths [first, end) of a group. Each path is on its own: nothing aliases. */
#define FOR_PATHS(i, first, end) _Pragma("omp simd") for (uint i = (first); i < (end); i++)

FN void store_aovs(Batch &__restrict b, uint slot, Aovs a) {
#define X(plane, value) b.aov[plane - PLANES_COMBINED][slot] = value;
  AOV_PLANES(X)
#undef X
}

/* ---------------------------------------------------------------- generate */

struct Tile {
  int column, row, width, height; /* within the region */
};

static void generate_batch(Batch &__restrict b, Scene s, Params params, Tile tile, uint first_sample, uint samples) {
  uint pixels = uint(tile.width * tile.height);
  b.current = 0;
  uint count = pixels * samples, width = uint(tile.width);
  b.count = count;
  FOR_PATHS(i, 0, count) {
    uint pixel = i / samples, sample = i - pixel * samples;
    uint row = pixel / width;
    Path p = generate_path(s, params, tile.column + int(pixel - row * width), tile.row + int(row), first_sample + sample, i);
    store_path(b.path_reals[0], b.path_uints[0], CAPACITY, i, p);
    b.red[i] = REAL(0.0);
    b.green[i] = REAL(0.0);
    b.blue[i] = REAL(0.0);
    b.alpha[i] = REAL(1.0);
  }
  if (params.aovs)
    for (uint i = 0; i < b.count; i++) store_aovs(b, i, no_aovs());
}

/* ------------------------------------------------------------------ extend */

static void extend_batch(Batch &__restrict b, Scene s) {
  Columns columns = b.columns();
  for (uint i = 0; i < b.count; i++) {
    if (!b.alive[i]) continue;
    Hit h = trace(s, path_ray(path_at(columns, i)), 0);
    b.hit_t[i] = h.t;
    b.hit_u[i] = h.u;
    b.hit_v[i] = h.v;
    b.hit_instance[i] = h.instance;
    b.hit_primitive[i] = h.primitive;
    b.hit_index[i] = h.index;
  }
}

FN uint hit_material(Scene s, Hit h) {
  if (h.index == NONE) return MISS;
  if (h.index & INDEX_SPHERE) return s.spheres[h.index & ~INDEX_SPHERE].material;
  return s.slot_materials[s.instances[h.instance].first_slot + (s.triangles[h.index].slot & 0xffffu)];
}

template <typename T>
static void permute_column(T *to, const T *from, const uint *order, uint n) {
#pragma omp simd
  for (uint i = 0; i < n; i++) to[i] = from[order[i]];
}

template <typename T>
static void permute_in_place(T *column, T *spare, const uint *order, uint n) {
  permute_column(spare, column, order, n);
  std::copy(spare, spare + n, column);
}

/* Sorts the living paths and their hits by material (stable counting sort) and leaves the others out.
 * Paths that hit nothing come first. */
static void sort_batch(Batch &__restrict b, Scene s, std::vector<Group> &groups) {
  groups.clear();
  uint bins = 0;
  for (uint i = 0; i < b.count; i++) {
    if (!b.alive[i]) continue;
    uint last = (b.columns().uints[PATH_UINT_status * CAPACITY + i] & PATH_LAST_HIT) != 0;
    uint material = hit_material(s, load_hit(b, i));
    b.key[i] = material == MISS ? 0 : 2 * material + 1 + last;
    bins = std::max(bins, b.key[i] + 1);
  }
  b.bins.assign(bins + 1, 0);
  for (uint i = 0; i < b.count; i++)
    if (b.alive[i]) b.bins[b.key[i] + 1]++;
  for (uint key = 0; key < bins; key++) {
    uint first = b.bins[key], size = b.bins[key + 1];
    if (size) groups.push_back({key ? (key - 1) / 2 : MISS, key && (key - 1) % 2, first, first + size});
    b.bins[key + 1] += first;
  }
  for (uint i = 0; i < b.count; i++)
    if (b.alive[i]) b.order[b.bins[b.key[i]]++] = i;

  uint n = groups.empty() ? 0 : groups.back().end;
  uint from = b.current, to = 1 - from;
  for (uint f = 0; f < PATH_REAL_COUNT; f++)
    permute_column(b.path_reals[to] + f * CAPACITY, b.path_reals[from] + f * CAPACITY, b.order, n);
  for (uint f = 0; f < PATH_UINT_COUNT; f++)
    permute_column(b.path_uints[to] + f * CAPACITY, b.path_uints[from] + f * CAPACITY, b.order, n);
  for (real *column : {b.hit_t, b.hit_u, b.hit_v}) permute_in_place(column, b.px, b.order, n);
  for (uint *column : {b.hit_instance, b.hit_primitive, b.hit_index}) permute_in_place(column, b.key, b.order, n);
  b.current = to;
  b.count = n;
}

/* ------------------------------------------------------------------- shade */

static void add_light(Batch &__restrict b, uint i, real3 light) {
  uint slot = b.columns().uints[PATH_UINT_slot * CAPACITY + i];
  b.red[slot] += light.x;
  b.green[slot] += light.y;
  b.blue[slot] += light.z;
}

static void shade_lamps(Batch &__restrict b, Scene s, Params params) {
  Columns columns = b.columns();
  uint count = b.count;
  for (uint l = 0; l < s.world[0].lamp_count; l++) {
    Light lamp = s.lights[l];
    if (!(lamp.size_u > 0.0f)) continue;
    FOR_PATHS(i, 0, count) {
      real3 light = see_lamp(params, lamp, path_at(columns, i), load_hit(b, i));
      b.fr[i] = light.x;
      b.fg[i] = light.y;
      b.fb[i] = light.z;
    }
    for (uint i = 0; i < b.count; i++) add_light(b, i, make_real3(b.fr[i], b.fg[i], b.fb[i]));
  }
}

static void shade_misses(Batch &__restrict b, Scene s, Params params, Group g) {
  Columns columns = b.columns();
  for (uint i = g.first; i < g.end; i++) {
    Path p = path_at(columns, i);
    add_light(b, i, see_world(s, params, p));
    b.alpha[p.slot] -= lost_alpha(params, p);
    b.alive[i] = 0;
  }
}

template <uint FEATURES>
static void make_surfaces(Batch &__restrict b, Scene s, Group g) {
  Columns columns = b.columns();
  FOR_PATHS(i, g.first, g.end) {
    Surface at = make_surface(s, path_ray(path_at(columns, i)), load_hit(b, i), FEATURES);
    b.px[i] = at.p.x;
    b.py[i] = at.p.y;
    b.pz[i] = at.p.z;
    b.offset[i] = at.offset;
    b.ngx[i] = at.ng.x;
    b.ngy[i] = at.ng.y;
    b.ngz[i] = at.ng.z;
    b.nsx[i] = at.ns.x;
    b.nsy[i] = at.ns.y;
    b.nsz[i] = at.ns.z;
    b.backfacing[i] = at.backfacing;
  }
}

static void shade_emission(Batch &__restrict b, Params params, Material m, Group g) {
  Columns columns = b.columns();
  for (uint i = g.first; i < g.end; i++)
    add_light(b, i, see_emission(params, m, load_surface(b, i, g.material), path_at(columns, i), load_hit(b, i)));
}

static void draw_lights(Batch &__restrict b, Scene s, Group g) {
  Columns columns = b.columns();
  uint count = s.world[0].light_count;
  FOR_PATHS(i, g.first, g.end) {
    Path p = path_at(columns, i);
    real choice = sample_bounce(p.seed, p.index, path_vertex(p), PAIR_CHOICE).x;
    real2 u = sample_bounce(p.seed, p.index, path_vertex(p), PAIR_LIGHT);
    LightSample l = sample_light(s.lights[pick_light(s, choice, count)], make_real3(b.px[i], b.py[i], b.pz[i]), u);
    b.ldx[i] = l.direction.x;
    b.ldy[i] = l.direction.y;
    b.ldz[i] = l.direction.z;
    b.distance[i] = l.distance;
    b.lr[i] = l.radiance.x;
    b.lg[i] = l.radiance.y;
    b.lb[i] = l.radiance.z;
    b.light_pdf[i] = l.pdf;
    b.can_be_hit[i] = l.can_be_hit;
    b.light_instance[i] = l.instance;
    b.light_primitive[i] = l.primitive;
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
    store_choice(b, i, make_choice(sample_bounce(p.seed, p.index, path_vertex(p), PAIR_CHOICE).y));
  }
}

/* The loops below run one instruction; CLOSURES and LAYERS expand each into a loop of its own. */
#define CLOSURE_LOOPS(number, name, class_)                                                              \
  static void consider_##name(Batch &__restrict b, Group g, Instruction c, uint k, const float *tables) {           \
    Columns columns = b.columns();                                                                        \
    FOR_PATHS(i, g.first, g.end) {                                                                       \
      Frame frame = make_frame(shading_normal(b, i));                                                    \
      real3 albedo = albedo_##name(c, b.backfacing[i], tables, local_wo(columns, frame, i));             \
      Choice choice = load_choice(b, i);                                                                 \
      real3 weight = closure_weight(c, choice);                                                          \
      real share = closure_share(weight, albedo);                                                        \
      store_choice(b, i, consider(choice, int(k), share));                                               \
      b.weight_r[k][i] = weight.x;                                                                       \
      b.weight_g[k][i] = weight.y;                                                                       \
      b.weight_b[k][i] = weight.z;                                                                       \
      b.share[k][i] = share;                                                                             \
    }                                                                                                    \
  }                                                                                                      \
  static void evaluate_##name(Batch &__restrict b, Group g, Instruction c, uint k, const float *tables,             \
                              const real *dx, const real *dy, const real *dz) {                          \
    Columns columns = b.columns();                                                                        \
    FOR_PATHS(i, g.first, g.end) {                                                                       \
      Frame frame = make_frame(shading_normal(b, i));                                                    \
      real3 wi = to_local(frame, make_real3(dx[i], dy[i], dz[i]));                                       \
      BsdfValue one = eval_##name(c, b.backfacing[i], tables, local_wo(columns, frame, i), wi);          \
      BsdfValue sum = make_value(make_real3(b.fr[i], b.fg[i], b.fb[i]), b.pdf[i]);                        \
      real3 weight = make_real3(b.weight_r[k][i], b.weight_g[k][i], b.weight_b[k][i]);                   \
      sum = add_closure(sum, one, weight, b.share[k][i], b.total[i]);                                    \
      b.fr[i] = sum.f.x;                                                                                 \
      b.fg[i] = sum.f.y;                                                                                 \
      b.fb[i] = sum.f.z;                                                                                 \
      b.pdf[i] = sum.pdf;                                                                                \
    }                                                                                                    \
  }                                                                                                      \
  static void sample_all_##name(Batch &__restrict b, Group g, Instruction c, uint k, const float *tables) {         \
    Columns columns = b.columns();                                                                        \
    FOR_PATHS(i, g.first, g.end) {                                                                       \
      Path p = path_at(columns, i);                                                                                \
      Frame frame = make_frame(shading_normal(b, i));                                                    \
      real2 u = sample_bounce(p.seed, p.index, path_vertex(p), PAIR_BSDF);                               \
      BsdfSample one = sample_##name(c, b.backfacing[i], tables, local_wo(columns, frame, i), b.choice_u[i], u); \
      int mine = b.chosen[i] == int(k);                                                                  \
      b.lix[i] = mine ? one.wi.x : b.lix[i];                                                             \
      b.liy[i] = mine ? one.wi.y : b.liy[i];                                                             \
      b.liz[i] = mine ? one.wi.z : b.liz[i];                                                             \
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
  static void apply_##name(Batch &__restrict b, Group g, Instruction c, const float *tables) {                      \
    Columns columns = b.columns();                                                                        \
    FOR_PATHS(i, g.first, g.end) {                                                                       \
      Frame frame = make_frame(shading_normal(b, i));                                                    \
      real3 kept = layer_##name(c, b.backfacing[i], tables, local_wo(columns, frame, i));                        \
      b.layer_r[i] = b.layer_r[i] * kept.x;                                                              \
      b.layer_g[i] = b.layer_g[i] * kept.y;                                                              \
      b.layer_b[i] = b.layer_b[i] * kept.z;                                                              \
    }                                                                                                    \
  }
LAYERS(LAYER_LOOPS)
#undef LAYER_LOOPS

static void choose_closures(Batch &__restrict b, Scene s, Material m, Group g) {
  start_choice(b, g);
  for (uint k = 0; k < m.count; k++) {
    Instruction c = s.instructions[m.first + k];
    switch (c.op) {
#define X(number, name, class_) \
  case number: consider_##name(b, g, c, k, s.albedo_tables); break;
      CLOSURES(X)
#undef X
#define X(number, name) \
  case number: apply_##name(b, g, c, s.albedo_tables); break;
      LAYERS(X)
#undef X
    }
  }
}

/* Value of the whole BSDF of the group towards the given world directions, into fr, fg, fb and pdf. */
static void evaluate_closures(Batch &__restrict b, Scene s, Material m, Group g, const real *dx, const real *dy, const real *dz) {
  for (real *column : {b.fr, b.fg, b.fb, b.pdf}) std::fill(column + g.first, column + g.end, REAL(0.0));
  for (uint k = 0; k < m.count; k++) {
    Instruction c = s.instructions[m.first + k];
    switch (c.op) {
#define X(number, name, class_) \
  case number: evaluate_##name(b, g, c, k, s.albedo_tables, dx, dy, dz); break;
      CLOSURES(X)
#undef X
    }
  }
  FOR_PATHS(i, g.first, g.end) {
    BsdfValue v = make_value(make_real3(b.fr[i], b.fg[i], b.fb[i]), b.pdf[i]);
    v = one_sided(load_surface(b, i, g.material), make_real3(dx[i], dy[i], dz[i]), v);
    b.fr[i] = v.f.x;
    b.fg[i] = v.f.y;
    b.fb[i] = v.f.z;
    b.pdf[i] = v.pdf;
  }
}

FN BsdfSample load_sample(const Batch &b, uint i) {
  return make_sample(make_real3(b.lix[i], b.liy[i], b.liz[i]), make_real3(b.sr[i], b.sg[i], b.sb[i]), b.delta[i],
                     b.label[i], b.valid[i]);
}

static void sample_closures(Batch &__restrict b, Scene s, Material m, Group g) {
  for (real *column : {b.lix, b.liy, b.liz, b.sr, b.sg, b.sb}) std::fill(column + g.first, column + g.end, REAL(0.0));
  for (int *column : {b.delta, b.label, b.valid}) std::fill(column + g.first, column + g.end, 0);
  for (uint k = 0; k < m.count; k++) {
    Instruction c = s.instructions[m.first + k];
    switch (c.op) {
#define X(number, name, class_) \
  case number: sample_all_##name(b, g, c, k, s.albedo_tables); break;
      CLOSURES(X)
#undef X
    }
  }
  FOR_PATHS(i, g.first, g.end) {
    real3 wi = to_world(make_frame(shading_normal(b, i)), make_real3(b.lix[i], b.liy[i], b.liz[i]));
    b.wix[i] = wi.x;
    b.wiy[i] = wi.y;
    b.wiz[i] = wi.z;
    b.valid[i] = one_sided_sample(load_surface(b, i, g.material), wi, load_sample(b, i)).valid;
  }
}

static void connect_lights(Batch &__restrict b, Params params, Group g) {
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
    b.cr[i] = c.light.x;
    b.cg[i] = c.light.y;
    b.cb[i] = c.light.z;
  }
}

static void scatter_paths(Batch &__restrict b, Params params, Group g) {
  Columns columns = b.columns();
  FOR_PATHS(i, g.first, g.end) {
    Path p = path_at(columns, i);
    Choice choice = load_choice(b, i);
    uint k = uint(max_int(choice.chosen, 0));
    BsdfValue value = make_value(make_real3(b.fr[i], b.fg[i], b.fb[i]), b.pdf[i]);
    real u = sample_bounce(p.seed, p.index, path_vertex(p), PAIR_ROULETTE).x;
    Scattered r = scatter_path(params, load_surface(b, i, g.material), p, load_hit(b, i), load_sample(b, i),
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
    Scattered r = pass_transparent(params, m, path_at(columns, i), load_hit(b, i));
    store_path(columns.reals, columns.uints, CAPACITY, i, r.path);
    b.alive[i] = uint(r.alive);
  }
}

static void shade_aovs(Batch &__restrict b, Scene s, Material m, Group g) {
  Columns columns = b.columns();
  for (uint i = g.first; i < g.end; i++) {
    Path p = path_at(columns, i);
    if (!shows_surface(p)) continue;
    store_aovs(b, p.slot, make_aovs(s, m, load_surface(b, i, g.material), p));
  }
}

static void connect_batch(Batch &__restrict b, Scene s, Params params, Group g, uint features) {
  for (uint i = g.first; i < g.end; i++) {
    real3 light = make_real3(b.cr[i], b.cg[i], b.cb[i]);
    if (is_dark(light)) continue;
    Ray ray = shadow_ray(make_real3(b.cox[i], b.coy[i], b.coz[i]), make_real3(b.ldx[i], b.ldy[i], b.ldz[i]),
                         b.distance[i], b.light_instance[i], b.light_primitive[i]);
    add_light(b, i, light * trace_connection(s, params, ray, features));
  }
}

template <uint FEATURES>
static void shade_group(Batch &__restrict b, Scene s, Params params, Group g) {
  Material m = s.materials[g.material];
  make_surfaces<FEATURES>(b, s, g);
  if (params.aovs) shade_aovs(b, s, m, g);
  if (m.flags & MATERIAL_EMITS) shade_emission(b, params, m, g);
  if (g.last) {
    pass_last(b, params, m, g);
    return;
  }
  choose_closures(b, s, m, g);
  bool lit = s.world[0].light_count > 0 && !(m.flags & MATERIAL_DELTA_ONLY);
  if (lit) {
    draw_lights(b, s, g);
    evaluate_closures(b, s, m, g, b.ldx, b.ldy, b.ldz);
    connect_lights(b, params, g);
    connect_batch(b, s, params, g, s.world[0].features);
  }
  sample_closures(b, s, m, g);
  evaluate_closures(b, s, m, g, b.wix, b.wiy, b.wiz);
  scatter_paths(b, params, g);
}

static void shade_batch(Batch &__restrict b, Scene s, Params params, const std::vector<Group> &groups) {
  shade_lamps(b, s, params);
  uint features = s.world[0].features;
  for (Group g : groups) {
    if (g.material == MISS)
      shade_misses(b, s, params, g);
    else if (features & (FEATURE_INSTANCES | FEATURE_SPHERES))
      shade_group<FEATURE_INSTANCES | FEATURE_SPHERES | FEATURE_SMOOTH>(b, s, params, g);
    else if (features & FEATURE_SMOOTH)
      shade_group<FEATURE_SMOOTH>(b, s, params, g);
    else
      shade_group<0>(b, s, params, g);
  }
}

/* -------------------------------------------------------------- accumulate */

/* Adds the batch's samples to the film in the order of their numbers. */
static void accumulate_batch(const Batch &b, Params params, Tile tile, uint first_sample, uint samples, float *sums) {
  size_t plane = size_t(params.width) * size_t(params.height);
  uint pixels = uint(tile.width * tile.height);
  for (uint pixel = 0; pixel < pixels; pixel++) {
    size_t at = size_t(tile.row + int(pixel) / tile.width) * size_t(params.width) +
                size_t(tile.column + int(pixel) % tile.width);
    for (uint k = 0; k < samples; k++) {
      uint slot = pixel * samples + k, sample = first_sample + k;
      float *half = sums + (PLANE_COMBINED + 4 * (sample & 1u)) * plane + at;
      half[0] += to_float(b.red[slot]);
      half[plane] += to_float(b.green[slot]);
      half[2 * plane] += to_float(b.blue[slot]);
      half[3 * plane] += to_float(b.alpha[slot]);
      if (!params.aovs) continue;
      for (uint a = PLANES_COMBINED; a < PLANES_ALL; a++)
        if (plane_takes(a, sample)) sums[a * plane + at] += to_float(b.aov[a - PLANES_COMBINED][slot]);
    }
  }
}

/* Tiles are squares, larger where a pixel has few samples, so that batches are full. */
static int tile_side(uint samples) { return samples >= 16 ? 8 : samples >= 4 ? 16 : 32; }

static void render_tile(Batch &__restrict b, Scene s, Params params, Tile tile, float *sums, std::vector<Group> &groups,
                        const std::atomic<int> *cancelled) {
  uint pixels = uint(tile.width * tile.height);
  uint step = std::max(1u, CAPACITY / pixels);
  for (uint done = 0; done < params.samples; done += step) {
    uint samples = std::min(step, params.samples - done);
    generate_batch(b, s, params, tile, params.first_sample + done, samples);
    std::fill(b.alive, b.alive + b.count, 1u);
    while (b.count > 0) {
      if (cancelled->load(std::memory_order_relaxed)) return;
      extend_batch(b, s);
      sort_batch(b, s, groups);
      std::fill(b.alive, b.alive + b.count, 1u);
      shade_batch(b, s, params, groups);
    }
    accumulate_batch(b, params, tile, params.first_sample + done, samples, sums);
  }
}

static Scene make_scene(const void *const *pointers) {
  Scene s;
  int k = 0;
#define X(type, name, comment) s.name = static_cast<const type *>(pointers[k++]);
  SCENE_BUFFERS(X)
#undef X
  return s;
}

bool render(const void *const *scene, const void *settings, int threads, float *sums, const std::atomic<int> *cancelled) {
  Scene s = make_scene(scene);
  Params params = *static_cast<const Params *>(settings);
  int side = tile_side(params.samples);
  int columns = (params.width + side - 1) / side, rows = (params.height + side - 1) / side;
#pragma omp parallel num_threads(threads)
  {
    FlushGuard guard;
    auto batch = std::make_unique<Batch>();
    std::vector<Group> groups;
#pragma omp for schedule(dynamic, 1)
    for (int t = 0; t < columns * rows; t++) {
      if (cancelled->load(std::memory_order_relaxed)) continue;
      int x = (t % columns) * side, y = (t / columns) * side;
      Tile tile{x, y, std::min(side, params.width - x), std::min(side, params.height - y)};
      render_tile(*batch, s, params, tile, sums, groups, cancelled);
    }
  }
  return !cancelled->load();
}

void trace_rays(const void *const *scene, const float *rays, long n, int any, int threads, float *hits, unsigned *ids) {
  Scene s = make_scene(scene);
#pragma omp parallel for num_threads(threads) schedule(dynamic, 4096)
  for (long i = 0; i < n; i++) {
    const float *r = rays + 8 * i;
    Ray ray = free_ray(make_real3(r[0], r[1], r[2]), make_real3(r[3], r[4], r[5]), r[6], r[7]);
    Hit h = trace(s, ray, any);
    hits[4 * i] = to_float(h.t);
    hits[4 * i + 1] = to_float(h.u);
    hits[4 * i + 2] = to_float(h.v);
    hits[4 * i + 3] = float_of_bits(h.index);
    ids[2 * i] = h.instance;
    ids[2 * i + 1] = h.primitive;
  }
}

}  // namespace ISOPHOTE_VARIANT
}  // namespace isophote
