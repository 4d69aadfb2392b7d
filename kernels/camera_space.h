/* Between the world and the camera's space, which is Cycles': z is against the last of the camera's axes. */
#ifndef ISOPHOTE_CAMERA_SPACE_H
#define ISOPHOTE_CAMERA_SPACE_H
#include "scene_records.h"

FN real3 turned_to_camera(Camera c, real3 v) {
  return make_real3(dot3(v, load3(c.x)), dot3(v, load3(c.y)), -dot3(v, load3(c.z)));
}
FN real3 turned_from_camera(Camera c, real3 v) { return load3(c.x) * v.x + load3(c.y) * v.y - load3(c.z) * v.z; }

#endif
