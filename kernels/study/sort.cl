/* Sorting a queue by a key of 12 bits, a counting sort in one pass, without order among equals. A work-group counts a
 * tile in local memory and then takes room in each bin at once, so that few bins do not mean much waiting.
 * Meister, Boksansky, Guthe and Bittner 2020, "On Ray Reordering Techniques for Faster GPU Ray Tracing", I3D, compare
 * keys; the one of octant and origin is among their best that are this short. */
#define SORT_BINS 4096u

/* Material of what was hit; paths that left the scene come first. */
FN uint material_key(Scene s, GLOBAL const uint *hit_uints, uint stride, uint i) {
  Hit h;
  h.instance = hit_uints[i];
  h.primitive = hit_uints[stride + i];
  return h.instance == NONE ? 0u : 1u + hit_material(s, h, SCENE_FEATURES) % (SORT_BINS - 1u);
}

FN uint spread_bits(uint x) { return (x & 1u) | ((x & 2u) << 2) | ((x & 4u) << 4); }

#define LOWEST(a) min_real(root->center_##a[0] - root->half_##a[0], root->center_##a[1] - root->half_##a[1])
#define HIGHEST(a) max_real(root->center_##a[0] + root->half_##a[0], root->center_##a[1] + root->half_##a[1])
/* Octant of the direction, then the cell of 8 x 8 x 8 in which the ray starts, in Morton order. */
FN uint ray_key(Scene s, Ray ray) {
  if (REF_KIND(s.world[0].root) != REF_NODE) return 0u;
  GLOBAL const Bvh2Node *root = &s.nodes[s.world[0].root];
  real3 lo = make_real3(LOWEST(x), LOWEST(y), LOWEST(z)), hi = make_real3(HIGHEST(x), HIGHEST(y), HIGHEST(z));
  uint x = uint_of(REAL(7.999) * clamp01((ray.origin.x - lo.x) / (hi.x - lo.x)));
  uint y = uint_of(REAL(7.999) * clamp01((ray.origin.y - lo.y) / (hi.y - lo.y)));
  uint z = uint_of(REAL(7.999) * clamp01((ray.origin.z - lo.z) / (hi.z - lo.z)));
  uint octant = (ray.direction.x < REAL(0.0) ? 1u : 0u) | (ray.direction.y < REAL(0.0) ? 2u : 0u) |
                (ray.direction.z < REAL(0.0) ? 4u : 0u);
  return octant << 9 | spread_bits(x) | spread_bits(y) << 1 | spread_bits(z) << 2;
}

#define SORT_TILE 4096u /* places of a tile */

FN void clear_bins(__local uint *counted) {
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint b = get_local_id(0); b < SORT_BINS; b += get_local_size(0)) counted[b] = 0u;
  barrier(CLK_LOCAL_MEM_FENCE);
}

__kernel void sort_count(SCENE_PARAMETERS, PATH_PARAMETERS, GLOBAL const uint *hit_uints, GLOBAL const uint *queue,
                         GLOBAL const uint *counts, GLOBAL uint *keys, GLOBAL uint *bins, uint by_material, uint bounce) {
  MAKE_SCENE
  __local uint counted[SORT_BINS];
  uint count = counts[2u * bounce];
  for (uint tile = get_group_id(0) * SORT_TILE; tile < count; tile += get_num_groups(0) * SORT_TILE) {
    clear_bins(counted);
    for (uint k = tile + get_local_id(0); k < min_uint(tile + SORT_TILE, count); k += get_local_size(0)) {
      uint i = queue[k];
      uint key = by_material ? material_key(s, hit_uints, stride, i)
                             : ray_key(s, path_ray(load_path(reals, uints, stride, i)));
      keys[k] = key;
      atomic_inc(&counted[key]);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint b = get_local_id(0); b < SORT_BINS; b += get_local_size(0))
      if (counted[b]) atomic_add(&bins[b], counted[b]);
  }
}

/* One work-group turns the counts into first places. */
__kernel void sort_places(GLOBAL uint *bins) {
  __local uint sums[GROUP_SIZE], total[1];
  uint each = SORT_BINS / GROUP_SIZE, first = get_local_id(0) * each, sum = 0u;
  for (uint b = first; b < first + each; b++) sum += bins[b];
  uint place = scan_group(sum, sums, total);
  for (uint b = first; b < first + each; b++) {
    uint held = bins[b];
    bins[b] = place;
    place += held;
  }
}

__kernel void sort_move(GLOBAL const uint *queue, GLOBAL const uint *counts, GLOBAL const uint *keys, GLOBAL uint *bins,
                        GLOBAL uint *sorted, uint bounce) {
  __local uint places[SORT_BINS];
  uint count = counts[2u * bounce];
  for (uint tile = get_group_id(0) * SORT_TILE; tile < count; tile += get_num_groups(0) * SORT_TILE) {
    clear_bins(places);
    uint end = min_uint(tile + SORT_TILE, count);
    for (uint k = tile + get_local_id(0); k < end; k += get_local_size(0)) atomic_inc(&places[keys[k]]);
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint b = get_local_id(0); b < SORT_BINS; b += get_local_size(0))
      if (places[b]) places[b] = atomic_add(&bins[b], places[b]);
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint k = tile + get_local_id(0); k < end; k += get_local_size(0))
      sorted[atomic_inc(&places[keys[k]])] = queue[k];
  }
}
