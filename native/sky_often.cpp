#define REGISTER_STRIDE 1u
#include <vector>

#include "../kernels/elementary.h"
#include "sky.h"

namespace isophote {
namespace {

/* All lengths are in kilometres. */
constexpr float EARTH = 6371.0f, THICKNESS = 100.0f, OUTER = EARTH + THICKNESS;
constexpr float ANISOTROPY = 0.8f, GROUND_ALBEDO = 0.3f, ISOTROPIC = 0.0795774715459476f;
constexpr int SEGMENTS = 64, TABLE_COSINES = 256, TABLE_HEIGHTS = 64;

/* A number for each of the wavelengths 630, 560, 490 and 430 nm. */
struct Spectrum {
  float at[4];
};
constexpr Spectrum IRRADIANCE = {{1.679f, 1.828f, 1.986f, 1.307f}};
constexpr Spectrum AIR_SCATTERING = {{6.605e-3f, 1.067e-2f, 1.842e-2f, 3.156e-2f}};
/* Cross section of ozone times the mean column of 334.5 Dobson units. */
constexpr Spectrum OZONE_ABSORPTION = {{3.472e-25f * 334.5f, 3.914e-25f * 334.5f, 1.349e-25f * 334.5f, 11.03e-27f * 334.5f}};
constexpr Spectrum DUST_ABSORPTION = {{2.8722e-24f, 4.6168e-24f, 7.9706e-24f, 1.3578e-23f}};
constexpr Spectrum DUST_SCATTERING = {{1.5908e-22f, 1.7711e-22f, 2.0942e-22f, 2.4033e-22f}};
constexpr float DUST_DENSITY = 1.3681e20f, DUST_BACKGROUND = 2e6f, DUST_SCALE = 0.73f;
constexpr Spectrum SCATTERED_OFTEN = {{0.217f, 0.347f, 0.594f, 1.0f}}; /* the fit of many orders, in parts of its last */
constexpr float XYZ_OF_SPECTRUM[4][3] = {{53.386917738564668f, 22.981337506691025f, 0.0f},
                                         {43.904844466369358f, 71.347795700053394f, 0.10250686796574131f},
                                         {1.6137278251608962f, 18.422960591455485f, 31.742921188390806f},
                                         {20.762668673810577f, 2.3614213523314369f, 110.48009643252140f}};

/* What air, dust and ozone do with light at a height, per kilometre: parts of the constants above. */
struct Matter {
  float air, dust, ozone;
};
FN Matter matter_at(Atmosphere a, float height) {
  float of_log = log_real(max_real(height, 1e-4f));
  Matter m;
  m.air = a.air * exp_real(-0.07771971f * pow_real(height, 1.16364243f));
  m.dust = a.dust * DUST_DENSITY * (exp_real(height * (-1.0f / DUST_SCALE)) + DUST_BACKGROUND / DUST_DENSITY);
  m.ozone = a.ozone * 3.78547397e20f * exp_real(square(of_log - 3.22261f) * -5.55555555f - of_log);
  return m;
}
FN float extinction(Matter m, int k) {
  return m.air * AIR_SCATTERING.at[k] + m.dust * (DUST_ABSORPTION.at[k] + DUST_SCATTERING.at[k]) +
         m.ozone * OZONE_ABSORPTION.at[k];
}

/* From a point on the axis, so far from the earth's middle, to a sphere around that; negative where it is not met. */
FN float way_to_sphere(float from_middle, float cosine, float radius) {
  float b = from_middle * cosine, c = (from_middle - radius) * (from_middle + radius), d = b * b - c;
  float root = sqrt(max_real(d, 0.0f));
  int missed = ((c > 0.0f) & (b > 0.0f)) | (d < 0.0f);
  return missed ? -1.0f : c <= 0.0f ? root - b : -b - root;
}

/* How much light comes through to a height from suns of so many zenith angles. */
void transmittances(Atmosphere a, const float *cosines, int n, float height, Spectrum *through) {
  float start = EARTH + height;
  std::vector<float> depths(4 * size_t(n));
  float *red = depths.data(), *green = red + n, *cyan = green + n, *blue = cyan + n;
  for (int i = 0; i < SEGMENTS; i++) {
#pragma omp simd
    for (int c = 0; c < n; c++) {
      float step = way_to_sphere(start, cosines[c], OUTER) / SEGMENTS, along = (float(i) + 0.5f) * step;
      Matter m = matter_at(a, max_real(sqrt(start * start + along * (along + 2.0f * start * cosines[c])) - EARTH, 0.0f));
      red[c] += extinction(m, 0) * step;
      green[c] += extinction(m, 1) * step;
      cyan[c] += extinction(m, 2) * step;
      blue[c] += extinction(m, 3) * step;
    }
  }
  for (int c = 0; c < n; c++) through[c] = {{exp_real(-red[c]), exp_real(-green[c]), exp_real(-cyan[c]), exp_real(-blue[c])}};
}

/* Transmittances by the cosine of the sun's zenith angle, from -1, and by height. */
struct Table {
  std::vector<Spectrum> entries{size_t(TABLE_COSINES) * TABLE_HEIGHTS};

  Table(Atmosphere a, int threads) {
    std::vector<float> cosines(TABLE_COSINES);
    for (int c = 0; c < TABLE_COSINES; c++) cosines[c] = 2.0f * (float(c) / (TABLE_COSINES - 1)) - 1.0f;
#pragma omp parallel for num_threads(threads) schedule(dynamic)
    for (int row = 0; row < TABLE_HEIGHTS; row++)
      transmittances(a, cosines.data(), TABLE_COSINES, THICKNESS * (float(row) / (TABLE_HEIGHTS - 1)),
                     &entries[size_t(row) * TABLE_COSINES]);
  }

  /* Linearly between the entries. */
  Spectrum at(float cosine, float height) const {
    float x = clamp01(cosine * 0.5f + 0.5f) * (TABLE_COSINES - 1), y = clamp01(height / THICKNESS) * (TABLE_HEIGHTS - 1);
    int left = int(x), low = int(y), right = min_int(left + 1, TABLE_COSINES - 1), high = min_int(low + 1, TABLE_HEIGHTS - 1);
    const Spectrum *below = &entries[size_t(low) * TABLE_COSINES], *above = &entries[size_t(high) * TABLE_COSINES];
    Spectrum s;
    for (int k = 0; k < 4; k++)
      s.at[k] = mix_real(mix_real(below[left].at[k], below[right].at[k], x - float(left)),
                         mix_real(above[left].at[k], above[right].at[k], x - float(left)), y - float(low));
    return s;
  }
};

/* A piece of a ray: all of it that does not depend on the longitude. */
struct Segment {
  float along, height, from_middle; /* its middle */
  Spectrum by_air, by_dust; /* how much of the light there reaches the viewer, phase functions left out */
  Spectrum by_ground; /* light that the ground has scattered, over 4 pi, in parts of what falls on it */
};

/* Of a ray from the axis, so far from the earth's middle. Within a segment light and extinction are constant (Hillaire
 * 2016, "Physically Based Sky, Atmosphere and Cloud Rendering in Frostbite", section 3.4). */
void make_segments(Segment *segments, Atmosphere a, const Table &table, float start, float sine, float length) {
  float step = length / SEGMENTS;
  Spectrum left = {{1.0f, 1.0f, 1.0f, 1.0f}}, to_ground = table.at(1.0f, 0.0f);
  for (int i = 0; i < SEGMENTS; i++) {
    Segment &s = segments[i];
    s.along = (float(i) + 0.5f) * step;
    s.from_middle = sqrt(start * start + s.along * (s.along + 2.0f * start * sine));
    s.height = max_real(s.from_middle - EARTH, 0.0f);
    Matter m = matter_at(a, s.height);
    Spectrum to_here = table.at(1.0f, s.height);
    float solid = TWO_PI * (1.0f - sqrt(max_real(1.0f - square(EARTH / s.from_middle), 0.0f)));
    for (int k = 0; k < 4; k++) {
      float lost = extinction(m, k), kept = exp_real(-step * lost);
      float seen = left.at[k] * IRRADIANCE.at[k] * (1.0f - kept) / max_real(lost, 1e-7f);
      s.by_air.at[k] = seen * m.air * AIR_SCATTERING.at[k];
      s.by_dust.at[k] = seen * m.dust * DUST_SCATTERING.at[k];
      s.by_ground.at[k] = ISOTROPIC * solid * GROUND_ALBEDO * INV_PI * to_ground.at[k] / to_here.at[k];
      left.at[k] *= kept;
    }
  }
}

/* Towards the viewer along a ray in direction d. */
Spectrum scattered_along(const Segment *segments, const Table &table, real3 sun, float start, real3 d) {
  float cosine = -dot3(d, sun), base = 1.0f + ANISOTROPY * (ANISOTROPY + 2.0f * cosine);
  float air_phase = 0.1875f * INV_PI * (1.0f + square(cosine));
  float dust_phase = ISOTROPIC * (1.0f - ANISOTROPY * ANISOTROPY) / (base * sqrt(base));
  Spectrum light = {};
  for (int i = 0; i < SEGMENTS; i++) {
    const Segment &s = segments[i];
    float sun_cosine = (start * sun.z - s.along * cosine) / s.from_middle;
    Spectrum direct = table.at(sun_cosine, s.height), on_ground = table.at(sun_cosine, 0.0f);
    float often = 0.02f / (1.0f + 5.0f * exp_real(-17.92f * sun_cosine));
    for (int k = 0; k < 4; k++) {
      float before = SCATTERED_OFTEN.at[k] * often + s.by_ground.at[k] * on_ground.at[k] * sun_cosine;
      light.at[k] += s.by_air.at[k] * (air_phase * direct.at[k] + before) +
                     s.by_dust.at[k] * (dust_phase * direct.at[k] + before);
    }
  }
  return light;
}

void to_xyz(Spectrum s, float *xyz) {
  for (int c = 0; c < 3; c++) {
    xyz[c] = 0.0f;
    for (int k = 0; k < 4; k++) xyz[c] += XYZ_OF_SPECTRUM[k][c] * s.at[k];
  }
}

}  // namespace

void scatter_often(Atmosphere a, const float *latitudes, int rows, const float *longitudes, int columns, int threads,
                   float *xyz) {
  Table table(a, threads);
  float from_middle = EARTH + a.altitude * 1e-3f;
  real2 of_sun = sin_cos_real(a.sun_elevation);
  real3 sun = make_real3(of_sun.y, 0.0f, of_sun.x);
#pragma omp parallel for num_threads(threads) schedule(dynamic)
  for (int row = 0; row < rows; row++) {
    real2 up = sin_cos_real(latitudes[row]);
    float to_ground = way_to_sphere(from_middle, up.x, EARTH), out = way_to_sphere(from_middle, up.x, OUTER);
    Segment segments[SEGMENTS];
    make_segments(segments, a, table, from_middle, up.x, to_ground < 0.0f ? out : to_ground);
    for (int i = 0; i < columns; i++) {
      real2 around = sin_cos_real(longitudes[i]);
      real3 d = make_real3(up.y * around.y, up.y * around.x, up.x);
      to_xyz(scattered_along(segments, table, sun, from_middle, d), xyz + 3 * (size_t(row) * columns + i));
    }
  }
}

void shine_often(Atmosphere a, const float *elevations, int count, float *xyz) {
  for (int i = 0; i < count; i++) {
    float cosine = sin_real(elevations[i]);
    Spectrum s;
    transmittances(a, &cosine, 1, a.altitude * 1e-3f, &s);
    for (int k = 0; k < 4; k++) s.at[k] *= IRRADIANCE.at[k];
    to_xyz(s, xyz + 3 * i);
  }
}

}  // namespace isophote
