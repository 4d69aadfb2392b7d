/* The part that glass and principled_glass share: a rough dielectric interface that reflects and
 * refracts. Reflection or refraction is chosen in proportion to their colours' averages at the
 * sampled microfacet. */
#ifndef ISOPHOTE_BSDF_INTERFACE_H
#define ISOPHOTE_BSDF_INTERFACE_H
#include "albedo.h"
#include "film.h"
#include "microfacet.h"

typedef struct {
  real roughness, multiscatter;
  real ior;                          /* behind the surface over in front of it */
  real3 f0;                          /* reflectance at normal incidence */
  real3 reflection, transmission;    /* tints */
  real film, film_ior;               /* thickness of a film on it, nm, and its index over that in front */
} Interface;

FN real interface_ior(real ior, int backfacing) {
  real bounded = max_real(ior, REAL(1e-5));
  return backfacing ? REAL(1.0) / bounded : bounded;
}

typedef struct {
  real3 reflectance, transmittance;
  real cos_t;      /* of the refracted ray to -m */
  real reflecting; /* probability of choosing reflection; 1 where neither has energy */
} InterfaceFresnel;

FN InterfaceFresnel interface_fresnel(Interface s, real cos_mo) {
  InterfaceFresnel r;
  DielectricFresnel fresnel = fresnel_dielectric(cos_mo, s.ior);
  /* Where nothing is refracted the film must not let anything through, whatever rounding makes of its own angles. */
  real3 film = select3(fresnel.cos_t > REAL(0.0),
                       tinted_film_reflectance(cos_mo, s.ior, s.f0, s.film, s.film_ior), splat3(REAL(1.0)));
  real3 f = select3(s.film > THINNEST_FILM, film, mix_to_white(s.f0, fresnel_rise(fresnel.f, s.ior)));
  r.reflectance = f * s.reflection;
  r.transmittance = (splat3(REAL(1.0)) - f) * s.transmission;
  r.cos_t = fresnel.cos_t;
  real total = average3(r.reflectance + r.transmittance);
  r.reflecting = total > REAL(0.0) ? average3(r.reflectance) / total : REAL(1.0);
  return r;
}

FN EnergyCompensation interface_compensation(Interface s, GLOBAL const float *tables, real mu) {
  return compensate_glass(tables, s.multiscatter, s.roughness, mu, s.ior, saturate3(s.transmission));
}

FN BsdfValue eval_interface(Interface s, GLOBAL const float *tables, real3 wo, real3 wi) {
  int refracts = wi.z < REAL(0.0);
  real alpha2 = square(ggx_alpha(s.roughness));
  GgxLobe lobe = ggx_lobe(alpha2, refracts ? s.ior : REAL(1.0), wo, wi);
  InterfaceFresnel fresnel = interface_fresnel(s, min_real(max_real(lobe.cos_mo, REAL(0.0)), REAL(1.0)));
  int delta = refracts ? is_delta_refraction(alpha2, s.ior) : is_delta(alpha2);
  real choice = refracts ? REAL(1.0) - fresnel.reflecting : fresnel.reflecting;
  real3 colour = select3(refracts, fresnel.transmittance, fresnel.reflectance);
  EnergyCompensation energy = interface_compensation(s, tables, wo.z);
  return make_value(select3(delta, zero3(), colour * energy.gain * lobe.f),
                    delta ? REAL(0.0) : choice * lobe.pdf);
}

FN BsdfSample sample_interface(Interface s, GLOBAL const float *tables, real3 wo, real u_choice, real2 u) {
  real alpha = ggx_alpha(s.roughness);
  real alpha2 = alpha * alpha;
  int smooth = is_delta(alpha2);
  real3 m = select3(smooth, make_real3(REAL(0.0), REAL(0.0), REAL(1.0)), sample_ggx_normal(alpha, wo, u));
  real cos_mo = dot3(wo, m);
  InterfaceFresnel fresnel = interface_fresnel(s, min_real(max_real(cos_mo, REAL(0.0)), REAL(1.0)));

  int refracts = u_choice >= fresnel.reflecting;
  real3 wi = normalize3(select3(refracts, refract3(wo, m, s.ior, fresnel.cos_t), reflect3(wo, m)));
  int valid = (cos_mo > REAL(0.0)) & (refracts ? wi.z < REAL(0.0) : wi.z > REAL(0.0));

  /* A rough interface of an index next to 1 has sharp refraction: its microfacets still mask. */
  int delta = refracts ? is_delta_refraction(alpha2, s.ior) : smooth;
  EnergyCompensation energy = interface_compensation(s, tables, wo.z);
  real3 masked = energy.gain * ggx_visibility(alpha2, wo, wi);
  real3 colour = select3(refracts, fresnel.transmittance, fresnel.reflectance);
  real choice = refracts ? REAL(1.0) - fresnel.reflecting : fresnel.reflecting;
  real3 f = colour * select3(smooth, splat3(REAL(1.0)), masked) * (REAL(1.0) / max_real(choice, TINY));
  return make_sample(wi, f, delta,
                     (refracts ? LABEL_TRANSMIT : LABEL_REFLECT) | (delta ? LABEL_SINGULAR : LABEL_GLOSSY),
                     valid);
}

/* Reflection from the tables, refraction and films as of a smooth interface: Cycles' estimate. */
FN real3 albedo_interface(Interface s, GLOBAL const float *tables, real3 wo) {
  InterfaceFresnel smooth = interface_fresnel(s, min_real(wo.z, REAL(1.0)));
  real rise = dielectric_rise(tables, s.roughness, wo.z, s.ior);
  real3 reflected = select3(s.film > THINNEST_FILM, smooth.reflectance, mix_to_white(s.f0, rise) * s.reflection);
  return (reflected + smooth.transmittance) * interface_compensation(s, tables, wo.z).saturation;
}
/* The part of it that is refracted. */
FN real3 transmitted_interface(Interface s, GLOBAL const float *tables, real3 wo) {
  return interface_fresnel(s, min_real(wo.z, REAL(1.0))).transmittance * interface_compensation(s, tables, wo.z).saturation;
}

#endif
