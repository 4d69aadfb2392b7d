/* A rough dielectric interface of Beckmann's microfacets (Blender's Glass and Refraction BSDF with that
 * distribution). */
#ifndef ISOPHOTE_BSDF_BECKMANN_GLASS_H
#define ISOPHOTE_BSDF_BECKMANN_GLASS_H
#include "beckmann.h"
#include "interface.h"

#define BECKMANN_GLASS_ROUGHNESS 0
#define BECKMANN_GLASS_IOR 1
#define BECKMANN_GLASS_REFLECTS 2
#define BECKMANN_GLASS_TINT 3

/* Without reflection all light is refracted but what is reflected totally, which is black (Refraction BSDF). */
FN InterfaceFresnel beckmann_fresnel(Closure c, real ior, real cos_mo) {
  InterfaceFresnel r;
  int reflects = param(c, BECKMANN_GLASS_REFLECTS) > REAL(0.0);
  DielectricFresnel fresnel = fresnel_dielectric(clamp01(cos_mo), ior);
  real f = mix_to_white(splat3(f0_from_ior(ior)), fresnel_rise(fresnel.f, ior)).x;
  real through = reflects ? REAL(1.0) - f : (fresnel.f < REAL(1.0) ? REAL(1.0) : REAL(0.0));
  r.cos_t = fresnel.cos_t;
  r.reflecting = reflects ? f : REAL(0.0);
  r.reflectance = param3(c, BECKMANN_GLASS_TINT) * r.reflecting;
  r.transmittance = param3(c, BECKMANN_GLASS_TINT) * through;
  return r;
}

FN BsdfValue eval_beckmann_glass(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  int refracts = wi.z < REAL(0.0);
  real ior = interface_ior(param(c, BECKMANN_GLASS_IOR), backfacing);
  real alpha = ggx_alpha(param(c, BECKMANN_GLASS_ROUGHNESS));
  BeckmannLobe lobe = beckmann_lobe(alpha, alpha, refracts ? ior : REAL(1.0), wo, wi);
  InterfaceFresnel fresnel = beckmann_fresnel(c, ior, lobe.cos_mo);
  int delta = refracts & is_delta_refraction(alpha * alpha, ior);
  real3 colour = select3(refracts, fresnel.transmittance, fresnel.reflectance);
  real choice = refracts ? REAL(1.0) - fresnel.reflecting : fresnel.reflecting;
  return make_value(select3(delta, zero3(), colour * lobe.f), delta ? REAL(0.0) : choice * lobe.pdf);
}

FN BsdfSample sample_beckmann_glass(Closure c, int backfacing, GLOBAL const float *tables, real3 wo,
                                    real u_choice, real2 u) {
  real ior = interface_ior(param(c, BECKMANN_GLASS_IOR), backfacing);
  real alpha = ggx_alpha(param(c, BECKMANN_GLASS_ROUGHNESS));
  real3 m = sample_beckmann_normal(alpha, alpha, u);
  real cos_mo = dot3(wo, m);
  InterfaceFresnel fresnel = beckmann_fresnel(c, ior, cos_mo);

  int refracts = u_choice >= fresnel.reflecting;
  int total = refracts & (fresnel.cos_t <= REAL(0.0)); /* refract3 may give no direction at all */
  real3 bent = select3(total, zero3() - wo, refract3(wo, m, ior, fresnel.cos_t));
  real3 wi = normalize3(select3(refracts, bent, reflect3(wo, m)));
  int valid = (cos_mo > REAL(0.0)) & !total & (refracts ? wi.z < REAL(0.0) : wi.z > REAL(0.0));

  int delta = refracts ? is_delta_refraction(alpha * alpha, ior) : is_delta(alpha * alpha);
  real3 colour = select3(refracts, fresnel.transmittance, fresnel.reflectance);
  real choice = refracts ? REAL(1.0) - fresnel.reflecting : fresnel.reflecting;
  /* What masking and the density of m leave of a sharp ray through rough facets; 1 where there is one facet only. */
  real masked = REAL(1.0) / (REAL(1.0) + beckmann_lambda(alpha, alpha, wo) + beckmann_lambda(alpha, alpha, wi));
  real kept = masked * max_real(cos_mo, REAL(0.0)) / max_real(wo.z * m.z, TINY);
  return make_sample(wi, colour * (kept / max_real(choice, TINY)), delta,
                     (refracts ? LABEL_TRANSMIT : LABEL_REFLECT) | (delta ? LABEL_SINGULAR : LABEL_GLOSSY),
                     valid);
}

/* Whatever the angle: where a smooth interface reflects totally, facets of a rough one still refract. */
FN real3 albedo_beckmann_glass(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return param3(c, BECKMANN_GLASS_TINT);
}

/* As through a smooth interface. */
FN real3 transmitted_beckmann_glass(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  if (!(param(c, BECKMANN_GLASS_REFLECTS) > REAL(0.0))) return param3(c, BECKMANN_GLASS_TINT);
  return beckmann_fresnel(c, interface_ior(param(c, BECKMANN_GLASS_IOR), backfacing), wo.z).transmittance;
}

#endif
