/* All of a material's program for one path, for devices whose lanes go through it instruction by instruction. */
#ifndef ISOPHOTE_EVALUATE_H
#define ISOPHOTE_EVALUATE_H
#include "shadow_catcher.h"

/* The whole BSDF in a direction, and where light is told apart by closures what parts of it those have. */
typedef struct {
  BsdfValue value;
  Shares parts;
} Evaluated;

/* `hidden`: kinds of rays for which there is no light. */
FN Evaluated evaluate_material(Scene s, Material m, int diffuse, Surface at, Choice all, real3 wo_world,
                               real3 wi_world, uint hidden, const real *r, int split) {
  Frame shading = make_frame(at.ns);
  real3 surface_wo = to_local(shading, wo_world), surface_wi = to_local(shading, wi_world);
  Choice c = make_choice(REAL(0.0));
  Evaluated made;
  made.parts = no_shares();
  BsdfValue sum = make_value(zero3(), REAL(0.0));
  for (uint k = 0u; k < m.count; k++) {
    Instruction i = met_instruction(s.instructions[m.first + k], diffuse);
    Closure one = closure_of(i, r);
    real3 wo = surface_wo, wi = surface_wi;
    if (has_own_frame(i)) {
      Frame own = own_frame(i, r);
      wo = to_local(own, wo_world);
      wi = to_local(own, wi_world);
    }
    if (is_closure(i.op)) {
      real3 weight = closure_weight(one, c);
      real share = all.total; /* alone, a closure has all of it: its albedo need not be found again */
      if (m.count > 1u) share = closure_share(weight, albedo_closure(one, at.backfacing, s.albedo_tables, wo));
      BsdfValue value = eval_closure(one, at.backfacing, s.albedo_tables, wo, wi);
      if (SCENE_FEATURES & FEATURE_BUMP) {
        value = one_sided_closure(at.ng, wi_world, wi, value);
        if ((i.flags & INSTRUCTION_SOFTENED) && is_diffuse(i.op)) value = soften_bump(at.ns, own_frame(i, r).z, wi_world, value);
      }
      if ((SCENE_FEATURES & FEATURE_LIGHT_LIMITS) && is_hidden(hidden, kind_towards(i.op, dot3(at.ng, wi_world) < REAL(0.0))))
        weight = zero3();
      real3 before = sum.f;
      sum = add_closure(sum, value, weight, share, all.total);
      if (split) made.parts = add_part(made.parts, before, sum.f, is_diffuse(i.op), wi.z);
    } else {
      c.layer = layer_closure(one, at.backfacing, s.albedo_tables, wo, c.layer);
    }
  }
  made.value = SCENE_FEATURES & FEATURE_BUMP ? sum : one_sided(at, wi_world, sum);
  return made;
}

#endif
