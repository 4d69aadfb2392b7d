/* Lambert's closure. */
#ifndef ISOPHOTE_BSDF_DIFFUSE_H
#define ISOPHOTE_BSDF_DIFFUSE_H
#include "../elementary.h"
#include "closure.h"

/* Cosine-weighted direction: Malley's method over the concentric disk of Shirley and Chiu 1997, "A
 * Low Distortion Map Between Disk and Square". */
FN real3 sample_cosine(real2 u) {
  real a = REAL(2.0) * u.x - REAL(1.0);
  real b = REAL(2.0) * u.y - REAL(1.0);
  int wide = fabs(a) > fabs(b);
  real radius = wide ? a : b; /* signed */
  real other = wide ? b : a;
  real2 angle = sin_cos_real(REAL(0.78539816339744831) * other / (radius == REAL(0.0) ? REAL(1.0) : radius));
  real along = radius * angle.y;
  real across = radius * angle.x;
  real z = sqrt((REAL(1.0) - fabs(radius)) * (REAL(1.0) + fabs(radius)));
  return make_real3(wide ? along : across, wide ? across : along, z);
}

FN BsdfValue eval_diffuse(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  real pdf = max_real(wi.z, REAL(0.0)) * INV_PI;
  return make_value(splat3(pdf), pdf);
}

FN BsdfSample sample_diffuse(Closure c, int backfacing, GLOBAL const float *tables, real3 wo,
                             real u_choice, real2 u) {
  real3 wi = sample_cosine(u);
  return make_sample(wi, zero3(), 0, LABEL_REFLECT | LABEL_DIFFUSE, wi.z > REAL(0.0));
}

FN real3 albedo_diffuse(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return splat3(REAL(1.0));
}

#endif
