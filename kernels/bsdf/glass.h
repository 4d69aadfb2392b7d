/* A rough dielectric interface of one colour (Blender's Glass BSDF). */
#ifndef ISOPHOTE_BSDF_GLASS_H
#define ISOPHOTE_BSDF_GLASS_H
#include "interface.h"

#define GLASS_ROUGHNESS 0
#define GLASS_IOR 1
#define GLASS_MULTISCATTER 2
#define GLASS_TINT 3

FN Interface glass_interface(Closure c, int backfacing) {
  Interface s;
  s.roughness = param(c, GLASS_ROUGHNESS);
  s.multiscatter = param(c, GLASS_MULTISCATTER);
  s.ior = interface_ior(param(c, GLASS_IOR), backfacing);
  s.f0 = splat3(f0_from_ior(s.ior));
  s.reflection = param3(c, GLASS_TINT);
  s.transmission = s.reflection;
  s.film = REAL(0.0);
  s.film_ior = REAL(1.0);
  return s;
}

FN BsdfValue eval_glass(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  return eval_interface(glass_interface(c, backfacing), tables, wo, wi);
}

FN BsdfSample sample_glass(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real u_choice,
                           real2 u) {
  return sample_interface(glass_interface(c, backfacing), tables, wo, u_choice, u);
}

FN real3 albedo_glass(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return albedo_interface(glass_interface(c, backfacing), tables, wo);
}

FN real3 transmitted_glass(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return transmitted_interface(glass_interface(c, backfacing), tables, wo);
}

#endif
