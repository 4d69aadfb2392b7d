/* Ashikhmin and Shirley 2000, "An Anisotropic Phong BRDF Model", eqs. 4 to 10, without Fresnel (Blender's Glossy
 * BSDF with that distribution). Exponents follow from the roughness along x and y: 2/alpha^2 - 2.
 *
 * Cycles mirrors the viewer at a facet that looks away as if it did not, along a vector that is no longer unit; such
 * samples count as none here. At roughness 0.8 a ball in Cycles is 1 % brighter for it. */
#ifndef ISOPHOTE_BSDF_ASHIKHMIN_SHIRLEY_H
#define ISOPHOTE_BSDF_ASHIKHMIN_SHIRLEY_H
#include "closure.h"
#include "microfacet.h"

#define ASHIKHMIN_SHIRLEY_ROUGHNESS_X 0
#define ASHIKHMIN_SHIRLEY_ROUGHNESS_Y 1
#define SHARPEST_PHONG REAL(1e-4) /* alpha at and below which Cycles takes the lobe for a mirror */

typedef struct {
  real x, y; /* along each axis */
  int delta;
} PhongExponents;
FN PhongExponents phong_exponents(Closure c) {
  PhongExponents e;
  real alpha_x = max_real(ggx_alpha(param(c, ASHIKHMIN_SHIRLEY_ROUGHNESS_X)), SHARPEST_PHONG);
  real alpha_y = max_real(ggx_alpha(param(c, ASHIKHMIN_SHIRLEY_ROUGHNESS_Y)), SHARPEST_PHONG);
  e.x = REAL(2.0) * (REAL(1.0) - alpha_x) * (REAL(1.0) + alpha_x) / (alpha_x * alpha_x);
  e.y = REAL(2.0) * (REAL(1.0) - alpha_y) * (REAL(1.0) + alpha_y) / (alpha_y * alpha_y);
  e.delta = max_real(alpha_x, alpha_y) <= SHARPEST_PHONG;
  return e;
}

FN BsdfValue eval_ashikhmin_shirley(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  PhongExponents e = phong_exponents(c);
  real3 m = wo + wi;
  real squared = dot3(m, m);
  m = m * (REAL(1.0) / sqrt(max_real(squared, TINY)));
  real cos_mo = max_real(dot3(wo, m), REAL(1e-6));
  int possible = (wi.z > REAL(0.0)) & !e.delta & (squared > TINY);
  real sine2 = m.x * m.x + m.y * m.y;
  real exponent = (e.x * m.x * m.x + e.y * m.y * m.y) / max_real(sine2, TINY);
  /* cos^n = (1 + tan^2)^(-n/2): the cosine itself has no digits left where n is large. */
  real tan2 = sine2 / square(max_real(m.z, REAL(1e-6)));
  real lobe = exp_real(REAL(-0.5) * exponent * log1p_real(tan2));
  real norm = sqrt((e.x + REAL(1.0)) * (e.y + REAL(1.0))) * INV_PI * REAL(0.125);
  real pdf = possible ? norm * lobe / cos_mo : REAL(0.0);
  return make_value(splat3(pdf * max_real(wi.z, REAL(0.0)) / max_real(max_real(wo.z, wi.z), REAL(1e-6))), pdf);
}

FN BsdfSample sample_ashikhmin_shirley(Closure c, int backfacing, GLOBAL const float *tables, real3 wo,
                                       real u_choice, real2 u) {
  PhongExponents e = phong_exponents(c);
  real2 turn = sin_cos_real(TWO_PI * u.x);
  real along = turn.y * sqrt(e.y + REAL(1.0)); /* tan phi = sqrt((nx + 1)/(ny + 1)) tan(2 pi u) */
  real across = turn.x * sqrt(e.x + REAL(1.0));
  real scale = REAL(1.0) / sqrt(along * along + across * across);
  real cos_phi = along * scale;
  real sin_phi = across * scale;
  real exponent = e.x * cos_phi * cos_phi + e.y * sin_phi * sin_phi;
  real log_cos2 = REAL(2.0) * log_real(REAL(1.0) - u.y) / (exponent + REAL(1.0));
  real sine = safe_sqrt(-expm1_real(log_cos2));
  real3 m = make_real3(sine * cos_phi, sine * sin_phi, exp_real(REAL(0.5) * log_cos2));
  m = select3(e.delta, make_real3(REAL(0.0), REAL(0.0), REAL(1.0)), m);
  real3 wi = normalize3(reflect3(wo, m));
  return make_sample(wi, splat3(REAL(1.0)), e.delta,
                     LABEL_REFLECT | (e.delta ? LABEL_SINGULAR : LABEL_GLOSSY), wi.z > REAL(0.0));
}

FN real3 albedo_ashikhmin_shirley(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return splat3(REAL(1.0));
}

#endif
