/* GGX reflection without Fresnel (Blender's Glossy BSDF). */
#ifndef ISOPHOTE_BSDF_GLOSSY_H
#define ISOPHOTE_BSDF_GLOSSY_H
#include "albedo.h"
#include "reflection.h"

#define GLOSSY_ROUGHNESS 0
#define GLOSSY_MULTISCATTER 1
#define GLOSSY_TINT 2

FN BsdfValue eval_glossy(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  real roughness = param(c, GLOSSY_ROUGHNESS);
  real3 tint = param3(c, GLOSSY_TINT);
  GgxLobe lobe = reflection_lobe(roughness, wo, wi);
  EnergyCompensation energy =
      compensate_reflection(tables, param(c, GLOSSY_MULTISCATTER), roughness, wo.z, saturate3(tint));
  return make_value(tint * energy.gain * lobe.f, lobe.pdf);
}

FN BsdfSample sample_glossy(Closure c, int backfacing, GLOBAL const float *tables, real3 wo,
                            real u_choice, real2 u) {
  return sample_reflection(param(c, GLOSSY_ROUGHNESS), param3(c, GLOSSY_TINT), wo, u);
}

FN real3 albedo_glossy(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  real3 tint = param3(c, GLOSSY_TINT);
  EnergyCompensation energy = compensate_reflection(tables, param(c, GLOSSY_MULTISCATTER),
                                                    param(c, GLOSSY_ROUGHNESS), wo.z, saturate3(tint));
  return tint * energy.saturation;
}

#endif
