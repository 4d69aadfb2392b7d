/* Directional albedos of GGX closures from tables, and what follows from them: the energy that single
 * scattering loses, and what a layer leaves for the layers below.
 *
 * tools/make_albedo_tables.py integrates the tables (isophote/data/albedo_tables.npy). Axes have nodes
 * at 0 and 1; brackets give the order, the last axis is the fastest:
 *   r, m   roughness (Blender's socket) and mu = wo.z
 *   R, M   their square roots: E falls steeply where both are small, and is divided by
 *   z      sqrt((ior - 1)/(ior + 1)) of the ior or of its inverse, whichever is above 1
 * The tables of rises have Cycles' axes and number of nodes on purpose: interpolating such convex
 * curves takes some tenths of a per cent from the base under a layer: both engines take the same. For the
 * same reason E of glass counts rays that are refracted to the wrong side (see the tool). */
#ifndef ISOPHOTE_BSDF_ALBEDO_H
#define ISOPHOTE_BSDF_ALBEDO_H
#include "closure.h"
#include "fresnel.h"

#define ALBEDO_FINE 64   /* R and M without z */
#define ALBEDO_COARSE 16 /* R with z, z, r, m */
#define ALBEDO_MU 32     /* M with z */
#define ALBEDO_SQUARE (ALBEDO_COARSE * ALBEDO_COARSE)
#define ALBEDO_BLOCK (ALBEDO_COARSE * ALBEDO_MU * ALBEDO_COARSE)

/* Where each table starts. */
#define ALBEDO_GGX 0                                                      /* [M][R]: E, Fresnel 1 */
#define ALBEDO_GGX_AVERAGE (ALBEDO_GGX + ALBEDO_FINE * ALBEDO_FINE)       /* [R]: 2 int E mu dmu */
#define ALBEDO_GLASS (ALBEDO_GGX_AVERAGE + ALBEDO_FINE)                   /* [z][M][R]: E, ior > 1 */
#define ALBEDO_GLASS_AVERAGE (ALBEDO_GLASS + ALBEDO_BLOCK)                /* [z][R] */
#define ALBEDO_GLASS_INVERSE (ALBEDO_GLASS_AVERAGE + ALBEDO_SQUARE)       /* [z][M][R]: E, ior < 1 */
#define ALBEDO_GLASS_INVERSE_AVERAGE (ALBEDO_GLASS_INVERSE + ALBEDO_BLOCK) /* [z][R] */
#define ALBEDO_RISE (ALBEDO_GLASS_INVERSE_AVERAGE + ALBEDO_SQUARE)        /* [z][m][r]: of Fresnel's curve */
#define ALBEDO_SCHLICK (ALBEDO_RISE + ALBEDO_COARSE * ALBEDO_SQUARE)      /* [m][r]: of Schlick's curve */
#define ALBEDO_SIZE (ALBEDO_SCHLICK + ALBEDO_SQUARE)

typedef struct {
  int low;
  real t;
} TableCell;
FN TableCell table_cell(real x, int nodes) {
  TableCell cell;
  real scaled = clamp01(x) * real_of(nodes - 1);
  cell.low = min_int(int_of(scaled), nodes - 2);
  cell.t = scaled - real_of(cell.low);
  return cell;
}

/* Linear interpolation along 1, 2 or 3 axes of nx, ny, nz nodes, x fastest, of the table at `first`. */
FN real read_table1(GLOBAL const float *tables, int first, int nx, real x) {
  TableCell cx = table_cell(x, nx);
  int at = first + cx.low;
  return mix_real(to_real(tables[at]), to_real(tables[at + 1]), cx.t);
}
FN real read_table2(GLOBAL const float *tables, int first, int nx, int ny, real x, real y) {
  TableCell cy = table_cell(y, ny);
  int at = first + cy.low * nx;
  return mix_real(read_table1(tables, at, nx, x), read_table1(tables, at + nx, nx, x), cy.t);
}
FN real read_table3(GLOBAL const float *tables, int first, int nx, int ny, int nz, real x, real y, real z) {
  TableCell cz = table_cell(z, nz);
  int at = first + cz.low * nx * ny;
  return mix_real(read_table2(tables, at, nx, ny, x, y),
                  read_table2(tables, at + nx * ny, nx, ny, x, y), cz.t);
}

FN real ior_coordinate(real ior) { return sqrt(fabs((ior - REAL(1.0)) / (ior + REAL(1.0)))); }

/* Average over microfacets seen from wo of the rise from F0 to 1, of Fresnel's and of Schlick's curve.
 * Microfacets whose reflection ends inside the surface count as 0. */
FN real dielectric_rise(GLOBAL const float *tables, real roughness, real mu, real ior) {
  return read_table3(tables, ALBEDO_RISE, ALBEDO_COARSE, ALBEDO_COARSE, ALBEDO_COARSE, roughness, mu,
                     ior_coordinate(ior));
}
FN real schlick_rise(GLOBAL const float *tables, real roughness, real mu) {
  return read_table2(tables, ALBEDO_SCHLICK, ALBEDO_COARSE, ALBEDO_COARSE, roughness, mu);
}

/* Scale that gives single scattering the energy of all scattering orders: Kulla and Conty 2017,
 * "Revisiting Physically Based Shading at Imageworks", with the lobe's shape kept (Turquin 2019,
 * "Practical multiple scattering compensation for microfacet models", section 3).
 *   gain = 1 + Fms (1 - E)/E,  Fms = Fss Eavg / (1 - Fss (1 - Eavg))
 * Fss is the average reflectance of one scattering; 1 gives 1/E. Depends on wo only, so a closure with
 * it is not reciprocal (neither is Cycles'). `saturation` is gain E: what remains of it where the
 * albedo itself is not to be compensated. */
typedef struct {
  real3 gain;
  real3 saturation;
} EnergyCompensation;

FN EnergyCompensation make_compensation(real e, real e_average, real3 fss) {
  EnergyCompensation r;
  real missing = (REAL(1.0) - e) / e;
  real lost = REAL(1.0) - e_average;
  real3 fms = make_real3(fss.x * e_average / (REAL(1.0) - fss.x * lost),
                         fss.y * e_average / (REAL(1.0) - fss.y * lost),
                         fss.z * e_average / (REAL(1.0) - fss.z * lost));
  r.gain = splat3(REAL(1.0)) + fms * missing;
  r.saturation = r.gain * e;
  return r;
}

/* Without multiscatter E counts as 1, which leaves gain and saturation 1. */
FN EnergyCompensation compensate_reflection(GLOBAL const float *tables, real multiscatter, real roughness,
                                            real mu, real3 fss) {
  int on = multiscatter > REAL(0.0);
  real r = safe_sqrt(roughness);
  real e = on ? read_table2(tables, ALBEDO_GGX, ALBEDO_FINE, ALBEDO_FINE, r, sqrt(mu)) : REAL(1.0);
  real average = on ? read_table1(tables, ALBEDO_GGX_AVERAGE, ALBEDO_FINE, r) : REAL(1.0);
  return make_compensation(e, average, fss);
}

FN EnergyCompensation compensate_glass(GLOBAL const float *tables, real multiscatter, real roughness,
                                       real mu, real ior, real3 fss) {
  int on = multiscatter > REAL(0.0);
  int thinner = ior < REAL(1.0);
  real r = safe_sqrt(roughness);
  real z = ior_coordinate(ior);
  real e = on ? read_table3(tables, thinner ? ALBEDO_GLASS_INVERSE : ALBEDO_GLASS, ALBEDO_COARSE,
                            ALBEDO_MU, ALBEDO_COARSE, r, sqrt(mu), z)
              : REAL(1.0);
  real average = on ? read_table2(tables, thinner ? ALBEDO_GLASS_INVERSE_AVERAGE : ALBEDO_GLASS_AVERAGE,
                                  ALBEDO_COARSE, ALBEDO_COARSE, r, z)
                    : REAL(1.0);
  return make_compensation(e, average, fss);
}

#endif
