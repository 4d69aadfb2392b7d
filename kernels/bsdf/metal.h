/* GGX reflection of a conductor with the F82-tint Fresnel term (Principled's metallic part, and the
 * Metallic BSDF). */
#ifndef ISOPHOTE_BSDF_METAL_H
#define ISOPHOTE_BSDF_METAL_H
#include "albedo.h"
#include "reflection.h"

#define METAL_ROUGHNESS 0
#define METAL_MULTISCATTER 1
#define METAL_F0 2
#define METAL_F82 5

FN EnergyCompensation metal_compensation(Closure c, GLOBAL const float *tables, real mu) {
  real3 f0 = param3(c, METAL_F0);
  return compensate_reflection(tables, param(c, METAL_MULTISCATTER), param(c, METAL_ROUGHNESS), mu,
                               fresnel_f82_average(f0, f82_edge(f0, param3(c, METAL_F82))));
}

FN real3 metal_fresnel(Closure c, real cos_mo) {
  real3 f0 = param3(c, METAL_F0);
  return fresnel_f82(cos_mo, f0, f82_edge(f0, param3(c, METAL_F82)));
}

FN BsdfValue eval_metal(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  GgxLobe lobe = reflection_lobe(param(c, METAL_ROUGHNESS), wo, wi);
  EnergyCompensation energy = metal_compensation(c, tables, wo.z);
  return make_value(metal_fresnel(c, lobe.cos_mo) * energy.gain * lobe.f, lobe.pdf);
}

FN BsdfSample sample_metal(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real u_choice,
                           real2 u) {
  return sample_reflection(param(c, METAL_ROUGHNESS), metal_fresnel(c, wo.z), wo, u);
}

/* The edge tint is left out, as in Cycles. */
FN real3 albedo_metal(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  real rise = schlick_rise(tables, param(c, METAL_ROUGHNESS), wo.z);
  return mix_to_white(param3(c, METAL_F0), rise) * metal_compensation(c, tables, wo.z).saturation;
}

#endif
