/* What every GGX closure shares: the distribution, masking, and their sampling.
 *
 * Directions are unit and local: z is the shading normal, wo the side of the viewer (wo.z > 0).
 * m is the microfacet normal (the half vector), eta the index of refraction behind the surface over
 * that in front of it, and 1 stands for reflection. alpha2 is the square of alpha = roughness^2. */
#ifndef ISOPHOTE_BSDF_MICROFACET_H
#define ISOPHOTE_BSDF_MICROFACET_H
#include "../elementary.h"
#include "../types.h"

/* At and below this alpha^2 a lobe is a delta, as in Cycles 4.5 (roughness 0.00376): narrower lobes
 * have half vectors that float32 directions cannot tell apart. */
#define DELTA_ALPHA2 REAL(2e-10)
/* Keeps divisions finite where both directions graze; far below anything float32 resolves there. */
#define TINY REAL(1e-30)

FN real ggx_alpha(real roughness) { return square(clamp01(roughness)); }
FN int is_delta(real alpha2) { return alpha2 <= DELTA_ALPHA2; }
/* Refraction turns a tilt d of the microfacet into a tilt (1 - 1/ior) d of the ray, so glass of an
 * index close to 1 is sharp however rough it is. */
FN int is_delta_refraction(real alpha2, real ior) {
  real bend = REAL(1.0) - REAL(1.0) / ior;
  return alpha2 * min_real(bend * bend, REAL(1.0)) <= DELTA_ALPHA2;
}

/* Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", eq. 72:
 * Lambda(v) = (ggx_length(v)/|v.z| - 1) / 2, kept as a length so that nothing divides by v.z. */
FN real ggx_length(real alpha2, real3 v) {
  return sqrt(alpha2 * (v.x * v.x + v.y * v.y) + v.z * v.z);
}

/* G2(wo, wi) / G1(wo), height-correlated (Heitz 2014, eq. 99): what a microfacet sampled by visible
 * normals keeps. */
FN real ggx_visibility(real alpha2, real3 wo, real3 wi) {
  real length_o = ggx_length(alpha2, wo);
  real cos_i = fabs(wi.z);
  return cos_i * (wo.z + length_o) /
         max_real(cos_i * length_o + wo.z * ggx_length(alpha2, wi), TINY);
}

typedef struct {
  real cos_mo; /* wo . m, > 0 where the pair is possible */
  real f;      /* BSDF times |wi.z|, without Fresnel */
  real pdf;    /* per solid angle of wi, without the choice between reflection and refraction */
} GgxLobe;

/* Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces", eqs. 16, 20, 21.
 * With eta = 1 the half vector and the Jacobian of refraction become those of reflection, so one
 * formula serves both; f and pdf are 0 where no microfacet connects wo and wi. */
FN GgxLobe ggx_lobe(real alpha2, real eta, real3 wo, real3 wi) {
  GgxLobe lobe;
  int refracts = wi.z < REAL(0.0);
  /* wo + eta wi, ordered so that nearly opposite directions lose no digits. */
  real3 m = (wo + wi) + wi * (eta - REAL(1.0));
  real squared = max_real(dot3(m, m), TINY);
  real scale = (m.z < REAL(0.0) ? REAL(-1.0) : REAL(1.0)) / sqrt(squared);
  m = m * scale;
  real cos_mo = dot3(wo, m);
  real cos_mi = dot3(wi, m);
  int possible = (cos_mo > REAL(0.0)) & (refracts ? cos_mi < REAL(0.0) : wi.z > REAL(0.0));

  /* 1 - cos^2 from x and y: 1 - m.z^2 would lose all digits of a small alpha. */
  real spread = (m.x * m.x + m.y * m.y) + alpha2 * m.z * m.z;
  real d = alpha2 * INV_PI / (spread * spread);
  real jacobian = refracts ? fabs(cos_mo * cos_mi) * (eta * eta) / squared : REAL(0.25);
  real visible = REAL(2.0) * d * jacobian / (wo.z + ggx_length(alpha2, wo)); /* D G1 J / wo.z */

  lobe.cos_mo = cos_mo;
  lobe.pdf = possible ? visible : REAL(0.0);
  lobe.f = possible ? visible * ggx_visibility(alpha2, wo, wi) : REAL(0.0);
  return lobe;
}

/* A microfacet normal with the density of those visible from wo: Dupuy and Benyoub 2023, "Sampling
 * Visible GGX Normals with Spherical Caps", section 3. The sine on the cap comes from factors that
 * do not cancel, so that small alpha keeps its digits. */
FN real3 sample_ggx_ellipsoid(real alpha_x, real alpha_y, real3 wo, real2 u) {
  real3 w = normalize3(make_real3(alpha_x * wo.x, alpha_y * wo.y, wo.z));
  real one_minus_wz = (w.x * w.x + w.y * w.y) / (REAL(1.0) + w.z);
  real height = (REAL(1.0) - u.y) * (REAL(1.0) + w.z); /* cos on the cap + w.z */
  real sine = sqrt(u.y * (REAL(1.0) + w.z) * (height + one_minus_wz));
  real2 phi = sin_cos_real(TWO_PI * u.x);
  return normalize3(make_real3(alpha_x * (w.x + sine * phi.y), alpha_y * (w.y + sine * phi.x), height));
}
FN real3 sample_ggx_normal(real alpha, real3 wo, real2 u) { return sample_ggx_ellipsoid(alpha, alpha, wo, u); }

FN real3 reflect3(real3 wo, real3 m) { return m * (REAL(2.0) * dot3(wo, m)) - wo; }
/* Refraction about m; cos_t > 0 is the cosine of the refracted ray to -m. */
FN real3 refract3(real3 wo, real3 m, real ior, real cos_t) {
  return (m * dot3(wo, m) - wo) * (REAL(1.0) / ior) - m * cos_t;
}

#endif
