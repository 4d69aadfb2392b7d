/* Shadow catchers: objects of which the picture shows how much darker others make them. As Cycles has it
 * (kernel/integrator/shadow_catcher.h, kernel/film/read.h): what the camera sees before it meets a catcher is the matte;
 * what it sees from there on is once lit with all objects there, and once with no others than catchers.
 *
 * So paths of a pass begin a second time when all have ended, with the same random numbers. Where they meet a catcher
 * they are alone with catchers from there on; those that meet none end at once. */
#ifndef ISOPHOTE_SHADOW_CATCHER_H
#define ISOPHOTE_SHADOW_CATCHER_H
#include "passes.h"

FN int catches(Params params) { return (SCENE_FEATURES & FEATURE_CATCHERS) && params.catching != CATCHING_NONE; }

/* Columns of a path: light and what the matte lacks of alpha, light among catchers alone, whether it has met one. */
#define CAUGHT_MATTE 0u
#define CAUGHT_LOST 3u
#define CAUGHT_ALONE 4u
#define CAUGHT_MET 7u
FN uint caught_column(Params params, uint which) {
  return plane_of(film_groups(params), GROUP_shadow_catcher) - PLANES_COMBINED + which;
}
FN int has_met(GLOBAL const real *columns, uint stride, uint slot, Params params) {
  return columns[caught_column(params, CAUGHT_MET) * stride + slot] != REAL(0.0);
}

/* A path that begins again; whether it does. */
FN int begins_again(GLOBAL real *columns, uint stride, uint slot, Params params) {
  int met = has_met(columns, stride, slot, params);
  columns[caught_column(params, CAUGHT_MET) * stride + slot] = REAL(0.0);
  return met;
}

FN int is_catcher(Scene s, uint instance, uint primitive) {
  uint kinds = instance == SPHERE_INSTANCE ? s.spheres[primitive].visibility : s.instances[instance].visibility;
  return (kinds >> CATCHER_SHIFT & RAY_ALL) != 0u;
}

/* Whether a path's hit is the first catcher that the camera sees: from there on it is caught. */
FN int is_being_caught(Scene s, Params params, Path p, Hit h) {
  int first = ((p.status & RAY_CAMERA) != 0u) & ((p.status & PATH_CAUGHT) == 0u);
  return catches(params) && first && is_catcher(s, h.instance, h.primitive);
}
FN Path meet_catcher(GLOBAL real *columns, uint stride, Scene s, Params params, Path p, Hit h) {
  if (!is_being_caught(s, params, p, h)) return p;
  columns[caught_column(params, CAUGHT_MET) * stride + p.slot] = REAL(1.0);
  if (!is_alone(params)) columns[caught_column(params, CAUGHT_LOST) * stride + p.slot] += lost_alpha(1, p);
  p.status |= PATH_CAUGHT;
  return p;
}

/* What the path loses of alpha it loses of the matte's, if it has met no catcher. */
FN void lose_matte(GLOBAL real *columns, uint stride, uint slot, Params params, real lost) {
  if (is_alone(params) || has_met(columns, stride, slot, params)) return;
  columns[caught_column(params, CAUGHT_LOST) * stride + slot] += lost;
}

/* Light for the planes of catchers; whether it is of Combined alone among the others, or of none. */
#define GOES_ON 0
#define COMBINED_ALONE 1
#define NOWHERE 2
FN int catch_light(GLOBAL real *columns, uint stride, uint slot, Params params, real3 light) {
  int met = has_met(columns, stride, slot, params), alone = is_alone(params);
  if (met == alone) {
    uint at = caught_column(params, alone ? CAUGHT_ALONE : CAUGHT_MATTE) * stride + slot;
    columns[at] += light.x;
    columns[at + stride] += light.y;
    columns[at + 2u * stride] += light.z;
  }
  return alone ? NOWHERE : met ? COMBINED_ALONE : GOES_ON;
}

/* Whether what shines is not there: an object that is none, among catchers alone. */
FN int is_away(Scene s, Params params, LightSample light) {
  return is_alone(params) && light.instance != NONE && !is_catcher(s, light.instance, light.primitive);
}

#endif
