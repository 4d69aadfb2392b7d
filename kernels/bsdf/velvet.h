/* Velvet: Ashikhmin, Premoze and Shirley 2000, "A Microfacet-based BRDF Generator", section 4, with the
 * distribution exp(-cot^2/sigma^2) of facets that stand upright and the shadowing of V grooves. Sampled
 * uniformly. */
#ifndef ISOPHOTE_BSDF_VELVET_H
#define ISOPHOTE_BSDF_VELVET_H
#include "../elementary.h"
#include "closure.h"

#define VELVET_SIGMA 0

FN BsdfValue eval_velvet(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  real sigma = min_real(max_real(param(c, VELVET_SIGMA), REAL(0.01)), REAL(1.0));
  real steepness = REAL(1.0) / (sigma * sigma);
  real3 m = wo + wi;
  m = m * (REAL(1.0) / sqrt(max_real(dot3(m, m), REAL(1e-30))));
  real cos_mo = dot3(wo, m);
  real sine2 = m.x * m.x + m.y * m.y;
  /* Cycles' limits: no facet stands across the normal, nor along a grazing pair's. */
  int possible = (wi.z > REAL(0.0)) & (m.z < REAL(1.0) - REAL(1e-5)) & (cos_mo > REAL(1e-5));
  real bounded2 = possible ? sine2 : REAL(1.0);
  real d = exp_real(-steepness * m.z * m.z / bounded2) * steepness * INV_PI / (bounded2 * bounded2);
  real ratio = REAL(2.0) * max_real(m.z / (possible ? cos_mo : REAL(1.0)), REAL(1e-5));
  real g = min_real(REAL(1.0), ratio * min_real(wo.z, wi.z));
  real f = possible ? REAL(0.25) * d * g / max_real(wo.z, REAL(1e-30)) : REAL(0.0);
  return make_value(splat3(f), wi.z > REAL(0.0) ? REAL(0.5) * INV_PI : REAL(0.0));
}

FN BsdfSample sample_velvet(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real u_choice,
                            real2 u) {
  real sine = sqrt(u.y * (REAL(2.0) - u.y)); /* of the polar angle whose cosine is 1 - u.y */
  real2 phi = sin_cos_real(TWO_PI * u.x);
  real3 wi = make_real3(sine * phi.y, sine * phi.x, REAL(1.0) - u.y);
  return make_sample(wi, zero3(), 0, LABEL_REFLECT | LABEL_DIFFUSE, 1);
}

FN real3 albedo_velvet(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return splat3(REAL(1.0));
}

#endif
