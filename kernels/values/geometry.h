/* The surface around the point: spaces, what a pixel covers of it, its triangle's edges. */
#ifndef ISOPHOTE_VALUES_GEOMETRY_H
#define ISOPHOTE_VALUES_GEOMETRY_H
#include "../panorama.h"
#include "attribute.h"
#include "object_space.h"
#include "value.h"

/* X(number, name, inputs, outputs) */
#define VALUES_GEOMETRY(X)        \
  X(224, footprint, 0, 10)        \
  X(225, attribute_at, 2, 4)      \
  X(226, to_object_vector, 3, 3)  \
  X(227, to_world_vector, 3, 3)   \
  X(228, to_object_normal, 3, 3)  \
  X(229, to_world_normal, 3, 3)   \
  X(230, wireframe, 1, 1)         \
  X(231, smooth_normal, 0, 3)     \
  X(232, to_camera_vector, 3, 3)  \
  X(233, window_point, 3, 3)

/* v made unit, or `other` where v has no direction. */
FN real3 unit_or(real3 v, real3 other) {
  real square = dot3(v, v);
  int fine = (square > REAL(1e-36)) & (square < REAL(1e36));
  return select3(fine, v * (REAL(1.0) / sqrt(fine ? square : REAL(1.0))), other);
}

/* Vectors between the object's space and the world's; spheres have no space of their own. */
FN real3 to_object(Scene s, Point at, real3 v) {
  return select3(at.instance == SPHERE_INSTANCE, v, vector_into_object(s, at, v));
}
FN real3 to_world_space(Scene s, Point at, real3 v) {
  return select3(at.instance == SPHERE_INSTANCE, v, vector_out_of_object(s, at, v));
}
FN real3 normal_to_object(Scene s, Point at, real3 n) {
  real3 turned = normal_into_object(s, at, n);
  return unit_or(select3(at.instance == SPHERE_INSTANCE, n, turned), zero3());
}
FN real3 normal_to_world(Scene s, Point at, real3 n) {
  real3 turned = normal_out_of_object(s, at, n);
  return unit_or(select3(at.instance == SPHERE_INSTANCE, n, turned), zero3());
}

/* The corners of the triangle, in the world, relative to the first. */
typedef struct {
  real3 e1, e2;
} Edges;

FN Edges triangle_edges(Scene s, Point at) {
  Edges e;
  GLOBAL const Instance *instance = instance_of(s, at);
  GLOBAL const uint *corner = &s.indices[at.instance == SPHERE_INSTANCE ? 0u : 3u * at.primitive];
  real3 v0 = vertex_at(s, at.instance, corner[0], at.time, at.in_time);
  real3 e1 = vertex_at(s, at.instance, corner[1], at.time, at.in_time) - v0;
  real3 e2 = vertex_at(s, at.instance, corner[2], at.time, at.in_time) - v0;
  int instanced = instance->root != NONE;
  e.e1 = select3(instanced, vector_out_of_object(s, at, e1), e1);
  e.e2 = select3(instanced, vector_out_of_object(s, at, e2), e2);
  return e;
}

/* How wide a pixel is where the ray met the surface, metres, as the camera would see it from so far: Igehy 1999,
 * "Tracing Ray Differentials", with one width for all directions, the mean of a pixel's sides. It grows with the length
 * of the path, by the angle that the pixel spans, which is smaller away from the middle of the picture. Before the ray
 * begins the path counts as straight: true of a ray of the camera and of the one behind its first bounce. */
FN real footprint_width(Scene s, Point at) {
  Camera c = s.camera[0];
  real x = fabs(to_real(c.right) - to_real(c.left)) / real_of(c.width);
  real y = fabs(to_real(c.top) - to_real(c.bottom)) / real_of(c.height);
  real3 begin = turned_to_camera(c, at.p - at.direction * at.length - load3(c.position));
  real before = sqrt(dot3(begin, begin));
  begin = begin * (REAL(1.0) / max_real(before, REAL(1e-30)));
  int seen = (at.kind & RAY_CAMERA) != 0u;
  real3 along = turned_to_camera(c, at.direction), d = select3(seen, along, begin);
  int framed = (d.x >= to_real(c.left) * d.z) & (d.x <= to_real(c.right) * d.z) & (d.y >= to_real(c.bottom) * d.z) &
               (d.y <= to_real(c.top) * d.z);
  d = select3(framed, d, make_real3(REAL(0.0), REAL(0.0), REAL(1.0)));
  real angle = d.z * (x * safe_sqrt(REAL(1.0) - d.x * d.x) + y * safe_sqrt(REAL(1.0) - d.y * d.y));
  real width = REAL(0.5) * (c.kind == CAMERA_PERSPECTIVE ? angle * (before + at.length) : x + y);
#if SCENE_FEATURES & FEATURE_PANORAMA
  if (is_panorama(c.kind))
    width = (seen ? panorama_pixel(c, c.kind, along) : to_real(c.pixel)) * (before + at.length);
#endif
  /* Below that float32 tells points of the surface no longer apart. */
  return max_real(width, max_of3(abs3(at.p)) * REAL(1e-5) + REAL(1e-12));
}

/* Two axes along the surface at right angles, as Cycles has them: which ones they are shows where a height jumps within
 * a footprint. */
FN Frame surface_axes(real3 n) {
  int even = (n.x == n.y) & (n.x == n.z);
  Frame f;
  f.x = normalize3(cross3(even ? make_real3(REAL(-1.0), REAL(1.0), REAL(1.0)) : splat3(REAL(1.0)), n));
  f.y = cross3(n, f.x);
  f.z = n;
  return f;
}

/* Steps along the surface, a footprint long, at right angles: their vectors in the world, and by how much the weights of
 * the triangle's second and third corner change on the way. */
VALUE(footprint) {
  real width = footprint_width(s, at);
  Frame frame = surface_axes(at.ng);
  real3 dx = frame.x * width, dy = frame.y * width;
  Edges e = triangle_edges(s, at);
  real3 n = cross3(e.e1, e.e2);
  real square = dot3(n, n);
  int flat = (at.instance != SPHERE_INSTANCE) & (square > REAL(0.0));
  n = n * (flat ? REAL(1.0) / square : REAL(0.0));
  OUT3(0, dx)
  OUT3(3, dy)
  OUT(6) = flat ? dot3(cross3(dx, e.e2), n) : REAL(0.0);
  OUT(7) = flat ? dot3(cross3(e.e1, dx), n) : REAL(0.0);
  OUT(8) = flat ? dot3(cross3(dy, e.e2), n) : REAL(0.0);
  OUT(9) = flat ? dot3(cross3(e.e1, dy), n) : REAL(0.0);
}

/* Attribute o.data at another place of the triangle's plane: weights of the second and third corner, in the mesh's
 * order. */
VALUE(attribute_at) {
  uint swapped = instance_of(s, at)->visibility & INSTANCE_MIRRORED;
  real u = IN(0), v = IN(1);
  at.u = swapped ? v : u;
  at.v = swapped ? u : v;
  Attribute a = read_attribute(s, o.data, at);
  OUT(0) = a.x;
  OUT(1) = a.y;
  OUT(2) = a.z;
  OUT(3) = a.w;
}

VALUE(to_object_vector) { OUT3(0, to_object(s, at, IN3(0))) }
VALUE(to_world_vector) { OUT3(0, to_world_space(s, at, IN3(0))) }
/* Unit. */
VALUE(to_object_normal) { OUT3(0, normal_to_object(s, at, IN3(0))) }
VALUE(to_world_normal) { OUT3(0, normal_to_world(s, at, IN3(0))) }

VALUE(to_camera_vector) { OUT3(0, turned_to_camera(s.camera[0], IN3(0))) }
/* Where the camera sees a point of its own space: 0 to 1 from the lower left of the frame. */
VALUE(window_point) {
  Camera c = s.camera[0];
  real3 p = IN3(0);
  real2 seen = seen_by_camera(c, p, unit_or(p, zero3()));
  /* Cycles shifts pictures only. */
  if (is_panorama(c.kind)) seen = make_real2(seen.x + to_real(c.shift_x), seen.y + to_real(c.shift_y));
  seen = share_of_window(c, seen);
  OUT3(0, make_real3(seen.x, seen.y, REAL(0.0)))
}

/* 1 within half of the size of an edge of the triangle, metres; o.data: pixels, as they are seen from the side. */
VALUE(wireframe) {
  Frame frame = make_frame(at.ng);
  real seen_x = safe_sqrt(REAL(1.0) - square(dot3(frame.x, at.direction)));
  real seen_y = safe_sqrt(REAL(1.0) - square(dot3(frame.y, at.direction)));
  real pixel = footprint_width(s, at) * REAL(0.5) * (seen_x + seen_y);
  real width = IN(0) * REAL(0.5) * (o.data ? pixel : REAL(1.0));
  Edges e = triangle_edges(s, at);
  uint swapped = instance_of(s, at)->visibility & INSTANCE_MIRRORED;
  real b1 = swapped ? at.v : at.u, b2 = swapped ? at.u : at.v, b0 = REAL(1.0) - b1 - b2;
  real3 n = cross3(e.e1, e.e2), e0 = e.e2 - e.e1;
  real area = sqrt(dot3(n, n));
  int near0 = b0 * area < width * sqrt(dot3(e0, e0));
  int near1 = b1 * area < width * sqrt(dot3(e.e2, e.e2));
  int near2 = b2 * area < width * sqrt(dot3(e.e1, e.e1));
  OUT(0) = ((at.instance != SPHERE_INSTANCE) & (near0 | near1 | near2)) ? REAL(1.0) : REAL(0.0);
}

/* A vertex's normal in the object's space. Those of meshes that lie in world space were turned there. */
FN real3 vertex_normal(Scene s, Point at, uint vertex) {
  GLOBAL const Instance *instance = instance_of(s, at);
  real3 n = stored_normal(s, at, vertex);
  return select3(instance->root != NONE, n, unit_or(transform_normal(instance->to_world, n), n));
}

/* The front's normal in the object's space, as it is interpolated: not unit. */
VALUE(smooth_normal) {
  GLOBAL const Instance *instance = instance_of(s, at);
  int smooth = (at.instance != SPHERE_INSTANCE) & ((instance->visibility & INSTANCE_SMOOTH) != 0u);
  GLOBAL const uint *corner = &s.indices[smooth ? 3u * at.primitive : 0u];
  uint swap = (instance->visibility & INSTANCE_MIRRORED) ? 1u : 0u;
  real3 flat = normal_to_object(s, at, at.backfacing ? zero3() - at.ng : at.ng);
  real3 n = flat;
  if (SCENE_FEATURES & s.world[0].features & FEATURE_SMOOTH) {
    real3 n0 = vertex_normal(s, at, corner[0]);
    real3 n1 = vertex_normal(s, at, corner[1u + swap]);
    real3 n2 = vertex_normal(s, at, corner[2u - swap]);
    n = n0 * (REAL(1.0) - at.u - at.v) + n1 * at.u + n2 * at.v;
  }
  OUT3(0, select3(smooth, n, flat))
}

#endif
