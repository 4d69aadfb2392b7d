/* Fresnel reflectances. */
#ifndef ISOPHOTE_BSDF_FRESNEL_H
#define ISOPHOTE_BSDF_FRESNEL_H
#include "../types.h"

FN real f0_from_ior(real ior) { return square((ior - REAL(1.0)) / (ior + REAL(1.0))); }

typedef struct {
  real f;     /* reflected share of unpolarised light; 1 at total internal reflection */
  real cos_t; /* cosine of the refracted ray; 0 at total internal reflection */
} DielectricFresnel;

/* Fresnel's equations for the cosine c of incidence (0 to 1). With e = ior^2 - 1 and
 * g = sqrt(e + c^2), c - g is written as -e/(c + g), so that an index close to 1 cancels nothing and
 * the index 1 reflects exactly nothing. */
FN DielectricFresnel fresnel_dielectric(real c, real ior) {
  DielectricFresnel r;
  real e = (ior - REAL(1.0)) * (ior + REAL(1.0));
  real g2 = e + c * c;
  real g = safe_sqrt(g2);
  real sum = max_real(c + g, REAL(1e-15));
  real s = e / (sum * sum);
  real p = e * (c * sum - REAL(1.0)) / (sum * max_real(ior * ior * c + g, REAL(1e-15)));
  int total = (g2 <= REAL(0.0)) & (e < REAL(0.0));
  r.f = total ? REAL(1.0) : min_real(REAL(0.5) * (s * s + p * p), REAL(1.0));
  r.cos_t = total ? REAL(0.0) : g / ior;
  return r;
}

/* How far Fresnel's curve has risen from its value at normal incidence to 1: the interpolation
 * between F0 and F90 = 1 that Cycles uses for every dielectric ("generalised Schlick" with a negative
 * exponent). Above ior 3.7 the curve first dips; the dip is clamped away. */
FN real fresnel_rise(real f, real ior) {
  real f0 = f0_from_ior(ior);
  return clamp01((f - f0) / (REAL(1.0) - f0));
}
FN real3 mix_to_white(real3 f0, real rise) { return f0 + (splat3(REAL(1.0)) - f0) * rise; }

/* Average of Fresnel's reflectance over a diffuse hemisphere: Kulla and Conty 2017, "Revisiting
 * Physically Based Shading at Imageworks", slide 19. */
FN real fresnel_dielectric_average(real ior) {
  real denser = (ior - REAL(1.0)) / (REAL(4.08567) + REAL(1.00071) * ior);
  real thinner =
      REAL(0.997118) + ior * (REAL(0.1014) - ior * (REAL(0.965241) + ior * REAL(0.130607)));
  return ior < REAL(1.0) ? thinner : denser;
}

/* F82-tint: Kutz, Hasan and Edmondson 2021, "Novel aspects of the Adobe Standard Material", section
 * 2.3: Schlick's curve less edge * c (1 - c)^6, the edge such that the curve at c = 1/7 is Schlick's
 * times the tint. */
FN real3 f82_edge(real3 f0, real3 tint) {
  real s = REAL(6.0) / REAL(7.0);
  real s5 = s * s * s * s * s;
  return mix_to_white(f0, s5) * (splat3(REAL(1.0)) - tint) * (REAL(7.0) / (s5 * s));
}
FN real3 fresnel_f82(real c, real3 f0, real3 edge) {
  real s = clamp01(REAL(1.0) - c);
  real s5 = s * s * s * s * s;
  real3 f = mix_to_white(f0, s5) - edge * (c * s5 * s);
  return make_real3(clamp01(f.x), clamp01(f.y), clamp01(f.z));
}
/* Its average over a diffuse hemisphere, in closed form. */
FN real3 fresnel_f82_average(real3 f0, real3 edge) {
  return mix_to_white(f0, REAL(1.0) / REAL(21.0)) - edge * (REAL(1.0) / REAL(126.0));
}

/* Reflectance of unpolarised light at a metal of complex index n + ik, for the cosine c of incidence: the
 * approximation for large n^2 + k^2 of Pharr, Jakob and Humphreys, "Physically Based Rendering", 2nd edition,
 * section 8.2.1, which Cycles uses. */
FN real fresnel_conductor(real c, real n, real k) {
  real squared = n * n + k * k;
  real c2 = c * c;
  real twice = REAL(2.0) * n * c;
  real parallel = (squared * c2 - twice + REAL(1.0)) / max_real(squared * c2 + twice + REAL(1.0), REAL(1e-15));
  real across = (squared - twice + c2) / max_real(squared + twice + c2, REAL(1e-15));
  return REAL(0.5) * (parallel + across);
}

#endif
