/* The OpenMP device: a wavefront of some hundred paths a thread.
 *
 * Each thread owns a batch of paths and runs the stages of kernels/stages.h over it. Before shading,
 * paths are sorted by material, so that every loop over paths runs one instruction of one material: its
 * constants are the same for all paths of the loop, which therefore vectorises. Compiled once for each
 * precision and instruction set, as ISOPHOTE_VARIANT. */
#include <omp.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "host_scene.h"
#include "render.h"
#include "walk_loops.h"

namespace isophote {
namespace ISOPHOTE_VARIANT {

/* ---------------------------------------------------------------- generate */

/* Pixels that are rendered together: places for generate_path, the sample from which the item's count, and where in a
 * plane of the sums they lie. */
struct Part {
  uint pixels;
  int column[CAPACITY], row[CAPACITY];
  uint first[CAPACITY], at[CAPACITY];
};

/* One loop for each kind of camera. */
template <int KIND>
FN_APART void generate_paths(Batch &__restrict b, Scene s, Params params, const Part &__restrict part, uint first_sample,
                             uint samples) {
  FOR_PATHS(i, 0, b.count) {
    uint pixel = i / samples, sample = first_sample + i - pixel * samples;
    Path p = generate_path(s, params, KIND, part.column[pixel], part.row[pixel], part.first[pixel] + sample, i);
    store_path(b.path_reals[0], b.path_uints[0], CAPACITY, i, p);
  }
}

FN_APART void move_paths(Batch &__restrict b, Scene s) {
  FOR_PATHS(i, 0, b.count) {
    Path p = move_with_camera(s, load_path(b.path_reals[0], b.path_uints[0], CAPACITY, i));
    store_path(b.path_reals[0], b.path_uints[0], CAPACITY, i, p);
  }
}

FN_APART void time_paths(Batch &__restrict b, Scene s) {
  real *__restrict times = b.times.data();
  FOR_PATHS(i, 0, b.count) {
    Path p = load_path(b.path_reals[0], b.path_uints[0], CAPACITY, i);
    times[i] = shutter_time(s, p.seed, p.index);
  }
}

template <int... KINDS>
static auto generate_functions(std::integer_sequence<int, KINDS...>) {
  return std::array{&generate_paths<KINDS>...};
}

static void generate_batch(Batch &__restrict b, Scene s, Params params, const Part &__restrict part, uint first_sample,
                           uint samples) {
  static const auto functions = generate_functions(std::make_integer_sequence<int, CAMERA_KINDS>{});
  b.current = 0;
  b.count = part.pixels * samples;
  functions[s.camera[0].kind](b, s, params, part, first_sample, samples);
  if (s.camera[0].poses) move_paths(b, s);
  if (!b.times.empty()) time_paths(b, s);
}

/* What paths have brought so far. */
static void clear_results(Batch &__restrict b, Params params) {
  for (real *light : {b.red, b.green, b.blue}) std::fill(light, light + b.count, REAL(0.0));
  std::fill(b.alpha, b.alpha + b.count, REAL(1.0));
  if (params.cut_plane)
    for (real *cut : b.cut) std::fill(cut, cut + b.count, REAL(0.0));
  if (params.groups)
    for (uint i = 0; i < b.count; i++) clear_columns(b.slot_columns.data(), CAPACITY, i, params);
}

/* ------------------------------------------------------------------ extend */

static void extend_batch(Batch &b, Scene s, Params params, Walkers *walkers, Rays kind) {
  uint living = 0;
  for (uint i = 0; i < b.count; i++) {
    b.order[living] = i;
    living += b.alive[i] && !(walkers && is_inside(path_at(b.columns(), i)));
  }
  b.closest += living;
  PathRays rays{b, params, b.columns()};
  trace_all(s, rays, living, 0, kind);
  if (walkers) walk_batch(b, s, *walkers);
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

/* Of paths that have a bounce left. */
FN Meeting meeting_inside(uint status, uint material_flags) {
  if (!(status & RAY_ALL)) return COMES_OUT;
  return meets_diffuse(status, material_flags) ? MEETS_DIFFUSE : SCATTERS;
}

/* Sorts the living paths and their hits by material (stable counting sort) and leaves the others out.
 * Paths that hit nothing come first, then those that volumes scatter. */
static void sort_batch(Batch &__restrict b, Scene s, bool walks, std::vector<Group> &groups) {
  groups.clear();
  uint bins = 0, meetings = walks ? MEETINGS : LAST + 1;
  for (uint i = 0; i < b.count; i++) {
    if (!b.alive[i]) continue;
    Hit h = load_hit(b, i);
    b.key[i] = h.instance == IN_VOLUME;
    if (h.instance != NONE && h.instance != IN_VOLUME) {
      uint material = hit_material(s, h, s.world[0].features);
      uint status = b.columns().uints[PATH_UINT_status * CAPACITY + i];
      Meeting meeting = status & PATH_LAST_HIT ? LAST : SCATTERS;
      if (walks && meeting == SCATTERS) meeting = meeting_inside(status, s.materials[material].flags);
      b.key[i] = meetings * material + 2 + meeting;
    }
    bins = std::max(bins, b.key[i] + 1);
  }
  b.bins.assign(bins + 1, 0);
  for (uint i = 0; i < b.count; i++)
    if (b.alive[i]) b.bins[b.key[i] + 1]++;
  for (uint key = 0; key < bins; key++) {
    uint first = b.bins[key], size = b.bins[key + 1];
    uint material = key == 0 ? MISS : key == 1 ? SCATTERED_BY_VOLUMES : (key - 2) / meetings;
    if (size) groups.push_back({material, Meeting(key > 1 ? (key - 2) % meetings : 0u), first, first + size});
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
  for (uint *column : {b.hit_instance, b.hit_primitive}) permute_in_place(column, b.key, b.order, n);
  b.current = to;
  b.count = n;
}

/* -------------------------------------------------------------- accumulate */

/* Adds the batch's samples to the film in the order of their numbers; those that are no numbers count as 0.
 *
 * A pixel's sums are taken out and put back once: tiles of different threads share cache lines of the film. */
static void accumulate_batch(const Batch &b, Params params, const Part &part, uint first_sample, uint samples,
                             float *sums) {
  size_t plane = size_t(params.width) * size_t(params.height);
  uint groups = params.groups, end = planes_end(groups), first_light = first_light_plane(groups);
  /* AOV outputs, light groups, what clamping cuts off, which `total` has at its end, and mattes lie behind the groups. */
  uint named = uint(params.named_planes), cuts = params.cut_plane ? PLANES_CUT : 0u;
  for (uint pixel = 0; pixel < part.pixels; pixel++) {
    float total[MOST_PLANES];
    float *own = sums + part.at[pixel];
    for (uint p = 0; p < end; p++) total[p] = own[p * plane];
    for (uint p = 0; p < cuts; p++) total[end + p] = own[(end + named + p) * plane];
    for (uint k = 0; k < samples; k++) {
      uint slot = pixel * samples + k, sample = part.first[pixel] + first_sample + k;
      int valid = is_addable(b.red[slot]) & is_addable(b.green[slot]) & is_addable(b.blue[slot]) & is_addable(b.alpha[slot]);
      if (params.cut_plane) valid &= is_addable(b.cut[0][slot]) & is_addable(b.cut[1][slot]);
      if (valid) {
        float *half = total + PLANE_COMBINED + 4 * (sample & 1u);
        half[0] += to_float(b.red[slot]);
        half[1] += to_float(b.green[slot]);
        half[2] += to_float(b.blue[slot]);
        half[3] += to_float(b.alpha[slot]);
        if (params.cut_plane) {
          float *cut = total + end + 2 * (sample & 1u);
          cut[0] += to_float(b.cut[0][slot]);
          cut[1] += to_float(b.cut[1][slot]);
        }
      }
      int lit = valid;
      for (uint a = PLANES_COMBINED; a < end; a++) {
        real value = b.slot_columns[(a - PLANES_COMBINED) * CAPACITY + slot];
        valid &= is_addable(value);
        if (plane_takes(groups, a, sample) & is_addable(value) & (lit | int(a < first_light))) total[a] += to_float(value);
      }
      for (uint a = 0; a < named; a++) {
        real value = b.slot_columns[(pass_columns(groups) + a) * CAPACITY + slot];
        valid &= is_addable(value);
        if (is_addable(value) & (lit | int(a < uint(params.light_plane)))) own[(end + a) * plane] += to_float(value);
      }
      if (has_any(groups, GROUPS_MATTES))
        add_mattes(own + first_matte_plane(params) * plane, uint(plane), b.slot_columns.data() + first_matte(groups) * CAPACITY + slot,
                   CAPACITY, params.matte_rows, matte_kinds(groups));
      if (!valid) total[PLANE_INVALID] += 1.0f;
    }
    for (uint p = 0; p < end; p++) own[p * plane] = total[p];
    for (uint p = 0; p < cuts; p++) own[(end + named + p) * plane] = total[end + p];
  }
}

/* How an item's pixels are cut into parts. A region's are squares, larger where a pixel has few samples, so that batches
 * are full; of a list, whose neighbours are near each other, as many as fill one batch. */
struct Cut {
  Params params;
  const ListedPixel *list; /* nullptr: a region */
  int side = 0, columns = 0, parts = 0;
  uint together = 0; /* listed pixels of a part */

  explicit Cut(const void *item) : params(*static_cast<const Params *>(item)), list(nullptr) {
    uint samples = params.samples;
    if (params.listed) {
      list = reinterpret_cast<const ListedPixel *>(static_cast<const Params *>(item) + 1);
      together = std::max(1u, CAPACITY / samples);
      parts = int((uint(params.width) + together - 1) / together);
    } else {
      side = samples >= 16 ? 8 : samples >= 4 ? 16 : 32;
      columns = (params.width + side - 1) / side;
      parts = columns * ((params.height + side - 1) / side);
    }
  }

  void fill(Part &part, int number) const {
    part.pixels = 0;
    auto add = [&](int column, int row, uint first, uint at) {
      uint k = part.pixels++;
      part.column[k] = column;
      part.row[k] = row;
      part.first[k] = first;
      part.at[k] = at;
    };
    if (list) {
      uint begin = uint(number) * together, end = std::min(begin + together, uint(params.width));
      for (uint at = begin; at < end; at++) add(list[at].x, list[at].y, list[at].first, at);
      return;
    }
    int x = (number % columns) * side, y = (number / columns) * side;
    for (int row = y; row < std::min(y + side, params.height); row++)
      for (int column = x; column < std::min(x + side, params.width); column++)
        add(column, row, 0, uint(row) * uint(params.width) + uint(column));
  }
};

/* A batch's paths from the camera to their ends; false where cancelled. */
static bool trace_paths(Batch &__restrict b, Scene s, Params params, std::vector<Group> &groups, Walkers *walkers,
                        const std::atomic<int> *cancelled) {
  for (Rays kind = COHERENT; b.count > 0; kind = SCATTERED) {
    if (cancelled->load(std::memory_order_relaxed)) return false;
    extend_batch(b, s, params, walkers, kind);
    if (s.world[0].features & FEATURE_VOLUME) travel_batch(b, s, params);
    sort_batch(b, s, walkers, groups);
    std::fill(b.alive, b.alive + b.count, 1u);
    shade_batch(b, s, params, groups);
    if (walkers) enter_objects(b, s, groups);
  }
  return true;
}

/* New paths live, in the volumes that are around them. */
static void begin_batch(Batch &__restrict b, Scene s) {
  if (s.world[0].features & FEATURE_VOLUME) begin_in_volumes(b, s);
  std::fill(b.alive, b.alive + b.count, 1u);
}

static void render_part(Batch &__restrict b, Scene s, Params params, const Part &part, float *sums,
                        std::vector<Group> &groups, Walkers *walkers, const std::atomic<int> *cancelled) {
  uint step = std::max(1u, CAPACITY / part.pixels);
  bool catching = (s.world[0].features & FEATURE_CATCHERS) && has_group(params.groups, GROUP_shadow_catcher);
  for (uint done = 0; done < params.samples; done += step) {
    uint samples = std::min(step, params.samples - done), first = params.first_sample + done;
    params.catching = catching ? CATCHING_FIRST : CATCHING_NONE;
    generate_batch(b, s, params, part, first, samples);
    clear_results(b, params);
    begin_batch(b, s);
    if (!trace_paths(b, s, params, groups, walkers, cancelled)) return;
    if (catching) {
      params.catching = CATCHING_ALONE;
      generate_batch(b, s, params, part, first, samples);
      begin_batch(b, s);
      for (uint i = 0; i < b.count; i++) b.alive[i] = uint(begins_again(b.slot_columns.data(), CAPACITY, i, params));
      if (!trace_paths(b, s, params, groups, walkers, cancelled)) return;
    }
    accumulate_batch(b, params, part, first, samples, sums);
  }
}

bool render(const void *const *scene, const WideTree *tree, const void *item, int threads, float *sums,
            uint64_t *rays, uint64_t *limits, const std::atomic<int> *cancelled) {
  Scene s = make_scene(scene, tree);
  Cut cut(item);
#pragma omp parallel num_threads(threads)
  {
    FlushGuard guard;
    auto batch = std::make_unique<Batch>();
    make_registers(*batch, s);
    batch->slot_columns.resize(size_t(link_column(cut.params) + 1) * CAPACITY);
    auto part = std::make_unique<Part>();
    std::vector<Group> groups;
    std::unique_ptr<Walkers> walkers;
    if (s.world[0].features & FEATURE_MOTION) batch->times.resize(CAPACITY);
    if (s.world[0].features & FEATURE_SUBSURFACE) {
      walkers = std::make_unique<Walkers>();
      batch->media.resize(size_t(MEDIUM_COLUMNS) * CAPACITY);
    }
    if (s.world[0].features & FEATURE_VOLUME) {
      batch->volumes.resize(size_t(VOLUME_COLUMNS) * CAPACITY);
      batch->shadow_volumes.resize(CAPACITY);
    }
#pragma omp for schedule(dynamic, 1)
    for (int t = 0; t < cut.parts; t++) {
      if (cancelled->load(std::memory_order_relaxed)) continue;
      cut.fill(*part, t);
      render_part(*batch, s, cut.params, *part, sums, groups, walkers.get(), cancelled);
    }
#pragma omp critical
    {
      rays[0] += batch->closest;
      rays[1] += batch->shadow;
      for (uint k = 0; k < LIMITS; k++) limits[k] += batch->limits[k];
    }
  }
  return !cancelled->load();
}

size_t batch_bytes() { return sizeof(Batch); }

/* Rays and hits of render.h's TraceFunction, from one on. */
struct ListedRays {
  const float *rays;
  float *hits;
  unsigned *ids;
  Ray ray(uint i) const {
    const float *r = rays + 8 * i;
    return free_ray(make_real3(r[0], r[1], r[2]), make_real3(r[3], r[4], r[5]), r[6], r[7]);
  }
  void store(uint i, const Hit &h) {
    hits[3 * i] = to_float(h.t);
    hits[3 * i + 1] = to_float(h.u);
    hits[3 * i + 2] = to_float(h.v);
    ids[2 * i] = h.instance;
    ids[2 * i + 1] = h.primitive;
  }
};

void trace_rays(const void *const *scene, const WideTree *tree, const float *rays, long n, int any, int threads,
                int packets, float *hits, unsigned *ids) {
  Scene s = make_scene(scene, tree);
  constexpr long PART = 4096;
#pragma omp parallel for num_threads(threads) schedule(dynamic, 1)
  for (long first = 0; first < n; first += PART) {
    ListedRays part{rays + 8 * first, hits + 3 * first, ids + 2 * first};
    uint count = uint(std::min(PART, n - first));
    if (tree)
      trace_all(s, part, count, any, packets ? COHERENT : SCATTERED);
    else
      for (uint i = 0; i < count; i++) part.store(i, trace(s, part.ray(i), any));
  }
}

}  // namespace ISOPHOTE_VARIANT
}  // namespace isophote
