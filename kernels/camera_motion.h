/* A camera that moves while its shutter is open: its poses, evenly over that time, are the records behind the scene's
 * camera, each with its place and its turn from there as a quaternion (x, y, z, w). */
#ifndef ISOPHOTE_CAMERA_MOTION_H
#define ISOPHOTE_CAMERA_MOTION_H
#include "camera.h"
#include "path.h"
#include "sampler.h"

#if SCENE_FEATURES & FEATURE_CAMERA_MOTION
/* Between quaternions along the shorter arc (Shoemake 1985, "Animating Rotation with Quaternion Curves"), linear where
 * it is short, as in Cycles. */
FN real4 slerp(real4 a, real4 b, real t) {
  real cosine = a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
  b = b * (cosine < REAL(0.0) ? REAL(-1.0) : REAL(1.0));
  cosine = fabs(cosine);
  int near = cosine > REAL(0.9995);
  real angle = acos_real(cosine);
  real sine = near ? REAL(1.0) : sin_real(angle);
  real4 q = a * (near ? REAL(1.0) - t : sin_real((REAL(1.0) - t) * angle) / sine) +
            b * (near ? t : sin_real(t * angle) / sine);
  return q * (REAL(1.0) / sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w));
}

FN real3 turned_by(real4 q, real3 v) {
  real3 axis = make_real3(q.x, q.y, q.z);
  real3 across = cross3(axis, v) * REAL(2.0);
  return v + across * q.w + cross3(axis, across);
}

/* A path that begins at a time of its own, where the camera is then. */
FN Path move_with_camera(Scene s, Path p) {
  int last = s.camera[0].poses - 1;
  real time = real_of(last) * sample_filter(s.filter_table + SHUTTER_TABLE, sample_pair(p.seed, p.index, PAIR_TIME).x);
  int step = min_int(int_of(time), last - 1);
  real t = time - real_of(step);
  GLOBAL const Camera *a = &s.camera[1 + step], *b = &s.camera[2 + step];
  real4 q = slerp(make_real4(to_real(a->turn[0]), to_real(a->turn[1]), to_real(a->turn[2]), to_real(a->turn[3])),
                  make_real4(to_real(b->turn[0]), to_real(b->turn[1]), to_real(b->turn[2]), to_real(b->turn[3])), t);
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
