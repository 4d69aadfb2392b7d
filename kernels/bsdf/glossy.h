/* GGX reflection without Fresnel (Blender's Glossy BSDF). */
#ifndef ISOPHOTE_BSDF_GLOSSY_H
#define ISOPHOTE_BSDF_GLOSSY_H
#include "albedo.h"
#include "reflection.h"

#define GLOSSY_ROUGHNESS 0
#define GLOSSY_MULTISCATTER 1
#define GLOSSY_TINT 2

FN real3 glossy_fresnel(Closure c, real cos_mo) { return param3(c, GLOSSY_TINT); }

FN EnergyCompensation glossy_compensation(Closure c, GLOBAL const float *tables, real mu) {
  return compensate_reflection(tables, param(c, GLOSSY_MULTISCATTER), param(c, GLOSSY_ROUGHNESS), mu,
                               saturate3(param3(c, GLOSSY_TINT)));
}

FN BsdfValue eval_glossy(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  GgxLobe lobe = reflection_lobe(param(c, GLOSSY_ROUGHNESS), wo, wi);
  EnergyCompensation energy = glossy_compensation(c, tables, wo.z);
  return make_value(glossy_fresnel(c, lobe.cos_mo) * energy.gain * lobe.f, lobe.pdf);
}

FN BsdfSample sample_glossy(Closure c, int backfacing, GLOBAL const float *tables, real3 wo,
                            real u_choice, real2 u) {
  return sample_reflection(param(c, GLOSSY_ROUGHNESS), glossy_fresnel(c, wo.z), wo, u);
}

FN real3 albedo_glossy(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return glossy_fresnel(c, wo.z) * glossy_compensation(c, tables, wo.z).saturation;
}

#endif
