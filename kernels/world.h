/* The world: what rays see that leave the scene, and drawing directions in proportion to how bright it is.
 *
 * A world that is not the same in all directions is a material whose emission is asked for with the direction as the
 * place. Its map is a piecewise constant density over an equirectangular picture (Pharr, Jakob and Humphreys 2016, PBR
 * 3rd ed., section 14.2.4), kept as cumulated chances alone: a cell's chance is the difference that drawing it sees. */
#ifndef ISOPHOTE_WORLD_H
#define ISOPHOTE_WORLD_H
#include "elementary.h"
#include "surface.h"

/* What a ray that leaves the scene "hits". No instance is asked of it: like a sphere it has none. */
FN Surface make_background(Scene s, real3 direction) {
  Surface r;
  r.p = direction;
  r.offset = REAL(0.0);
  r.ng = zero3() - direction;
  r.ns = r.ng;
  r.backfacing = 0;
  r.material = s.world[0].material;
  return r;
}
FN Hit background_hit(real t) {
  Hit h = no_hit(t);
  h.instance = SPHERE_INSTANCE;
  return h;
}

/* Of cells whose cumulated chances, from 0 to 1, begin at `first` of the map: the cell in which u falls. */
typedef struct {
  uint cell;
  real chance;
  real rest; /* where in it, 0 to 1 */
} CellDraw;

FN CellDraw draw_cell(Scene s, uint first, uint cells, real u) {
  CellDraw r;
  uint low = 0u;
  UNROLL
  for (uint step = MOST_MAP_CELLS >> 1; step > 0u; step >>= 1) {
    uint next = low + step;
    real there = to_real(s.world_map[first + min_uint(next, cells)]);
    low = ((next < cells) & (there <= u)) ? next : low;
  }
  real start = to_real(s.world_map[first + low]);
  r.cell = low;
  r.chance = to_real(s.world_map[first + low + 1u]) - start;
  r.rest = (u - start) / r.chance;
  return r;
}

FN real cell_chance(Scene s, uint first, uint cell) {
  return to_real(s.world_map[first + cell + 1u]) - to_real(s.world_map[first + cell]);
}

/* Per solid angle, from chances of row and column. A direction at a pole is not quite there. */
FN real map_pdf(World w, real chance, real sine) {
  return chance * real_of(w.map_width) * real_of(w.map_height) / (TWO_PI * PI * max_real(sine, REAL(1e-8)));
}

typedef struct {
  real3 direction;
  real pdf;
} WorldSample;

/* Rows of the map begin at the sphere's south pole, as those of pictures do. */
FN WorldSample sample_map(Scene s, real2 u) {
  WorldSample r;
  World w = s.world[0];
  CellDraw row = draw_cell(s, 0u, w.map_height, u.y);
  uint first = w.map_height + 1u + row.cell * (w.map_width + 1u);
  CellDraw column = draw_cell(s, first, w.map_width, u.x);
  real theta = PI * (REAL(1.0) - (real_of(row.cell) + row.rest) / real_of(w.map_height));
  real phi = TWO_PI * (REAL(0.5) - (real_of(column.cell) + column.rest) / real_of(w.map_width));
  real2 polar = sin_cos_real(theta), around = sin_cos_real(phi);
  r.direction = make_real3(polar.x * around.y, polar.x * around.x, polar.y);
  r.pdf = map_pdf(w, row.chance * column.chance, polar.x);
  return r;
}

FN real pdf_map(Scene s, real3 direction) {
  World w = s.world[0];
  real v = REAL(1.0) - acos_real(direction.z) * INV_PI;
  real u = REAL(0.5) - atan2_real(direction.y, direction.x) * (REAL(0.5) * INV_PI);
  uint row = min_uint(uint_of(max_real(v, REAL(0.0)) * real_of(w.map_height)), w.map_height - 1u);
  uint column = min_uint(uint_of(max_real(u, REAL(0.0)) * real_of(w.map_width)), w.map_width - 1u);
  uint first = w.map_height + 1u + row * (w.map_width + 1u);
  real sine = sqrt(direction.x * direction.x + direction.y * direction.y);
  return map_pdf(w, cell_chance(s, 0u, row) * cell_chance(s, first, column), sine);
}

/* A disc of the world that is brighter and smaller than what cells can tell is drawn apart, evenly over its solid angle:
 * densities add up. */
FN real pdf_world(Scene s, real3 direction, uint features) {
  real pdf = pdf_map(s, direction);
  if (features & FEATURE_WORLD_SUN) {
    World w = s.world[0];
    real chance = to_real(w.sun_chance), width = to_real(w.sun_width);
    real3 off = direction - load3(w.sun); /* |off|^2 = 2 (1 - cos), exact for small angles */
    real of_sun = REAL(0.5) * dot3(off, off) < width ? chance / (TWO_PI * width) : REAL(0.0);
    pdf = pdf * (REAL(1.0) - chance) + of_sun;
  }
  return pdf;
}

FN WorldSample sample_world(Scene s, real2 u, uint features) {
  if (!(features & FEATURE_WORLD_SUN)) return sample_map(s, u);
  World w = s.world[0];
  real chance = to_real(w.sun_chance);
  int in_sun = u.x < chance;
  u.x = min_real(in_sun ? u.x / chance : (u.x - chance) / (REAL(1.0) - chance), REAL(0.99999994));
  WorldSample r = sample_map(s, u);
  Frame f = make_frame(load3(w.sun));
  real below = to_real(w.sun_width) * u.x, sine = sqrt(below * (REAL(2.0) - below)); /* 1 less the cosine */
  real2 around = sin_cos_real(TWO_PI * u.y);
  real3 in_disc = f.z * (REAL(1.0) - below) + (f.x * around.y + f.y * around.x) * sine;
  r.direction = select3(in_sun, in_disc, r.direction);
  r.pdf = pdf_world(s, r.direction, features);
  return r;
}

#endif
