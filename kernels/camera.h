/* From a point on the film to a ray. */
#ifndef ISOPHOTE_CAMERA_H
#define ISOPHOTE_CAMERA_H
#include "camera_space.h"
#include "disk.h"
#include "panorama.h"
#include "ray.h"
#include "sampler.h"

FN int has_lens(Camera c) { return (SCENE_FEATURES & FEATURE_LENS) && c.lens > 0.0f; }

/* A point of the lens, metres along the camera's x and y. */
FN real2 sample_lens(Camera c, real2 u) {
  real2 p = c.blades > 2 ? sample_polygon(c.blades, to_real(c.blade_rotation), u) : sample_disk(u);
  real radius = to_real(c.lens);
  return make_real2(p.x * radius / to_real(c.lens_ratio), p.y * radius);
}

#if SCENE_FEATURES & FEATURE_PANORAMA
/* Spherical stereo, in the camera's space: the eye lies to the side of each direction, and looks where both eyes meet. */
FN Ray move_to_eye(Camera c, Ray r) {
  real3 d = r.direction;
  real level = sqrt(d.x * d.x + d.y * d.y), offset = to_real(c.eye);
  real from = to_real(c.merge_from), to = to_real(c.merge_to);
  if (to > REAL(0.0)) {
    real part = (fabs(atan2_real(d.z, level)) - from) / max_real(to - from, REAL(1e-6));
    offset = offset * cos_real(clamp01(part) * (REAL(0.5) * PI));
  }
  real scale = level > REAL(0.0) ? offset / level : REAL(0.0);
  real3 side = make_real3(d.y * scale, -d.x * scale, REAL(0.0));
  r.origin = r.origin + side;
  if (c.convergence > 0.0f) r.direction = normalize3(d * to_real(c.convergence) - side);
  return r;
}

/* The ray through a point of a panorama's window. Clip distances are along the ray, the lens lies across it, and in
 * focus is a sphere. Where the camera sees nothing the ray has no length. */
FN Ray make_panorama_ray(Camera c, int kind, real px, real py, real2 on_lens) {
  real3 d = panorama_direction(c, kind, px, py);
  int seen = dot3(d, d) > REAL(0.0);
  real3 forward = make_real3(REAL(1.0), REAL(0.0), REAL(0.0));
  d = select3(seen, d, forward);
  real near = to_real(c.clip_start);
  Ray r = free_ray(zero3(), d, REAL(0.0), seen ? to_real(c.clip_end) - near : REAL(0.0));
  if (has_lens(c)) {
    Frame across = make_frame_along(d, forward);
    r.origin = across.x * on_lens.x + across.y * on_lens.y;
    r.direction = normalize3(d * to_real(c.focus) - r.origin);
  }
  if (c.eye != 0.0f) r = move_to_eye(c, r);
  r.direction = turned_from_camera(c, r.direction);
  r.origin = load3(c.position) + turned_from_camera(c, r.origin) + r.direction * near;
  return r;
}
#endif

/* The ray through film point (x, y), in pixels from the lower left of the full frame, and the lens' point. `kind` is the
 * camera's, where the compiler may know it. */
FN Ray make_camera_ray(Camera c, int kind, real x, real y, real2 on_lens) {
  real px = to_real(c.left) + (to_real(c.right) - to_real(c.left)) * (x / real_of(c.width));
  real py = to_real(c.bottom) + (to_real(c.top) - to_real(c.bottom)) * (y / real_of(c.height));
#if SCENE_FEATURES & FEATURE_PANORAMA
  if (is_panorama(kind)) return make_panorama_ray(c, kind, px, py, on_lens);
#endif
  real3 ax = load3(c.x), ay = load3(c.y), az = load3(c.z);
  int perspective = kind == CAMERA_PERSPECTIVE;
  real3 on_window = ax * px + ay * py;
  real3 toward = select3(perspective, on_window - az, zero3() - az);
  real3 lens = zero3();
  if (has_lens(c)) { /* all rays of a film point meet where it is in focus */
    lens = ax * on_lens.x + ay * on_lens.y;
    toward = toward - lens * (REAL(1.0) / to_real(c.focus));
  }
  real length = sqrt(dot3(toward, toward));
  real3 direction = toward * (REAL(1.0) / length);
  real start = to_real(c.clip_start) * length;
  real3 origin = load3(c.position) + select3(perspective, zero3(), on_window) + direction * start;
  if (has_lens(c)) origin = origin + lens;
  return free_ray(origin, direction, REAL(0.0), to_real(c.clip_end) * length - start);
}

/* Distance from the camera, and along its axis: Blender's Mist and Depth passes. A panorama has no axis. */
FN real camera_distance(Camera c, real3 p) {
  real3 away = p - load3(c.position);
  return c.kind == CAMERA_ORTHOGRAPHIC ? fabs(dot3(away, load3(c.z))) : sqrt(dot3(away, away));
}
FN real camera_depth(Camera c, real3 p) {
  if (is_panorama(c.kind)) return camera_distance(c, p);
  return -dot3(p - load3(c.position), load3(c.z));
}

#endif
