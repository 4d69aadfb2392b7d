/* Which objects a light lights, and which cast shadows in its light: Blender's light linking, as Cycles has it
 * (kernel/light/sample.h). A receiver is in one of 64 sets and a blocker in one of 64 others; what shines has masks of the
 * sets that it does not light and of those that do not stop its light. */
#ifndef ISOPHOTE_LIGHT_LINKING_H
#define ISOPHOTE_LIGHT_LINKING_H
#include "ray.h"

FN int is_in_mask(GLOBAL const uint *mask, uint set) { return int_of(mask[set >> 5] >> (set & 31u) & 1u); }

/* Places in Scene.links. */
FN uint link_of_object(Scene s, uint instance, uint primitive) {
  return instance == SPHERE_INSTANCE ? s.world[0].sphere_links + primitive : instance;
}
FN uint link_of_lamp(Scene s, uint lamp) { return s.world[0].lamp_links + lamp; }
FN uint link_of_light(Scene s, uint light) {
  return s.lights[light].kind == LIGHT_TRIANGLE ? s.lights[light].instance : link_of_lamp(s, light);
}

/* The set of receivers that a hit's object is in; volumes are in that of objects that are linked to nothing. */
FN uint receiver_set(Scene s, Hit h) {
  int in_volume = h.instance == IN_VOLUME;
  uint set = s.links[in_volume ? 0u : link_of_object(s, h.instance, h.primitive)].receiver;
  return in_volume ? 0u : set;
}

/* Whether some objects do not stop a light. */
FN int is_shadow_linked(Scene s, uint link) { return (s.links[link].unblocked[0] | s.links[link].unblocked[1]) != 0u; }

#endif
