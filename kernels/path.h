/* The state of a path as a value, and its load and store as a structure of arrays.
 *
 * One list names the fields. Arrays lie one after the other in two blocks, of reals and of uints,
 * each `stride` long, so that a path is a column. */
#ifndef ISOPHOTE_PATH_H
#define ISOPHOTE_PATH_H
#include "ray.h"

#define PATH_REALS(X)                                                                        \
  X(ox) X(oy) X(oz) X(dx) X(dy) X(dz) X(t_min) X(t_max)                                      \
  X(red) X(green) X(blue) /* throughput */                                                   \
  X(pdf) /* density per solid angle with which the direction was drawn; 0: no light sampling competes */

#define PATH_UINTS(X)                                                                        \
  X(after_instance) X(after_primitive) /* of a path inside an object: what it has hit there */ \
  X(slot)    /* where its result goes: pixel and sample of the item */                       \
  X(seed)    /* of pixel and replicate */                                                    \
  X(index)   /* of the sample within the replicate */                                        \
  X(bounces) /* counts by kind, 8 bits each: all, diffuse, glossy, transmission */           \
  X(status)  /* RAY_ bits of the last scattering | transparent count << 8 | PATH_ flags | receiver << 18 */

/* Normal of the last vertex (light_tree.h, pack_normal), in the highest bits of status. */
#define PATH_RECEIVER_SHIFT 18
#define PATH_LAST_HIT 0x10000u    /* a bounce limit is reached: see what is hit, do not scatter */
#define PATH_CAUGHT 0x20000u      /* has met a catcher of shadows (shadow_catcher.h) */
#define PATH_FROM_CAMERA RAY_CAMERA /* has only passed transparent surfaces: its hit is what the pixel shows */

typedef struct {
#define X(name) real name;
  PATH_REALS(X)
#undef X
#define X(name) uint name;
  PATH_UINTS(X)
#undef X
#if SCENE_FEATURES & FEATURE_MOTION
  real time; /* of the shutter; in a column of its own, which devices have only where something moves */
#endif
} Path;

enum {
#define X(name) PATH_REAL_##name,
  PATH_REALS(X)
#undef X
  PATH_REAL_COUNT
};
enum {
#define X(name) PATH_UINT_##name,
  PATH_UINTS(X)
#undef X
  PATH_UINT_COUNT
};

FN Path load_path(GLOBAL const real *reals, GLOBAL const uint *uints, uint stride, uint i) {
  Path p;
#define X(name) p.name = reals[PATH_REAL_##name * stride + i];
  PATH_REALS(X)
#undef X
#define X(name) p.name = uints[PATH_UINT_##name * stride + i];
  PATH_UINTS(X)
#undef X
  return p;
}

FN void store_path(GLOBAL real *reals, GLOBAL uint *uints, uint stride, uint i, Path p) {
#define X(name) reals[PATH_REAL_##name * stride + i] = p.name;
  PATH_REALS(X)
#undef X
#define X(name) uints[PATH_UINT_##name * stride + i] = p.name;
  PATH_UINTS(X)
#undef X
}

FN Path path_at_time(Path p, real time) {
#if SCENE_FEATURES & FEATURE_MOTION
  p.time = time;
#endif
  return p;
}
FN real path_time(Path p) {
#if SCENE_FEATURES & FEATURE_MOTION
  return p.time;
#else
  return REAL(0.0);
#endif
}
FN real3 path_throughput(Path p) { return make_real3(p.red, p.green, p.blue); }
FN Path with_throughput(Path p, real3 t) {
  p.red = t.x;
  p.green = t.y;
  p.blue = t.z;
  return p;
}
FN int path_bounce(Path p) { return int_of(p.bounces & 255u); }
FN uint path_kind(Path p) { return p.status & 255u; }
/* Below a surface, where it is of no kind, until it has been scattered out. */
FN int is_inside(Path p) { return (SCENE_FEATURES & FEATURE_SUBSURFACE) && !(p.status & RAY_ALL); }

FN Ray path_ray(Path p) {
  Ray r = free_ray(make_real3(p.ox, p.oy, p.oz), make_real3(p.dx, p.dy, p.dz), p.t_min, p.t_max);
  if (SCENE_FEATURES & FEATURE_TRANSPARENT) { /* else no path has gone through a surface */
    r.after_instance = p.after_instance;
    r.after_primitive = p.after_primitive;
  }
  r.kind = path_kind(p);
  return ray_at(r, path_time(p));
}
FN Path with_ray(Path p, Ray r) {
  p.ox = r.origin.x;
  p.oy = r.origin.y;
  p.oz = r.origin.z;
  p.dx = r.direction.x;
  p.dy = r.direction.y;
  p.dz = r.direction.z;
  p.t_min = r.t_min;
  p.t_max = r.t_max;
  p.after_instance = r.after_instance;
  p.after_primitive = r.after_primitive;
  return p;
}

#endif
