/* A hole in the picture: no light comes from it, and a transparent film loses its part of alpha (stages.h). */
#ifndef ISOPHOTE_BSDF_HOLDOUT_H
#define ISOPHOTE_BSDF_HOLDOUT_H
#include "closure.h"

FN BsdfValue eval_holdout(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  return make_value(zero3(), REAL(0.0));
}

FN BsdfSample sample_holdout(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real u_choice,
                             real2 u) {
  return make_sample(wo, zero3(), 1, LABEL_REFLECT | LABEL_SINGULAR, 0);
}

FN real3 albedo_holdout(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) { return zero3(); }

#endif
