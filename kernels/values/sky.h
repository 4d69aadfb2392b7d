/* Skies, by direction. Angles, places on pictures and the order of operations are those of Cycles
 * (src/kernel/svm/sky.h): a direction that is not of unit length has the latitude whose sine its z is.
 * A step's `data` is the first of its constants in value_tables. */
#ifndef ISOPHOTE_VALUES_SKY_H
#define ISOPHOTE_VALUES_SKY_H
#include "value.h"

/* X(number, name, inputs, outputs) */
#define VALUES_SKY(X)       \
  X(200, daylight, 3, 3)    \
  X(201, dome_place, 3, 3)  \
  X(202, globe_place, 3, 2) \
  X(203, sun_disc, 3, 4)

#define CONSTANT(n) to_real(s.value_tables[o.data + (n)])
#define CONSTANT3(n) make_real3(CONSTANT(n), CONSTANT((n) + 1), CONSTANT((n) + 2))

/* On the unit sphere. */
FN real3 from_latitude(real3 v) {
  real z = min_real(max_real(v.z, REAL(-1.0)), REAL(1.0));
  real across = sqrt(v.x * v.x + v.y * v.y);
  real scale = sqrt(REAL(1.0) - z * z) / (across > REAL(0.0) ? across : REAL(1.0));
  return make_real3(v.x * scale, v.y * scale, z);
}

/* One channel of the sky, whose constants begin at `first`: the form of Hosek and Wilkie 2012, "An Analytic Model for
 * Full Spectral Sky-Dome Radiance", section 5, of which that of Perez (Preetham, Shirley and Smits 1999, "A Practical
 * Analytic Model for Daylight", appendix A.1) is a special case. */
FN real daylight_channel(Scene s, ValueStep o, uint first, real up, real horizon, real gamma, real cosine) {
  real anisotropy = CONSTANT(first + 9u);
  real base = REAL(1.0) + anisotropy * anisotropy - REAL(2.0) * anisotropy * cosine, even = cosine * cosine;
  real haze = (REAL(1.0) + even) / (base * sqrt(base));
  real by_height = REAL(1.0) + CONSTANT(first + 1u) * exp_real(CONSTANT(first + 2u) / (up + horizon));
  real by_sun = CONSTANT(first + 3u) + CONSTANT(first + 4u) * exp_real(CONSTANT(first + 5u) * gamma) +
                CONSTANT(first + 6u) * even + CONSTANT(first + 7u) * haze + CONSTANT(first + 8u) * sqrt(up);
  return CONSTANT(first) * by_height * by_sun;
}

/* XYZ of an analytic sky, or Yxy where `number` is not 0. Constants: direction of the sun; what is added to the cosine
 * of the zenith angle; ten for each channel. Below the horizon it is what it is there. */
VALUE(daylight) {
  real3 d = from_latitude(IN3(0));
  real cosine = min_real(max_real(dot3(d, CONSTANT3(0u)), REAL(-1.0)), REAL(1.0));
  real gamma = acos_real(cosine), up = max_real(d.z, REAL(0.00099999983)), horizon = CONSTANT(3u);
  real3 found = make_real3(daylight_channel(s, o, 4u, up, horizon, gamma, cosine),
                           daylight_channel(s, o, 14u, up, horizon, gamma, cosine),
                           daylight_channel(s, o, 24u, up, horizon, gamma, cosine));
  int none = found.z == REAL(0.0);
  real over_y = found.x / (none ? REAL(1.0) : found.z);
  real3 of_chroma = make_real3(none ? REAL(0.0) : found.y * over_y, found.x,
                               none ? REAL(0.0) : (REAL(1.0) - found.y - found.z) * over_y);
  OUT3(0, select3(o.number != 0.0f, of_chroma, found))
}

/* Around the sky from where the sun's rotation, `number`, is 0, so that the sun's longitude is 1/2: 0 to 1. */
FN real sky_turn(ValueStep o, real3 v) {
  real turns = (to_real(o.number) - atan2_real(v.y, v.x)) * (REAL(0.5) * INV_PI) - REAL(0.25);
  return turns - floor(turns);
}
/* Where a height of 0 to pi/2 lies on a picture that has more of the horizon. */
FN real spread_height(real height) { return sqrt(max_real(height, REAL(0.0)) * (REAL(2.0) * INV_PI)); }

/* The place on a picture of what is above the horizon, and how much of it is left: below, the horizon fades away. */
VALUE(dome_place) {
  real3 v = IN3(0);
  real rest = max_real(REAL(1.0) + REAL(2.5) * v.z, REAL(0.0));
  int below = v.z < REAL(0.0);
  OUT(0) = sky_turn(o, v);
  OUT(1) = below ? REAL(0.0) : spread_height(asin_real(v.z));
  OUT(2) = below ? rest * rest * rest : REAL(1.0);
}
/* On a picture of all heights. */
VALUE(globe_place) {
  real3 v = IN3(0);
  real half_height = REAL(0.5) * spread_height(fabs(asin_real(v.z)));
  OUT(0) = sky_turn(o, v);
  OUT(1) = v.z < REAL(0.0) ? REAL(0.5) - half_height : REAL(0.5) + half_height;
}

/* Radiance of the sun's disc, darker at its limb, and 1 where it is. Constants: its direction and half its width; the
 * lowest height at which it is seen; factor and summand that make 0 of the height of its lower end and 1 of that of its
 * upper; the radiances of both. */
VALUE(sun_disc) {
  real3 v = IN3(0), sun = CONSTANT3(0u), off = v - sun, along = v + sun;
  real angle = REAL(2.0) * atan2_real(sqrt(dot3(off, off)), sqrt(dot3(along, along))), height = asin_real(v.z);
  int inside = (angle < CONSTANT(3u)) & (height >= CONSTANT(4u));
  real edge = angle / CONSTANT(3u);
  real limb = REAL(0.4) + REAL(0.6) * sqrt(max_real(REAL(1.0) - edge * edge, REAL(0.0)));
  real3 low = CONSTANT3(7u), high = CONSTANT3(10u);
  real3 radiance = low + (high - low) * (height * CONSTANT(5u) + CONSTANT(6u));
  OUT3(0, select3(inside, positive3(radiance) * limb, zero3()))
  OUT(3) = inside ? REAL(1.0) : REAL(0.0);
}

#undef CONSTANT
#undef CONSTANT3
#endif
