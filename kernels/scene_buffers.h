/* THE list of the scene's arrays: element type, name, meaning. Struct fields, kernel parameters,
 * the order of arguments and, through the binding, the numpy side are expanded from it. */
#ifndef ISOPHOTE_SCENE_BUFFERS_H
#define ISOPHOTE_SCENE_BUFFERS_H
#include "scene_records.h"

#define SCENE_BUFFERS(X)                                                                       \
  X(Camera, camera, "and its poses where it moves")                                            \
  X(World, world, "one")                                                                       \
  X(Bvh2Node, nodes, "of the world's tree and of those of instanced meshes")                   \
  X(Triangle, triangles, "in the order of the leaves")                                         \
  X(packed3, vertices, "of all meshes; world space of meshes with one user, else object space") \
  X(uint, indices, "three vertices a triangle, in the scene's order; of strands, a segment's ends and the first again") \
  X(packed3, normals, "unit, of the vertices of smooth meshes, in the space of the vertices")  \
  X(float, radii, "of the vertices of strands, object space; of a strand's ends times -1")       \
  X(ushort, slots, "material slot of each triangle; empty where all are 0")                    \
  X(Sphere, spheres, "")                                                                       \
  X(Instance, instances, "every instance of the scene")                                        \
  X(Motion, motions, "of each instance; empty where none moves")                                \
  X(Pose, poses, "of the instances that move")                                                  \
  X(packed3, shapes, "vertices and normals of meshes that deform, in object space")             \
  X(uint, slot_materials, "material of each instance's slots")                                 \
  X(Material, materials, "")                                                                   \
  X(Instruction, instructions, "programs of the materials")                                    \
  X(AovOutput, aovs, "of each material")                                                       \
  X(ValueStep, steps, "what computes the materials' values")                                    \
  X(float, value_tables, "curves and ramps")                                                   \
  X(MeshAttribute, mesh_attributes, "of each mesh, in the order of the attributes; empty where no step reads one") \
  X(float, attribute_values, "")                                                               \
  X(uint, instance_meshes, "mesh of each instance; empty where no step reads an attribute")      \
  X(float, instance_values, "what steps ask of each instance, by instance and column")         \
  X(float, terminators, "cutoff of each instance that is smooth (terminator.h), else 0; empty where all are 0") \
  X(uint, light_groups, "of instances and spheres; empty where none has one")                  \
  X(float, pass_indices, "of instances, spheres and materials, then ids for Cryptomatte; either only where there are some") \
  X(Image, images, "")                                                                         \
  X(uint, texels, "of the images, in words of four bytes")                                      \
  X(Light, lights, "lamps, then emissive triangles")                                           \
  X(LightCluster, light_tree, "pairs of clusters: picks a light")                              \
  X(Link, links, "of instances, spheres and lamps; empty where nothing is linked")             \
  X(ushort, lit_shares, "of each cluster of light_tree and set of receivers: what part of its intensity lights them")  \
  X(float, world_map, "cumulated chances of its rows, then of the columns of each; empty where it is not drawn") \
  X(float, filter_table, "inverse CDFs of the pixel filter of width 1 and of the shutter")                 \
  X(float, albedo_tables, "directional albedos of microfacet closures (bsdf/albedo.h)")

typedef struct {
#define X(type, name, comment) GLOBAL const type *name;
  SCENE_BUFFERS(X)
#undef X
  GLOBAL const void *accelerator; /* of a host: its own tree (native/tracer.h) */
} Scene;

#endif
