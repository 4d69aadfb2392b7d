/* Attributes of meshes at a point: UV maps, colours, whatever a mesh stores under a name. */
#ifndef ISOPHOTE_VALUES_ATTRIBUTE_H
#define ISOPHOTE_VALUES_ATTRIBUTE_H
#include "object_space.h"
#include "value.h"

/* Up to four components; one fills the first three, what is missing is 0, and 1 in w. */
typedef struct {
  real x, y, z, w;
} Attribute;

FN real attribute_component(Scene s, uint e0, uint e1, uint e2, real b0, Point at, uint k) {
  return to_real(s.attribute_values[e0 + k]) * b0 + to_real(s.attribute_values[e1 + k]) * at.u +
         to_real(s.attribute_values[e2 + k]) * at.v;
}

/* Attribute `number` of the mesh at a point, interpolated over its triangle. */
FN Attribute read_attribute(Scene s, uint number, Point at) {
  Attribute a;
  int is_mesh = at.instance != SPHERE_INSTANCE;
  uint instance = is_mesh ? at.instance : 0u, primitive = is_mesh ? at.primitive : 0u;
  MeshAttribute m = s.mesh_attributes[s.instance_meshes[instance] * s.world[0].attributes + number];
  uint swap = (s.instances[instance].visibility & INSTANCE_MIRRORED) ? 1u : 0u;
  uint c1 = 3u * primitive + 1u + swap, c2 = 3u * primitive + 2u - swap;
  int by_vertex = m.domain == DOMAIN_VERTEX, by_corner = m.domain == DOMAIN_CORNER;
  uint other = m.domain == DOMAIN_TRIANGLE ? primitive : 0u;
  uint e0 = by_vertex ? s.indices[3u * primitive] : by_corner ? 3u * primitive : other;
  uint e1 = by_vertex ? s.indices[c1] : by_corner ? c1 : other;
  uint e2 = by_vertex ? s.indices[c2] : by_corner ? c2 : other;
  int there = is_mesh & (m.domain != DOMAIN_NONE);
  uint last = there ? m.components - 1u : 0u;
  e0 = there ? m.first + m.components * e0 : 0u;
  e1 = there ? m.first + m.components * e1 : 0u;
  e2 = there ? m.first + m.components * e2 : 0u;
  real b0 = REAL(1.0) - at.u - at.v;
  real x = attribute_component(s, e0, e1, e2, b0, at, 0u);
  real y = attribute_component(s, e0, e1, e2, b0, at, min_uint(1u, last));
  real z = attribute_component(s, e0, e1, e2, b0, at, min_uint(2u, last));
  real w = attribute_component(s, e0, e1, e2, b0, at, last);
  a.x = there ? x : REAL(0.0);
  a.y = there ? y : REAL(0.0);
  a.z = (there & (last != 1u)) ? z : REAL(0.0);
  a.w = (there & (last == 3u)) ? w : REAL(1.0);
  return a;
}

/* The interpolated normal, unit and on the viewer's side, before it is bent for closures (Surface.ns). */
FN real3 unbent_normal(Scene s, Point at) {
  real3 n = at.ns;
  if (SCENE_FEATURES & s.world[0].features & FEATURE_SMOOTH) {
    int is_mesh = at.instance != SPHERE_INSTANCE;
    GLOBAL const Instance *instance = &s.instances[is_mesh ? at.instance : 0u];
    int smooth = is_mesh & ((instance->visibility & INSTANCE_SMOOTH) != 0u);
    GLOBAL const uint *corner = &s.indices[smooth ? 3u * at.primitive : 0u];
    uint swap = (instance->visibility & INSTANCE_MIRRORED) ? 1u : 0u;
    real3 n0 = stored_normal(s, at, corner[0]), n1 = stored_normal(s, at, corner[1u + swap]);
    real3 n2 = stored_normal(s, at, corner[2u - swap]);
    real3 own = n0 * (REAL(1.0) - at.u - at.v) + n1 * at.u + n2 * at.v;
    own = select3(instance->root != NONE, normal_out_of_object(s, at, own), own);
    real squared = dot3(own, own);
    int fine = smooth & (squared > REAL(0.0));
    real side = at.backfacing ? REAL(-1.0) : REAL(1.0);
    n = select3(fine, own * (side / sqrt(fine ? squared : REAL(1.0))), n);
  }
  return n;
}

#endif
