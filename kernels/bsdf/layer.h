/* What a layer leaves for the layers below it: 1 less the largest channel of its albedo, so that no
 * channel of the base exceeds what passes (Cycles' closure layering). */
#ifndef ISOPHOTE_BSDF_LAYER_H
#define ISOPHOTE_BSDF_LAYER_H
#include "specular.h"

FN real3 layer_specular(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return splat3(clamp01(REAL(1.0) - max_of3(albedo_specular(c, backfacing, tables, wo))));
}

#endif
