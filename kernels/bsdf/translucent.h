/* Lambert's closure on the other side: light that a thin sheet lets through in all directions. */
#ifndef ISOPHOTE_BSDF_TRANSLUCENT_H
#define ISOPHOTE_BSDF_TRANSLUCENT_H
#include "diffuse.h"

FN BsdfValue eval_translucent(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  real pdf = max_real(-wi.z, REAL(0.0)) * INV_PI;
  return make_value(splat3(pdf), pdf);
}

FN BsdfSample sample_translucent(Closure c, int backfacing, GLOBAL const float *tables, real3 wo,
                                 real u_choice, real2 u) {
  real3 wi = zero3() - sample_cosine(u);
  return make_sample(wi, zero3(), 0, LABEL_TRANSMIT | LABEL_DIFFUSE, wi.z < REAL(0.0));
}

FN real3 albedo_translucent(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return splat3(REAL(1.0));
}

#endif
