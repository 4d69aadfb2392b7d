/* Sheen of microscopic fibres: Zeltner, Burley and Chiang 2022, "Practical Multiple-Scattering Sheen Using
 * Linearly Transformed Cosines". A cosine lobe under the inverse of
 *   ( a 0 b )
 *   ( 0 a 0 )   in a frame whose x axis is the viewer's side,
 *   ( 0 0 1 )
 * times the albedo R. a, b and R lie in tables (bench/sheen_table.py), [roughness][mu], 32 nodes each. */
#ifndef ISOPHOTE_BSDF_SHEEN_H
#define ISOPHOTE_BSDF_SHEEN_H
#include "albedo.h"
#include "diffuse.h"

#define SHEEN_ROUGHNESS 0

#define LTC_NODES 32
#define LTC_A ALBEDO_SIZE
#define LTC_B (LTC_A + LTC_NODES * LTC_NODES)
#define LTC_ALBEDO (LTC_B + LTC_NODES * LTC_NODES)

FN real read_sheen(Closure c, GLOBAL const float *tables, int first, real mu) {
  real roughness = min_real(max_real(param(c, SHEEN_ROUGHNESS), REAL(1e-3)), REAL(1.0));
  return read_table2(tables, first, LTC_NODES, LTC_NODES, mu, roughness);
}

/* Cosine and sine of the viewer's azimuth. */
FN real2 sheen_side(real3 wo) {
  real squared = wo.x * wo.x + wo.y * wo.y;
  real scale = REAL(1.0) / sqrt(max_real(squared, REAL(1e-30)));
  int upright = squared < REAL(1e-30);
  return make_real2(upright ? REAL(1.0) : wo.x * scale, upright ? REAL(0.0) : wo.y * scale);
}

FN BsdfValue eval_sheen(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  real a = read_sheen(c, tables, LTC_A, wo.z);
  real b = read_sheen(c, tables, LTC_B, wo.z);
  real2 side = sheen_side(wo);
  real along = side.x * wi.x + side.y * wi.y;
  real across = side.x * wi.y - side.y * wi.x;
  real squared = square(a * along + b * wi.z) + square(a * across) + square(wi.z);
  real pdf = wi.z > REAL(0.0) ? wi.z * INV_PI * square(a / squared) : REAL(0.0);
  return make_value(splat3(pdf * read_sheen(c, tables, LTC_ALBEDO, wo.z)), pdf);
}

FN BsdfSample sample_sheen(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real u_choice,
                           real2 u) {
  real a = read_sheen(c, tables, LTC_A, wo.z);
  real b = read_sheen(c, tables, LTC_B, wo.z);
  real2 side = sheen_side(wo);
  real3 cosine = sample_cosine(u);
  real along = (cosine.x - cosine.z * b) / a;
  real across = cosine.y / a;
  real3 wi = normalize3(
      make_real3(side.x * along - side.y * across, side.y * along + side.x * across, cosine.z));
  return make_sample(wi, zero3(), 0, LABEL_REFLECT | LABEL_DIFFUSE, wi.z > REAL(0.0));
}

FN real3 albedo_sheen(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return splat3(read_sheen(c, tables, LTC_ALBEDO, wo.z));
}

#endif
