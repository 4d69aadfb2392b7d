/* Rough diffuse reflection that keeps its energy: Fujii's "A tiny improvement of Oren-Nayar reflectance
 * model" (2012), and light of further bounces between its facets as in the OpenPBR specification 1.1, section
 * 3.3 (the diffuse base); so Cycles has it since 4.3. */
#ifndef ISOPHOTE_BSDF_ROUGH_DIFFUSE_H
#define ISOPHOTE_BSDF_ROUGH_DIFFUSE_H
#include "diffuse.h"
#include "microfacet.h"

#define ROUGH_DIFFUSE_ROUGHNESS 0
#define ROUGH_DIFFUSE_ALBEDO 1

/* With s the roughness, one scattering is a (1 + s t), t from the angle between the two azimuths. Its directional
 * albedo is 1 - a s (LOSS - g(mu)), on average 1 - a s (LOSS - LOSS_G): kept as losses, so that nothing cancels
 * where s is small. */
#define ROUGH_DIFFUSE_LOSS REAL(0.90412966012823)   /* pi/2 - 2/3 */
#define ROUGH_DIFFUSE_LOSS_G REAL(0.22772843572653) /* (2 pi - 5.6) / 3 */

typedef struct {
  real a, b; /* b = a s */
} RoughDiffuse;
FN RoughDiffuse make_rough_diffuse(Closure c) {
  RoughDiffuse r;
  real s = clamp01(param(c, ROUGH_DIFFUSE_ROUGHNESS));
  r.a = REAL(1.0) / (PI + s * ROUGH_DIFFUSE_LOSS);
  r.b = s * r.a;
  return r;
}

/* What a direction of cosine mu loses of one scattering. g(mu) = sin (theta - 2/3 - sin cos)
 * + 2/3 (1 - sin^3) tan, whose last term is written without the division by the cosine. */
FN real rough_diffuse_loss(RoughDiffuse r, real mu) {
  real c = clamp01(mu);
  real s = safe_sqrt(REAL(1.0) - c * c);
  real bounded = s * c * (REAL(1.0) + s + s * s) / (REAL(1.0) + s);
  real g = s * (acos_real(c) - REAL(0.66666666666666667) - s * c) + REAL(0.66666666666666667) * bounded;
  return r.b * max_real(ROUGH_DIFFUSE_LOSS - g, REAL(0.0));
}

/* Albedo of all further bounces over the loss of both directions, and over that of the viewer's alone. */
FN real3 rough_diffuse_returned(RoughDiffuse r, real3 albedo) {
  real lost = r.b * (ROUGH_DIFFUSE_LOSS - ROUGH_DIFFUSE_LOSS_G);
  real3 left = splat3(REAL(1.0)) - albedo * lost;
  return make_real3(albedo.x * albedo.x / left.x, albedo.y * albedo.y / left.y, albedo.z * albedo.z / left.z) *
         (REAL(1.0) - lost);
}

FN BsdfValue eval_rough_diffuse(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  RoughDiffuse r = make_rough_diffuse(c);
  real cos_i = max_real(wi.z, REAL(0.0));
  real t = wo.x * wi.x + wo.y * wi.y + min_real(wo.z, REAL(0.0)) * cos_i; /* a viewer behind has an angle of 90 degrees */
  t = t > REAL(0.0) ? t / max_real(max_real(wo.z, cos_i), TINY) : t;
  real lost = r.b * (ROUGH_DIFFUSE_LOSS - ROUGH_DIFFUSE_LOSS_G);
  /* Both losses are in proportion to b, and so is `lost`: 0 over 0 for no roughness, which has no further bounces. */
  real pair = rough_diffuse_loss(r, wo.z) * rough_diffuse_loss(r, cos_i) / max_real(lost, TINY) * INV_PI;
  real3 more = rough_diffuse_returned(r, saturate3(param3(c, ROUGH_DIFFUSE_ALBEDO))) * pair;
  return make_value((splat3(max_real(r.a + r.b * t, REAL(0.0))) + more) * cos_i, cos_i * INV_PI);
}

FN BsdfSample sample_rough_diffuse(Closure c, int backfacing, GLOBAL const float *tables, real3 wo,
                                   real u_choice, real2 u) {
  return sample_diffuse(c, backfacing, tables, wo, u_choice, u);
}

FN real3 albedo_rough_diffuse(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  RoughDiffuse r = make_rough_diffuse(c);
  real loss = rough_diffuse_loss(r, wo.z);
  real3 more = rough_diffuse_returned(r, saturate3(param3(c, ROUGH_DIFFUSE_ALBEDO))) * loss;
  return splat3(REAL(1.0) - loss) + more;
}

#endif
