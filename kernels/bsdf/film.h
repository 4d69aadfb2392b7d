/* Interference in a thin film on a dielectric: Belcour and Barla 2017, "A Practical Extension to Microfacet Theory for
 * the Modeling of Varying Iridescence". */
#ifndef ISOPHOTE_BSDF_FILM_H
#define ISOPHOTE_BSDF_FILM_H
#include "../elementary.h"
#include "fresnel.h"

#define THINNEST_FILM REAL(0.1) /* nm: at and below it there is none */

typedef struct {
  real s, p; /* amplitudes of both polarisations, signed */
  real cos_t;
  int total; /* all is reflected */
} Reflection;
FN Reflection reflected_waves(real c, real eta) {
  Reflection r;
  real squared = eta * eta - (REAL(1.0) - c) * (REAL(1.0) + c);
  real g = safe_sqrt(squared); /* eta cos_t */
  r.total = squared <= REAL(0.0);
  r.cos_t = g / eta;
  r.s = (c - g) / max_real(c + g, REAL(1e-15));
  r.p = (eta * c - r.cos_t) / max_real(eta * c + r.cos_t, REAL(1e-15));
  return r;
}

/* The Fourier transform of the eye's sensitivities at the phase `way` = 2 pi times the optical path in micrometres, by
 * the paper's fit of Gaussians to X, Y, Z (1 at `way` = 0); then as linear RGB of Rec. 709 in which an even
 * reflectance is white. */
FN real3 film_sensitivity(real way) {
  real bounded = min_real(way, REAL(3500.0)); /* where all Gaussians have long been 0 */
  real w2 = bounded * bounded;
  real x = REAL(0.846590) * cos_real(REAL(1.6810) * bounded) * exp_real(REAL(-4.3278e-3) * w2) +
           REAL(0.153868) * cos_real(REAL(2.2399) * bounded) * exp_real(REAL(-4.5282e-3) * w2);
  real y = REAL(1.000222) * cos_real(REAL(1.7953) * bounded) * exp_real(REAL(-9.3046e-3) * w2);
  real z = REAL(1.001122) * cos_real(REAL(2.2084) * bounded) * exp_real(REAL(-6.6121e-3) * w2);
  return make_real3(REAL(3.0799545) * x - REAL(1.5371385) * y - REAL(0.54281594) * z,
                    REAL(-0.92125826) * x + REAL(1.8760108) * y + REAL(0.04524742) * z,
                    REAL(0.05288738) * x - REAL(0.2040259) * y + REAL(1.15113851) * z);
}

/* One polarisation's share of Airy's sum, eq. 10: what does not interfere, and the coefficients of the first three
 * differences of paths; more do not show. The phase jumps of pi at both interfaces are signs of the amplitudes. */
typedef struct {
  real base, c1, c2, c3;
} AirySum;
FN AirySum add_polarisation(AirySum sum, real top, real bottom) {
  real reflected = top * top;
  real passed = REAL(1.0) - reflected;
  real under = bottom * bottom;
  real back = passed * passed * under / max_real(REAL(1.0) - reflected * under, REAL(1e-15));
  real turn = -top * bottom;
  real c1 = (back - passed) * turn; /* halved for the average of both, doubled for both signs of the difference */
  sum.base = sum.base + REAL(0.5) * (reflected + back);
  sum.c1 = sum.c1 + c1;
  sum.c2 = sum.c2 + c1 * turn;
  sum.c3 = sum.c3 + c1 * turn * turn;
  return sum;
}

/* Reflectance (RGB) at the cosine c of incidence of a film `thickness` nm thick, of index film_ior, on a medium of index
 * ior. Films below 30 nm fade out, as in Cycles. */
FN real3 film_reflectance(real c, real ior, real thickness, real film_ior) {
  real t = clamp01(thickness * (REAL(1.0) / REAL(30.0)));
  real n = mix_real(REAL(1.0), film_ior, t * t * (REAL(3.0) - REAL(2.0) * t));
  Reflection top = reflected_waves(c, n);
  Reflection bottom = reflected_waves(top.cos_t, ior / n);
  AirySum sum;
  sum.base = sum.c1 = sum.c2 = sum.c3 = REAL(0.0);
  sum = add_polarisation(sum, top.s, bottom.s);
  sum = add_polarisation(sum, top.p, bottom.p);
  real way = TWO_PI * REAL(2e-3) * n * thickness * top.cos_t;
  real3 f = splat3(sum.base) + film_sensitivity(way) * sum.c1 + film_sensitivity(REAL(2.0) * way) * sum.c2 +
            film_sensitivity(REAL(3.0) * way) * sum.c3;
  return select3(top.total | bottom.total, splat3(REAL(1.0)),
                 make_real3(clamp01(f.x), clamp01(f.y), clamp01(f.z)));
}

/* The same with the reflectance f0 at normal incidence instead of that of ior: scaled by their ratio, the less the
 * nearer the reflectance is to 1 (Cycles' way to have a specular tint). */
FN real scaled_reflectance(real f, real f0, real real_f0) {
  real s = clamp01((REAL(1.0) - f) / (REAL(1.0) - real_f0));
  return f * (REAL(1.0) + (f0 / max_real(real_f0, REAL(1e-5)) - REAL(1.0)) * s);
}
FN real3 tinted_film_reflectance(real c, real ior, real3 f0, real thickness, real film_ior) {
  real3 f = film_reflectance(c, ior, thickness, film_ior);
  real real_f0 = f0_from_ior(ior);
  real3 scaled = make_real3(scaled_reflectance(f.x, f0.x, real_f0), scaled_reflectance(f.y, f0.y, real_f0),
                            scaled_reflectance(f.z, f0.z, real_f0));
  return select3(real_f0 > REAL(1e-5), scaled, f);
}

#endif
