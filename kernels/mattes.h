/* Cryptomatte: which objects, materials and assets a pixel shows, and how much of each (Friedman and Jones 2015, "Fully
 * Automatic ID Mattes with Support for Motion Blur and Transparency").
 *
 * A table has the weight that found no row, then rows of a weight and an id of each kind, those with a weight first. A
 * path has one in its columns, of the surfaces that the camera sees along it; a pixel has one in the film, to which
 * samples are added in their order. Weights in the film are whole numbers of 1 / MATTE_UNITS, of which a block's sum is
 * exact in a float, so that all sums are, in any order. Ids are float32 numbers, neither zero nor denormal. */
#ifndef ISOPHOTE_MATTES_H
#define ISOPHOTE_MATTES_H
#include "params.h"
#include "surface.h"

#define MOST_MATTE_WEIGHT REAL(16.0) /* of a sample: colours of transparent surfaces may make it more than 1 */

/* Adds a weight to a table whose numbers lie `stride` apart. */
#define ADD_MATTE(name, type)                                                                                       \
  FN void name(GLOBAL type *table, uint stride, uint rows, uint kinds, type weight, type id0, type id1, type id2) { \
    GLOBAL type *row = table + stride;                                                                              \
    for (uint k = 0u; k < rows; k++) {                                                                              \
      int same = row[stride] == id0;                                                                                \
      if (kinds > 1u) same = same & (row[2u * stride] == id1);                                                      \
      if (kinds > 2u) same = same & (row[3u * stride] == id2);                                                      \
      if (same | !(row[0] > 0)) {                                                                                   \
        row[0] += weight;                                                                                           \
        row[stride] = id0;                                                                                          \
        if (kinds > 1u) row[2u * stride] = id1;                                                                     \
        if (kinds > 2u) row[3u * stride] = id2;                                                                     \
        return;                                                                                                     \
      }                                                                                                             \
      row += (1u + kinds) * stride;                                                                                 \
    }                                                                                                               \
    table[0] += weight;                                                                                             \
  }
ADD_MATTE(add_path_matte, real)
ADD_MATTE(add_film_matte, float)
#undef ADD_MATTE

FN void clear_mattes(GLOBAL real *table, uint stride, uint kinds) {
  table[0] = REAL(0.0);
  for (uint k = 0u; k < MATTE_RECORDS; k++) table[(1u + k * (1u + kinds)) * stride] = REAL(0.0);
}

/* What the camera sees of a surface. */
FN void show_matte(GLOBAL real *table, uint stride, uint groups, Scene s, Hit h, uint material, real weight) {
  World w = s.world[0];
  if (w.mattes == NONE || !(weight > REAL(0.0))) return;
  uint thing = w.mattes + 2u * (h.instance == SPHERE_INSTANCE ? w.sphere_mattes + h.primitive : h.instance);
  real ids[3] = {REAL(0.0), REAL(0.0), REAL(0.0)};
  uint kinds = 0u;
  if (groups & GROUPS_MATTE_OBJECT) ids[kinds++] = to_real(s.pass_indices[thing]);
  if (groups & GROUPS_MATTE_MATERIAL) ids[kinds++] = to_real(s.pass_indices[w.material_mattes + material]);
  if (groups & GROUPS_MATTE_ASSET) ids[kinds++] = to_real(s.pass_indices[thing + 1u]);
  add_path_matte(table, stride, MATTE_RECORDS, kinds, weight, ids[0], ids[1], ids[2]);
}

FN float matte_units(real weight) {
  return to_float(floor(min_real(weight, MOST_MATTE_WEIGHT) * real_of(MATTE_UNITS) + REAL(0.5)));
}

/* A path's table into its pixel's. */
FN void add_mattes(GLOBAL float *film, uint plane, GLOBAL const real *table, uint stride, uint rows, uint kinds) {
  if (table[0] > REAL(0.0)) film[0] += matte_units(table[0]);
  GLOBAL const real *row = table + stride;
  for (uint k = 0u; k < MATTE_RECORDS && row[0] > REAL(0.0); k++) {
    float units = matte_units(row[0]);
    real id1 = kinds > 1u ? row[2u * stride] : REAL(0.0), id2 = kinds > 2u ? row[3u * stride] : REAL(0.0);
    if (units > 0.0f) add_film_matte(film, plane, rows, kinds, units, to_float(row[stride]), to_float(id1), to_float(id2));
    row += (1u + kinds) * stride;
  }
}

#endif
