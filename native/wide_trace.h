/* Traversal of the wide tree for one ray: eight boxes, then four triangles, in one SIMD test each.
 *
 * SIMD only finds candidates; whether and where one is hit says triangle_hit, so the bits are those of
 * every other tree. Included once for each variant; only for float. */
#pragma once
#if defined(__SSE__)
#include <immintrin.h>
#endif

#include "../kernels/bvh.h"
#include "wide_tree.h"

/* Vectors wider than the target's registers only pass between functions that are inlined. */
#pragma GCC diagnostic ignored "-Wpsabi"

namespace isophote {
namespace ISOPHOTE_VARIANT {

typedef float Float8 __attribute__((vector_size(32)));
typedef float Float4 __attribute__((vector_size(16)));
typedef int Int8 __attribute__((vector_size(32)));
typedef int Int4 __attribute__((vector_size(16)));

FN Float8 larger(Float8 a, Float8 b) { return a > b ? a : b; }
FN Float8 smaller(Float8 a, Float8 b) { return a < b ? a : b; }

FN unsigned bits_of(Int8 mask) {
#if defined(__AVX__)
  return unsigned(_mm256_movemask_ps(__m256(mask)));
#else
  unsigned bits = 0;
  for (int k = 0; k < WIDTH; k++) bits |= unsigned(mask[k] & 1) << k;
  return bits;
#endif
}
FN unsigned bits_of(Int4 mask) {
#if defined(__SSE__)
  return unsigned(_mm_movemask_ps(__m128(mask)));
#else
  unsigned bits = 0;
  for (int k = 0; k < BLOCK; k++) bits |= unsigned(mask[k] & 1) << k;
  return bits;
#endif
}

/* A ray in the space of the tree, with the planes of boxes that it meets first on each axis. */
struct WideRay {
  LocalRay ray;
  int near_x, near_y, near_z; /* rows of WideNode::bounds; the far ones are their neighbours */
};

FN WideRay make_wide_ray(real3 origin, real3 direction) {
  WideRay r;
  r.ray = make_local_ray(origin, direction);
  r.near_x = r.ray.inverse.x < 0.0f ? 1 : 0;
  r.near_y = r.ray.inverse.y < 0.0f ? 3 : 2;
  r.near_z = r.ray.inverse.z < 0.0f ? 5 : 4;
  return r;
}

FN Float8 bound(const WideNode &n, int row) { return *reinterpret_cast<const Float8 *>(n.bounds[row]); }

/* Which children the ray enters before t_max, and where. */
FN unsigned enter_boxes(const WideNode &n, const WideRay &r, float t_min, float t_max, Float8 &enter) {
  const LocalRay &ray = r.ray;
  Float8 ax = (bound(n, r.near_x) - ray.origin.x) * ray.inverse.x, bx = (bound(n, r.near_x ^ 1) - ray.origin.x) * ray.inverse.x;
  Float8 ay = (bound(n, r.near_y) - ray.origin.y) * ray.inverse.y, by = (bound(n, r.near_y ^ 1) - ray.origin.y) * ray.inverse.y;
  Float8 az = (bound(n, r.near_z) - ray.origin.z) * ray.inverse.z, bz = (bound(n, r.near_z ^ 1) - ray.origin.z) * ray.inverse.z;
  enter = larger(larger(ax, ay), larger(az, Float8{} + t_min));
  Float8 leave = smaller(smaller(bx, by), smaller(bz, Float8{} + t_max));
  return bits_of(enter <= leave * SLAB_SLACK);
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
  Float4 t = (u * (r.shear.scale * az) + v * (r.shear.scale * bz) + w * (r.shear.scale * cz)) * (1.0f / det);
  Int4 hit = ~(negative & positive) & (det != zero) & (t >= zero + t_min) & (t <= zero + t_max);
  return bits_of(hit) & ((1u << (b.count & ~LAST_IN_LEAF)) - 1u);
}

FN Hit hit_blocks(const WideTree &tree, Scene s, uint index, uint instance, const LocalRay &local, const Ray &ray, Hit best) {
  for (;;) {
    const TriangleBlock &b = tree.blocks[index++];
    for (unsigned bits = candidates(b, local, ray.t_min, best.t); bits; bits &= bits - 1) {
      uint at = b.first + uint(__builtin_ctz(bits));
      const Triangle &t = s.triangles[at];
      if (instance == NONE && !((t.slot >> 16) & ray.kind)) continue;
      TriangleHit h = triangle_hit(load3(t.v0), load3(t.v1), load3(t.v2), local.origin, local.direction, local.shear);
      best = keep_closer(best, h, instance != NONE ? instance : t.instance, t.primitive, at, ray);
    }
    if (b.count & LAST_IN_LEAF) return best;
  }
}

/* The closest hit; with any != 0 the first one found. The same as trace() of kernels/bvh.h. */
static Hit trace_wide(const WideTree &tree, Scene s, Ray ray, int any) {
  struct Entry {
    uint ref;
    float t;
  };
  constexpr int STACK = WIDTH * STACK_SIZE;
  Entry stack[STACK];
  int top = 0;
  Hit best = no_hit(ray.t_max);
  uint instance = NONE;
  WideRay world = make_wide_ray(ray.origin, ray.direction);
  WideRay local = world;
  float slack_t_min = ray.t_min * (1.0f - 16.0f * ROUNDING);
  uint ref = tree.root;
  if (ref == NONE) return best;
  for (;;) {
    uint kind = REF_KIND(ref);
    if (kind == REF_NODE) {
      const WideNode &n = tree.nodes[ref];
      alignas(32) Float8 enter;
      unsigned bits = enter_boxes(n, local, slack_t_min, best.t * LIMIT_SLACK, enter);
      if (bits) {
        uint first = uint(__builtin_ctz(bits));
        bits &= bits - 1;
        if (!bits) {
          ref = n.child[first];
          continue;
        }
        int bottom = top;
        stack[top++] = {n.child[first], enter[first]};
        for (; bits; bits &= bits - 1) {
          uint k = uint(__builtin_ctz(bits));
          Entry entry{n.child[k], enter[k]};
          int at = top++;
          if (!any)
            for (; at > bottom && stack[at - 1].t < entry.t; at--) stack[at] = stack[at - 1];
          stack[at] = entry;
        }
        ref = stack[--top].ref;
        continue;
      }
    } else if (ref == REF_RETURN) {
      instance = NONE;
      local = world;
    } else if (kind == REF_TRIANGLES) {
      best = hit_blocks(tree, s, REF_INDEX(ref), instance, local.ray, ray, best);
      if (any && best.index != NONE) return best;
    } else if (kind == REF_SPHERES) {
      best = hit_spheres(s, REF_INDEX(ref), local.ray, ray, best);
      if (any && best.index != NONE) return best;
    } else {
      uint i = REF_INDEX(ref);
      if (s.instances[i].visibility & ray.kind) {
        stack[top++] = {REF_RETURN, 0.0f};
        instance = i;
        local = make_wide_ray(transform_point(s.instances[i].to_object, ray.origin),
                              transform_vector(s.instances[i].to_object, ray.direction));
        ref = tree.roots[i];
        continue;
      }
    }
    do {
      if (top == 0) return best;
      ref = stack[--top].ref;
    } while (stack[top].t > best.t * LIMIT_SLACK);
  }
}

}  // namespace ISOPHOTE_VARIANT
}  // namespace isophote
