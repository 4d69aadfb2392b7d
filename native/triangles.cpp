#include "triangles.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace isophote {
namespace {

/* Triangles or vertices that a thread takes at once; for fewer no other is woken: to OpenMP a new caller is a new team. */
constexpr size_t CHUNK = 4096;

/* Calls work(mesh, begin, end) for runs of vertices of one mesh each, in parallel. `first`: vertex of each mesh. */
template <typename Work>
void for_vertices(const uint32_t *first, size_t meshes, int threads, Work work) {
  size_t n = first[meshes];
#pragma omp parallel for num_threads(threads) schedule(static) if (n > CHUNK)
  for (size_t chunk = 0; chunk < (n + CHUNK - 1) / CHUNK; chunk++) {
    size_t begin = chunk * CHUNK, end = std::min(n, begin + CHUNK);
    for (size_t m = size_t(std::upper_bound(first, first + meshes + 1, begin) - first) - 1; begin < end; m++) {
      size_t stop = std::min(end, size_t(first[m + 1]));
      if (begin < stop) work(m, begin, stop);
      begin = stop;
    }
  }
}

void transform_point(const double *m, const float *from, float *to) {
  double x = double(from[0]), y = double(from[1]), z = double(from[2]);
  for (int row = 0; row < 3; row++) to[row] = float(m[4 * row] * x + m[4 * row + 1] * y + m[4 * row + 2] * z + m[4 * row + 3]);
}

/* Normals go with the inverse's transpose. */
void transform_normal(const double *inverse, const float *n, float *to) {
  double x = double(n[0]), y = double(n[1]), z = double(n[2]), out[3];
  for (int column = 0; column < 3; column++)
    out[column] = x * inverse[column] + y * inverse[3 + column] + z * inverse[6 + column];
  double length = __builtin_sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
  if (!(length > 0.0)) length = 1.0;
  for (int k = 0; k < 3; k++) to[k] = float(out[k] / length);
}

}  // namespace

const MeshUse &Meshes::use_of(uint32_t primitive) const {
  return uses[size_t(std::upper_bound(first, first + count + 1, primitive) - first) - 1];
}

Triangle Meshes::record(uint32_t primitive) const {
  const MeshUse &use = use_of(primitive);
  const float *a = corner(primitive, 0), *b = corner(primitive, use.mirrored ? 2 : 1), *c = corner(primitive, use.mirrored ? 1 : 2);
  Triangle t;
  t.v0 = {a[0], a[1], a[2]};
  t.v1 = {b[0], b[1], b[2]};
  t.v2 = {c[0], c[1], c[2]};
  t.primitive = primitive;
  t.instance = use.instance;
  t.flags = use.visibility << 16;
  return t;
}

Triangle LeafTriangles::operator[](size_t place) const {
  Triangle t = meshes.record(order[place]);
  t.flags |= last[place] ? LAST_IN_LEAF : 0u;
  return t;
}

void bake_vertices(const float *from, const uint32_t *first, const MeshUse *uses, size_t meshes, float *to, int threads) {
  for_vertices(first, meshes, threads, [&](size_t m, size_t begin, size_t end) {
    if (uses[m].instance == NONE) {
      std::memcpy(to + 3 * begin, from + 3 * begin, 3 * sizeof(float) * (end - begin));
    } else {
      for (size_t v = begin; v < end; v++) transform_point(uses[m].to_world, from + 3 * v, to + 3 * v);
    }
  });
}

void bake_normals(const float *from, const int32_t *first_normal, const uint32_t *first, const MeshUse *uses, size_t meshes,
                  float *to, int threads) {
  for_vertices(first, meshes, threads, [&](size_t m, size_t begin, size_t end) {
    if (first_normal[m] < 0) return;
    size_t at = 3 * (size_t(first_normal[m]) + begin - first[m]), count = end - begin;
    if (uses[m].instance == NONE) {
      std::memcpy(to + at, from + at, 3 * sizeof(float) * count);
    } else {
      for (size_t k = at; k < at + 3 * count; k += 3) transform_normal(uses[m].to_object, from + k, to + k);
    }
  });
}

void make_triangles(const LeafTriangles &leaves, Triangle *to, int threads) {
#pragma omp parallel for num_threads(threads) schedule(static) if (leaves.count > CHUNK)
  for (size_t k = 0; k < leaves.count; k++) to[k] = leaves[k];
}

void find_bad_triangles(const float *vertices, const uint32_t *triangles, size_t count, uint8_t *bad, int threads) {
#pragma omp parallel for num_threads(threads) schedule(static) if (count > CHUNK)
  for (size_t t = 0; t < count; t++) {
    const float *v[3];
    for (int c = 0; c < 3; c++) v[c] = vertices + 3 * size_t(triangles[3 * t + size_t(c)]);
    double e[2][3], reach = 0.0;
    for (int k = 0; k < 2; k++)
      for (int a = 0; a < 3; a++) {
        e[k][a] = double(v[k + 1][a] - v[0][a]);
        reach = std::max(reach, e[k][a] * e[k][a]);
      }
    double x = e[0][1] * e[1][2] - e[0][2] * e[1][1];
    double y = e[0][2] * e[1][0] - e[0][0] * e[1][2];
    double z = e[0][0] * e[1][1] - e[0][1] * e[1][0];
    double square = x * x + y * y + z * z;
    /* The products of triangle_hit must not overflow. */
    bad[t] = !(square > 0.0 && square <= std::numeric_limits<double>::max() && reach <= double(std::numeric_limits<float>::max()));
  }
}

void find_mesh_boxes(const float *vertices, const uint32_t *triangles, const uint32_t *mesh_triangles, size_t meshes,
                     float *boxes, int threads) {
  std::fill_n(boxes, 6 * meshes, 0.0f);
  for (size_t m = 0; m < meshes; m++) {
    const uint32_t *first = triangles + 3 * size_t(mesh_triangles[m]);
    size_t corners = 3 * size_t(mesh_triangles[m + 1] - mesh_triangles[m]);
    if (!corners) continue;
    float low[3], high[3];
    for (int a = 0; a < 3; a++) low[a] = high[a] = vertices[3 * size_t(first[0]) + size_t(a)];
#pragma omp parallel for num_threads(threads) schedule(static) reduction(min : low[:3]) reduction(max : high[:3]) \
    if (corners > 3 * CHUNK)
    for (size_t c = 0; c < corners; c++)
      for (int a = 0; a < 3; a++) {
        float x = vertices[3 * size_t(first[c]) + size_t(a)];
        low[a] = x < low[a] ? x : low[a];
        high[a] = x > high[a] ? x : high[a];
      }
    std::copy_n(low, 3, boxes + 6 * m);
    std::copy_n(high, 3, boxes + 6 * m + 3);
  }
}

bool all_finite(const float *values, size_t count, int threads) {
  uint32_t wrong = 0;
#pragma omp parallel for num_threads(threads) schedule(static) reduction(| : wrong) if (count > CHUNK)
  for (size_t i = 0; i < count; i++) {
    uint32_t bits;
    std::memcpy(&bits, values + i, sizeof bits);
    wrong |= (bits & 0x7f800000u) == 0x7f800000u;
  }
  return !wrong;
}

}  // namespace isophote
