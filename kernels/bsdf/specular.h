/* The dielectric reflection that lies over Principled's diffuse base. The index of refraction is that
 * of the coat whichever side is hit, as in Cycles. */
#ifndef ISOPHOTE_BSDF_SPECULAR_H
#define ISOPHOTE_BSDF_SPECULAR_H
#include "albedo.h"
#include "reflection.h"

#define SPECULAR_ROUGHNESS 0
#define SPECULAR_MULTISCATTER 1
#define SPECULAR_IOR 2
#define SPECULAR_TINT 3

FN real3 specular_f0(Closure c) {
  return saturate3(param3(c, SPECULAR_TINT) * f0_from_ior(param(c, SPECULAR_IOR)));
}

FN EnergyCompensation specular_compensation(Closure c, GLOBAL const float *tables, real mu) {
  real ior = param(c, SPECULAR_IOR);
  real3 fss = mix_to_white(specular_f0(c), fresnel_rise(fresnel_dielectric_average(ior), ior));
  return compensate_reflection(tables, param(c, SPECULAR_MULTISCATTER), param(c, SPECULAR_ROUGHNESS), mu, fss);
}

FN real3 specular_fresnel(Closure c, real cos_mo) {
  real ior = param(c, SPECULAR_IOR);
  return mix_to_white(specular_f0(c), fresnel_rise(fresnel_dielectric(cos_mo, ior).f, ior));
}

FN BsdfValue eval_specular(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  GgxLobe lobe = reflection_lobe(param(c, SPECULAR_ROUGHNESS), wo, wi);
  EnergyCompensation energy = specular_compensation(c, tables, wo.z);
  return make_value(specular_fresnel(c, lobe.cos_mo) * energy.gain * lobe.f, lobe.pdf);
}

FN BsdfSample sample_specular(Closure c, int backfacing, GLOBAL const float *tables, real3 wo,
                              real u_choice, real2 u) {
  return sample_reflection(param(c, SPECULAR_ROUGHNESS), specular_fresnel(c, wo.z), wo, u);
}

FN real3 albedo_specular(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  real rise = dielectric_rise(tables, param(c, SPECULAR_ROUGHNESS), wo.z, param(c, SPECULAR_IOR));
  return mix_to_white(specular_f0(c), rise) * specular_compensation(c, tables, wo.z).saturation;
}

#endif
