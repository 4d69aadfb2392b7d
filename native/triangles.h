/* A scene's meshes, and the records that tracing reads of their triangles. */
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "../kernels/scene_records.h"

namespace isophote {

/* How a mesh comes into the space of its tree. isophote/geometry.py, MESH_USE. */
struct MeshUse {
  uint32_t instance; /* its only user; NONE: it stays in object space */
  uint32_t visibility;
  uint32_t mirrored; /* two corners change places, so that a triangle's front stays its front */
  uint32_t unused;
  double to_world[12];
  double to_object[9];
};

/* Meshes as they are traced and shaded: vertices in the space of their tree. */
struct Meshes {
  const float *vertices;     /* 3 each */
  const uint32_t *triangles; /* 3 vertices each */
  const uint32_t *first;     /* triangle of each mesh, and one more */
  const MeshUse *uses;
  size_t count;

  size_t triangle_count() const { return first[count]; }
  const MeshUse &use_of(uint32_t primitive) const;
  Triangle record(uint32_t primitive) const; /* not LAST_IN_LEAF */
  const float *corner(uint32_t primitive, int k) const { return vertices + 3 * size_t(triangles[3 * size_t(primitive) + size_t(k)]); }
};

/* The triangles of a tree's leaves: what is made of them is made where it is asked for. */
struct LeafTriangles {
  Meshes meshes;
  const uint32_t *order; /* primitives; some are in several leaves */
  const uint8_t *last;   /* whether it ends its leaf */
  size_t count;

  Triangle operator[](size_t place) const;
};

/* Vertices as meshes' uses ask for: transformed in double, rounded once. `first`: vertex of each mesh, and one more. */
void bake_vertices(const float *from, const uint32_t *first, const MeshUse *uses, size_t meshes, float *to, int threads);

/* Normals likewise. `first_normal`: of each mesh, -1 for those that have none. */
void bake_normals(const float *from, const int32_t *first_normal, const uint32_t *first, const MeshUse *uses, size_t meshes,
                  float *to, int threads);

/* The records of a tree's leaves, in their order. */
void make_triangles(const LeafTriangles &leaves, Triangle *to, int threads);

/* bad[i]: the cross product of two edges of triangle i, of float32, is zero or not finite. */
void find_bad_triangles(const float *vertices, const uint32_t *triangles, size_t count, uint8_t *bad, int threads);

/* Low and high corner, 6 floats, of each mesh's triangles; zeros for a mesh without any. */
void find_mesh_boxes(const float *vertices, const uint32_t *triangles, const uint32_t *mesh_triangles, size_t meshes,
                     float *boxes, int threads);

bool all_finite(const float *values, size_t count, int threads);

}  // namespace isophote
