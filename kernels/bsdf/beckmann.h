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

typedef struct {
  real cos_mo; /* wo . m */
  real f;      /* BSDF times |wi.z|, without Fresnel */
  real pdf;    /* per solid angle of wi, without the choice between reflection and refraction */
} BeckmannLobe;

/* eta: of the medium behind the surface over that in front of it where wi is below, 1 for reflection; both 0 where no
 * microfacet connects wo and wi. As ggx_lobe. */
FN BeckmannLobe beckmann_lobe(real alpha_x, real alpha_y, real eta, real3 wo, real3 wi) {
  BeckmannLobe lobe;
  int refracts = wi.z < REAL(0.0);
  real3 m = (wo + wi) + wi * (eta - REAL(1.0));
  real squared = dot3(m, m);
  m = m * ((m.z < REAL(0.0) ? REAL(-1.0) : REAL(1.0)) / sqrt(max_real(squared, TINY)));
  real cos_mo = dot3(wo, m);
  real cos_mi = dot3(wi, m);
  /* At microfacets seen still flatter the density would not fit into float32. */
  int possible = (cos_mo > REAL(1e-20)) & (refracts ? cos_mi < REAL(0.0) : wi.z > REAL(0.0)) &
                 (m.z > REAL(1e-6)) & (squared > TINY) & !is_delta(alpha_x * alpha_y);
  real x = possible ? alpha_x : REAL(1.0);
  real y = possible ? alpha_y : REAL(1.0);
  real cos2 = max_real(m.z * m.z, REAL(1e-12));
  real slope2 = (square(m.x / x) + square(m.y / y)) / cos2;
  real d = exp_real(-slope2) * INV_PI / (x * y * cos2 * cos2);
  real masked = REAL(1.0) / (REAL(1.0) + beckmann_lambda(x, y, wo) + beckmann_lambda(x, y, wi));
  /* How much of m's solid angle belongs to wi's, times cos_mo. */
  real jacobian = refracts ? fabs(cos_mo * cos_mi) * (eta * eta) / max_real(squared, TINY) : REAL(0.25);
  lobe.cos_mo = cos_mo;
  lobe.f = possible ? d * masked * jacobian / max_real(wo.z, TINY) : REAL(0.0);
  lobe.pdf = possible ? d * m.z * jacobian / max_real(cos_mo, TINY) : REAL(0.0);
  return lobe;
}

/* A microfacet normal with the density of the distribution. */
FN real3 sample_beckmann_normal(real alpha_x, real alpha_y, real2 u) {
  real radius = safe_sqrt(-log_real(REAL(1.0) - u.y));
  real2 phi = sin_cos_real(TWO_PI * u.x);
  real3 m = normalize3(make_real3(alpha_x * radius * phi.y, alpha_y * radius * phi.x, REAL(1.0)));
  return select3(is_delta(alpha_x * alpha_y), make_real3(REAL(0.0), REAL(0.0), REAL(1.0)), m);
}

FN BsdfValue eval_beckmann(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  BeckmannLobe lobe = beckmann_lobe(ggx_alpha(param(c, BECKMANN_ROUGHNESS_X)),
                                    ggx_alpha(param(c, BECKMANN_ROUGHNESS_Y)), REAL(1.0), wo, wi);
  int none = wi.z <= REAL(0.0);
  return make_value(splat3(none ? REAL(0.0) : lobe.f), none ? REAL(0.0) : lobe.pdf);
}

FN BsdfSample sample_beckmann(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real u_choice,
                              real2 u) {
  real alpha_x = ggx_alpha(param(c, BECKMANN_ROUGHNESS_X));
  real alpha_y = ggx_alpha(param(c, BECKMANN_ROUGHNESS_Y));
  int delta = is_delta(alpha_x * alpha_y);
  real3 m = sample_beckmann_normal(alpha_x, alpha_y, u);
  real3 wi = normalize3(reflect3(wo, m));
  int valid = (wi.z > REAL(0.0)) & (dot3(wo, m) > REAL(0.0));
  return make_sample(wi, splat3(REAL(1.0)), delta,
                     LABEL_REFLECT | (delta ? LABEL_SINGULAR : LABEL_GLOSSY), valid);
}

FN real3 albedo_beckmann(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return splat3(REAL(1.0));
}

#endif
