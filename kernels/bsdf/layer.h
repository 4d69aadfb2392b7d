/* What layers leave for those below them: from the running layer weight to the one of what follows.
 *
 * A layer takes the largest channel of its weighted albedo, so that no channel of the base exceeds what passes
 * (Cycles' closure layering). */
#ifndef ISOPHOTE_BSDF_LAYER_H
#define ISOPHOTE_BSDF_LAYER_H
#include "film_specular.h"
#include "sheen.h"
#include "specular.h"

#define LAYER_ABSORPTION_IOR 0
#define LAYER_ABSORPTION_TINT 1

FN real3 below_layer(Closure c, real3 albedo, real3 layer) {
  return layer * clamp01(REAL(1.0) - max_of3(c.weight * albedo));
}

/* A new stack begins. */
FN real3 layer_reset(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 layer) {
  return splat3(REAL(1.0));
}

FN real3 layer_specular(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 layer) {
  return below_layer(c, albedo_specular(c, backfacing, tables, wo), layer);
}

FN real3 layer_film_specular(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 layer) {
  return below_layer(c, albedo_film_specular(c, backfacing, tables, wo), layer);
}

FN real3 layer_sheen(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 layer) {
  return below_layer(c, albedo_sheen(c, backfacing, tables, wo), layer);
}

/* Beer's law in a coat: its tint is what one way along the normal leaves, the refracted viewer's way is longer
 * by 1/cos. `weight` mixes from no coat (0) to it (1). */
FN real3 layer_absorption(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 layer) {
  real ior = max_real(param(c, LAYER_ABSORPTION_IOR), REAL(1.0));
  real cosine = sqrt(REAL(1.0) - (REAL(1.0) - min_real(wo.z * wo.z, REAL(1.0))) / (ior * ior));
  real length = REAL(1.0) / max_real(cosine, REAL(1e-4));
  real3 tint = param3(c, LAYER_ABSORPTION_TINT);
  real3 kept = make_real3(pow_real(tint.x, length), pow_real(tint.y, length), pow_real(tint.z, length));
  real3 weight = c.weight;
  return layer * (splat3(REAL(1.0)) + (kept - splat3(REAL(1.0))) * weight);
}

#endif
