/* Breadth-first traversal with queues of (ray, node): the report's second next step.
 *
 * A level's queue holds a pair for every ray that entered a node; a work-item tests one pair's two children and
 * appends those that are hit, all of a group's left children before its right ones, so that rays of one node stay
 * together. Leaves go to a list of the ray's own, which bfs_finish tests. No hit is known on the way down, so no box is
 * skipped for lying behind one: that is what breadth first costs. counts[level] is the length of a level's queue,
 * entries[0] the number of leaves; the host stops where they do not fit. */

#define LEAF_PARAMETERS GLOBAL uint *heads, GLOBAL uint *leaf_refs, GLOBAL uint *leaf_instances, GLOBAL uint *leaf_next, \
                        GLOBAL uint *entries
#define PAIR_PARAMETERS(x) GLOBAL uint *x##_columns, GLOBAL uint *x##_refs, GLOBAL uint *x##_instances

FN void add_leaf(LEAF_PARAMETERS, uint capacity, uint i, uint ref, uint instance) {
  uint at = atomic_inc(&entries[0]);
  if (at >= capacity) return;
  leaf_refs[at] = ref;
  leaf_instances[at] = instance;
  leaf_next[at] = atomic_xchg(&heads[i], at);
}

__kernel void bfs_start(SCENE_PARAMETERS, GLOBAL const uint *queue, GLOBAL const uint *places, PAIR_PARAMETERS(pair),
                        LEAF_PARAMETERS, uint capacity, GLOBAL uint *counts, uint bounce) {
  MAKE_SCENE
  uint count = places[2u * bounce];
  for (uint k = get_global_id(0); k < count; k += get_global_size(0)) {
    uint i = queue[k], root = s.world[0].root;
    heads[i] = NONE;
    pair_columns[k] = i;
    pair_refs[k] = root;
    pair_instances[k] = NONE;
    if (k == 0u) counts[0] = root == NONE ? 0u : count;
  }
}

/* A pair's reference may be a node, a leaf or an instance: roots of trees may be any of them. */
__kernel void bfs_level(SCENE_PARAMETERS, PATH_PARAMETERS, PAIR_PARAMETERS(pair), PAIR_PARAMETERS(next), LEAF_PARAMETERS,
                        uint capacity, GLOBAL uint *counts, uint level) {
  MAKE_SCENE
  __local uint lefts, rights, first_left, first_right;
  uint count = counts[level];
  for (uint base = get_group_id(0) * get_local_size(0); base < count; base += get_global_size(0)) {
    uint k = base + get_local_id(0);
    if (get_local_id(0) == 0u) {
      lefts = 0u;
      rights = 0u;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    uint i = 0u, instance = NONE, left = NONE, right = NONE, at_left = 0u, at_right = 0u;
    if (k < count) {
      i = pair_columns[k];
      instance = pair_instances[k];
      uint ref = pair_refs[k], kind = REF_KIND(ref);
      Ray ray = path_ray(load_path(reals, uints, stride, i));
      if (kind == REF_INSTANCE) {
        if (s.instances[REF_INDEX(ref)].visibility & ray.kind) {
          instance = REF_INDEX(ref);
          left = s.instances[instance].root;
        }
      } else if (kind != REF_NODE) {
        add_leaf(heads, leaf_refs, leaf_instances, leaf_next, entries, capacity, i, ref, instance);
      } else {
        LocalRay space = make_local_ray(ray.origin, ray.direction);
        if (instance != NONE)
          space = make_local_ray(transform_point(s.instances[instance].to_object, ray.origin),
                                 transform_vector(s.instances[instance].to_object, ray.direction));
        GLOBAL const Bvh2Node *n = &s.nodes[ref];
        real t_min = ray.t_min * (REAL(1.0) - REAL(16.0) * ROUNDING), limit = ray.t_max * LIMIT_SLACK;
        real t0 = enter_box(n->center_x[0], n->half_x[0], n->center_y[0], n->half_y[0], n->center_z[0], n->half_z[0], space, t_min, limit);
        real t1 = enter_box(n->center_x[1], n->half_x[1], n->center_y[1], n->half_y[1], n->center_z[1], n->half_z[1], space, t_min, limit);
        left = t0 >= REAL(0.0) ? n->child[0] : NONE;
        right = t1 >= REAL(0.0) ? n->child[1] : NONE;
      }
      if (left != NONE) at_left = atomic_inc(&lefts);
      if (right != NONE) at_right = atomic_inc(&rights);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (get_local_id(0) == 0u) {
      first_left = lefts + rights ? atomic_add(&counts[level + 1u], lefts + rights) : 0u;
      first_right = first_left + lefts;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint side = 0u; side < 2u; side++) {
      uint ref = side ? right : left, at = side ? first_right + at_right : first_left + at_left;
      if (ref == NONE || at >= capacity) continue;
      next_columns[at] = i;
      next_refs[at] = ref;
      next_instances[at] = instance;
    }
  }
}

__kernel void bfs_finish(SCENE_PARAMETERS, PATH_PARAMETERS, HIT_PARAMETERS, GLOBAL const uint *queue,
                         GLOBAL const uint *places, GLOBAL const uint *heads, GLOBAL const uint *leaf_refs,
                         GLOBAL const uint *leaf_instances, GLOBAL const uint *leaf_next, uint bounce) {
  MAKE_SCENE
  uint count = places[2u * bounce];
  for (uint k = get_global_id(0); k < count; k += get_global_size(0)) {
    uint i = queue[k];
    Ray ray = path_ray(load_path(reals, uints, stride, i));
    Hit best = no_hit(ray.t_max);
    for (uint e = heads[i]; e != NONE; e = leaf_next[e]) {
      uint ref = leaf_refs[e], instance = leaf_instances[e];
      LocalRay space = make_local_ray(ray.origin, ray.direction);
      if (REF_KIND(ref) == REF_SPHERE) {
        best = hit_sphere(s, REF_INDEX(ref), space, ray, best);
        continue;
      }
      if (instance != NONE)
        space = make_local_ray(transform_point(s.instances[instance].to_object, ray.origin),
                               transform_vector(s.instances[instance].to_object, ray.direction));
      best = hit_triangles(s, REF_INDEX(ref), instance, space, ray, best);
    }
    store_hit(hit_reals, hit_uints, stride, i, best);
  }
}
