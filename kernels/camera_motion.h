/* A camera that moves while its shutter is open: its poses, evenly over that time, are the records behind the scene's
 * camera, each with its place and its turn from there as a quaternion (x, y, z, w). */
#ifndef ISOPHOTE_CAMERA_MOTION_H
#define ISOPHOTE_CAMERA_MOTION_H
#include "camera.h"
#include "motion.h"
#include "path.h"

#if SCENE_FEATURES & FEATURE_CAMERA_MOTION
/* A path that begins at a time of its own, where the camera is then. */
FN Path move_with_camera(Scene s, Path p) {
  Between k = between_keys(uint_of(s.camera[0].poses), shutter_time(s, p.seed, p.index));
  GLOBAL const Camera *a = &s.camera[1u + k.first], *b = a + 1;
  real t = k.part;
  real4 q = slerp(load_turn(a->turn), load_turn(b->turn), t);
  real3 place = load3(a->position) * (REAL(1.0) - t) + load3(b->position) * t;
  real3 origin = place + turned_by(q, make_real3(p.ox, p.oy, p.oz) - load3(s.camera[0].position));
  real3 direction = normalize3(turned_by(q, make_real3(p.dx, p.dy, p.dz)));
  p.ox = origin.x;
  p.oy = origin.y;
  p.oz = origin.z;
  p.dx = direction.x;
  p.dy = direction.y;
  p.dz = direction.z;
  return p;
}
#endif

#endif
