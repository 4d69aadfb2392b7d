#include "triangles.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace isophote {
namespace {

/* Triangles that a thread takes at once; for fewer than that none is woken: to OpenMP a new caller is a new team. */
constexpr size_t CHUNK = 4096;

/* Calls work(part, first, end) for runs of triangles of one part each, in parallel. */
template <typename Work>
void for_runs(const Parts &parts, int threads, Work work) {
  size_t n = parts.size();
#pragma omp parallel for num_threads(threads) schedule(static) if (n > CHUNK)
  for (size_t chunk = 0; chunk < (n + CHUNK - 1) / CHUNK; chunk++) {
    size_t first = chunk * CHUNK, end = std::min(n, first + CHUNK);
    for (size_t p = parts.part_of(first); first < end; p++) {
      size_t stop = std::min(end, parts.start[p + 1]);
      work(p, first, stop);
      first = stop;
    }
  }
}

void transform_point(const double *m, const float *from, float *to) {
  double x = double(from[0]), y = double(from[1]), z = double(from[2]);
  for (int row = 0; row < 3; row++) to[row] = float(m[4 * row] * x + m[4 * row + 1] * y + m[4 * row + 2] * z + m[4 * row + 3]);
}

/* Normals go with the inverse's transpose. */
packed3 transform_normal(const double *inverse, const float *n) {
  double x = double(n[0]), y = double(n[1]), z = double(n[2]), out[3];
  for (int column = 0; column < 3; column++)
    out[column] = x * inverse[column] + y * inverse[3 + column] + z * inverse[6 + column];
  double length = __builtin_sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
  if (!(length > 0.0)) length = 1.0;
  return {float(out[0] / length), float(out[1] / length), float(out[2] / length)};
}

CornerNormals bake_normals(const Part &part, const float *n) {
  CornerNormals out;
  if (part.instance == NONE) {
    std::memcpy(&out, n, sizeof out);
    return out;
  }
  out.n0 = transform_normal(part.to_object, n);
  out.n1 = transform_normal(part.to_object, n + (part.mirrored ? 6 : 3));
  out.n2 = transform_normal(part.to_object, n + (part.mirrored ? 3 : 6));
  return out;
}

}  // namespace

Parts::Parts(const Part *parts, size_t count) : part(parts), start(count + 1, 0) {
  for (size_t p = 0; p < count; p++) start[p + 1] = start[p] + parts[p].count;
}

size_t Parts::smooth(const uint32_t *order, size_t count) const {
  size_t sum = 0;
  if (count == size()) {
    for (size_t p = 0; p + 1 < start.size(); p++) sum += part[p].normals < 0 ? 0 : part[p].count;
  } else {
    for (size_t k = 0; k < count; k++) sum += part[part_of(order[k])].normals >= 0;
  }
  return sum;
}

size_t Parts::part_of(size_t triangle) const {
  return size_t(std::upper_bound(start.begin(), start.end(), triangle) - start.begin()) - 1;
}

void bake_corners(const SceneTriangles &scene, const Parts &parts, float *corners, int threads) {
  for_runs(parts, threads, [&](size_t p, size_t first, size_t end) {
    const Part &part = parts.part[p];
    const uint32_t *triangle = scene.triangles + 3 * (part.first + first - parts.start[p]);
    for (size_t t = first; t < end; t++, triangle += 3) {
      float *out = corners + 9 * t;
      for (int c = 0; c < 3; c++) {
        const float *vertex = scene.vertices + 3 * size_t(triangle[part.mirrored && c ? 3 - c : c]);
        if (part.instance == NONE)
          std::memcpy(out + 3 * c, vertex, 3 * sizeof(float));
        else
          transform_point(part.to_world, vertex, out + 3 * c);
      }
    }
  });
}

void place_triangles(const SceneTriangles &scene, const Parts &parts, const float *corners, const uint32_t *order,
                     const uint8_t *last, size_t count, int threads, PlacedTriangles out) {
  size_t chunks = (count + CHUNK - 1) / CHUNK;
  std::vector<uint32_t> smooth(chunks + 1, 0); /* smooth triangles of each chunk, then before it */
#pragma omp parallel for num_threads(threads) schedule(static) if (chunks > 1)
  for (size_t chunk = 0; chunk < chunks; chunk++) {
    for (size_t k = chunk * CHUNK; k < std::min(count, (chunk + 1) * CHUNK); k++) {
      size_t p = parts.part_of(order[k]);
      const Part &part = parts.part[p];
      uint32_t primitive = uint32_t(part.first + order[k] - parts.start[p]);
      Triangle &t = out.triangles[k];
      const float *c = corners + 9 * size_t(order[k]);
      t.v0 = {c[0], c[1], c[2]};
      t.v1 = {c[3], c[4], c[5]};
      t.v2 = {c[6], c[7], c[8]};
      t.primitive = primitive;
      t.instance = part.instance;
      t.slot = scene.slots[primitive] | part.visibility << 16 | (last[k] ? LAST_IN_LEAF : 0u);
      /* The place in the scene's normals for now, below that in the tree's. */
      out.normal_index[k] = part.normals < 0 ? NONE : uint32_t(part.normals) + primitive - part.first;
      smooth[chunk + 1] += part.normals >= 0;
    }
  }
  for (size_t chunk = 0; chunk < chunks; chunk++) smooth[chunk + 1] += smooth[chunk];
  if (!smooth[chunks]) return;
#pragma omp parallel for num_threads(threads) schedule(static) if (chunks > 1)
  for (size_t chunk = 0; chunk < chunks; chunk++) {
    uint32_t at = smooth[chunk];
    for (size_t k = chunk * CHUNK; k < std::min(count, (chunk + 1) * CHUNK); k++) {
      uint32_t &index = out.normal_index[k];
      if (index == NONE) continue;
      out.normals[at] = bake_normals(parts.part[parts.part_of(order[k])], scene.normals + 9 * size_t(index));
      index = at++;
    }
  }
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

bool same_bytes(const void *a, const void *b, size_t size, int threads) {
  constexpr size_t block = 1 << 20;
  uint32_t differ = 0;
#pragma omp parallel for num_threads(threads) schedule(static) reduction(| : differ) if (size > block)
  for (size_t at = 0; at < size; at += block)
    differ |= std::memcmp(static_cast<const char *>(a) + at, static_cast<const char *>(b) + at, std::min(block, size - at)) != 0;
  return !differ;
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
