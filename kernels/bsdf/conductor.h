/* GGX reflection of a metal given by its complex index of refraction n + ik (Metallic BSDF, physical conductor). */
#ifndef ISOPHOTE_BSDF_CONDUCTOR_H
#define ISOPHOTE_BSDF_CONDUCTOR_H
#include "albedo.h"
#include "reflection.h"

#define CONDUCTOR_ROUGHNESS 0
#define CONDUCTOR_MULTISCATTER 1
#define CONDUCTOR_N 2
#define CONDUCTOR_K 5

FN real3 conductor_fresnel(Closure c, real cos_mo) {
  real3 n = param3(c, CONDUCTOR_N);
  real3 k = param3(c, CONDUCTOR_K);
  real mu = clamp01(cos_mo);
  return make_real3(fresnel_conductor(mu, n.x, k.x), fresnel_conductor(mu, n.y, k.y), fresnel_conductor(mu, n.z, k.z));
}

/* The average of an F82 metal that agrees at normal incidence and at the cosine 1/7. */
FN EnergyCompensation conductor_compensation(Closure c, GLOBAL const float *tables, real mu) {
  real3 f0 = conductor_fresnel(c, REAL(1.0));
  real s = REAL(6.0) / REAL(7.0);
  real s5 = s * s * s * s * s;
  real3 edge = (mix_to_white(f0, s5) - conductor_fresnel(c, REAL(1.0) / REAL(7.0))) * (REAL(7.0) / (s5 * s));
  return compensate_reflection(tables, param(c, CONDUCTOR_MULTISCATTER), param(c, CONDUCTOR_ROUGHNESS), mu,
                               saturate3(fresnel_f82_average(f0, edge)));
}

FN BsdfValue eval_conductor(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  GgxLobe lobe = reflection_lobe(param(c, CONDUCTOR_ROUGHNESS), wo, wi);
  EnergyCompensation energy = conductor_compensation(c, tables, wo.z);
  return make_value(conductor_fresnel(c, lobe.cos_mo) * energy.gain * lobe.f, lobe.pdf);
}

FN BsdfSample sample_conductor(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real u_choice,
                               real2 u) {
  return sample_reflection(param(c, CONDUCTOR_ROUGHNESS), conductor_fresnel(c, wo.z), wo, u);
}

/* As of a smooth surface, Cycles' estimate. */
FN real3 albedo_conductor(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return conductor_fresnel(c, wo.z) * conductor_compensation(c, tables, wo.z).saturation;
}

#endif
