/* The paths that a thread works on at a time, in structures of arrays. Included once a variant. */
#pragma once
#include <algorithm>
#include <vector>

#include "tracer.h"

namespace isophote {
namespace ISOPHOTE_VARIANT {

constexpr uint CAPACITY = 1024;
constexpr uint MISS = NONE;
constexpr uint SCATTERED_BY_VOLUMES = NONE - 1u;

/* The path columns that are being read, fetched before a loop so that the loop sees plain arrays. */
struct Columns {
  real *reals;
  uint *uints;
  const real *times; /* by slot; nullptr where nothing moves */
};

/* Scratch memory of one thread; every array is a column of CAPACITY values. */
struct Batch {
  alignas(64) real path_reals[2][PATH_REAL_COUNT * CAPACITY];
  alignas(64) uint path_uints[2][PATH_UINT_COUNT * CAPACITY];
  alignas(64) real hit_t[CAPACITY], hit_u[CAPACITY], hit_v[CAPACITY];
  alignas(64) uint hit_instance[CAPACITY], hit_primitive[CAPACITY];
  alignas(64) uint key[CAPACITY], order[CAPACITY], alive[CAPACITY];
  /* surfaces */
  alignas(64) real px[CAPACITY], py[CAPACITY], pz[CAPACITY], offset[CAPACITY];
  alignas(64) real ngx[CAPACITY], ngy[CAPACITY], ngz[CAPACITY], nsx[CAPACITY], nsy[CAPACITY], nsz[CAPACITY];
  alignas(64) int backfacing[CAPACITY];
  /* choice of a light */
  alignas(64) uint walk_at[CAPACITY];
  alignas(64) real walk_chance[CAPACITY], walk_u[CAPACITY], light_u[CAPACITY], light_fine[CAPACITY];
  /* light samples */
  alignas(64) real ldx[CAPACITY], ldy[CAPACITY], ldz[CAPACITY], distance[CAPACITY], light_pdf[CAPACITY];
  alignas(64) real lr[CAPACITY], lg[CAPACITY], lb[CAPACITY];
  alignas(64) int can_be_hit[CAPACITY];
  alignas(64) uint light_hidden[CAPACITY];
  alignas(64) uint light_instance[CAPACITY], light_primitive[CAPACITY];
  /* choice of a closure; weights and shares of each closure */
  alignas(64) real layer_r[CAPACITY], layer_g[CAPACITY], layer_b[CAPACITY];
  alignas(64) real total[CAPACITY], choice_u[CAPACITY], chosen_share[CAPACITY];
  alignas(64) int chosen[CAPACITY];
  alignas(64) real weight_r[MOST_INSTRUCTIONS][CAPACITY], weight_g[MOST_INSTRUCTIONS][CAPACITY], weight_b[MOST_INSTRUCTIONS][CAPACITY];
  alignas(64) real share[MOST_INSTRUCTIONS][CAPACITY];
  alignas(64) real seen_r[CAPACITY], seen_g[CAPACITY], seen_b[CAPACITY]; /* weights where lights are hidden from kinds of rays */
  /* value of the BSDF towards the light or the next direction */
  alignas(64) real fr[CAPACITY], fg[CAPACITY], fb[CAPACITY], pdf[CAPACITY];
  /* sampled direction, and its cosine to the closure's normal */
  alignas(64) real wix[CAPACITY], wiy[CAPACITY], wiz[CAPACITY], height[CAPACITY];
  alignas(64) real sr[CAPACITY], sg[CAPACITY], sb[CAPACITY];
  alignas(64) int delta[CAPACITY], label[CAPACITY], valid[CAPACITY];
  /* connections */
  alignas(64) real cox[CAPACITY], coy[CAPACITY], coz[CAPACITY], cr[CAPACITY], cg[CAPACITY], cb[CAPACITY];
  alignas(64) real connection_cut[CAPACITY]; /* where light is clamped */
  /* where light is told apart by closures: the BSDF without the closure under way, and parts of it (Shares) */
  alignas(64) real before_r[CAPACITY], before_g[CAPACITY], before_b[CAPACITY];
  alignas(64) real diffuse_r[CAPACITY], diffuse_g[CAPACITY], diffuse_b[CAPACITY];
  alignas(64) real glossy_r[CAPACITY], glossy_g[CAPACITY], glossy_b[CAPACITY];
  Shadow shadows[CAPACITY]; /* of connections in scenes with transparent surfaces, and of Ambient Occlusion */
  /* results by slot */
  alignas(64) real red[CAPACITY], green[CAPACITY], blue[CAPACITY], alpha[CAPACITY];
  alignas(64) real cut[2][CAPACITY]; /* luminance that clamping took from direct and indirect light */
  std::vector<real> slot_columns; /* kernels/passes.h: of the film's further planes, a column each */

  /* Values of materials, a column a register: of the surfaces being shaded, and of those that shadow rays meet. */
  std::vector<real> registers, shadow_registers;
  std::vector<real> times; /* of paths, by slot, where the scene has FEATURE_MOTION */
  std::vector<real> media; /* of paths inside an object, where the scene has FEATURE_SUBSURFACE */
  std::vector<uint> volumes; /* by slot, kernels/volume.h, where it has FEATURE_VOLUME; then also of `shadows`: */
  std::vector<Volumes> shadow_volumes;
  static_assert(REGISTER_STRIDE == CAPACITY);
  static_assert(GROUP_vector == 7 && GROUP_ambient_occlusion == 12);  // VECTORS_USED and OCCLUSION_USED have these numbers

  uint current = 0; /* which of the two halves of the path arrays is read */
  uint count = 0;
  uint64_t closest = 0, shadow = 0; /* rays traced so far, for the mean path length */
  uint64_t limits[LIMITS] = {};     /* paths that each bounce limit has ended */
  std::vector<uint> bins;

  Columns columns() { return {path_reals[current], path_uints[current], times.empty() ? nullptr : times.data()}; }
};

/* What paths that meet a material do there: they scatter, or have had their last bounce; and of materials with subsurface
 * scattering they take it for diffuse, or come out of it. */
enum Meeting { SCATTERS, LAST, MEETS_DIFFUSE, COMES_OUT, MEETINGS };

/* Paths that do the same at one material. */
struct Group {
  uint material;
  Meeting meeting;
  uint first, end;
};

FN Hit load_hit(const Batch &b, uint i) {
  Hit h;
  h.t = b.hit_t[i];
  h.u = b.hit_u[i];
  h.v = b.hit_v[i];
  h.instance = b.hit_instance[i];
  h.primitive = b.hit_primitive[i];
  return h;
}

FN void store_hit(Batch &b, uint i, const Hit &h) {
  b.hit_t[i] = h.t;
  b.hit_u[i] = h.u;
  b.hit_v[i] = h.v;
  b.hit_instance[i] = h.instance;
  b.hit_primitive[i] = h.primitive;
}

static void add_light(Batch &__restrict b, Params params, uint i, Brought brought, uint from) {
  uint slot = b.columns().uints[PATH_UINT_slot * CAPACITY + i];
  int caught = catches(params) ? catch_light(b.slot_columns.data(), CAPACITY, slot, params, brought.light) : GOES_ON;
  if (caught == NOWHERE) return;
  b.red[slot] += brought.light.x;
  b.green[slot] += brought.light.y;
  b.blue[slot] += brought.light.z;
  if (params.cut_plane) b.cut[brought.indirect][slot] += cut_luminance(brought);
  if (has_any(params.groups, GROUPS_LIGHT) && caught == GOES_ON)
    add_light_passes(b.slot_columns.data(), CAPACITY, slot, params, brought, from);
}

static void lose_alpha(Batch &__restrict b, Params params, uint slot, real lost) {
  if (catches(params)) lose_matte(b.slot_columns.data(), CAPACITY, slot, params, lost);
  if (!is_alone(params)) b.alpha[slot] -= lost;
}

FN Brought load_brought(Batch &b, Params params, uint i) {
  Brought brought;
  brought.light = make_real3(b.cr[i], b.cg[i], b.cb[i]);
  brought.cut = params.cut_plane ? b.connection_cut[i] : REAL(0.0);
  brought.indirect = (b.columns().uints[PATH_UINT_bounces * CAPACITY + i] & 255u) > 0u;
  return brought;
}

static void count_limits(Batch &b, uint reached) {
  for (uint k = 0; k < LIMITS; k++) b.limits[k] += reached >> k & 1u;
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

FN void store_surface(Batch &__restrict b, uint i, Surface at) {
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

FN Path path_at(Columns c, uint i) {
  Path p = load_path(c.reals, c.uints, CAPACITY, i);
  return path_at_time(p, c.times ? c.times[p.slot] : REAL(0.0));
}

FN Point load_point(const Batch &b, Columns c, uint i) {
  Path p = path_at(c, i);
  return make_point(load_surface(b, i, 0), path_ray(p), load_hit(b, i), p.bounces, uint_of(path_passed(p)));
}

FN real3 shading_normal(const Batch &b, uint i) { return make_real3(b.nsx[i], b.nsy[i], b.nsz[i]); }

FN real3 local_wo(Columns c, Frame frame, uint i) {
  return to_local(frame, make_real3(-c.reals[PATH_REAL_dx * CAPACITY + i], -c.reals[PATH_REAL_dy * CAPACITY + i],
                                    -c.reals[PATH_REAL_dz * CAPACITY + i]));
}

/* The rays of the first paths in order; their hits go to the batch's columns. */
struct PathRays {
  Batch &b;
  Params params;
  Columns columns;
  Ray ray(uint i) const { return traced_ray(params, path_at(columns, b.order[i])); }
  void store(uint i, const Hit &h) { store_hit(b, b.order[i], h); }
};

/* The loop over the paths [first, end) of a group. Each path is on its own: nothing aliases. */
#define FOR_PATHS(i, first, end) _Pragma("omp simd") for (uint i = (first); i < (end); i++)

}  // namespace ISOPHOTE_VARIANT
}  // namespace isophote
