#include "presplit.h"

#include <omp.h>

#include <algorithm>
#include <cmath>

namespace isophote {
namespace {

constexpr size_t CHUNK = 4096;
constexpr float OUTLIER = 16.0f; /* how many times its share of the scene's box a triangle may waste */
constexpr double BUDGET = 1.0;   /* about the most pieces, relative to the number of triangles */
constexpr int MAX_CUTS = 6;      /* one after the other: 64 pieces */
constexpr int GRID = 24;         /* levels of halving the scene's box */
constexpr float EDGE = 0.1f;     /* of a piece's extent, that no cut shall leave */

struct Point {
  float x[3];
};

/* Convex, in a plane: a triangle cut by MAX_CUTS planes. */
struct Polygon {
  Point points[3 + MAX_CUTS];
  int count = 0;
};

Box bounds(const Polygon &p) {
  Box box = no_box();
  for (int i = 0; i < p.count; i++)
    for (int a = 0; a < 3; a++) {
      box[a] = std::min(box[a], p.points[i].x[a]);
      box[4 + a] = std::min(box[4 + a], -p.points[i].x[a]);
    }
  return box;
}

/* Half the area of the box beyond what the flattest box around a rectangle of twice the polygon would have:
 * nothing for anything that lies across an axis. */
float needless(const Polygon &p, Box box) {
  float normal[3] = {};
  for (int i = 1; i + 1 < p.count; i++)
    for (int a = 0; a < 3; a++) {
      int b = (a + 1) % 3, c = (a + 2) % 3;
      const float *o = p.points[0].x, *q = p.points[i].x, *r = p.points[i + 1].x;
      normal[a] += (q[b] - o[b]) * (r[c] - o[c]) - (q[c] - o[c]) * (r[b] - o[b]);
    }
  return half_area(box) - fabs(normal[0]) - fabs(normal[1]) - fabs(normal[2]);
}

Polygon triangle(const BuildInput &input, size_t i) {
  Polygon p;
  p.count = 3;
  for (int k = 0; k < 3; k++) std::copy_n(input.meshes.corner(input.position_of(i), k), 3, p.points[k].x);
  return p;
}

/* What lies on the lower side (sign 1) or the upper one (-1) of a plane across an axis. */
Polygon cut(const Polygon &p, int axis, float at, float sign) {
  Polygon out;
  for (int i = 0; i < p.count; i++) {
    const Point &a = p.points[i], &b = p.points[(i + 1) % p.count];
    float da = (at - a.x[axis]) * sign, db = (at - b.x[axis]) * sign;
    if (da >= 0.0f) out.points[out.count++] = a;
    if ((da > 0.0f && db < 0.0f) || (da < 0.0f && db > 0.0f)) {
      Point &q = out.points[out.count++];
      for (int k = 0; k < 3; k++) q.x[k] = a.x[k] + da / (da - db) * (b.x[k] - a.x[k]);
      q.x[axis] = at;
    }
  }
  return out;
}

/* Where to cut between lo and hi: on the coarsest plane of the grid, so that pieces end where the tree's upper
 * splits are, or in the middle where that leaves too little. */
float cut_between(float lo, float hi, float scene_lo, float scene_hi) {
  for (int level = 1; level < GRID; level++) {
    float step = (scene_hi - scene_lo) / float(1 << level);
    float at = scene_lo + float(int64_t((hi - scene_lo) / step)) * step;
    if (at <= lo || at >= hi) continue;
    float edge = EDGE * (hi - lo);
    if (at - lo > edge && hi - at > edge) return at;
    break;
  }
  return 0.5f * lo + 0.5f * hi;
}

void add_pieces(const Polygon &p, uint32_t number, int cuts, float allowed, Box scene, std::vector<Piece> &pieces) {
  Box box = bounds(p);
  Float4 e = extent(box);
  int axis = e[1] > e[0] ? 1 : 0;
  if (e[2] > e[axis]) axis = 2;
  float at = cut_between(box[axis], -box[4 + axis], scene[axis], -scene[4 + axis]);
  if (cuts == MAX_CUTS || needless(p, box) <= allowed || !(at > box[axis] && at < -box[4 + axis]))
    return pieces.push_back({box, number});
  add_pieces(cut(p, axis, at, 1.0f), number, cuts + 1, allowed, scene, pieces);
  add_pieces(cut(p, axis, at, -1.0f), number, cuts + 1, allowed, scene, pieces);
}

}  // namespace

std::vector<Piece> cut_slanted(const BuildInput &input, Box scene, int threads) {
  size_t n = input.triangles(), chunks = (n + CHUNK - 1) / CHUNK;
  float share = half_area(scene) / float(n) * OUTLIER;
  std::vector<std::vector<uint32_t>> found(chunks);
  std::vector<double> sums(chunks, 0.0);
#pragma omp parallel for num_threads(threads) schedule(static)
  for (size_t chunk = 0; chunk < chunks; chunk++)
    for (size_t i = chunk * CHUNK; i < std::min(n, (chunk + 1) * CHUNK); i++) {
      Polygon p = triangle(input, i);
      float wasted = needless(p, bounds(p));
      if (!(wasted > share)) continue;
      found[chunk].push_back(uint32_t(i));
      sums[chunk] += double(wasted);
    }
  double sum = 0.0;
  for (double s : sums) sum += s;
  float allowed = std::max(share, float(sum / (BUDGET * double(n))));
  std::vector<Piece> pieces;
  if (!std::isfinite(allowed)) return pieces; /* at the edge of float's range */
  for (const auto &chunk : found)
    for (uint32_t i : chunk) {
      size_t before = pieces.size();
      add_pieces(triangle(input, i), i, 0, allowed, scene, pieces);
      if (pieces.size() == before + 1) pieces.pop_back();
    }
  return pieces;
}

}  // namespace isophote
