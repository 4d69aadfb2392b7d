/* Phase functions: how volumes scatter light, by the angle between where it was going and where it goes. Densities per
 * solid angle, so their integral is 1. */
#ifndef ISOPHOTE_PHASE_H
#define ISOPHOTE_PHASE_H
#include "types.h"

/* Mean cosine up to which peaks are told from a straight line, as in Cycles. */
#define MOST_ANISOTROPY REAL(0.999)

FN real bounded_anisotropy(real g) { return min_real(max_real(g, -MOST_ANISOTROPY), MOST_ANISOTROPY); }

/* Henyey and Greenstein 1941, "Diffuse radiation in the galaxy"; g: mean cosine. 1 - cosine is half the square of what the
 * unit vectors differ by, which keeps the digits of a narrow peak; a peak backwards is one of the opposite direction. */
FN real henyey_greenstein(real3 before, real3 after, real g) {
  real forward = fabs(g);
  real3 off = after - before * (g < REAL(0.0) ? REAL(-1.0) : REAL(1.0));
  real width = square(REAL(1.0) - forward) + forward * dot3(off, off);
  return REAL(0.25) * INV_PI * (REAL(1.0) - forward) * (REAL(1.0) + forward) / (width * sqrt(width));
}

/* What Draine 2003, "Scattering by Interstellar Dust Grains. I. Optical and Ultraviolet", equation 4, has more of each
 * direction than Henyey and Greenstein: alpha 0 is theirs, alpha 1 with g 0 Rayleigh's. */
FN real draine_ratio(real cosine, real g, real alpha) {
  return (REAL(1.0) + alpha * cosine * cosine) /
         (REAL(1.0) + alpha * (REAL(1.0) + REAL(2.0) * g * g) * REAL(0.33333333333333333));
}

/* A direction with the density of henyey_greenstein. */
FN real3 sample_henyey_greenstein(real3 before, real g, real2 u) {
  real forward = fabs(g), narrow = REAL(1.0) - forward, stretch = narrow + REAL(2.0) * forward * u.x;
  real bent = narrow * (REAL(1.0) + forward) / stretch;
  real gap = min_real(narrow * (REAL(1.0) - u.x) * (bent + narrow) / stretch, REAL(2.0)); /* 1 - cosine */
  real sine = safe_sqrt(gap * (REAL(2.0) - gap));
  Frame frame = make_frame(before * (g < REAL(0.0) ? REAL(-1.0) : REAL(1.0)));
  real2 phi = sin_cos_real(TWO_PI * u.y);
  return normalize3(to_world(frame, make_real3(sine * phi.y, sine * phi.x, REAL(1.0) - gap)));
}

#endif
