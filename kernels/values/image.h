/* Pictures: reading them at a place, and the ways from points and directions to places on them.
 *
 * Coordinates, interpolation, extension and the order of operations are those of Cycles (src/kernel/svm/image.h,
 * src/kernel/device/cpu/image.h): a picture by sRGB's curve is interpolated as it is stored and decoded thereafter. */
#ifndef ISOPHOTE_VALUES_IMAGE_H
#define ISOPHOTE_VALUES_IMAGE_H
#include "object_space.h"
#include "value.h"

/* X(number, name, inputs, outputs) */
#define VALUES_IMAGE(X)         \
  X(192, image, 2, 4)           \
  X(193, tiled_image, 2, 4)     \
  X(194, sphere_place, 3, 2)    \
  X(195, tube_place, 3, 2)      \
  X(196, sky_place, 3, 2)       \
  X(197, mirror_ball_place, 3, 2) \
  X(198, box_sides, 0, 6)       \
  X(199, stored_color, 4, 3)

/* Four numbers of a texel; grey ones hold the same in x, y and z, opaque ones 1 in w. */
typedef struct {
  real x, y, z, w;
} Texel;

FN real value_of_half(uint bits) {
  uint exponent = (bits >> 10) & 31u, mantissa = bits & 1023u;
  float normal = float_of_bits(((exponent + 112u) << 23) | (mantissa << 13));
  real size = exponent ? to_real(normal) : real_of(mantissa) * REAL(5.9604644775390625e-8);
  return (bits & 0x8000u) ? -size : size;
}

/* Channel number `at`, counted from the picture's first. Here and below modes are told apart by bits: compilers make
 * switches of comparisons with several numbers, and loops over paths do not vectorise with those. */
FN real read_channel(Scene s, Image i, uint at) {
  uint fold = TEXEL_FOLD(i.texel), bits = 32u >> fold;
  uint word = s.texels[i.first + (at >> fold)];
  uint stored = (word >> ((at & ((1u << fold) - 1u)) * bits)) & (0xffffffffu >> (32u - bits));
  real fraction = real_of(stored) * (fold & 2u ? REAL(0.00392156862745098) : REAL(1.5259021896696422e-5));
  real number = fold ? value_of_half(stored & 0xffffu) : to_real(float_of_bits(stored));
  return i.texel & TEXEL_NUMBER ? number : fraction;
}

FN Texel read_texel(Scene s, Image i, uint column, uint row) {
  Texel t;
  uint at = (row * uint_of(i.width) + column) * uint_of(i.channels);
  int grey = i.channels == 1;
  t.x = read_channel(s, i, at);
  t.y = read_channel(s, i, at + (grey ? 0u : 1u));
  t.z = read_channel(s, i, at + (grey ? 0u : 2u));
  real last = read_channel(s, i, at + uint_of(i.channels) - 1u);
  t.w = i.channels == 4 ? last : REAL(1.0);
  return t;
}

/* A coordinate with 0 and 1 at the picture's ends, brought so near to it that no digit is lost and integers hold it. */
FN real bound_coordinate(real u, uint extension) {
  real period = extension & IMAGE_SPECIAL ? REAL(2.0) : REAL(1.0);
  real repeated = u - period * floor(u / period);
  real bounded = min_real(max_real(u, REAL(-4.0)), REAL(5.0));
  real brought = extension & IMAGE_ENDS ? bounded : repeated;
  return fabs(u) < REAL(1e30) ? brought : REAL(0.0); /* also where u is no number */
}

/* Where texel n, counted from the picture's first on, lies on it: out of it where extension is IMAGE_CLIP. */
FN real extend_texel(real n, real size, uint extension) {
  real period = extension & IMAGE_SPECIAL ? REAL(2.0) * size : size;
  real wrapped = n - period * floor((n + REAL(0.5)) / period);
  real mirrored = wrapped < size ? wrapped : REAL(2.0) * size - REAL(1.0) - wrapped;
  real clamped = min_real(max_real(n, REAL(0.0)), size - REAL(1.0));
  real ended = extension & IMAGE_SPECIAL ? n : clamped;
  return extension & IMAGE_ENDS ? ended : mirrored;
}

/* One of the texels that count at a coordinate, and by how much. */
typedef struct {
  uint texel;
  real weight;
} Tap;

/* The k-th, of one, of two in linear or of four in cubic interpolation (the uniform B-spline). */
FN Tap make_tap(real u, int size, uint interpolation, uint extension, uint k) {
  Tap r;
  real width = real_of(size);
  real x = bound_coordinate(u, extension) * width - (interpolation ? REAL(0.5) : REAL(0.0));
  real first = floor(x), t = x - first, s = REAL(1.0) - t;
  real outer = k & 2u ? t : s, inner = k & 1u ? t : s;
  real steep = outer * outer * outer * REAL(0.16666666666666667);
  real gentle = (REAL(0.5) * inner - REAL(1.0)) * inner * inner + REAL(0.66666666666666667);
  real cubic = (k + 1u) & 2u ? gentle : steep;
  real weight = interpolation & IMAGE_CUBIC ? cubic : (interpolation ? inner : REAL(1.0));
  real n = first + real_of(k) - (interpolation & IMAGE_CUBIC ? REAL(1.0) : REAL(0.0));
  n = extend_texel(n, width, extension);
  int inside = (n >= REAL(0.0)) & (n < width);
  r.texel = inside ? uint_of(n) : 0u;
  r.weight = inside ? weight : REAL(0.0);
  return r;
}

FN real decode_srgb(real c) {
  real curved = pow_real((max_real(c, REAL(0.0)) + REAL(0.055)) * REAL(0.94786729857819905), REAL(2.4));
  return c < REAL(0.04045) ? max_real(c, REAL(0.0)) * REAL(0.077399380804953561) : curved;
}

/* Adds the k-th of a picture's taps at (u, v) to the outputs. */
FN void add_tap(Scene s, ValueStep o, Image i, real u, real v, real *r, uint k) {
  uint interpolation = IMAGE_INTERPOLATION(i.flags), extension = IMAGE_EXTENSION(i.flags);
  Tap x = make_tap(u, i.width, interpolation, extension, k & ((1u << interpolation) - 1u));
  Tap y = make_tap(v, i.height, interpolation, extension, k >> interpolation);
  Texel t = read_texel(s, i, x.texel, y.texel);
  real weight = x.weight * y.weight;
  real red = OUT(0), green = OUT(1), blue = OUT(2), alpha = OUT(3);
  OUT(0) = t.x * weight + (k ? red : REAL(0.0));
  OUT(1) = t.y * weight + (k ? green : REAL(0.0));
  OUT(2) = t.z * weight + (k ? blue : REAL(0.0));
  OUT(3) = t.w * weight + (k ? alpha : REAL(0.0));
}

/* Image o.data at the place (u, v): colour and alpha. */
VALUE(image) { add_tap(s, o, s.images[o.data], IN(0), IN(1), r, k); }

/* A colour as it is stored, and alpha: without alpha (IMAGE_DIVIDE_ALPHA of o.data), from sRGB's curve (IMAGE_SRGB). */
VALUE(stored_color) {
  real alpha = IN(3);
  int divide = (o.data & IMAGE_DIVIDE_ALPHA) && (alpha != REAL(0.0)) & (alpha != REAL(1.0));
  real3 c = IN3(0) * (REAL(1.0) / (divide ? alpha : REAL(1.0)));
  int curved = (o.data & IMAGE_SRGB) != 0u;
  OUT3(0, select3(curved, make_real3(decode_srgb(c.x), decode_srgb(c.y), decode_srgb(c.z)), c))
}

/* A picture of tiles, each a unit wide, ten in a row. From o.data on value_tables hold: how many there are places for,
 * then the number of each place's image; that of the last stands for all that there are not. */
VALUE(tiled_image) {
  real u = IN(0), v = IN(1);
  uint places = uint_of(s.value_tables[o.data]);
  int there = (u > REAL(-1.0)) & (v > REAL(-1.0)) & (u < REAL(10.0)) & (v < REAL(1000.0));
  real column = there ? max_real(floor(u), REAL(0.0)) : REAL(0.0), row = there ? max_real(floor(v), REAL(0.0)) : REAL(0.0);
  uint place = uint_of(row) * 10u + uint_of(column);
  place = there ? min_uint(place, places - 1u) : places - 1u;
  Image i = s.images[uint_of(s.value_tables[o.data + 1u + place])];
  add_tap(s, o, i, u - column, v - row, r, k);
}

/* Of a point in the unit cube, around its middle: by longitude and latitude. */
VALUE(sphere_place) {
  real3 p = IN3(0) * REAL(2.0) - splat3(REAL(1.0));
  real length = sqrt(dot3(p, p));
  int there = length > REAL(0.0), off_axis = (p.x != REAL(0.0)) | (p.y != REAL(0.0));
  real cosine = p.z / (there ? length : REAL(1.0));
  OUT(0) = (there & off_axis) ? REAL(0.5) - atan2_real(p.x, p.y) * (REAL(0.5) * INV_PI) : REAL(0.0);
  OUT(1) = there ? REAL(1.0) - acos_real(cosine) * INV_PI : REAL(0.0);
}

/* By longitude and height. */
VALUE(tube_place) {
  real3 p = IN3(0) * REAL(2.0) - splat3(REAL(1.0));
  int there = (p.x != REAL(0.0)) | (p.y != REAL(0.0));
  OUT(0) = there ? REAL(0.5) - atan2_real(p.x, p.y) * (REAL(0.5) * INV_PI) : REAL(0.0);
  OUT(1) = there ? (p.z + REAL(1.0)) * REAL(0.5) : REAL(0.0);
}

FN real3 unit_or_zero(real3 d) {
  real length = sqrt(dot3(d, d));
  return d * (length > REAL(0.0) ? REAL(1.0) / length : REAL(0.0));
}

/* A direction on an equirectangular picture. */
VALUE(sky_place) {
  real3 d = unit_or_zero(IN3(0));
  int there = dot3(d, d) > REAL(0.0);
  OUT(0) = there ? REAL(0.5) - atan2_real(d.y, d.x) * (REAL(0.5) * INV_PI) : REAL(0.0);
  OUT(1) = there ? REAL(1.0) - acos_real(d.z) * INV_PI : REAL(0.0);
}

/* A direction as a mirroring ball shows it that is seen along y. */
VALUE(mirror_ball_place) {
  real3 d = unit_or_zero(IN3(0));
  d.y = d.y - REAL(1.0);
  real length = REAL(2.0) * safe_sqrt(REAL(-0.5) * d.y);
  real scale = length > REAL(0.0) ? REAL(1.0) / length : REAL(1.0);
  OUT(0) = REAL(0.5) * (d.x * scale + REAL(1.0));
  OUT(1) = REAL(0.5) * (d.z * scale + REAL(1.0));
}

/* How much a picture counts from each of the three sides of a box, blended over o.number of the way between them, and
 * which of the two each is: 1 where the object's normal looks along the axis. */
VALUE(box_sides) {
  int in_object = at.instance < SPHERE_INSTANCE;
  real3 n = select3(in_object, normal_into_object(s, at, at.ns), at.ns);
  real3 a = abs3(n);
  a = a * (REAL(1.0) / max_real(a.x + a.y + a.z, REAL(1e-30)));
  real blend = to_real(o.number), limit = REAL(0.5) * (REAL(1.0) + blend), rest = REAL(1.0) - limit;
  real scale = REAL(1.0) / (blend > REAL(0.0) ? blend : REAL(1.0)), start = REAL(0.5) * (REAL(1.0) - blend);
  int only_x = (a.x > limit * (a.x + a.y)) & (a.x > limit * (a.x + a.z));
  int only_y = (a.y > limit * (a.x + a.y)) & (a.y > limit * (a.y + a.z));
  int only_z = (a.z > limit * (a.x + a.z)) & (a.z > limit * (a.y + a.z));
  int no_z = a.z < rest * (a.x + a.y), no_x = a.x < rest * (a.y + a.z), no_y = a.y < rest * (a.x + a.z);
  real tiny = REAL(1e-30);
  real of_xy = clamp01((a.x / max_real(a.x + a.y, tiny) - start) * scale);
  real of_yz = clamp01((a.y / max_real(a.y + a.z, tiny) - start) * scale);
  real of_xz = clamp01((a.x / max_real(a.x + a.z, tiny) - start) * scale);
  real3 three = (a * (REAL(2.0) - limit) + splat3(limit - REAL(1.0))) * (REAL(1.0) / max_real(REAL(2.0) * limit - REAL(1.0), tiny));
  real3 w = select3(no_y, make_real3(of_xz, REAL(0.0), REAL(1.0) - of_xz), three);
  w = select3(no_x, make_real3(REAL(0.0), of_yz, REAL(1.0) - of_yz), w);
  w = select3(no_z, make_real3(of_xy, REAL(1.0) - of_xy, REAL(0.0)), w);
  w = select3(blend > REAL(0.0), w, make_real3(REAL(1.0), REAL(0.0), REAL(0.0)));
  w = select3(only_z, make_real3(REAL(0.0), REAL(0.0), REAL(1.0)), w);
  w = select3(only_y, make_real3(REAL(0.0), REAL(1.0), REAL(0.0)), w);
  w = select3(only_x, make_real3(REAL(1.0), REAL(0.0), REAL(0.0)), w);
  OUT3(0, w)
  OUT(3) = n.x < REAL(0.0) ? REAL(0.0) : REAL(1.0);
  OUT(4) = n.y > REAL(0.0) ? REAL(1.0) : REAL(0.0);
  OUT(5) = n.z > REAL(0.0) ? REAL(1.0) : REAL(0.0);
}

#endif
