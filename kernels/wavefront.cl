/* The OpenCL device: entry points that load, call a stage and store.
 *
 * Paths lie in structures of arrays, a column a path; queues hold the columns of those that live.
 * counts[2 b] is the length of the queue of bounce b, counts[2 b + 1] that of its connections; they
 * stay on the device. A launch has at least as many work-items as its queue is long.
 * The host defines SCENE_FEATURES, CLOSURES_USED, GROUPS_USED and CLAMPS, so that what scene and film lack is not
 * compiled.
 * limits[k] counts the paths of a pass that the k-th bounce limit has ended; behind are the 64-bit sums of passes. */
#include "evaluate.h"
#include "shine.h"
#include "way.h"

#define SCENE_PARAMETERS \
  SCENE_BUFFERS(SCENE_PARAMETER) GLOBAL const Params *params_buffer
#define SCENE_PARAMETER(type, name, comment) GLOBAL const type *name,
#define MAKE_SCENE    \
  Scene s;            \
  SCENE_BUFFERS(SCENE_ASSIGN) Params params = params_buffer[0];
#define SCENE_ASSIGN(type, name, comment) s.name = name;

#define PATH_PARAMETERS GLOBAL real *reals, GLOBAL uint *uints, uint stride
#define HIT_PARAMETERS GLOBAL real *hit_reals, GLOBAL uint *hit_uints
#define LIGHT_PARAMETERS GLOBAL real *light_reals, GLOBAL uint *light_uints
#define RESULT_PARAMETERS GLOBAL real *results, GLOBAL real *columns, GLOBAL uint *limits
#define RESULT_ARGUMENTS results, columns, limits
#define QUEUE_PARAMETERS GLOBAL const uint *queue, GLOBAL uint *next_queue, GLOBAL uint *light_queue, GLOBAL uint *counts

/* A path's time has a column of its own, behind its medium. */
#define TIME_COLUMN (PATH_REAL_COUNT + (SCENE_FEATURES & FEATURE_SUBSURFACE ? MEDIUM_COLUMNS : 0))
#if SCENE_FEATURES & FEATURE_MOTION
FN Path load_whole_path(PATH_PARAMETERS, uint i) {
  return path_at_time(load_path(reals, uints, stride, i), reals[TIME_COLUMN * stride + i]);
}
#else
#define load_whole_path load_path
#endif

FN void store_hit(HIT_PARAMETERS, uint stride, uint i, Hit h) {
  hit_reals[i] = h.t;
  hit_reals[stride + i] = h.u;
  hit_reals[2u * stride + i] = h.v;
  hit_uints[i] = h.instance;
  hit_uints[stride + i] = h.primitive;
}

FN Hit load_hit(HIT_PARAMETERS, uint stride, uint i) {
  Hit h;
  h.t = hit_reals[i];
  h.u = hit_reals[stride + i];
  h.v = hit_reals[2u * stride + i];
  h.instance = hit_uints[i];
  h.primitive = hit_uints[stride + i];
  return h;
}

#include "connection.cl"

/* `columns` are those of passes.h, `from` as there. */
FN void add_result(GLOBAL real *results, GLOBAL real *columns, uint stride, uint slot, Params params, Brought b, uint from) {
  int caught = catches(params) ? catch_light(columns, stride, slot, params, b.light) : GOES_ON;
  if (caught == NOWHERE) return;
  results[slot] += b.light.x;
  results[stride + slot] += b.light.y;
  results[2u * stride + slot] += b.light.z;
  if (CLAMPS) results[(4u + uint_of(b.indirect)) * stride + slot] += cut_luminance(b);
  if (has_any(film_groups(params), GROUPS_LIGHT) && caught == GOES_ON) add_light_passes(columns, stride, slot, params, b, from);
}

FN void lose_alpha(GLOBAL real *results, GLOBAL real *columns, uint stride, uint slot, Params params, real lost) {
  if (catches(params)) lose_matte(columns, stride, slot, params, lost);
  if (!is_alone(params)) results[3u * stride + slot] -= lost;
}

FN void count_limits(GLOBAL uint *limits, uint reached) {
  for (uint k = 0u; k < LIMITS; k++)
    if (reached >> k & 1u) atomic_inc(&limits[k]);
}

typedef struct {
  Path path;
  Connection connection;
  Medium medium; /* of a path that has gone below the surface */
  int alive, connected;
} Shaded;

/* A light for a path's vertex at a point whose normal is packed; `fine`: a random number of its own. */
FN LightSample draw_light(Scene s, Params params, Path p, Hit h, real3 point, uint normal, real fine, GLOBAL real *columns,
                          uint stride) {
  real2 u = sample_bounce(p.seed, p.index, path_vertex(p), PAIR_LIGHT);
  LightWalk walk = start_walk(u.x);
  Receiver receiver = make_receiver(point, normal);
  if (SCENE_FEATURES & FEATURE_LINKING) receiver.set = receiver_set(s, h);
  for (uint depth = 0u; depth < s.world[0].light_depth; depth++) walk = step_walk(s, walk, receiver);
  if (has_any(film_groups(params), GROUPS_LIGHT_GROUPS))
    columns[drawn_group_column(params) * stride + p.slot] = real_of(drawn_light_group(s, walk));
  LightSample light = finish_light(s, walk, point, u.y, fine, (p.bounces & 255u) + 1u, path_time(p), SCENE_FEATURES);
  if (is_away(s, params, light)) light.pdf = REAL(0.0);
  if (SCENE_FEATURES & FEATURE_LINKING) light = link_sample(s, light, walk.at & ~CLUSTER_LIGHT, receiver.set);
  return light;
}

#if SCENE_FEATURES & FEATURE_VOLUME
#include "travel.cl"
#endif

FN GLOBAL const ListedPixel *listed_pixels(GLOBAL const Params *params_buffer) {
  return (GLOBAL const ListedPixel *)(params_buffer + 1);
}

/* Number `slot` of a pass: samples of the pixels from first_pixel on, those of one pixel side by side. */
FN Path start_path(Scene s, GLOBAL const Params *params_buffer, GLOBAL real *results, GLOBAL real *columns, uint stride,
                   uint first_pixel, uint slot) {
  Params params = params_buffer[0];
  uint pixel = first_pixel + slot / params.samples;
  uint sample = params.first_sample + slot % params.samples;
  if (!is_alone(params)) {
    for (uint c = 0u; c < (CLAMPS ? 6u : 4u); c++) results[c * stride + slot] = c == 3u ? REAL(1.0) : REAL(0.0);
    clear_columns(columns, stride, slot, params);
  }
  uint row = pixel / uint_of(params.width);
  int x = int_of(pixel - row * uint_of(params.width)), y = int_of(row);
  if (params.listed) {
    ListedPixel listed = listed_pixels(params_buffer)[pixel];
    x = listed.x;
    y = listed.y;
    sample += listed.first;
  }
  Path p = generate_path(s, params, s.camera[0].kind, x, y, sample, slot);
#if SCENE_FEATURES & FEATURE_CAMERA_MOTION
  p = move_with_camera(s, p);
#endif
#if SCENE_FEATURES & FEATURE_MOTION
  p.time = shutter_time(s, p.seed, p.index);
#endif
  if (is_alone(params) && !begins_again(columns, stride, slot, params)) {
    p = with_throughput(p, zero3());
    p.t_max = REAL(0.0); /* hits nothing */
  }
  return p;
}

__kernel void generate(SCENE_PARAMETERS, PATH_PARAMETERS, RESULT_PARAMETERS, GLOBAL uint *queue, GLOBAL uint *counts,
                       uint counts_length, uint first_pixel, uint count) {
  MAKE_SCENE
  uint i = get_global_id(0);
  for (uint k = i; k < counts_length; k += get_global_size(0)) counts[k] = k ? 0u : count;
  if (i >= count) return;
  Path p = start_path(s, params_buffer, results, columns, stride, first_pixel, i);
  store_path(reals, uints, stride, i, p);
#if SCENE_FEATURES & FEATURE_MOTION
  reals[TIME_COLUMN * stride + i] = p.time;
#endif
#if SCENE_FEATURES & FEATURE_VOLUME
  begin_in_volumes(s, p, uints, stride, i);
#endif
  queue[i] = i;
}

/* A group's share of a queue, [first, end): its lanes begin with one each, and who is done takes the next.
 *
 * A warp is busy until its longest walk is over. With rays that go anywhere two thirds of an H200's lanes were idle
 * on average; giving those whose walk is over new rays follows Aila, Laine and Karras 2012, "Understanding the
 * Efficiency of Ray Traversal on GPUs - Kepler and Fermi Addendum". A lane waits until fewer than COMPANY are walking,
 * because to begin a walk costs as much as some steps. */
#define COMPANY 20u
typedef struct {
  uint first, end;
} Share;

FN Share share_of_group(uint count) {
  uint each = (count + uint_of(get_num_groups(0)) - 1u) / uint_of(get_num_groups(0));
  Share share;
  share.first = min_uint(uint_of(get_group_id(0)) * each, count);
  share.end = min_uint(share.first + each, count);
  return share;
}

__kernel void extend(SCENE_PARAMETERS, PATH_PARAMETERS, HIT_PARAMETERS, GLOBAL const uint *queue,
                     GLOBAL const uint *counts, uint bounce) {
  MAKE_SCENE
  __local uint next;
  Share share = share_of_group(counts[2u * bounce]);
  if (get_local_id(0) == 0) next = share.first + uint_of(get_local_size(0));
  barrier(CLK_LOCAL_MEM_FENCE);
  uint stack[STACK_SIZE], i = 0u;
  Walk w;
  w.ref = NONE;
  Way way;
  way.inside = 0;
  for (uint k = share.first + uint_of(get_local_id(0)); k < share.end;) {
    if (w.ref == NONE) {
      i = queue[k];
      Path p = load_whole_path(reals, uints, stride, i);
      Ray ray = traced_ray(params, p);
      way.inside = is_inside(p);
      if (way.inside) {
        start_way(&way, p, load_medium(reals + PATH_REAL_COUNT * stride, stride, i));
        ray = next_ray(&way);
      }
      begin_walk(&w, stack, s, ray);
    }
    go_on(&w, stack, s, 0, next < share.end ? COMPANY : 0u);
    if (w.ref == NONE) {
      if (way.inside) {
        int state = end_flight(&way, w.best);
        if (state == WALK_ON) {
          begin_walk(&w, stack, s, next_ray(&way));
          continue;
        }
        store_path(reals, uints, stride, i, path_at_exit(way.path, way.walker, w.best, state));
        if (state == WALK_LOST) w.best = no_hit(FAR_AWAY);
      }
      store_hit(hit_reals, hit_uints, stride, i, w.best);
      k = atomic_inc(&next);
    }
  }
}

#if OCCLUSION_USED
#include "occlude.cl"
#endif

FN void miss_scene(Scene s, Params params, Path p, RESULT_PARAMETERS, uint stride, const real *r) {
  add_result(results, columns, stride, p.slot, params, see_world(s, params, p, last_set(s, params, columns, stride, p.slot), r), seen_from(p, GROUP_environment, s.world[0].light_group));
  lose_alpha(results, columns, stride, p.slot, params, lost_alpha(params.film_transparent, p));
}

FN Shaded shade_path(Scene s, Params params, Path p, Hit h, RESULT_PARAMETERS, uint stride) {
  Shaded r;
  r.path = p;
  r.alive = 0;
  r.connected = 0;
  real registers[REGISTERS];
  if ((SCENE_FEATURES & FEATURE_VISIBLE_LIGHTS) && !(SCENE_FEATURES & FEATURE_VOLUME)) {
    for (uint l = 0u; l < s.world[0].lamp_count; l++) {
      if (!(s.lights[l].size_u > 0.0f)) continue;
      LightHit seen = find_lamp(s.lights[l], p, h, SCENE_FEATURES);
      if (seen.hit)
        add_result(results, columns, stride, p.slot, params,
                   see_lamp(s, params, l, p, last_set(s, params, columns, stride, p.slot), seen, registers),
                   seen_from(p, GROUP_emission, LIGHT_GROUP(s.lights[l].flags)));
    }
  }
  Surface at;
  int missed = h.instance == NONE;
  if (missed) {
    if (!(SCENE_FEATURES & FEATURE_WORLD)) {
      miss_scene(s, params, p, RESULT_ARGUMENTS, stride, registers);
      return r;
    }
    at = make_background(s, make_real3(p.dx, p.dy, p.dz));
    h = background_hit(h.t);
  } else {
    p = meet_catcher(columns, stride, s, params, p, h);
    at = make_surface(s, path_ray(p), h, SCENE_FEATURES);
  }
  Material m = s.materials[at.material];
  int diffuse = meets_diffuse(p.status, m.flags);
  m = met_material(m, diffuse);
  if (is_inside(p)) m = missed ? m : exit_material(s, m);
  compute_values(s, m, m.steps, at, path_ray(p), h, p.bounces, uint_of(path_passed(p)), registers);
  if (missed) {
    miss_scene(s, params, p, RESULT_ARGUMENTS, stride, registers);
    return r;
  }
  uint groups = film_groups(params);
  if (m.flags & MATERIAL_EMITS)
    add_result(results, columns, stride, p.slot, params,
               see_emission(s, params, m, p, last_set(s, params, columns, stride, p.slot), h, registers),
               seen_from(p, GROUP_emission, has_any(groups, GROUPS_LIGHT_GROUPS) ? object_light_group(s, h) : 0u));
  if (has_any(groups, GROUPS_SURFACE) && !is_alone(params)) show_surface(columns, stride, groups, s, m, at, p, h, registers);
  if (IS_USED(OP_HOLDOUT) && (m.flags & MATERIAL_HOLDS_OUT))
    lose_alpha(results, columns, stride, p.slot, params, held_alpha(s, m, p, registers));
  if (p.status & PATH_LAST_HIT) {
    count_limits(limits, ending_limits(params, m, p));
    Scattered passed = pass_transparent(params, m, p, h, registers);
    r.path = passed.path;
    r.alive = passed.alive;
    return r;
  }

  real3 wo_world = make_real3(-p.dx, -p.dy, -p.dz);
  real3 surface_wo = to_local(make_frame(at.ns), wo_world);
  int vertex = path_vertex(p);
  real2 u_choice = sample_bounce(p.seed, p.index, vertex, PAIR_CHOICE);
  Choice choice = make_choice(u_choice.y);
  real3 weight = zero3();
  for (uint k = 0u; k < m.count; k++) {
    Instruction i = met_instruction(s.instructions[m.first + k], diffuse);
    Closure one = closure_of(i, registers);
    real3 wo = has_own_frame(i) ? to_local(own_frame(i, registers), wo_world) : surface_wo;
    if (is_closure(i.op)) {
      real3 w = closure_weight(one, choice);
      choice = consider(choice, int_of(k), closure_share(w, albedo_closure(one, at.backfacing, s.albedo_tables, wo)));
      weight = select3(choice.chosen == int_of(k), w, weight);
    } else {
      choice.layer = layer_closure(one, at.backfacing, s.albedo_tables, wo, choice.layer);
    }
  }

  if (choice.chosen < 0) return r; /* black from here */
  Instruction chosen = met_instruction(s.instructions[m.first + uint_of(choice.chosen)], diffuse);
  Frame frame = frame_of(chosen, at, registers);
  BsdfSample sample = sample_closure(closure_of(chosen, registers), at.backfacing, s.albedo_tables,
                                     to_local(frame, wo_world), choice.u, sample_bounce(p.seed, p.index, vertex, PAIR_BSDF));
  real3 direction = to_world(frame, sample.wi);
  sample = one_sided_sample(at, direction, sample);

  int lit = (SCENE_FEATURES & FEATURE_LIGHTS) && !(m.flags & MATERIAL_DELTA_ONLY);
  LightSample light;
  light.direction = direction;
  light.hidden = 0u;
  if (lit) {
    light = draw_light(s, params, p, h, at.p, receiver_normal(at, m.flags), u_choice.x, columns, stride);
  }

  /* Towards the light, then along the path, in a loop: closures are inlined wherever they are called, and with all of
   * their code twice shading took a tenth longer on an H200 and compiled for 0.8 s more. */
  int split = has_any(groups, GROUPS_SPLIT) && path_bounce(p) == 0;
  int lifts = (SCENE_FEATURES & FEATURE_TERMINATOR) != 0u;
  Evaluated next, of_light;
  next.value = make_value(zero3(), REAL(0.0));
  next.parts = no_shares();
#pragma unroll 1
  for (int turn = lit ? 0 : 1; turn < 2; turn++) {
    of_light = next;
    Surface side = at;
    if (lifts && !turn) side.ng = light_side(s, at, h.instance);
    next = evaluate_material(s, m, diffuse, side, choice, wo_world, turn ? direction : light.direction,
                             turn ? 0u : light.hidden, registers, split);
  }
  if (split) {
    store_shares(columns, stride, p.slot, groups, SHARES_OF_PATH, path_shares(next.parts, next.value.f, sample));
    if (lit) store_shares(columns, stride, p.slot, groups, SHARES_OF_LIGHT, make_shares(of_light.parts, of_light.value.f));
  }
  if (lit) {
    if (SCENE_FEATURES & FEATURE_SHINES) params.cut_plane = 0; /* clamped where its radiance is computed */
    r.connection = connect_light(params, at, light, of_light.value, p);
    r.connected = !is_dark(r.connection.brought.light);
    if (lifts && r.connected) r.connection.ray = lifted_ray(s, at, h, r.connection.ray);
  }
  Scattered on = scatter_path(params, at, m.flags, p, h, sample, direction, weight, choice, next.value,
                              sample_bounce(p.seed, p.index, vertex, PAIR_ROULETTE).x);
  r.path = on.path;
  r.alive = on.alive;
  if ((SCENE_FEATURES & FEATURE_LINKING) && !(sample.label & LABEL_TRANSPARENT))
    columns[link_column(params) * stride + p.slot] = real_of(receiver_set(s, h));
  if ((SCENE_FEATURES & FEATURE_SUBSURFACE) && is_inside(on.path)) {
    Entrance e = make_entrance(closure_of(chosen, registers), at.ns);
    r.path = with_throughput(on.path, path_throughput(on.path) * e.weight);
    r.medium = e.medium;
  }
  return r;
}

/* With a known size of group, compilers keep to the registers that such a group can have. */
#ifdef SHADE_GROUP
__attribute__((reqd_work_group_size(SHADE_GROUP, 1, 1)))
#endif
__kernel void shade(SCENE_PARAMETERS, PATH_PARAMETERS, HIT_PARAMETERS, LIGHT_PARAMETERS, RESULT_PARAMETERS,
                    QUEUE_PARAMETERS, uint bounce) {
  MAKE_SCENE
  __local uint alive, connected, first_alive, first_connected;
  uint k = get_global_id(0), local_k = get_local_id(0);
  if (local_k == 0u) {
    alive = 0u;
    connected = 0u;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  int lives = 0, connects = 0;
  uint i = 0u, at_alive = 0u, at_connected = 0u;
  if (k < counts[2u * bounce]) {
    i = queue[k];
    Path p = load_whole_path(reals, uints, stride, i);
    Hit h = load_hit(hit_reals, hit_uints, stride, i);
#if SCENE_FEATURES & FEATURE_VOLUME
    Shaded r = h.instance == IN_VOLUME ? shade_volume(s, params, p, h, uints, columns, stride)
                                       : shade_path(s, params, p, h, RESULT_ARGUMENTS, stride);
    move_in_volumes(s, params, p, h, r, uints, light_uints, stride, i);
#else
    Shaded r = shade_path(s, params, p, h, RESULT_ARGUMENTS, stride);
#endif
    lives = r.alive;
    connects = r.connected;
    if (lives) {
      store_path(reals, uints, stride, i, r.path);
      if (is_inside(r.path)) store_medium(reals + PATH_REAL_COUNT * stride, stride, i, r.medium);
      at_alive = atomic_inc(&alive);
    }
    if (connects) {
      store_connection(light_reals, light_uints, stride, i, r.connection);
      at_connected = atomic_inc(&connected);
    }
  }
  /* One atomic for each queue and work-group. */
  barrier(CLK_LOCAL_MEM_FENCE);
  if (local_k == 0u) {
    first_alive = alive ? atomic_add(&counts[2u * bounce + 2u], alive) : 0u;
    first_connected = connected ? atomic_add(&counts[2u * bounce + 1u], connected) : 0u;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lives) next_queue[first_alive + at_alive] = i;
  if (connects) light_queue[first_connected + at_connected] = i;
}

#if SCENE_FEATURES & FEATURE_SHINES
/* Before `connect`: completes the connections of a bounce. */
__kernel void complete(SCENE_PARAMETERS, uint stride, LIGHT_PARAMETERS, GLOBAL const uint *light_queue,
                       GLOBAL const uint *counts, uint bounce) {
  MAKE_SCENE
  uint k = get_global_id(0);
  if (k >= counts[2u * bounce + 1u]) return;
  uint i = light_queue[k];
  real registers[REGISTERS];
  Connection c = load_connection(light_reals, light_uints, stride, i);
  store_connection(light_reals, light_uints, stride, i, shine(s, params, c, SCENE_FEATURES, registers));
}
#endif

__kernel void connect(SCENE_PARAMETERS, uint stride, LIGHT_PARAMETERS, RESULT_PARAMETERS, GLOBAL const uint *light_queue,
                      GLOBAL const uint *counts, uint bounce) {
  MAKE_SCENE
  __local uint next;
  Share share = share_of_group(counts[2u * bounce + 1u]);
  if (get_local_id(0) == 0) next = share.first + uint_of(get_local_size(0));
  barrier(CLK_LOCAL_MEM_FENCE);
  uint stack[STACK_SIZE], i = 0u;
  Connection c;
  Walk w;
  w.ref = NONE;
  for (uint k = share.first + uint_of(get_local_id(0)); k < share.end;) {
    if (w.ref == NONE) {
      i = light_queue[k];
      c = load_connection(light_reals, light_uints, stride, i);
      if (SCENE_FEATURES & FEATURE_TRANSPARENT) {
        real registers[REGISTERS];
#if SCENE_FEATURES & FEATURE_VOLUME
        Shadow d = connect_in_volumes(s, params, c, light_uints, stride, i, registers);
#else
        Shadow d = trace_connection(s, params, c, SCENE_FEATURES, registers);
#endif
        add_result(results, columns, stride, i, params, behind_shadow(c.brought, d), FROM_LIGHT);
        if (d.limited) atomic_inc(&limits[LIMITS - 1]);
        k = atomic_inc(&next);
        continue;
      }
      begin_walk(&w, stack, s, among_catchers(c.ray, is_alone(params)));
    }
    go_on(&w, stack, s, 1, next < share.end ? COMPANY : 0u);
    if (w.ref == NONE) {
      if (w.best.instance == NONE) add_result(results, columns, stride, i, params, c.brought, FROM_LIGHT);
      k = atomic_inc(&next);
    }
  }
}

#include "accumulate.cl"
