/* THE list of the scene's arrays: element type, name, meaning. Struct fields, kernel parameters,
 * the order of arguments and, through the binding, the numpy side are expanded from it. */
#ifndef ISOPHOTE_SCENE_BUFFERS_H
#define ISOPHOTE_SCENE_BUFFERS_H
#include "scene_records.h"

#define SCENE_BUFFERS(X)                                                                       \
  X(Camera, camera, "one")                                                                     \
  X(World, world, "one")                                                                       \
  X(Bvh2Node, nodes, "of the world's tree and of those of instanced meshes")                   \
  X(Triangle, triangles, "in the order of the leaves")                                         \
  X(uint, normal_index, "of each triangle: its entry in corner_normals, or NONE if flat")      \
  X(CornerNormals, corner_normals, "of smooth triangles")                                      \
  X(Sphere, spheres, "in the order of the leaves")                                             \
  X(Instance, instances, "every instance of the scene")                                        \
  X(uint, slot_materials, "material of each instance's slots")                                 \
  X(Material, materials, "")                                                                   \
  X(Instruction, instructions, "programs of the materials")                                    \
  X(Light, lights, "lamps, then emissive triangles")                                           \
  X(LightCluster, light_tree, "pairs of clusters: picks a light")                              \
  X(float, filter_table, "inverse CDF of the pixel filter of width 1")                 \
  X(float, albedo_tables, "directional albedos of microfacet closures (bsdf/albedo.h)")

typedef struct {
#define X(type, name, comment) GLOBAL const type *name;
  SCENE_BUFFERS(X)
#undef X
  GLOBAL const void *accelerator; /* of a host: its own tree (native/tracer.h) */
} Scene;

#endif
