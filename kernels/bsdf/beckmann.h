/* Reflection by Beckmann's microfacets without Fresnel (Blender's Glossy BSDF with that distribution), of two
 * roughnesses along x and y. The masking is Walter et al.'s rational fit, as in Cycles, and microfacets are sampled
 * by the distribution itself, Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces",
 * eqs. 25 to 29: the visible ones need error functions and iterations. */
#ifndef ISOPHOTE_BSDF_BECKMANN_H
#define ISOPHOTE_BSDF_BECKMANN_H
#include "closure.h"
#include "microfacet.h"

#define BECKMANN_ROUGHNESS_X 0
#define BECKMANN_ROUGHNESS_Y 1

/* Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", below eq. 69; s is the
 * square of 1/a there. */
FN real beckmann_lambda(real alpha_x, real alpha_y, real3 v) {
  real s = (square(alpha_x * v.x) + square(alpha_y * v.y)) / max_real(v.z * v.z, TINY);
  real a = REAL(1.0) / sqrt(max_real(s, REAL(0.39)));
  real fit = ((REAL(0.396) * a - REAL(1.259)) * a + REAL(1.0)) / ((REAL(2.181) * a + REAL(3.535)) * a);
  return s < REAL(0.39) ? REAL(0.0) : fit;
}

FN BsdfValue eval_beckmann(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  real alpha_x = ggx_alpha(param(c, BECKMANN_ROUGHNESS_X));
  real alpha_y = ggx_alpha(param(c, BECKMANN_ROUGHNESS_Y));
  real alpha2 = alpha_x * alpha_y;
  real3 m = wo + wi;
  real squared = dot3(m, m);
  m = m * (REAL(1.0) / sqrt(max_real(squared, TINY)));
  real cos_mo = dot3(wo, m);
  int possible = (wi.z > REAL(0.0)) & (cos_mo > REAL(0.0)) & (m.z > REAL(1e-6)) & (squared > TINY) & !is_delta(alpha2);
  alpha_x = possible ? alpha_x : REAL(1.0);
  alpha_y = possible ? alpha_y : REAL(1.0);
  alpha2 = alpha_x * alpha_y;
  real cos2 = max_real(m.z * m.z, REAL(1e-12));
  real slope2 = (square(m.x / alpha_x) + square(m.y / alpha_y)) / cos2;
  real d = exp_real(-slope2) * INV_PI / (alpha2 * cos2 * cos2);
  real masked = REAL(1.0) / (REAL(1.0) + beckmann_lambda(alpha_x, alpha_y, wo) + beckmann_lambda(alpha_x, alpha_y, wi));
  real f = REAL(0.25) * d * masked / max_real(wo.z, TINY);
  real pdf = REAL(0.25) * d * m.z / max_real(cos_mo, TINY);
  return make_value(splat3(possible ? f : REAL(0.0)), possible ? pdf : REAL(0.0));
}

FN BsdfSample sample_beckmann(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real u_choice,
                              real2 u) {
  real alpha_x = ggx_alpha(param(c, BECKMANN_ROUGHNESS_X));
  real alpha_y = ggx_alpha(param(c, BECKMANN_ROUGHNESS_Y));
  int delta = is_delta(alpha_x * alpha_y);
  real radius = safe_sqrt(-log_real(REAL(1.0) - u.y));
  real2 phi = sin_cos_real(TWO_PI * u.x);
  real3 m = normalize3(make_real3(alpha_x * radius * phi.y, alpha_y * radius * phi.x, REAL(1.0)));
  m = select3(delta, make_real3(REAL(0.0), REAL(0.0), REAL(1.0)), m);
  real3 wi = normalize3(reflect3(wo, m));
  int valid = (wi.z > REAL(0.0)) & (dot3(wo, m) > REAL(0.0));
  return make_sample(wi, splat3(REAL(1.0)), delta,
                     LABEL_REFLECT | (delta ? LABEL_SINGULAR : LABEL_GLOSSY), valid);
}

FN real3 albedo_beckmann(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return splat3(REAL(1.0));
}

#endif
