/* GGX refraction alone, without Fresnel except for total internal reflection, which is black (Blender's
 * Refraction BSDF). */
#ifndef ISOPHOTE_BSDF_REFRACTION_H
#define ISOPHOTE_BSDF_REFRACTION_H
#include "interface.h"

#define REFRACTION_ROUGHNESS 0
#define REFRACTION_IOR 1

FN BsdfValue eval_refraction(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  real ior = interface_ior(param(c, REFRACTION_IOR), backfacing);
  real alpha2 = square(ggx_alpha(param(c, REFRACTION_ROUGHNESS)));
  GgxLobe lobe = ggx_lobe(alpha2, ior, wo, wi);
  int none = is_delta_refraction(alpha2, ior) | (wi.z >= REAL(0.0));
  return make_value(splat3(none ? REAL(0.0) : lobe.f), none ? REAL(0.0) : lobe.pdf);
}

FN BsdfSample sample_refraction(Closure c, int backfacing, GLOBAL const float *tables, real3 wo,
                                real u_choice, real2 u) {
  real ior = interface_ior(param(c, REFRACTION_IOR), backfacing);
  real alpha = ggx_alpha(param(c, REFRACTION_ROUGHNESS));
  real alpha2 = alpha * alpha;
  int smooth = is_delta(alpha2);
  int delta = is_delta_refraction(alpha2, ior);
  real3 m = select3(smooth, make_real3(REAL(0.0), REAL(0.0), REAL(1.0)), sample_ggx_normal(alpha, wo, u));
  real cos_mo = dot3(wo, m);
  DielectricFresnel fresnel = fresnel_dielectric(min_real(max_real(cos_mo, REAL(0.0)), REAL(1.0)), ior);
  int refracts = fresnel.f < REAL(1.0); /* else refract3 may give no direction at all */
  real3 wi = select3(refracts, normalize3(refract3(wo, m, ior, fresnel.cos_t)), zero3() - wo);
  int valid = (cos_mo > REAL(0.0)) & refracts & (wi.z < REAL(0.0));
  real f = smooth ? REAL(1.0) : ggx_visibility(alpha2, wo, wi);
  return make_sample(wi, splat3(f), delta, LABEL_TRANSMIT | (delta ? LABEL_SINGULAR : LABEL_GLOSSY), valid);
}

/* Whatever the angle: where a smooth interface reflects totally, facets of a rough one still refract. */
FN real3 albedo_refraction(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return splat3(REAL(1.0));
}

FN real3 transmitted_refraction(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return splat3(REAL(1.0));
}

#endif
