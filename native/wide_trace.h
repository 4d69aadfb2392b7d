/* Traversal of the wide tree for many rays in turn.
 *
 * A ray meets few nodes and leaves (about seven and three in a closed room of a million triangles), and on its
 * own it mostly waits: for the next node from the caches, and for branches that nobody can foretell. So a
 * thread walks LANES rays at a time, one step each, in three loops over lists: those at a node, those at a
 * block of triangles, those at something else. A step has no branches; what it leads to decides in which list
 * the ray goes on, and is fetched until its turn comes.
 *
 * SIMD only finds candidates; whether and where one is hit says triangle_hit, so the bits are those of
 * every other tree. Included once for each variant; only for float. */
#pragma once
#include "../kernels/bvh.h"
#include "wide_simd.h"

namespace isophote {
namespace ISOPHOTE_VARIANT {

constexpr uint LANES = 32;
constexpr uint STACK = WIDTH * STACK_SIZE;
constexpr uint REF_DONE = NONE; /* at the bottom of each stack */

/* Distances to planes are b * inverse + offset. The offset's own rounding moves a plane by less than what one
 * of the coordinates is rounded by, so it is widened by four roundings of origin * inverse (two would do with
 * fused multiply-add), and comparing allows for 8 more roundings of the distances themselves. */
constexpr float OFFSET_SLACK = 4.0f * ROUNDING, ENTER_SLACK = 1.0f + 16.0f * ROUNDING;

/* Of the planes across an axis: of several rays, or of several axes of one ray. */
template <typename Floats>
struct Slab {
  Floats inverse, near_offset, far_offset;
};

template <typename Floats>
FN Slab<Floats> make_slab(Floats origin, Floats direction) {
  /* So small that the ray does not leave a slab by it, so large that origin * inverse stays finite. */
  Floats zero{}, least = zero + 1e-30f, tiny = larger(least, absolute(origin) * 1e-36f);
  Slab<Floats> s;
  s.inverse = 1.0f / (absolute(direction) < tiny ? (direction < zero ? -tiny : tiny) : direction);
  Floats offset = -origin * s.inverse, slack = absolute(offset) * OFFSET_SLACK;
  s.near_offset = offset - slack;
  s.far_offset = offset + slack;
  return s;
}

/* make_shear for a direction x, y, z, 0: with one division, and without branches, which nobody could foretell. */
FN Shear make_shear_at_once(Float4 direction) {
  STRICT_FP
  Float4 a = absolute(direction);
  unsigned outcome = bits_of(Int4(__builtin_shufflevector(a, a, 0, 0, 1, 3) > __builtin_shufflevector(a, a, 1, 2, 2, 3)));
  constexpr int LARGEST = 0x192a; /* axis for each outcome of x > y, x > z, y > z, as in largest_axis */
  constexpr Int4 PERMUTED[3] = {{1, 2, 0, 3}, {2, 0, 1, 3}, {0, 1, 2, 3}};
  Shear s;
  s.axis = LARGEST >> (2 * outcome) & 3;
  Float4 d = pick(direction, PERMUTED[s.axis]), ones = splat4(1.0f);
  Float4 quotient = __builtin_shufflevector(d, ones, 0, 1, 4, 5) / splat4(d[2]);
  s.shear_x = quotient[0];
  s.shear_y = quotient[1];
  s.scale = quotient[2];
  return s;
}

/* A ray on its way through the tree. */
struct alignas(64) Lane {
  Slab<Float4> slab;    /* of the axes x, y, z */
  Int4 near_row;        /* bytes in WideNode::bounds to the planes met first; the far ones are beside them */
  float t_min, limit;   /* of box tests, widened */
  uint32_t top;         /* of the stack: its last entry is where the ray is */
  uint number;
  LocalRay local; /* in the space of the tree that is being walked */
  uint instance;
  unsigned candidates;
  const TriangleBlock *block;
  Ray ray;
  Hit best;
  alignas(64) uint32_t refs[STACK + WIDTH];
  float enters[STACK + WIDTH]; /* distances at which the entries are entered */
};

constexpr int ROW = sizeof(float[WIDTH]);

FN void enter_space(Lane &l, real3 origin, real3 direction, uint instance) {
  Float4 from{origin.x, origin.y, origin.z, 0.0f}, toward{direction.x, direction.y, direction.z, 0.0f};
  l.local.origin = origin;
  l.local.direction = direction;
  l.local.shear = make_shear_at_once(toward);
  l.instance = instance;
  l.slab = make_slab(from, toward);
  l.near_row = Int4{0, 2, 4, 0} * ROW + ((toward < Float4{}) & ROW);
}

FN void push(Lane &l, uint32_t ref) {
  l.refs[l.top] = ref;
  l.enters[l.top++] = 0.0f;
}

FN void start(Lane &l, const WideTree &tree, uint number, const Ray &ray) {
  l.number = number;
  l.ray = ray;
  l.best = no_hit(ray.t_max);
  l.t_min = ray.t_min * (1.0f - 16.0f * ROUNDING);
  l.limit = ray.t_max * LIMIT_SLACK;
  l.top = 0;
  enter_space(l, ray.origin, ray.direction, NONE);
  push(l, REF_DONE);
  if (tree.root != NONE) push(l, tree.root);
}

FN Float8 row(const WideNode &n, int bytes) {
  return *reinterpret_cast<const Float8 *>(reinterpret_cast<const char *>(n.bounds) + bytes);
}

/* The children that are entered as keys, the nearest last: the distance, of which the three last bits say which child
 * it is. Distances that are not negative order like integers. Returns how many there are. */
FN uint order_children(Int8 entered, Float8 enter, Int8 *keys) {
  *keys = sorted((Int8(enter) & 0x7ffffff8) | Int8{0, 1, 2, 3, 4, 5, 6, 7} | ~entered);
  return uint(__builtin_popcount(bits_of(entered)));
}

/* Puts the children that the ray enters in the place of the node, the nearest on top. */
FN void step_node(Lane &l, const WideTree &tree) {
  const WideNode &n = tree.nodes[l.refs[l.top - 1]];
  Float8 enter = splat8(l.t_min), leave = splat8(l.limit);
  for (int axis = 0; axis < 3; axis++) {
    int near = l.near_row[axis], far = near ^ ROW;
    enter = larger(multiply_add(row(n, near), splat8(l.slab.inverse[axis]), splat8(l.slab.near_offset[axis])), enter);
    leave = smaller(multiply_add(row(n, far), splat8(l.slab.inverse[axis]), splat8(l.slab.far_offset[axis])), leave);
  }
  Int8 key;
  uint count = order_children(enter <= leave * ENTER_SLACK, enter, &key);
  *reinterpret_cast<Int8u *>(&l.refs[l.top - 1]) = pick(n.child, key);
  *reinterpret_cast<Int8u *>(&l.enters[l.top - 1]) = key & ~7;
  l.top += count - 1;
}

FN Float4 corner(const TriangleBlock &b, int c, int axis) { return *reinterpret_cast<const Float4 *>(b.corner[c][axis]); }

/* Which triangles of a block the ray's line may hit within (t_min, t_max): triangle_hit's arithmetic. */
FN unsigned candidates(const TriangleBlock &b, const LocalRay &r, float t_min, float t_max) {
  STRICT_FP
  int z = r.shear.axis, x = z == 2 ? 0 : z + 1, y = z == 0 ? 2 : z - 1;
  float o[3] = {r.origin.x, r.origin.y, r.origin.z};
  Float4 az = corner(b, 0, z) - o[z], bz = corner(b, 1, z) - o[z], cz = corner(b, 2, z) - o[z];
  Float4 ax = corner(b, 0, x) - o[x] - r.shear.shear_x * az, ay = corner(b, 0, y) - o[y] - r.shear.shear_y * az;
  Float4 bx = corner(b, 1, x) - o[x] - r.shear.shear_x * bz, by = corner(b, 1, y) - o[y] - r.shear.shear_y * bz;
  Float4 cx = corner(b, 2, x) - o[x] - r.shear.shear_x * cz, cy = corner(b, 2, y) - o[y] - r.shear.shear_y * cz;
  Float4 u = cx * by - cy * bx, v = ax * cy - ay * cx, w = bx * ay - by * ax;
  Float4 zero{};
  Int4 negative = (u < zero) | (v < zero) | (w < zero), positive = (u > zero) | (v > zero) | (w > zero);
  Float4 det = u + v + w;
  Float4 t = absolute((u * (r.shear.scale * az) + v * (r.shear.scale * bz) + w * (r.shear.scale * cz)) * (1.0f / det));
  Int4 hit = ~(negative & positive) & (det != zero) & (t >= splat4(t_min)) & (t <= splat4(t_max));
  return bits_of(hit) & ((1u << (b.count & ~LAST_IN_LEAF)) - 1u);
}

FN void step_block(Lane &l, const WideTree &tree) {
  uint32_t &ref = l.refs[l.top - 1];
  const TriangleBlock &b = tree.blocks[REF_INDEX(ref)];
  l.block = &b;
  l.candidates = candidates(b, l.local, l.ray.t_min, l.best.t);
  ref++; /* the leaf's next block, if there is one */
  l.top -= b.count >> 31;
}

/* Drops what lies behind the closest hit; after any hit nothing is left to do. */
FN void shorten(Lane &l, int any) {
  l.limit = l.best.t * LIMIT_SLACK;
  uint32_t kept = 1;
  for (uint32_t k = 1; k < l.top && !any; k++) {
    uint32_t ref = l.refs[k];
    float enter = l.enters[k];
    l.refs[kept] = ref;
    l.enters[kept] = enter;
    kept += enter <= l.limit;
  }
  l.top = kept;
}

FN real3 corner_of(const TriangleBlock &b, int c, uint k) { return make_real3(b.corner[c][0][k], b.corner[c][1][k], b.corner[c][2][k]); }

FN void hit_candidates(Lane &l, int any) {
  const TriangleBlock &b = *l.block;
  float before = l.best.t;
  for (unsigned bits = l.candidates; bits; bits &= bits - 1) {
    uint k = uint(__builtin_ctz(bits));
    if (!(b.visibility[k] & l.ray.kind)) continue;
    TriangleHit h = triangle_hit(corner_of(b, 0, k), corner_of(b, 1, k), corner_of(b, 2, k), l.local.origin,
                                 l.local.direction, l.local.shear);
    l.best = keep_closer(l.best, h, l.instance != NONE ? l.instance : b.instance[k], b.primitive[k], l.ray);
  }
  if (l.best.t < before || (any && l.best.instance != NONE)) shorten(l, any);
}

/* A sphere, an instance, the way back from one, a triangle of a mesh that deforms, or a segment of a strand. Apart: most
 * rays meet none, and inlined, all of this made the loops below 15 % slower. */
FN_APART void step_rare(Lane &l, const WideTree &tree, Scene s, int any) {
  uint32_t ref = l.refs[--l.top];
  if (ref == REF_RETURN) {
    enter_space(l, l.ray.origin, l.ray.direction, NONE);
  } else if (REF_KIND(ref) == REF_SPHERE) {
    float before = l.best.t;
    l.best = l.instance == NONE ? hit_sphere(s, REF_INDEX(ref), l.local, l.ray, l.best)
                                : hit_single(s, REF_INDEX(ref), l.instance, l.local, l.ray, l.best);
    if (l.best.t < before || (any && l.best.instance != NONE)) shorten(l, any);
  } else {
    const Instance &i = s.instances[REF_INDEX(ref)];
    if ((i.visibility & l.ray.kind) && is_within(REF_INDEX(ref), l.ray)) {
      push(l, REF_RETURN);
      LocalRay local = ray_in_instance(s, REF_INDEX(ref), l.ray);
      enter_space(l, local.origin, local.direction, REF_INDEX(ref));
      push(l, tree.roots[REF_INDEX(ref)]);
    }
  }
}

/* What is neither node nor triangle. False where the ray is done. */
FN bool step_other(Lane &l, const WideTree &tree, Scene s, int any) {
  if (l.refs[l.top - 1] == REF_DONE) return false;
  step_rare(l, tree, s, any);
  return true;
}

/* Asks for the node or block that a reference names. */
FN void fetch(const WideTree &tree, uint32_t ref) {
  const char *node = reinterpret_cast<const char *>(tree.nodes.data() + (REF_KIND(ref) == REF_NODE ? ref : 0));
  const char *block = reinterpret_cast<const char *>(tree.blocks.data() + REF_INDEX(ref));
  const char *next = REF_KIND(ref) == REF_TRIANGLES ? block : node;
  __builtin_prefetch(next);
  __builtin_prefetch(next + 64);
  __builtin_prefetch(next + 128);
  __builtin_prefetch(next + 192);
}

/* Closest hits of the rays source.ray(0) to source.ray(count - 1), given to source.store(number, hit); with
 * any != 0 the first one found of each, which says only that there is one. The same as trace() of kernels/bvh.h. */
template <typename Source>
static void trace_wide(const WideTree &tree, Scene s, Source &source, uint count, int any) {
  Lane lanes[LANES];
  uint nodes[LANES], blocks[LANES], others[LANES], found[LANES];
  uint at_node = 0, at_block = 0, at_other = 0, started = 0;
  /* Puts a lane where its next step belongs: at the end of each list, of which one grows. */
  auto enqueue = [&](uint lane) __attribute__((always_inline)) {
    uint32_t ref = lanes[lane].refs[lanes[lane].top - 1], kind = REF_KIND(ref);
    nodes[at_node] = blocks[at_block] = others[at_other] = lane;
    at_node += kind == REF_NODE;
    at_block += kind == REF_TRIANGLES;
    at_other += kind > REF_TRIANGLES;
    fetch(tree, ref);
  };
  for (; started < count && started < LANES; started++) {
    start(lanes[started], tree, started, source.ray(started));
    enqueue(started);
  }
  while (at_node + at_block + at_other) {
    uint n = at_node;
    at_node = 0;
    for (uint i = 0; i < n; i++) {
      uint k = nodes[i];
      step_node(lanes[k], tree);
      enqueue(k);
    }
    n = at_block;
    at_block = 0;
    uint found_count = 0;
    for (uint i = 0; i < n; i++) {
      uint k = blocks[i];
      step_block(lanes[k], tree);
      found[found_count] = k;
      found_count += lanes[k].candidates != 0;
    }
    for (uint i = 0; i < found_count; i++) hit_candidates(lanes[found[i]], any);
    for (uint i = 0; i < n; i++) enqueue(blocks[i]);
    n = at_other;
    at_other = 0;
    for (uint i = 0; i < n; i++) {
      uint k = others[i];
      if (!step_other(lanes[k], tree, s, any)) {
        source.store(lanes[k].number, lanes[k].best);
        if (started == count) continue;
        start(lanes[k], tree, started, source.ray(started));
        started++;
      }
      enqueue(k);
    }
  }
}

}  // namespace ISOPHOTE_VARIANT
}  // namespace isophote
