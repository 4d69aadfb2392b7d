/* Anisotropic variants of the closures that reflect by GGX: alpha_x along the frame's x axis, alpha_y along y.
 *
 * aniso_NAME has the parameters of NAME, the first of which is the roughness along x, and behind them the roughness
 * along y. Whatever comes from tables is that of their geometric mean, as in Cycles. */
#ifndef ISOPHOTE_BSDF_ANISOTROPIC_H
#define ISOPHOTE_BSDF_ANISOTROPIC_H
#include "conductor.h"
#include "glossy.h"
#include "metal.h"
#include "specular.h"

typedef struct {
  real x, y; /* alphas */
  int delta;
} AnisotropicAlpha;
FN AnisotropicAlpha anisotropic_alpha(real roughness_x, real roughness_y) {
  AnisotropicAlpha a;
  a.x = ggx_alpha(roughness_x);
  a.y = ggx_alpha(roughness_y);
  a.delta = is_delta(a.x * a.y);
  return a;
}

FN Closure isotropic_mean(Closure c, int roughness_y) {
  c.params[0] = safe_sqrt(clamp01(c.params[0]) * clamp01(c.params[roughness_y]));
  return c;
}

/* Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", eqs. 72 and 86. */
FN real anisotropic_length(AnisotropicAlpha a, real3 v) {
  return sqrt(square(a.x * v.x) + square(a.y * v.y) + v.z * v.z);
}

/* As reflection_lobe, with eq. 85 of Heitz 2014 for the distribution. */
FN GgxLobe anisotropic_lobe(AnisotropicAlpha a, real3 wo, real3 wi) {
  GgxLobe lobe;
  real3 m = wo + wi;
  real squared = dot3(m, m);
  m = m * (REAL(1.0) / sqrt(max_real(squared, TINY)));
  lobe.cos_mo = dot3(wo, m);
  int possible = (lobe.cos_mo > REAL(0.0)) & (wi.z > REAL(0.0)) & !a.delta & (squared > TINY);
  real x = possible ? a.x : REAL(1.0);
  real y = possible ? a.y : REAL(1.0);
  real spread = m.x * m.x * (y / x) + m.y * m.y * (x / y) + x * y * m.z * m.z;
  real d = x * y * INV_PI / (spread * spread);
  real length_o = anisotropic_length(a, wo);
  real visible = REAL(0.5) * d / (wo.z + length_o);
  real kept = wi.z * (wo.z + length_o) / max_real(wi.z * length_o + wo.z * anisotropic_length(a, wi), TINY);
  lobe.pdf = possible ? visible : REAL(0.0);
  lobe.f = possible ? visible * kept : REAL(0.0);
  return lobe;
}

FN BsdfSample sample_anisotropic(AnisotropicAlpha a, real3 mirror_fresnel, real3 wo, real2 u) {
  real3 m = select3(a.delta, make_real3(REAL(0.0), REAL(0.0), REAL(1.0)), sample_ggx_ellipsoid(a.x, a.y, wo, u));
  real3 wi = normalize3(reflect3(wo, m));
  int valid = (wi.z > REAL(0.0)) & (dot3(wo, m) > REAL(0.0));
  return make_sample(wi, mirror_fresnel, a.delta, LABEL_REFLECT | (a.delta ? LABEL_SINGULAR : LABEL_GLOSSY), valid);
}

#define ANISO_GLOSSY_ROUGHNESS_Y 5
#define ANISO_METAL_ROUGHNESS_Y 8
#define ANISO_SPECULAR_ROUGHNESS_Y 6
#define ANISO_CONDUCTOR_ROUGHNESS_Y 8

#define ANISOTROPIC(name, roughness_y)                                                                          \
  FN BsdfValue eval_aniso_##name(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {   \
    GgxLobe lobe = anisotropic_lobe(anisotropic_alpha(param(c, 0), param(c, roughness_y)), wo, wi);             \
    EnergyCompensation energy = name##_compensation(isotropic_mean(c, roughness_y), tables, wo.z);              \
    return make_value(name##_fresnel(c, lobe.cos_mo) * energy.gain * lobe.f, lobe.pdf);                         \
  }                                                                                                             \
  FN BsdfSample sample_aniso_##name(Closure c, int backfacing, GLOBAL const float *tables, real3 wo,            \
                                    real u_choice, real2 u) {                                                   \
    return sample_anisotropic(anisotropic_alpha(param(c, 0), param(c, roughness_y)), name##_fresnel(c, wo.z),   \
                              wo, u);                                                                           \
  }                                                                                                             \
  FN real3 albedo_aniso_##name(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {               \
    return albedo_##name(isotropic_mean(c, roughness_y), backfacing, tables, wo);                               \
  }
ANISOTROPIC(glossy, ANISO_GLOSSY_ROUGHNESS_Y)
ANISOTROPIC(metal, ANISO_METAL_ROUGHNESS_Y)
ANISOTROPIC(specular, ANISO_SPECULAR_ROUGHNESS_Y)
ANISOTROPIC(conductor, ANISO_CONDUCTOR_ROUGHNESS_Y)
#undef ANISOTROPIC

#endif
