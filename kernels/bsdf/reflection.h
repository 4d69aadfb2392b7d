/* The part that glossy, metal and specular share: a GGX lobe on the side of the viewer. They differ in
 * Fresnel's term only, which depends on the angle between wo and the microfacet. */
#ifndef ISOPHOTE_BSDF_REFLECTION_H
#define ISOPHOTE_BSDF_REFLECTION_H
#include "closure.h"
#include "microfacet.h"

/* The lobe at wi, all zero where wi lies below the surface and for a mirror. */
FN GgxLobe reflection_lobe(real roughness, real3 wo, real3 wi) {
  real alpha2 = square(ggx_alpha(roughness));
  GgxLobe lobe = ggx_lobe(alpha2, REAL(1.0), wo, wi);
  int none = is_delta(alpha2) | (wi.z <= REAL(0.0));
  lobe.f = none ? REAL(0.0) : lobe.f;
  lobe.pdf = none ? REAL(0.0) : lobe.pdf;
  return lobe;
}

/* The direction; a mirror's f is Fresnel's term at wo.z. */
FN BsdfSample sample_reflection(real roughness, real3 mirror_fresnel, real3 wo, real2 u) {
  real alpha = ggx_alpha(roughness);
  int delta = is_delta(alpha * alpha);
  real3 m = select3(delta, make_real3(REAL(0.0), REAL(0.0), REAL(1.0)), sample_ggx_normal(alpha, wo, u));
  real3 wi = normalize3(reflect3(wo, m));
  int valid = (wi.z > REAL(0.0)) & (dot3(wo, m) > REAL(0.0));
  return make_sample(wi, mirror_fresnel, delta, LABEL_REFLECT | (delta ? LABEL_SINGULAR : LABEL_GLOSSY), valid);
}

#endif
