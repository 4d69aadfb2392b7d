/* Colours: HSV and HSL, blend modes that need a case by case formula, the glow of black bodies.
 *
 * Formulas outside of their customary ranges are those of Cycles (src/util/color.h, src/kernel/svm/color_util.h), since
 * node graphs use them there, too. */
#ifndef ISOPHOTE_VALUES_COLOUR_H
#define ISOPHOTE_VALUES_COLOUR_H
#include "value.h"

/* X(number, name, inputs, outputs) */
#define VALUES_COLOUR(X)   \
  X(96, rgb_to_hsv, 3, 3)  \
  X(97, hsv_to_rgb, 3, 3)  \
  X(98, rgb_to_hsl, 3, 3)  \
  X(99, hsl_to_rgb, 3, 3)  \
  X(100, blackbody, 1, 3)  \
  X(101, gamma, 2, 1)      \
  X(102, overlay, 3, 1)    \
  X(103, dodge, 3, 1)      \
  X(104, burn, 3, 1)       \
  X(105, dipole_length, 2, 3)

/* Turns from red, in [0, 1], of a colour whose largest part is `most`, by `range` more than its least, which is not 0. */
FN real hue_of(real3 c, real most, real range) {
  real from_red = (c.y - c.z) / range, from_green = (c.z - c.x) / range, from_blue = (c.x - c.y) / range;
  real sixths = c.x == most ? from_red : c.y == most ? from_green + REAL(2.0) : from_blue + REAL(4.0);
  real hue = sixths / REAL(6.0);
  return hue < REAL(0.0) ? hue + REAL(1.0) : hue;
}

VALUE(rgb_to_hsv) {
  real3 c = IN3(0);
  real most = max_of3(c), range = most - min_of3(c);
  real saturation = most == REAL(0.0) ? REAL(0.0) : range / (most == REAL(0.0) ? REAL(1.0) : most);
  int grey = saturation == REAL(0.0);
  real hue = hue_of(c, most, grey ? REAL(1.0) : range);
  OUT3(0, make_real3(grey ? REAL(0.0) : hue, saturation, most))
}
VALUE(hsv_to_rgb) {
  real3 hsv = IN3(0);
  real sixths = (hsv.x == REAL(1.0) ? REAL(0.0) : hsv.x) * REAL(6.0);
  real sector = floor(sixths);
  real along = sixths - sector, v = hsv.z;
  real least = v * (REAL(1.0) - hsv.y);
  real falling = v * (REAL(1.0) - hsv.y * along);
  real rising = v * (REAL(1.0) - hsv.y * (REAL(1.0) - along));
  int s0 = sector == REAL(0.0), s1 = sector == REAL(1.0), s2 = sector == REAL(2.0);
  int s3 = sector == REAL(3.0), s4 = sector == REAL(4.0); /* all others are the fifth */
  real red = s1 ? falling : (s2 | s3) ? least : s4 ? rising : v;
  real green = s0 ? rising : (s1 | s2) ? v : s3 ? falling : least;
  real blue = (s0 | s1) ? least : s2 ? rising : (s3 | s4) ? v : falling;
  OUT3(0, make_real3(red, green, blue))
}
VALUE(rgb_to_hsl) {
  real3 c = IN3(0);
  real most = max_of3(c), least = min_of3(c);
  real range = most - least, sum = most + least;
  real lightness = min_real(REAL(1.0), sum * REAL(0.5));
  int grey = range == REAL(0.0);
  real room = lightness > REAL(0.5) ? REAL(2.0) - sum : sum;
  real saturation = range / (grey ? REAL(1.0) : room);
  real hue = hue_of(c, most, grey ? REAL(1.0) : range);
  OUT3(0, make_real3(grey ? REAL(0.0) : hue, saturation, lightness))
}
VALUE(hsl_to_rgb) {
  real3 hsl = IN3(0);
  real sixths = hsl.x * REAL(6.0);
  real chroma = (REAL(1.0) - fabs(REAL(2.0) * hsl.z - REAL(1.0))) * hsl.y;
  real red = clamp01(fabs(sixths - REAL(3.0)) - REAL(1.0)) - REAL(0.5);
  real green = clamp01(REAL(2.0) - fabs(sixths - REAL(2.0))) - REAL(0.5);
  real blue = clamp01(REAL(2.0) - fabs(sixths - REAL(4.0))) - REAL(0.5);
  OUT3(0, make_real3(red, green, blue) * chroma + splat3(hsl.z))
}

/* One of seven numbers, by the piece of the fit below in which a temperature lies. */
FN real piece_of(real t, real a, real b, real c, real d, real e, real f, real g) {
  real piece = t < REAL(965.0) ? a : b;
  piece = t < REAL(1167.0) ? piece : c;
  piece = t < REAL(1449.0) ? piece : d;
  piece = t < REAL(1902.0) ? piece : e;
  piece = t < REAL(3315.0) ? piece : f;
  return t < REAL(6365.0) ? piece : g;
}
/* Colour of a black body at a temperature in K, luminance near 1: the fit of Cycles in seven pieces, a / T + b T + c for
 * red and green and a cubic polynomial for blue (src/kernel/tables.h), 800 K to 12000 K. */
VALUE(blackbody) {
  real t = min_real(max_real(IN(0), REAL(800.0)), REAL(12000.0)), inverse = REAL(1.0) / t;
  real r0 = piece_of(t, REAL(1.61919106e+03), REAL(2.48845471e+03), REAL(3.34143193e+03), REAL(4.09461742e+03),
                     REAL(4.67028036e+03), REAL(4.59509185e+03), REAL(3.78717450e+03));
  real r1 = piece_of(t, REAL(-2.05010916e-03), REAL(-1.11330907e-03), REAL(-4.86551192e-04), REAL(-1.27446582e-04),
                     REAL(2.91258199e-05), REAL(2.87495649e-05), REAL(9.35907826e-06));
  real r2 = piece_of(t, REAL(5.02995757e+00), REAL(3.22621544e+00), REAL(1.76486769e+00), REAL(7.25731635e-01),
                     REAL(1.26703442e-01), REAL(1.50345020e-01), REAL(3.99075871e-01));
  real g0 = piece_of(t, REAL(-4.88999748e+02), REAL(-7.55994277e+02), REAL(-1.02363977e+03), REAL(-1.26571316e+03),
                     REAL(-1.42529332e+03), REAL(-1.17554822e+03), REAL(-5.00799571e+02));
  real g1 = piece_of(t, REAL(6.04330754e-04), REAL(3.16730098e-04), REAL(1.20223470e-04), REAL(4.87340896e-06),
                     REAL(-4.01150431e-05), REAL(-2.16378048e-05), REAL(-4.59832026e-06));
  real g2 = piece_of(t, REAL(-7.55807526e-02), REAL(4.78306139e-01), REAL(9.36662319e-01), REAL(1.27054498e+00),
                     REAL(1.43972784e+00), REAL(1.30408023e+00), REAL(1.09098763e+00));
  real b0 = piece_of(t, REAL(5.96945309e-11), REAL(2.40430366e-11), REAL(-1.40949732e-11), REAL(-3.61460868e-11),
                     REAL(-1.97075738e-11), REAL(-1.61997957e-13), REAL(6.72650283e-13));
  real b1 = piece_of(t, REAL(-4.85742887e-08), REAL(5.55021075e-08), REAL(1.89878968e-07), REAL(2.84822009e-07),
                     REAL(1.75359352e-07), REAL(-1.64216008e-08), REAL(-2.73078809e-08));
  real b2 = piece_of(t, REAL(-9.70622247e-05), REAL(-1.98503712e-04), REAL(-3.56632824e-04), REAL(-4.93211319e-04),
                     REAL(-2.50542825e-04), REAL(3.86216271e-04), REAL(4.24098264e-04));
  real b3 = piece_of(t, REAL(-4.07936148e-03), REAL(2.89312858e-02), REAL(9.10767778e-02), REAL(1.56723440e-01),
                     REAL(-2.22783266e-02), REAL(-7.38077418e-01), REAL(-7.52335691e-01));
  OUT(0) = max_real(r0 * inverse + r1 * t + r2, REAL(0.0));
  OUT(1) = max_real(g0 * inverse + g1 * t + g2, REAL(0.0));
  OUT(2) = max_real(((b0 * t + b1) * t + b2) * t + b3, REAL(0.0));
}

/* x^y of what is positive; the rest stays. 1 where y is 0. */
VALUE(gamma) {
  real x = IN(0), y = IN(1);
  real power = x > REAL(0.0) ? pow_real(x, y) : x;
  OUT(0) = y == REAL(0.0) ? REAL(1.0) : power;
}

/* Blend modes: the first with the second by the third. */
VALUE(overlay) {
  real a = IN(0), b = IN(1), t = IN(2), rest = REAL(1.0) - t;
  real dark = a * (rest + REAL(2.0) * t * b);
  real light = REAL(1.0) - (rest + REAL(2.0) * t * (REAL(1.0) - b)) * (REAL(1.0) - a);
  OUT(0) = a < REAL(0.5) ? dark : light;
}
VALUE(dodge) {
  real a = IN(0), room = REAL(1.0) - IN(2) * IN(1);
  int full = room <= REAL(0.0);
  real brighter = min_real(a / (full ? REAL(1.0) : room), REAL(1.0));
  OUT(0) = a == REAL(0.0) ? a : full ? REAL(1.0) : brighter;
}
VALUE(burn) {
  real t = IN(2), room = (REAL(1.0) - t) + t * IN(1);
  int none = room <= REAL(0.0);
  real darker = clamp01(REAL(1.0) - (REAL(1.0) - IN(0)) / (none ? REAL(1.0) : room));
  OUT(0) = none ? REAL(0.0) : darker;
}

/* Light that a dipole reflects, of reduced albedo a and internal reflection A, as 4 A / 3: Jensen et al. 2001, "A Practical
 * Model for Subsurface Light Transport", equation 9. */
FN real dipole_reflectance(real a, real internal) {
  real root = sqrt(REAL(3.0) * (REAL(1.0) - a));
  return REAL(0.5) * a * (REAL(1.0) + exp_real(-internal * root)) * exp_real(-root);
}
/* Mean free path over the diffusion length that the user gives, for a colour and an index of refraction: from the reduced
 * albedo of such a dipole, found by halving. A step a halving, with the ends in the last two outputs; it is to be done
 * twelve times as in Cycles 4.5 (closure/bssrdf.h), which shows where the colour is light. */
VALUE(dipole_length) {
  real colour = IN(0), slower = REAL(1.0) / IN(1);
  real back = slower * (REAL(0.71) - REAL(1.44) * slower) + REAL(0.668) + REAL(0.0636) * IN(1);
  real internal = REAL(1.3333333333333333) * (REAL(1.0) + back) / (REAL(1.0) - back);
  real low = k ? OUT(1) : REAL(0.0), high = k ? OUT(2) : REAL(1.0), middle = REAL(0.5) * (low + high);
  int above = dipole_reflectance(middle, internal) < colour;
  real bright = colour < REAL(0.995) ? middle : REAL(0.999999);
  OUT(0) = sqrt(REAL(3.0) * (REAL(1.0) - (colour < REAL(1e-4) ? REAL(0.0) : bright)));
  OUT(1) = above ? middle : low;
  OUT(2) = above ? high : middle;
}

#endif
