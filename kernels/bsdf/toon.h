/* Toon shading: a cone of even brightness with a soft edge, around the normal (diffuse) or the mirrored viewer
 * (glossy). f is a share of the cone's uniform density, as in Cycles: there is no cosine. */
#ifndef ISOPHOTE_BSDF_TOON_H
#define ISOPHOTE_BSDF_TOON_H
#include "../elementary.h"
#include "closure.h"
#include "microfacet.h"

#define TOON_SIZE 0
#define TOON_SMOOTH 1
#define HALF_PI REAL(1.57079632679489662)

typedef struct {
  real angle, soft; /* of the even part and of its edge */
  real height;      /* 1 - cos of the whole cone, 0 where it is empty */
} ToonCone;
FN ToonCone make_toon(Closure c) {
  ToonCone t;
  t.angle = clamp01(param(c, TOON_SIZE)) * HALF_PI;
  t.soft = clamp01(param(c, TOON_SMOOTH)) * HALF_PI;
  real sine = sin_real(REAL(0.5) * min_real(t.angle + t.soft, HALF_PI));
  t.height = REAL(2.0) * sine * sine;
  return t;
}

FN BsdfValue eval_toon(Closure c, real3 axis, real3 wi) {
  ToonCone t = make_toon(c);
  real3 across = cross3(axis, wi);
  real angle = atan2_real(sqrt(dot3(across, across)), dot3(axis, wi));
  int inside = (angle < min_real(t.angle + t.soft, HALF_PI)) & (wi.z > REAL(0.0)) & (t.height > REAL(0.0));
  real pdf = inside ? REAL(1.0) / max_real(TWO_PI * t.height, TINY) : REAL(0.0);
  real edge = REAL(1.0) - (angle - t.angle) / max_real(t.soft, TINY);
  return make_value(splat3(pdf * (angle < t.angle ? REAL(1.0) : clamp01(edge))), pdf);
}

/* A direction of the cone around the normal, uniform. */
FN real3 sample_toon(Closure c, real2 u) {
  real depth = u.y * make_toon(c).height;
  real sine = sqrt(depth * (REAL(2.0) - depth));
  real2 phi = sin_cos_real(TWO_PI * u.x);
  return make_real3(sine * phi.y, sine * phi.x, REAL(1.0) - depth);
}

FN BsdfValue eval_diffuse_toon(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  return eval_toon(c, make_real3(REAL(0.0), REAL(0.0), REAL(1.0)), wi);
}

FN BsdfSample sample_diffuse_toon(Closure c, int backfacing, GLOBAL const float *tables, real3 wo,
                                  real u_choice, real2 u) {
  real3 wi = sample_toon(c, u);
  int valid = (make_toon(c).height > REAL(0.0)) & (wi.z > REAL(0.0));
  return make_sample(wi, zero3(), 0, LABEL_REFLECT | LABEL_DIFFUSE, valid);
}

FN real3 albedo_diffuse_toon(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return splat3(REAL(1.0));
}

FN BsdfValue eval_glossy_toon(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  return eval_toon(c, make_real3(-wo.x, -wo.y, wo.z), wi);
}

FN BsdfSample sample_glossy_toon(Closure c, int backfacing, GLOBAL const float *tables, real3 wo,
                                 real u_choice, real2 u) {
  real3 wi = normalize3(to_world(make_frame(make_real3(-wo.x, -wo.y, wo.z)), sample_toon(c, u)));
  int valid = (make_toon(c).height > REAL(0.0)) & (wi.z > REAL(0.0));
  return make_sample(wi, zero3(), 0, LABEL_REFLECT | LABEL_GLOSSY, valid);
}

FN real3 albedo_glossy_toon(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return splat3(REAL(1.0));
}

#endif
