/* Light that wanders about below the surface before it leaves it elsewhere. The closure draws where light enters, and
 * says what it wanders in; walk.h has the way. There is nothing to evaluate: no light passes here by reflection.
 *
 * Chiang, Kutz and Burley 2016, "Practical and Controllable Subsurface Scattering for Production Path Tracing": what
 * users give is the colour that comes out and a mean free path. As in Cycles 4.5, whoever was scattered diffusely before
 * meets a diffuse closure of the same weight instead (scatter.h). */
#ifndef ISOPHOTE_BSDF_SUBSURFACE_H
#define ISOPHOTE_BSDF_SUBSURFACE_H
#include "diffuse.h"
#include "microfacet.h"

#define SUBSURFACE_RADIUS 0 /* reduced mean free paths, metres */
#define SUBSURFACE_ALBEDO 3
#define SUBSURFACE_ANISOTROPY 6
#define SUBSURFACE_IOR 7
#define SUBSURFACE_ROUGHNESS 8
#define SUBSURFACE_DIFFUSE 9 /* chance to enter by Lambert's law instead of by refraction */
#define SUBSURFACE_OUT 10    /* 1: weight of the closure by which light comes out (prepare.py) */

/* Below it, guided directions would get infinite densities: the rest is weight. */
#define LEAST_SCATTERING REAL(0.2)
#define MOST_SCATTERING REAL(0.999999) /* beyond, float32 has few digits left for what is absorbed */

FN BsdfValue eval_subsurface(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  return make_value(zero3(), REAL(0.0));
}

/* Refraction by GGX' facets without Fresnel's term and without their shadows, which the colour is to have already. */
FN BsdfSample sample_subsurface(Closure c, int backfacing, GLOBAL const float *tables, real3 wo,
                                real u_choice, real2 u) {
  real alpha = ggx_alpha(param(c, SUBSURFACE_ROUGHNESS)), ior = param(c, SUBSURFACE_IOR);
  real3 m = select3(is_delta(alpha * alpha), make_real3(REAL(0.0), REAL(0.0), REAL(1.0)), sample_ggx_normal(alpha, wo, u));
  real sine = safe_sqrt(REAL(1.0) - square(dot3(wo, m))) / ior;
  real3 wi = normalize3(refract3(wo, m, ior, safe_sqrt(REAL(1.0) - sine * sine)));
  wi = select3(u_choice < param(c, SUBSURFACE_DIFFUSE), zero3() - sample_cosine(u), wi);
  return make_sample(wi, splat3(REAL(1.0)), 1, LABEL_SUBSURFACE, wi.z < REAL(0.0));
}

/* Of the colour, which is in the weight. */
FN real3 albedo_subsurface(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  return splat3(REAL(1.0));
}

/* What fills the object below such a closure. */
typedef struct {
  real3 extinction; /* 1/m */
  real3 scattering; /* its part of the extinction: albedos of one scattering */
  real anisotropy;  /* mean cosine of the phase function of Henyey and Greenstein */
  real guiding;     /* inverse of the diffusion length, in mean free paths */
  real3 normal;     /* of the surface where the path has entered, outward */
} Medium;

FN real polynomial7(real x, real c0, real c1, real c2, real c3, real c4, real c5, real c6, real c7) {
  return c0 + x * (c1 + x * (c2 + x * (c3 + x * (c4 + x * (c5 + x * (c6 + x * c7))))));
}

/* Two curves, for dark and for light colours. */
typedef struct {
  real low, low_scale, low_power, high, high_scale, high_power;
} AlbedoFit;

/* Constants of Wrenninge, Villemin and Hery 2017, "Path Traced Subsurface Scattering using Anisotropic Phase Functions
 * and Non-Exponential Free Flights", as Cycles 4.5 has them. */
FN AlbedoFit fit_albedo(real g) {
  AlbedoFit f;
  f.low = polynomial7(g, REAL(1.8260523782), REAL(-1.28451056436), REAL(-1.79904629312), REAL(9.19393289202),
                      REAL(-22.8215585862), REAL(32.0234874259), REAL(-23.6264803333), REAL(7.21067002658));
  f.low_scale = REAL(4.98511194385) + REAL(0.127355959438) *
      exp_real(polynomial7(g, REAL(0.0), REAL(31.1491581433), REAL(-201.847017512), REAL(841.576016723),
                           REAL(-2018.09288505), REAL(2731.71560286), REAL(-1935.41424244), REAL(559.009054474)));
  f.low_power = polynomial7(g, REAL(1.09686102424), REAL(-0.394704063468), REAL(1.05258115941), REAL(-8.83963712726),
                            REAL(28.8643230661), REAL(-46.8802913581), REAL(38.5402837518), REAL(-12.7181042538));
  f.high = polynomial7(g, REAL(0.496310210422), REAL(0.360146581622), REAL(-2.15139309747), REAL(17.8896899217),
                       REAL(-55.2984010333), REAL(82.065982243), REAL(-58.5106008578), REAL(15.8478295021));
  f.high_scale = REAL(4.23190299701) + REAL(0.00310603949088) *
      exp_real(polynomial7(g, REAL(0.0), REAL(76.7316253952), REAL(-594.356773233), REAL(2448.8834203),
                           REAL(-5576.68528998), REAL(7116.60171912), REAL(-4763.54467887), REAL(1303.5318055)));
  f.high_power = polynomial7(g, REAL(2.40602999408), REAL(-2.51814844609), REAL(9.18494908356), REAL(-79.2191708682),
                             REAL(259.082868209), REAL(-403.613804597), REAL(302.85712436), REAL(-87.4370473567));
  return f;
}

/* Albedo of one scattering at which a half-space lit from everywhere has the given colour. */
FN real scattering_albedo(AlbedoFit f, real colour) {
  real one = REAL(1.0), root = sqrt(sqrt(colour));
  real low = f.low * pow_real(atan2_real(f.low_scale * colour, one), f.low_power);
  real high = f.high * pow_real(atan2_real(f.high_scale * colour, one), f.high_power);
  return min_real(max_real(mix_real(low, high, root), REAL(0.0)), MOST_SCATTERING);
}

/* How a path goes in. */
typedef struct {
  Medium medium;
  real3 weight; /* times the path's, which has the colour already that the walk will bring */
} Entrance;

FN Entrance make_entrance(Closure c, real3 normal) {
  Entrance e;
  Medium m;
  real3 albedo = param3(c, SUBSURFACE_ALBEDO), radius = param3(c, SUBSURFACE_RADIUS);
  m.anisotropy = param(c, SUBSURFACE_ANISOTROPY);
  real reduced = REAL(1.0) - m.anisotropy, least = LEAST_SCATTERING;
  m.extinction = make_real3(REAL(1.0) / (radius.x * reduced), REAL(1.0) / (radius.y * reduced),
                            REAL(1.0) / (radius.z * reduced));
  AlbedoFit fit = fit_albedo(m.anisotropy);
  real3 s = make_real3(scattering_albedo(fit, albedo.x), scattering_albedo(fit, albedo.y),
                       scattering_albedo(fit, albedo.z));
  m.scattering = make_real3(max_real(s.x, least), max_real(s.y, least), max_real(s.z, least));
  /* d'Eon and Krivanek 2020, "Zero-Variance Theory for Efficient Subsurface Scattering", equation 67, of the channel
   * that is absorbed least: too strong a pull outward would make fireflies of it. */
  real most = max_of3(m.scattering);
  real power = REAL(2.44294) - REAL(0.0215813) * most + REAL(0.578637) / most;
  m.guiding = sqrt(max_real(REAL(1.0) - pow_real(most, power), REAL(1e-7)));
  m.normal = normal;
  e.medium = m;
  e.weight = make_real3(albedo.x > REAL(0.0) ? min_real(s.x / least, REAL(1.0)) / albedo.x : REAL(0.0),
                        albedo.y > REAL(0.0) ? min_real(s.y / least, REAL(1.0)) / albedo.y : REAL(0.0),
                        albedo.z > REAL(0.0) ? min_real(s.z / least, REAL(1.0)) / albedo.z : REAL(0.0));
  return e;
}

#endif
