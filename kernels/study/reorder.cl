/* Closing the gaps that ended paths leave in a queue: within each work-group or over all of it. */

/* Exclusive sum over the group; all of it call together. sums[0] is free to be read as the total's place afterwards:
 * the total is returned through total[0]. Hillis and Steele 1986, "Data Parallel Algorithms". */
FN uint scan_group(uint value, __local uint *sums, __local uint *total) {
  uint lane = get_local_id(0), width = get_local_size(0);
  uint sum = value;
  sums[lane] = value;
  for (uint step = 1u; step < width; step <<= 1) {
    barrier(CLK_LOCAL_MEM_FENCE);
    uint before = lane >= step ? sums[lane - step] : 0u;
    barrier(CLK_LOCAL_MEM_FENCE);
    sum += before;
    sums[lane] = sum;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane == width - 1u) total[0] = sum;
  barrier(CLK_LOCAL_MEM_FENCE);
  return sum - value;
}

/* The report's work-group reordering: each group packs its own stretch of the queue. */
__kernel void reorder_groups(GLOBAL uint *queue, GLOBAL const uint *counts, uint bounce) {
  __local uint sums[GROUP_SIZE], packed[GROUP_SIZE], total[1];
  uint count = counts[2u * bounce];
  for (uint base = get_group_id(0) * GROUP_SIZE; base < count; base += get_global_size(0)) {
    uint lane = get_local_id(0), k = base + lane;
    uint i = k < count ? queue[k] : NONE;
    uint rank = scan_group(i != NONE, sums, total);
    packed[lane] = NONE;
    barrier(CLK_LOCAL_MEM_FENCE);
    if (i != NONE) packed[rank] = i;
    barrier(CLK_LOCAL_MEM_FENCE);
    if (k < count) queue[k] = packed[lane];
    barrier(CLK_LOCAL_MEM_FENCE);
  }
}

/* The report's global reordering: a recursive exclusive scan. The host scans flags by groups, then the groups' sums in
 * the same way until one group holds them all, adds the sums back and moves the living to their places. */
__kernel void flag_living(GLOBAL const uint *queue, GLOBAL uint *flags, uint count) {
  uint k = get_global_id(0);
  if (k < count) flags[k] = queue[k] != NONE;
}

__kernel void scan_groups(GLOBAL uint *values, GLOBAL uint *sums_of_groups, uint count) {
  __local uint sums[GROUP_SIZE], total[1];
  uint k = get_global_id(0);
  uint rank = scan_group(k < count ? values[k] : 0u, sums, total);
  if (k < count) values[k] = rank;
  if (get_local_id(0) == 0u) sums_of_groups[get_group_id(0)] = total[0];
}

__kernel void add_sums(GLOBAL uint *values, GLOBAL const uint *sums_of_groups, uint count) {
  uint k = get_global_id(0);
  if (k < count) values[k] += sums_of_groups[get_group_id(0)];
}

__kernel void move_living(GLOBAL const uint *queue, GLOBAL const uint *places, GLOBAL uint *next_queue,
                          GLOBAL uint *counts, uint bounce, uint count) {
  uint k = get_global_id(0);
  if (k >= count) return;
  if (queue[k] != NONE) next_queue[places[k]] = queue[k];
  if (k == count - 1u) counts[2u * bounce + 2u] = places[k] + (queue[k] != NONE);
}

/* The same by one atomic a group, as the shipping kernels do while they shade, here as a pass of its own. */
__kernel void compact(GLOBAL const uint *queue, GLOBAL uint *next_queue, GLOBAL uint *counts, uint bounce) {
  __local uint alive, first;
  uint count = counts[2u * bounce];
  for (uint base = get_group_id(0) * get_local_size(0); base < count; base += get_global_size(0)) {
    uint k = base + get_local_id(0);
    if (get_local_id(0) == 0u) alive = 0u;
    barrier(CLK_LOCAL_MEM_FENCE);
    uint i = k < count ? queue[k] : NONE;
    uint rank = i != NONE ? atomic_inc(&alive) : 0u;
    barrier(CLK_LOCAL_MEM_FENCE);
    if (get_local_id(0) == 0u) first = alive ? atomic_add(&counts[2u * bounce + 2u], alive) : 0u;
    barrier(CLK_LOCAL_MEM_FENCE);
    if (i != NONE) next_queue[first + rank] = i;
  }
}
