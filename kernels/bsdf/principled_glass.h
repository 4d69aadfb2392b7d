/* Principled's transmission: a rough dielectric interface whose reflection is tinted at normal
 * incidence only, and whose transmission tint is the square root of the base colour (two crossings make
 * the colour). */
#ifndef ISOPHOTE_BSDF_PRINCIPLED_GLASS_H
#define ISOPHOTE_BSDF_PRINCIPLED_GLASS_H
#include "interface.h"

#define PRINCIPLED_GLASS_ROUGHNESS 0
#define PRINCIPLED_GLASS_MULTISCATTER 1
#define PRINCIPLED_GLASS_IOR 2
#define PRINCIPLED_GLASS_TINT 3
#define PRINCIPLED_GLASS_TRANSMISSION 6

FN Interface principled_interface(Closure c, int backfacing) {
  Interface s;
  s.roughness = param(c, PRINCIPLED_GLASS_ROUGHNESS);
  s.multiscatter = param(c, PRINCIPLED_GLASS_MULTISCATTER);
  s.ior = interface_ior(param(c, PRINCIPLED_GLASS_IOR), backfacing);
  s.f0 = saturate3(param3(c, PRINCIPLED_GLASS_TINT) * f0_from_ior(s.ior));
  s.reflection = splat3(REAL(1.0));
  s.transmission = param3(c, PRINCIPLED_GLASS_TRANSMISSION);
  s.film = REAL(0.0);
  s.film_ior = REAL(1.0);
  return s;
}

FN BsdfValue eval_principled_glass(Closure c, int backfacing, GLOBAL const float *tables, real3 wo,
                                   real3 wi) {
  return eval_interface(principled_interface(c, backfacing), tables, wo, wi);
}

FN BsdfSample sample_principled_glass(Closure c, int backfacing, GLOBAL const float *tables, real3 wo,
                                      real u_choice, real2 u) {
  return sample_interface(principled_interface(c, backfacing), tables, wo, u_choice, u);
}

FN real3 albedo_principled_glass(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return albedo_interface(principled_interface(c, backfacing), tables, wo);
}

FN real3 transmitted_principled_glass(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return transmitted_interface(principled_interface(c, backfacing), tables, wo);
}

#endif
