/* Triangles on their way from a scene's arrays to the records that kernels read, in the order of a tree's leaves. */
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "../kernels/scene_records.h"

namespace isophote {

/* A scene's arrays (isophote/scene.py, FIELDS). */
struct SceneTriangles {
  const float *vertices;
  const uint32_t *triangles, *slots;
  const float *normals;
};

/* A run of a mesh's triangles, and how they come into the space of their tree. isophote/geometry.py, PART. */
struct Part {
  uint32_t first, count;
  uint32_t instance; /* NONE: they stay in object space */
  uint32_t visibility;
  int32_t normals;   /* entry of the first one's in the scene's normals, -1: flat */
  uint32_t mirrored; /* two corners change places, so that a triangle's front stays its front */
  double to_world[12];
  double to_object[9];
};

/* Parts that lie one after the other: where each begins, and how many triangles they have. */
struct Parts {
  const Part *part;
  std::vector<size_t> start; /* one more than parts */
  Parts(const Part *parts, size_t count);
  size_t size() const { return start.back(); }
  /* How many of the `count` triangles that `order` names have normals; each is named at least once. */
  size_t smooth(const uint32_t *order, size_t count) const;
  size_t part_of(size_t triangle) const;
};

/* Corners of all triangles of the parts, 9 floats each: transformed in double, rounded once. */
void bake_corners(const SceneTriangles &scene, const Parts &parts, float *corners, int threads);

struct PlacedTriangles {
  Triangle *triangles;
  uint32_t *normal_index; /* into normals, NONE where flat */
  CornerNormals *normals;
};

/* Records of `count` triangles in a tree's order; `order` numbers the triangles of the parts, `last` marks ends of
 * leaves. */
void place_triangles(const SceneTriangles &scene, const Parts &parts, const float *corners, const uint32_t *order,
                     const uint8_t *last, size_t count, int threads, PlacedTriangles out);

/* bad[i]: the cross product of two edges of triangle i, of float32, is zero or not finite. */
void find_bad_triangles(const float *vertices, const uint32_t *triangles, size_t count, uint8_t *bad, int threads);

/* Low and high corner, 6 floats, of each mesh's triangles; zeros for a mesh without any. */
void find_mesh_boxes(const float *vertices, const uint32_t *triangles, const uint32_t *mesh_triangles, size_t meshes,
                     float *boxes, int threads);

/* Whether two blocks of memory hold the same bytes. */
bool same_bytes(const void *a, const void *b, size_t size, int threads);

bool all_finite(const float *values, size_t count, int threads);

}  // namespace isophote
