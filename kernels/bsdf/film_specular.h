/* Principled's specular layer under a thin film, of two roughnesses as in anisotropic.h. */
#ifndef ISOPHOTE_BSDF_FILM_SPECULAR_H
#define ISOPHOTE_BSDF_FILM_SPECULAR_H
#include "anisotropic.h"
#include "film.h"

#define FILM_SPECULAR_ROUGHNESS_X 0
#define FILM_SPECULAR_THICKNESS 6
#define FILM_SPECULAR_FILM_IOR 7
#define FILM_SPECULAR_ROUGHNESS_Y 8

/* The first six parameters are those of specular. */
FN real3 film_specular_fresnel(Closure c, real cos_mo) {
  real thickness = param(c, FILM_SPECULAR_THICKNESS);
  real3 film = tinted_film_reflectance(clamp01(cos_mo), param(c, SPECULAR_IOR), specular_f0(c), thickness,
                                       max_real(param(c, FILM_SPECULAR_FILM_IOR), REAL(1e-5)));
  return select3(thickness > THINNEST_FILM, film, specular_fresnel(c, cos_mo));
}

/* As of a smooth surface, Cycles' estimate. */
FN real3 albedo_film_specular(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  Closure mean = isotropic_mean(c, FILM_SPECULAR_ROUGHNESS_Y);
  return film_specular_fresnel(c, wo.z) * specular_compensation(mean, tables, wo.z).saturation;
}

FN BsdfValue eval_film_specular(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  Closure mean = isotropic_mean(c, FILM_SPECULAR_ROUGHNESS_Y);
  AnisotropicAlpha alpha =
      anisotropic_alpha(param(c, FILM_SPECULAR_ROUGHNESS_X), param(c, FILM_SPECULAR_ROUGHNESS_Y));
  GgxLobe lobe = anisotropic_lobe(alpha, wo, wi);
  EnergyCompensation energy = specular_compensation(mean, tables, wo.z);
  return make_value(film_specular_fresnel(c, lobe.cos_mo) * energy.gain * lobe.f, lobe.pdf);
}

FN BsdfSample sample_film_specular(Closure c, int backfacing, GLOBAL const float *tables, real3 wo,
                                   real u_choice, real2 u) {
  AnisotropicAlpha alpha =
      anisotropic_alpha(param(c, FILM_SPECULAR_ROUGHNESS_X), param(c, FILM_SPECULAR_ROUGHNESS_Y));
  return sample_anisotropic(alpha, film_specular_fresnel(c, wo.z), wo, u);
}

#endif
