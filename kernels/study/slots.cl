/* The report's pipeline: a kernel a stage over a queue that has a place for every path.
 *
 * A place holds a path's column, or NONE once the path has ended. counts[2 b] is how many places bounce b has,
 * counts[2 b + 1] how many paths it began with. What closes the gaps is in reorder.cl. */

__kernel void start_slots(SCENE_PARAMETERS, PATH_PARAMETERS, RESULT_PARAMETERS, GLOBAL uint *queue, uint first_pixel,
                          uint count) {
  MAKE_SCENE
  uint i = get_global_id(0);
  if (i >= count) return;
  store_path(reals, uints, stride, i, start_path(s, params_buffer, results, columns, stride, first_pixel, i));
  queue[i] = i;
}

__kernel void extend_slots(SCENE_PARAMETERS, PATH_PARAMETERS, HIT_PARAMETERS, GLOBAL const uint *queue,
                           GLOBAL const uint *counts, uint bounce) {
  MAKE_SCENE
  uint count = counts[2u * bounce];
  for (uint k = get_global_id(0); k < count; k += get_global_size(0)) {
    uint i = queue[k];
    if (i == NONE) continue;
    store_hit(hit_reals, hit_uints, stride, i, trace(s, path_ray(load_path(reals, uints, stride, i)), 0));
  }
}

/* Results have a stride of their own: with path regeneration there are more samples than paths. */
__kernel void shade_slots(SCENE_PARAMETERS, PATH_PARAMETERS, HIT_PARAMETERS, LIGHT_PARAMETERS, RESULT_PARAMETERS,
                          uint result_stride, GLOBAL uint *queue, GLOBAL uint *light_queue, GLOBAL uint *counts,
                          uint bounce) {
  MAKE_SCENE
  __local uint alive;
  uint count = counts[2u * bounce];
  for (uint base = get_group_id(0) * get_local_size(0); base < count; base += get_global_size(0)) {
    uint k = base + get_local_id(0);
    if (get_local_id(0) == 0u) alive = 0u;
    barrier(CLK_LOCAL_MEM_FENCE);
    uint i = k < count ? queue[k] : NONE;
    if (i != NONE) {
      Shaded r = shade_path(s, params, load_path(reals, uints, stride, i), load_hit(hit_reals, hit_uints, stride, i),
                            results, columns, limits, result_stride);
      if (r.alive) {
        store_path(reals, uints, stride, i, r.path);
        atomic_inc(&alive);
      }
      if (r.connected) store_connection(light_reals, light_uints, stride, i, r.connection);
      queue[k] = r.alive ? i : NONE;
      light_queue[k] = r.connected ? i : NONE;
    } else if (k < count) {
      light_queue[k] = NONE;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (get_local_id(0) == 0u && alive) atomic_add(&counts[2u * bounce + 3u], alive);
  }
}

__kernel void connect_slots(SCENE_PARAMETERS, PATH_PARAMETERS, LIGHT_PARAMETERS, RESULT_PARAMETERS,
                            uint result_stride, GLOBAL const uint *light_queue, GLOBAL const uint *counts, uint bounce) {
  MAKE_SCENE
  uint count = counts[2u * bounce];
  for (uint k = get_global_id(0); k < count; k += get_global_size(0)) {
    uint i = light_queue[k];
    if (i == NONE) continue;
    Connection c = load_connection(light_reals, light_uints, stride, i);
    real registers[REGISTERS];
    Shadow d = trace_connection(s, params, c, SCENE_FEATURES, registers);
    add_result(results, columns, result_stride, uints[PATH_UINT_slot * stride + i], params,
               behind_shadow(c.brought, d), FROM_LIGHT);
  }
}

#if TRAVERSAL == TRAVERSAL_LIST
/* The same two with chunks of triangles in local memory: all of a group trace together. */
__kernel void extend_together(SCENE_PARAMETERS, PATH_PARAMETERS, HIT_PARAMETERS, GLOBAL const uint *queue,
                              GLOBAL const uint *counts, uint bounce) {
  MAKE_SCENE
  __local Triangle chunk[GROUP_SIZE];
  uint count = counts[2u * bounce];
  for (uint base = get_group_id(0) * GROUP_SIZE; base < count; base += get_global_size(0)) {
    uint k = base + get_local_id(0);
    uint i = k < count ? queue[k] : NONE;
    Ray ray = path_ray(load_path(reals, uints, stride, i == NONE ? 0u : i));
    Hit h = trace_list_together(s, ray, 0, i != NONE, chunk);
    if (i != NONE) store_hit(hit_reals, hit_uints, stride, i, h);
  }
}

/* Shadow rays in scenes without transparent surfaces; the host refuses others. */
__kernel void connect_together(SCENE_PARAMETERS, PATH_PARAMETERS, LIGHT_PARAMETERS, RESULT_PARAMETERS,
                               uint result_stride, GLOBAL const uint *light_queue, GLOBAL const uint *counts,
                               uint bounce) {
  MAKE_SCENE
  __local Triangle chunk[GROUP_SIZE];
  uint count = counts[2u * bounce];
  for (uint base = get_group_id(0) * GROUP_SIZE; base < count; base += get_global_size(0)) {
    uint k = base + get_local_id(0);
    uint i = k < count ? light_queue[k] : NONE;
    Connection c = load_connection(light_reals, light_uints, stride, i == NONE ? 0u : i);
    Hit h = trace_list_together(s, c.ray, 1, i != NONE, chunk);
    if (i != NONE && h.instance == NONE)
      add_result(results, columns, result_stride, uints[PATH_UINT_slot * stride + i], params, c.brought, FROM_LIGHT);
  }
}
#endif

/* Path regeneration (Novak, Havran and Dachsbacher 2010, "Path Regeneration for Interactive Path Tracing", EG short
 * papers): whoever has ended starts the next sample. next[0] counts the samples that have been started. */
__kernel void regenerate(SCENE_PARAMETERS, PATH_PARAMETERS, RESULT_PARAMETERS, uint result_stride, GLOBAL uint *queue,
                         GLOBAL uint *counts, GLOBAL uint *next, uint bounce, uint first_pixel, uint samples) {
  MAKE_SCENE
  __local uint ended, first;
  uint count = counts[2u * bounce];
  for (uint base = get_group_id(0) * get_local_size(0); base < count; base += get_global_size(0)) {
    uint k = base + get_local_id(0);
    if (get_local_id(0) == 0u) ended = 0u;
    barrier(CLK_LOCAL_MEM_FENCE);
    int wants = k < count && queue[k] == NONE;
    uint rank = wants ? atomic_inc(&ended) : 0u;
    barrier(CLK_LOCAL_MEM_FENCE);
    if (get_local_id(0) == 0u) {
      first = ended ? atomic_add(&next[0], ended) : 0u;
      uint started = first < samples ? min_uint(ended, samples - first) : 0u;
      if (started) atomic_add(&counts[2u * bounce + 1u], started);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (wants && first + rank < samples) {
      store_path(reals, uints, stride, k, start_path(s, params_buffer, results, columns, result_stride, first_pixel, first + rank));
      queue[k] = k;
    }
  }
}
