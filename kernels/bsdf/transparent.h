/* Light passing straight through, as if the surface were not there. */
#ifndef ISOPHOTE_BSDF_TRANSPARENT_H
#define ISOPHOTE_BSDF_TRANSPARENT_H
#include "closure.h"

FN BsdfValue eval_transparent(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  return make_value(zero3(), REAL(0.0));
}

FN BsdfSample sample_transparent(Closure c, int backfacing, GLOBAL const float *tables, real3 wo,
                                 real u_choice, real2 u) {
  return make_sample(-wo, splat3(REAL(1.0)), 1, LABEL_TRANSMIT | LABEL_TRANSPARENT, 1);
}

FN real3 albedo_transparent(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return splat3(REAL(1.0));
}

#endif
