/* Cellular textures (Worley 1996) in one to four dimensions, as Cycles' svm/voronoi.h has them: each cell of a grid has a
 * point, and what is made depends on the points near by.
 *
 * A step looks at one neighbouring cell and is repeated over all of them; what it keeps are its outputs. Its number says
 * how lengths are measured. Cells are given as whole numbers, of which random_of_N or pcg_N make the place of the point. */
#ifndef ISOPHOTE_VALUES_VORONOI_H
#define ISOPHOTE_VALUES_VORONOI_H
#include "../elementary.h"
#include "hash.h"
#include "value.h"

/* X(number, name, inputs, outputs) */
#define VALUES_VORONOI(X)              \
  X(160, voronoi_f1_1d, 2, 2)          \
  X(161, voronoi_f1_2d, 3, 3)          \
  X(162, voronoi_f1_3d, 4, 4)          \
  X(163, voronoi_f1_4d, 5, 5)          \
  X(164, voronoi_f2_1d, 2, 4)          \
  X(165, voronoi_f2_2d, 3, 6)          \
  X(166, voronoi_f2_3d, 4, 8)          \
  X(167, voronoi_f2_4d, 5, 10)         \
  X(168, voronoi_smooth_1d, 3, 5)      \
  X(169, voronoi_smooth_2d, 4, 6)      \
  X(170, voronoi_smooth_3d, 5, 7)      \
  X(171, voronoi_smooth_4d, 6, 8)      \
  X(172, voronoi_edge_1d, 2, 1)        \
  X(173, voronoi_edge_2d, 3, 4)        \
  X(174, voronoi_edge_3d, 4, 5)        \
  X(175, voronoi_edge_4d, 5, 6)        \
  X(176, voronoi_radius_1d, 2, 4)      \
  X(177, voronoi_radius_2d, 3, 6)      \
  X(178, voronoi_radius_3d, 4, 8)      \
  X(179, voronoi_radius_4d, 5, 10)     \
  X(180, minkowski_f1_2d, 4, 3)        \
  X(181, minkowski_f1_3d, 5, 4)        \
  X(182, minkowski_f1_4d, 6, 5)        \
  X(183, minkowski_f2_2d, 4, 6)        \
  X(184, minkowski_f2_3d, 5, 8)        \
  X(185, minkowski_f2_4d, 6, 10)       \
  X(186, minkowski_smooth_2d, 5, 6)    \
  X(187, minkowski_smooth_3d, 6, 7)    \
  X(188, minkowski_smooth_4d, 7, 8)

/* Of a step's number: how lengths are measured, and that cells are hashed as whole numbers (Blender 5.0). */
#define METRIC_MANHATTAN 1u
#define METRIC_CHEBYCHEV 2u
#define METRIC_MASK 3u
#define CELLS_ARE_WHOLE 4u
#define FARTHEST REAL(3.0e38)

/* Vectors have as many coordinates as there are dimensions; the others are 0. The number of dimensions `d` is known when
 * functions are compiled, and so are the branches on it. */
FN real4 floor4(real4 a) { return make_real4(floor(a.x), floor(a.y), floor(a.z), floor(a.w)); }
FN real dot4(real4 a, real4 b) { return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w; }
FN real4 select4(int c, real4 a, real4 b) {
  return make_real4(c ? a.x : b.x, c ? a.y : b.y, c ? a.z : b.z, c ? a.w : b.w);
}
FN real4 load4(ValueStep o, const real *r, uint d) {
  return make_real4(IN(0u), d > 1u ? IN(1u) : REAL(0.0), d > 2u ? IN(2u) : REAL(0.0), d > 3u ? IN(3u) : REAL(0.0));
}
FN real4 state4(ValueStep o, const real *r, uint first, uint d) {
  return make_real4(OUT(first), d > 1u ? OUT(first + 1u) : REAL(0.0), d > 2u ? OUT(first + 2u) : REAL(0.0),
                    d > 3u ? OUT(first + 3u) : REAL(0.0));
}
FN void store4(ValueStep o, real *r, uint first, uint d, real4 v) {
  OUT(first) = v.x;
  if (d > 1u) OUT(first + 1u) = v.y;
  if (d > 2u) OUT(first + 2u) = v.z;
  if (d > 3u) OUT(first + 3u) = v.w;
}

FN real4 whole_hash(real4 c, uint d) {
  if (d == 4u) return pcg_4(c.x, c.y, c.z, c.w);
  if (d == 3u) {
    real3 v = pcg_3(c.x, c.y, c.z);
    return make_real4(v.x, v.y, v.z, REAL(0.0));
  }
  real2 v = pcg_2(c.x, c.y);
  return make_real4(v.x, v.y, REAL(0.0), REAL(0.0));
}
FN real4 float_hash(real4 c, uint d) {
  if (d == 4u)
    return make_real4(random_of_4(c.x, c.y, c.z, c.w), random_of_4(c.w, c.x, c.y, c.z),
                      random_of_4(c.z, c.w, c.x, c.y), random_of_4(c.y, c.z, c.w, c.x));
  if (d == 3u)
    return make_real4(random_of_3(c.x, c.y, c.z), random_of_4(c.x, c.y, c.z, REAL(1.0)),
                      random_of_4(c.x, c.y, c.z, REAL(2.0)), REAL(0.0));
  if (d == 2u)
    return make_real4(random_of_2(c.x, c.y), random_of_3(c.x, c.y, REAL(1.0)), REAL(0.0), REAL(0.0));
  return make_real4(random_of_1(c.x), REAL(0.0), REAL(0.0), REAL(0.0));
}
/* Where the point of a cell lies in it, in [0, 1]. */
FN real4 random_in_cell(real4 c, uint d, int whole) {
  if (d == 1u) return float_hash(c, d);
  return select4(whole, whole_hash(c, d), float_hash(c, d));
}
FN real3 cell_color(real4 c, uint d, int whole) {
  real4 h = float_hash(c, d);
  if (d == 1u) return make_real3(h.x, random_of_2(c.x, REAL(1.0)), random_of_2(c.x, REAL(2.0)));
  if (d == 2u) h.z = random_of_3(c.x, c.y, REAL(2.0));
  if (d == 4u) {
    h.y = random_of_4(c.z, c.x, c.w, c.y);
    h.z = random_of_4(c.w, c.z, c.y, c.x);
  }
  h = select4(whole, whole_hash(c, d == 2u ? 3u : d), h);
  return make_real3(h.x, h.y, h.z);
}

/* The way to neighbour k of a grid `width` wide, x first. */
FN real4 neighbour(uint k, uint width, uint d) {
  real middle = real_of(width / 2u);
  real4 v = make_real4(real_of(k % width) - middle, REAL(0.0), REAL(0.0), REAL(0.0));
  if (d > 1u) v.y = real_of(k / width % width) - middle;
  if (d > 2u) v.z = real_of(k / (width * width) % width) - middle;
  if (d > 3u) v.w = real_of(k / (width * width * width)) - middle;
  return v;
}

/* What grows as the length of v: its square, of Euclid's metric. `exponent` is Minkowski's. */
FN real measure(real4 v, uint d, uint mode, int minkowski, real exponent) {
  real x = fabs(v.x), y = fabs(v.y), z = fabs(v.z), w = fabs(v.w);
  if (minkowski)
    return pow_real(x, exponent) + pow_real(y, exponent) + (d > 2u ? pow_real(z, exponent) : REAL(0.0)) +
           (d > 3u ? pow_real(w, exponent) : REAL(0.0));
  uint metric = mode & METRIC_MASK;
  real m = dot4(v, v);
  m = metric == METRIC_MANHATTAN ? x + y + z + w : m;
  m = metric == METRIC_CHEBYCHEV ? max_real(max_real(x, y), max_real(z, w)) : m;
  return m;
}

/* A cell that is looked at, and where its point lies. */
typedef struct {
  real4 cell, way; /* its number; from the point of the texture to its point */
} Seen;

FN Seen see_cell(real4 p, real4 offset, real randomness, uint d, int whole) {
  real4 base = floor4(p);
  Seen s;
  s.cell = base + offset;
  real4 place = offset + random_in_cell(s.cell, d, whole) * randomness;
  s.way = place - (p - base);
  return s;
}

/* The nearest point. Makes its measure and its cell. */
FN void step_f1(ValueStep o, real *r, uint k, uint d, int minkowski) {
  uint mode = uint_of(o.number);
  Seen s = see_cell(load4(o, r, d), neighbour(k, 3u, d), IN(d), d, (mode & CELLS_ARE_WHOLE) != 0u);
  real m = measure(s.way, d, mode, minkowski, minkowski ? IN(d + 1u) : REAL(0.0));
  real nearest = k ? OUT(0) : FARTHEST;
  int nearer = (k == 0u) | (m < nearest);
  OUT(0) = nearer ? m : nearest;
  store4(o, r, 1u, d, select4(nearer, s.cell, state4(o, r, 1u, d)));
}

/* The second nearest point: its measure and cell, then those of the nearest. */
FN void step_f2(ValueStep o, real *r, uint k, uint d, int minkowski) {
  uint mode = uint_of(o.number), first = d + 1u;
  Seen s = see_cell(load4(o, r, d), neighbour(k, 3u, d), IN(d), d, (mode & CELLS_ARE_WHOLE) != 0u);
  real m = measure(s.way, d, mode, minkowski, minkowski ? IN(d + 1u) : REAL(0.0));
  real nearest = k ? OUT(first) : FARTHEST, second = k ? OUT(0) : FARTHEST;
  real4 nearest_cell = select4(k, state4(o, r, first + 1u, d), s.cell);
  real4 second_cell = select4(k, state4(o, r, 1u, d), s.cell);
  int nearer = m < nearest, next = !nearer & (m < second);
  OUT(0) = nearer ? nearest : next ? m : second;
  store4(o, r, 1u, d, select4(nearer, nearest_cell, select4(next, s.cell, second_cell)));
  OUT(first) = nearer ? m : nearest;
  store4(o, r, first + 1u, d, select4(nearer, s.cell, nearest_cell));
}

/* All points near by, nearer ones more; smoothness is the last input. Makes distance, colour, place. */
FN void step_smooth(ValueStep o, real *r, uint k, uint d, int minkowski) {
  uint mode = uint_of(o.number);
  int whole = (mode & CELLS_ARE_WHOLE) != 0u;
  real4 p = load4(o, r, d), offset = neighbour(k, 5u, d);
  Seen s = see_cell(p, offset, IN(d), d, whole);
  real exponent = minkowski ? IN(d + 1u) : REAL(0.0), smoothness = max_real(IN(d + 1u + uint_of(minkowski)), REAL(1e-6));
  real m = measure(s.way, d, mode, minkowski, exponent);
  real length = (mode & METRIC_MASK) ? m : sqrt(m);
  length = minkowski ? pow_real(m, exponent != REAL(0.0) ? REAL(1.0) / exponent : REAL(0.0)) : length;
  length = d == 1u ? fabs(s.way.x) : length;

  real before = k ? OUT(0) : length;
  real t = clamp01(REAL(0.5) + REAL(0.5) * (before - length) / smoothness);
  real h = k ? t * t * (REAL(3.0) - REAL(2.0) * t) : REAL(1.0), rest = REAL(1.0) - h;
  real correction = smoothness * h * rest, less = correction / (REAL(1.0) + REAL(3.0) * smoothness);
  OUT(0) = before * rest + length * h - correction;
  real3 color = cell_color(s.cell, d, whole);
  real3 color_before = select3(k, make_real3(OUT(1), OUT(2), OUT(3)), color);
  OUT3(1, color_before * rest + color * h - splat3(less))
  real4 place = p + s.way, place_before = select4(k, state4(o, r, 4u, d), place);
  store4(o, r, 4u, d, place_before * rest + place * h - make_real4(less, less, less, less));
}

/* The distance to the plane halfway between the nearest point and another: the cells are looked at twice, first for the
 * nearest. Makes the distance, then the nearest point's measure and the way to it. */
FN void step_edge(ValueStep o, real *r, uint k, uint d, uint cells) {
  int again = k >= cells;
  Seen s = see_cell(load4(o, r, d), neighbour(again ? k - cells : k, 3u, d), IN(d), d,
                    (uint_of(o.number) & CELLS_ARE_WHOLE) != 0u);
  real m = dot4(s.way, s.way), nearest = k ? OUT(1) : FARTHEST;
  real4 to_nearest = select4(k, state4(o, r, 2u, d), s.way);
  int nearer = !again & (m < nearest);
  OUT(1) = nearer ? m : nearest;
  store4(o, r, 2u, d, select4(nearer, s.way, to_nearest));
  real4 across = s.way - to_nearest;
  real square = dot4(across, across), edge = k ? OUT(0) : FARTHEST;
  int is_other = again & (square > REAL(0.0001));
  real to_edge = REAL(0.5) * dot4(to_nearest + s.way, across) / sqrt(is_other ? square : REAL(1.0));
  OUT(0) = is_other && to_edge < edge ? to_edge : edge;
}

/* The nearest point, then the one nearest to that. Makes the square of the distance between them; then the nearest
 * point's measure, the way to it and the offset of its cell. */
FN void step_radius(ValueStep o, real *r, uint k, uint d, uint cells) {
  int again = k >= cells, whole = (uint_of(o.number) & CELLS_ARE_WHOLE) != 0u;
  real4 none = make_real4(REAL(0.0), REAL(0.0), REAL(0.0), REAL(0.0));
  real4 there = select4(k, state4(o, r, 2u, d), none), shift = select4(k, state4(o, r, 2u + d, d), none);
  uint number = again ? k - cells : k;
  real4 step = neighbour(number, 3u, d), offset = select4(again, shift + step, step);
  Seen s = see_cell(load4(o, r, d), offset, IN(d), d, whole);
  real m = dot4(s.way, s.way), nearest = k ? OUT(1) : FARTHEST;
  int nearer = !again & (m < nearest);
  real4 across = s.way - there;
  real square = dot4(across, across), least = k ? OUT(0) : FARTHEST;
  int is_other = again & (number != cells / 2u);
  OUT(0) = is_other && square < least ? square : least;
  OUT(1) = nearer ? m : nearest;
  store4(o, r, 2u, d, select4(nearer, s.way, there));
  store4(o, r, 2u + d, d, select4(nearer, offset, shift));
}

/* A point, then randomness; exponent of Minkowski's metric; smoothness. */
#define VORONOI(n, cells)                                                \
  VALUE(voronoi_f1_##n##d) { step_f1(o, r, k, n##u, 0); }                \
  VALUE(voronoi_f2_##n##d) { step_f2(o, r, k, n##u, 0); }                \
  VALUE(voronoi_smooth_##n##d) { step_smooth(o, r, k, n##u, 0); }        \
  VALUE(voronoi_radius_##n##d) { step_radius(o, r, k, n##u, cells##u); }
#define MINKOWSKI(n, cells)                                              \
  VALUE(voronoi_edge_##n##d) { step_edge(o, r, k, n##u, cells##u); }     \
  VALUE(minkowski_f1_##n##d) { step_f1(o, r, k, n##u, 1); }              \
  VALUE(minkowski_f2_##n##d) { step_f2(o, r, k, n##u, 1); }              \
  VALUE(minkowski_smooth_##n##d) { step_smooth(o, r, k, n##u, 1); }
VORONOI(1, 3)
VORONOI(2, 9)
VORONOI(3, 27)
VORONOI(4, 81)
MINKOWSKI(2, 9)
MINKOWSKI(3, 27)
MINKOWSKI(4, 81)
#undef VORONOI
#undef MINKOWSKI

/* Of one dimension: the nearer middle between the cell's point and those beside it. */
VALUE(voronoi_edge_1d) {
  real base = floor(IN(0)), within = IN(0) - base, randomness = IN(1);
  real own = random_of_1(base) * randomness;
  real left = random_of_1(base - REAL(1.0)) * randomness - REAL(1.0);
  real right = random_of_1(base + REAL(1.0)) * randomness + REAL(1.0);
  OUT(0) = min_real(fabs((own + left) * REAL(0.5) - within), fabs((own + right) * REAL(0.5) - within));
}

#endif
