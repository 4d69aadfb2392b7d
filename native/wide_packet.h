/* Traversal of the wide tree for packets of sixteen rays that go much the same way: those of the camera.
 *
 * All rays of a packet are at the same node. Its eight boxes are tested at once against the packet's bounds
 * (interval arithmetic as in Boulos, Wald and Shirley 2006, "Geometric and Arithmetic Culling Methods for
 * Entire Ray Packets"), then those that are left one by one against the sixteen rays. Triangles are tested
 * likewise, the sixteen rays at a time, and triangle_hit itself runs in a vectorised loop over the rays. */
#pragma once
#include "wide_trace.h"

namespace isophote {
namespace ISOPHOTE_VARIANT {

constexpr uint PACKET = 16;

/* Sixteen rays, value by value, and their bounds. */
struct alignas(64) Packet {
  union Column {
    Float16 all;
    float at[PACKET];
  };
  Column origin[3], direction[3], inverse[3], near_offset[3], far_offset[3];
  Column shear_x, shear_y, scale, t_min, box_t_min, t, u, v;
  float low_inverse[3], high_inverse[3]; /* over the rays */
  float near_origin[3], far_origin[3];   /* of the origins those that make near planes nearest, far ones farthest */
  int near_row[3]; /* as in Lane */
  float first, limit; /* least t_min, largest t: widened */
  int axis;           /* the largest of the direction, the same in all */
  uint instance[PACKET], primitive[PACKET];
  uint after_instance[PACKET], after_primitive[PACKET], skip_instance[PACKET], skip_primitive[PACKET], kind[PACKET];
};

struct Bounds {
  float low, high;
};
FN Bounds bounds_of(const Packet::Column &c) {
  Bounds b{c.at[0], c.at[0]};
  for (uint k = 1; k < PACKET; k++) {
    b.low = min_real(b.low, c.at[k]);
    b.high = max_real(b.high, c.at[k]);
  }
  return b;
}

/* Rays from to from + count - 1, the first of them again where there are no more. */
template <typename Source>
static void load_packet(Packet &p, const Source &source, uint from, uint count) {
  for (uint k = 0; k < PACKET; k++) {
    const Ray r = source.ray(from + (k < count ? k : 0));
    p.origin[0].at[k] = r.origin.x;
    p.origin[1].at[k] = r.origin.y;
    p.origin[2].at[k] = r.origin.z;
    p.direction[0].at[k] = r.direction.x;
    p.direction[1].at[k] = r.direction.y;
    p.direction[2].at[k] = r.direction.z;
    p.t_min.at[k] = r.t_min;
    p.t.at[k] = r.t_max;
    p.after_instance[k] = r.after_instance;
    p.after_primitive[k] = r.after_primitive;
    p.skip_instance[k] = r.skip_instance;
    p.skip_primitive[k] = r.skip_primitive;
    p.kind[k] = r.kind;
  }
}

/* What tests of triangles need beside the rays; those are for the axis of the first ray. 0 where all have that axis. */
static int start_packet(Packet &p) {
  p.axis = make_shear(make_real3(p.direction[0].at[0], p.direction[1].at[0], p.direction[2].at[0])).axis;
  int axis = p.axis, apart = 0;
#pragma omp simd reduction(| : apart)
  for (uint k = 0; k < PACKET; k++) {
    Shear shear = make_shear(make_real3(p.direction[0].at[k], p.direction[1].at[k], p.direction[2].at[k]));
    apart |= shear.axis ^ axis;
    p.shear_x.at[k] = shear.shear_x;
    p.shear_y.at[k] = shear.shear_y;
    p.scale.at[k] = shear.scale;
    p.box_t_min.at[k] = p.t_min.at[k] * (1.0f - 16.0f * ROUNDING);
    p.u.at[k] = p.v.at[k] = 0.0f;
    p.instance[k] = p.primitive[k] = NONE;
  }
  return apart;
}

/* What a walk needs as well. False where the rays go too different ways to be a packet. */
static bool prepare_packet(Packet &p) {
  int apart = start_packet(p);
  for (int a = 0; a < 3; a++) {
    Slab<Float16> slab = make_slab(p.origin[a].all, p.direction[a].all);
    p.inverse[a].all = slab.inverse;
    p.near_offset[a].all = slab.near_offset;
    p.far_offset[a].all = slab.far_offset;
    Bounds inverse = bounds_of(p.inverse[a]), origin = bounds_of(p.origin[a]);
    bool back = inverse.low < 0.0f;
    apart |= back & (inverse.high > 0.0f);
    p.low_inverse[a] = inverse.low;
    p.high_inverse[a] = inverse.high;
    p.near_origin[a] = back ? origin.low : origin.high;
    p.far_origin[a] = back ? origin.high : origin.low;
    p.near_row[a] = (2 * a + back) * ROW;
  }
  p.first = bounds_of(p.box_t_min).low;
  p.limit = bounds_of(p.t).high * LIMIT_SLACK;
  return !apart;
}

/* Children that some ray of the packet may enter, and a lower bound of where. */
FN Int8 enter_bounds(const Packet &p, const WideNode &n, Float8 &enter) {
  enter = splat8(p.first);
  Float8 leave = splat8(p.limit);
  for (int a = 0; a < 3; a++) {
    Float8 near = row(n, p.near_row[a]) - p.near_origin[a], far = row(n, p.near_row[a] ^ ROW) - p.far_origin[a];
    enter = larger(smaller(near * p.low_inverse[a], near * p.high_inverse[a]), enter);
    leave = smaller(larger(far * p.low_inverse[a], far * p.high_inverse[a]), leave);
  }
  enter = enter * (1.0f - 8.0f * ROUNDING);
  return enter <= leave * ENTER_SLACK;
}

FN bool enters_child(const Packet &p, const WideNode &n, uint k) {
  Float16 enter = p.box_t_min.all, leave = p.t.all * LIMIT_SLACK;
  for (int a = 0; a < 3; a++) {
    float near = n.bounds[p.near_row[a] / ROW][k], far = n.bounds[(p.near_row[a] ^ ROW) / ROW][k];
    enter = larger(multiply_add(splat16(near), p.inverse[a].all, p.near_offset[a].all), enter);
    leave = smaller(multiply_add(splat16(far), p.inverse[a].all, p.far_offset[a].all), leave);
  }
  return any_of(enter <= leave * ENTER_SLACK);
}

/* What may_hit looks at: a walk comes near what it tests, so distances rarely tell more there. */
enum Test { EDGES, EDGES_AND_DISTANCE };

/* Whether the line of any ray may pass the triangle, and if asked no farther than the ray has hit something:
 * triangle_hit's arithmetic. */
template <Test TEST>
FN bool may_hit(const Packet &p, const TriangleBlock &b, uint k) {
  STRICT_FP
  int z = p.axis, x = z == 2 ? 0 : z + 1, y = z == 0 ? 2 : z - 1;
  Float16 px[3], py[3], pz[3];
  for (int c = 0; c < 3; c++) {
    pz[c] = b.corner[c][z][k] - p.origin[z].all;
    px[c] = b.corner[c][x][k] - p.origin[x].all - p.shear_x.all * pz[c];
    py[c] = b.corner[c][y][k] - p.origin[y].all - p.shear_y.all * pz[c];
  }
  Float16 u = px[2] * py[1] - py[2] * px[1], v = px[0] * py[2] - py[0] * px[2], w = px[1] * py[0] - py[1] * px[0];
  Float16 zero{};
  Int16 negative = (u < zero) | (v < zero) | (w < zero), positive = (u > zero) | (v > zero) | (w > zero);
  Int16 hit = ~(negative & positive);
  if (TEST == EDGES || !any_of(hit)) return any_of(hit);
  Float16 det = u + v + w, scale = p.scale.all;
  Float16 t = absolute((u * (scale * pz[0]) + v * (scale * pz[1]) + w * (scale * pz[2])) * (1.0f / det));
  return any_of(hit & (t >= p.t_min.all) & (t <= p.t.all));
}

FN Hit hit_of(const Packet &p, uint k) {
  Hit h;
  h.t = p.t.at[k];
  h.u = p.u.at[k];
  h.v = p.v.at[k];
  h.instance = p.instance[k];
  h.primitive = p.primitive[k];
  return h;
}

FN void set_hit(Packet &p, uint k, Hit h) {
  p.t.at[k] = h.t;
  p.u.at[k] = h.u;
  p.v.at[k] = h.v;
  p.instance[k] = h.instance;
  p.primitive[k] = h.primitive;
}

/* Whether a triangle of the block may have become some ray's closest. */
template <Test TEST>
static bool hit_block(Packet &p, const TriangleBlock &b) {
  uint count = b.count & ~LAST_IN_LEAF;
  bool closer = false;
  for (uint k = 0; k < count; k++) {
    if (!may_hit<TEST>(p, b, k)) continue;
    real3 v0 = corner_of(b, 0, k), v1 = corner_of(b, 1, k), v2 = corner_of(b, 2, k);
    uint instance = b.instance[k], primitive = b.primitive[k], kinds = b.visibility[k];
#pragma omp simd
    for (uint i = 0; i < PACKET; i++) {
      Shear shear;
      shear.axis = p.axis;
      shear.shear_x = p.shear_x.at[i];
      shear.shear_y = p.shear_y.at[i];
      shear.scale = p.scale.at[i];
      TriangleHit h = triangle_hit(v0, v1, v2, make_real3(p.origin[0].at[i], p.origin[1].at[i], p.origin[2].at[i]),
                                   make_real3(p.direction[0].at[i], p.direction[1].at[i], p.direction[2].at[i]), shear);
      h.hit &= (kinds & p.kind[i]) != 0;
      Ray ray = free_ray(zero3(), zero3(), REAL(0.0), REAL(0.0));
      ray.t_min = p.t_min.at[i];
      ray.after_instance = p.after_instance[i];
      ray.after_primitive = p.after_primitive[i];
      ray.skip_instance = p.skip_instance[i];
      ray.skip_primitive = p.skip_primitive[i];
      set_hit(p, i, keep_closer(hit_of(p, i), h, instance, primitive, ray));
    }
    closer = true;
  }
  return closer;
}

static void walk_packet(Packet &p, const WideTree &tree) {
  uint32_t refs[STACK + WIDTH];
  float enters[STACK + WIDTH];
  uint top = 0;
  uint32_t ref = tree.root;
  for (;;) {
    if (REF_KIND(ref) == REF_NODE) {
      const WideNode &n = tree.nodes[ref];
      Float8 enter;
      Int8 entered = enter_bounds(p, n, enter);
      alignas(32) int keys[WIDTH];
      uint count = order_children(entered, enter, reinterpret_cast<Int8 *>(keys));
      for (uint i = 0; i < count; i++) {
        uint k = uint(keys[i]) & 7u;
        refs[top] = n.child[k];
        enters[top] = float_of_bits(uint(keys[i]) & ~7u);
        fetch(tree, n.child[k]);
        top += enters_child(p, n, k);
      }
    } else {
      for (uint at = REF_INDEX(ref);; at++) {
        if (hit_block<EDGES>(p, tree.blocks[at])) p.limit = bounds_of(p.t).high * LIMIT_SLACK;
        if (tree.blocks[at].count & LAST_IN_LEAF) break;
      }
    }
    do {
      if (top == 0) return;
      ref = refs[--top];
    } while (enters[top] > p.limit);
  }
}

/* As trace_wide for closest hits, where neighbours among the rays go much the same way, in trees of triangles of the
 * world only. */
template <typename Source>
static void trace_packets(const WideTree &tree, Scene s, Source &source, uint count) {
  struct Rest {
    Source &source;
    uint first;
    Ray ray(uint i) const { return source.ray(first + i); }
    void store(uint i, const Hit &h) { source.store(first + i, h); }
  };
  Packet p;
  for (uint from = 0; from < count; from += PACKET) {
    uint n = count - from < PACKET ? count - from : PACKET;
    load_packet(p, source, from, n);
    if (tree.root == NONE || !prepare_packet(p)) {
      Rest rest{source, from};
      trace_wide(tree, s, rest, n, 0);
      continue;
    }
    walk_packet(p, tree);
    for (uint k = 0; k < n; k++) source.store(from + k, hit_of(p, k));
  }
}

}  // namespace ISOPHOTE_VARIANT
}  // namespace isophote
