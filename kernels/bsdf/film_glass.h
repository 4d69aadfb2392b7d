/* Principled's transmission under a thin film; the first nine parameters are those of principled_glass. */
#ifndef ISOPHOTE_BSDF_FILM_GLASS_H
#define ISOPHOTE_BSDF_FILM_GLASS_H
#include "principled_glass.h"

#define FILM_GLASS_THICKNESS 9
#define FILM_GLASS_FILM_IOR 10

/* From inside, the indices count from that of the glass. */
FN Interface film_interface(Closure c, int backfacing) {
  Interface s = principled_interface(c, backfacing);
  real film_ior = max_real(param(c, FILM_GLASS_FILM_IOR), REAL(1e-5));
  s.film = param(c, FILM_GLASS_THICKNESS);
  s.film_ior = backfacing ? film_ior * s.ior : film_ior;
  return s;
}

FN BsdfValue eval_film_glass(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  return eval_interface(film_interface(c, backfacing), tables, wo, wi);
}

FN BsdfSample sample_film_glass(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real u_choice,
                                real2 u) {
  return sample_interface(film_interface(c, backfacing), tables, wo, u_choice, u);
}

FN real3 albedo_film_glass(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return albedo_interface(film_interface(c, backfacing), tables, wo);
}

FN real3 transmitted_film_glass(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return transmitted_interface(film_interface(c, backfacing), tables, wo);
}

#endif
