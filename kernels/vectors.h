/* The Vector pass: where a point of a surface is seen in the frame before and in the one after, as Cycles has it
 * (kernel/geom/primitive.h, primitive_motion_vector). The keys of the scene are then those of the three frames. */
#ifndef ISOPHOTE_VECTORS_H
#define ISOPHOTE_VECTORS_H
#include "camera_space.h"
#include "motion.h"
#include "panorama.h"
#include "path.h"
#include "surface.h"

#if VECTORS_USED
/* Where the camera of the frame `k` (0 to 2, the one in the middle is the picture's) sees a point, pixels. */
FN real2 seen_in_frame(Scene s, uint k, real3 p) {
  Camera c = s.camera[0];
  real3 v = p - load3(c.position);
  if (k != 1u) {
    GLOBAL const Camera *other = &s.camera[1u + k];
    real4 turn = load_turn(other->turn);
    v = turned_by(make_real4(-turn.x, -turn.y, -turn.z, turn.w), p - load3(other->position));
  }
  v = turned_to_camera(c, v);
  real2 at = share_of_window(c, seen_by_camera(c, v, normalize3(v)));
  return make_real2(at.x * real_of(c.width), at.y * real_of(c.height));
}

/* The point p of a hit in the frame before (time 0) or after (1). */
FN real3 point_in_frame(Scene s, real3 p, Hit h, real time) {
  if (!(s.world[0].vectors & VECTORS_MOTION) || h.instance >= SPHERE_INSTANCE) return p;
  Motion motion = s.motions[h.instance];
  if (motion.shapes) {
    uint swap = (s.instances[h.instance].visibility & INSTANCE_MIRRORED) ? 1u : 0u;
    GLOBAL const uint *corner = &s.indices[3u * h.primitive];
    real3 inside = shape_at(s, motion, motion.first_shape, corner[0], time) * (REAL(1.0) - h.u - h.v) +
                  shape_at(s, motion, motion.first_shape, corner[1u + swap], time) * h.u +
                  shape_at(s, motion, motion.first_shape, corner[2u - swap], time) * h.v;
    if (!motion.poses) return transform_point(s.instances[h.instance].to_world, inside);
    return placed_point(placement_at(s, motion, time), inside);
  }
  if (!motion.poses) return p;
  return placed_point(placement_at(s, motion, time), unplaced_point(placement_at(s, motion, REAL(0.5)), p));
}

/* Pixels from where the point was seen before, then to where it will be: x, y, x, y. */
FN real4 motion_vector(Scene s, real3 p, Hit h) {
  real2 now = seen_in_frame(s, 1u, p);
  real2 before = seen_in_frame(s, 0u, point_in_frame(s, p, h, REAL(0.0)));
  real2 after = seen_in_frame(s, 2u, point_in_frame(s, p, h, REAL(1.0)));
  return make_real4(before.x - now.x, before.y - now.y, now.x - after.x, now.y - after.y);
}
#endif

#endif
