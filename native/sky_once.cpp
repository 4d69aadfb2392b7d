#define REGISTER_STRIDE 1u
#include <vector>

#include "../kernels/elementary.h"
#include "sky.h"

namespace isophote {
namespace {

constexpr int WAVELENGTHS = 21; /* 380 nm to 780 nm in steps of 20 nm */
constexpr float STEP = 20.0f;
constexpr int SEGMENTS = 32, NODES = 8;
constexpr float EARTH = 6360e3f, THICKNESS = 60e3f; /* radius, height of the atmosphere, metres */
constexpr float MIE = 2e-5f, MIE_EXTINCTION = 1.11f * MIE; /* per metre */
constexpr float ANISOTROPY = 0.76f;

/* The sun's irradiance above the atmosphere, W/(m^2 nm); Rayleigh scattering and absorption by ozone, per metre; the CIE
 * 1931 observer. The numbers are those of Cycles. */
struct Band {
  float irradiance, rayleigh, ozone, x, y, z;
};
constexpr Band BANDS[WAVELENGTHS] = {
    {1.45756830f, 5.42482009e-5f, 3.25126850e-9f, 0.001368f, 0.000039f, 0.006450001f},
    {1.56596306f, 4.41854987e-5f, 5.85395365e-9f, 0.01431f, 0.000396f, 0.06785001f},
    {1.65148449f, 3.63515191e-5f, 1.97719116e-8f, 0.13438f, 0.004f, 0.6456f},
    {1.71496242f, 3.01792901e-5f, 7.30956876e-8f, 0.34828f, 0.023f, 1.74706f},
    {1.75797984f, 2.52632023e-5f, 2.00845616e-7f, 0.2908f, 0.06f, 1.6692f},
    {1.78256408f, 2.13085931e-5f, 4.03839581e-7f, 0.09564f, 0.13902f, 0.8129501f},
    {1.79095108f, 1.80983803e-5f, 6.35513359e-7f, 0.0049f, 0.323f, 0.272f},
    {1.78541550f, 1.54705713e-5f, 9.67070412e-7f, 0.06327f, 0.71f, 0.07824999f},
    {1.76815555f, 1.33028498e-5f, 1.54797400e-6f, 0.2904f, 0.954f, 0.0203f},
    {1.74122070f, 1.15018478e-5f, 2.09038647e-6f, 0.5945f, 0.995f, 0.0039f},
    {1.70647127f, 9.99557430e-6f, 2.46128056e-6f, 0.9163f, 0.87f, 0.001650001f},
    {1.66556087f, 8.72799974e-6f, 2.73551299e-6f, 1.0622f, 0.631f, 0.0008f},
    {1.61993437f, 7.65513701e-6f, 2.15125863e-6f, 0.8544499f, 0.381f, 0.00019f},
    {1.57083597f, 6.74217204e-6f, 1.59051841e-6f, 0.4479f, 0.175f, 0.00002f},
    {1.51932335f, 5.96134126e-6f, 1.12356198e-6f, 0.1649f, 0.061f, 0.0f},
    {1.46628495f, 5.29034598e-6f, 7.35275515e-7f, 0.04677f, 0.017f, 0.0f},
    {1.41245853f, 4.71115688e-6f, 4.64501304e-7f, 0.01135916f, 0.004102f, 0.0f},
    {1.35844962f, 4.20910481e-6f, 3.30960799e-7f, 0.002899327f, 0.001047f, 0.0f},
    {1.30474914f, 3.77218381e-6f, 2.25126123e-7f, 0.0006900786f, 0.0002492f, 0.0f},
    {1.25174963f, 3.39051255e-6f, 1.48791293e-7f, 0.0001661505f, 0.00006f, 0.0f},
    {1.19975999f, 3.05591532e-6f, 1.68286234e-7f, 0.00004150994f, 0.00001499f, 0.0f},
};

/* Gauss-Laguerre quadrature with 8 nodes, scaled by 25, e^x in the weights. */
constexpr float NODE[NODES] = {0.006811185292f, 0.03614807107f, 0.09004346519f, 0.1706680068f,
                               0.2818362161f,   0.4303406404f,  0.6296271457f,  0.9145252695f};
constexpr float NODE_WEIGHT[NODES] = {0.01750893642f, 0.04135477391f, 0.06678839063f, 0.09507698807f,
                                      0.1283416365f,  0.1707430204f,  0.2327233347f,  0.3562490486f};

/* Points have their z from the ground on, so that heights keep their digits. |p|^2 - EARTH^2, and the height. */
FN float above_ground(real3 p) { return p.x * p.x + p.y * p.y + p.z * (2.0f * EARTH + p.z); }
FN float height_of(real3 p) {
  float above = above_ground(p);
  return above / (sqrt(above + EARTH * EARTH) + EARTH);
}
FN float towards(real3 p, real3 d) { return dot3(p, d) + EARTH * d.z; }

/* Of air, dust and ozone, in parts of what they are on the ground, and of the most for ozone. */
FN real3 densities(float height) {
  float ozone = 1.0f - fabs(height - 25e3f) * (1.0f / 15e3f);
  return make_real3(exp_real(height * (-1.0f / 8e3f)), exp_real(height * (-1.0f / 1.2e3f)), max_real(ozone, 0.0f));
}

/* From a point within the atmosphere to its end. */
FN float way_out(real3 p, real3 d) {
  float b = towards(p, d), c = above_ground(p) - THICKNESS * (2.0f * EARTH + THICKNESS);
  float root = sqrt(max_real(b * b - c, 0.0f));
  return b > 0.0f ? -c / (b + root) : root - b;
}

/* Whether the line along a direction that points down meets the ground. */
FN int meets_ground(real3 p, real3 d) {
  float b = towards(p, d);
  return (d.z < 0.0f) & (b * b >= above_ground(p));
}

/* Densities summed up on the way out, metres. */
FN real3 depth_to_space(real3 p, real3 d) {
  real3 sum = zero3();
  float length = way_out(p, d);
  UNROLL
  for (int k = 0; k < NODES; k++) sum = sum + densities(height_of(p + d * (length * NODE[k]))) * NODE_WEIGHT[k];
  return sum * length;
}

FN real3 direction_of(float latitude, float longitude) {
  real2 up = sin_cos_real(latitude), around = sin_cos_real(longitude);
  return make_real3(up.y * around.y, up.y * around.x, up.x);
}

FN float rayleigh_phase(float cosine) { return 0.1875f * INV_PI * (1.0f + square(cosine)); }
FN float mie_phase(float cosine) {
  float g = ANISOTROPY, base = 1.0f + g * g - 2.0f * g * cosine;
  return 3.0f * (1.0f - g * g) * (1.0f + square(cosine)) / (8.0f * PI * (2.0f + g * g) * (base * sqrt(base)));
}

/* One number for each direction of a row. */
struct Row {
  std::vector<float> x, y, z, length, air, dust, ozone, all_air, all_dust, all_ozone, rayleigh, mie;
  std::vector<float> spectrum; /* by wavelength */
  explicit Row(int n)
      : x(n), y(n), z(n), length(n), air(n), dust(n), ozone(n), all_air(n), all_dust(n), all_ozone(n), rayleigh(n), mie(n),
        spectrum(size_t(n) * WAVELENGTHS) {}
};

void start_row(Row &r, Atmosphere a, real3 sun, float latitude, const float *longitudes, int n) {
  for (int i = 0; i < n; i++) {
    real3 d = direction_of(latitude, longitudes[i]);
    float cosine = dot3(d, sun);
    r.x[i] = d.x;
    r.y[i] = d.y;
    r.z[i] = d.z;
    r.length[i] = way_out(make_real3(0.0f, 0.0f, a.altitude), d) / SEGMENTS;
    r.rayleigh[i] = rayleigh_phase(cosine);
    r.mie[i] = mie_phase(cosine);
    r.air[i] = r.dust[i] = r.ozone[i] = 0.0f;
  }
  r.spectrum.assign(r.spectrum.size(), 0.0f);
}

/* What the middle of a segment scatters, dimmed on both ways. Densities have their factors in `air`, `dust`, `ozone`. */
void add_segment(Row &r, Atmosphere a, real3 sun, int segment, int n) {
  float *x = r.x.data(), *y = r.y.data(), *z = r.z.data(), *length = r.length.data();
  float *air = r.air.data(), *dust = r.dust.data(), *ozone = r.ozone.data();
  float *all_air = r.all_air.data(), *all_dust = r.all_dust.data(), *all_ozone = r.all_ozone.data();
  std::vector<float> scattered(2 * size_t(n));
  float *by_air = scattered.data(), *by_dust = by_air + n, *rayleigh = r.rayleigh.data(), *mie = r.mie.data();
#pragma omp simd
  for (int i = 0; i < n; i++) {
    real3 d = make_real3(x[i], y[i], z[i]);
    real3 p = make_real3(0.0f, 0.0f, a.altitude) + d * (length[i] * (float(segment) + 0.5f));
    real3 here = densities(height_of(p)), out = depth_to_space(p, sun);
    int lit = !meets_ground(p, sun);
    air[i] += length[i] * a.air * here.x;
    dust[i] += length[i] * a.dust * here.y;
    ozone[i] += length[i] * a.ozone * here.z;
    all_air[i] = air[i] + a.air * out.x;
    all_dust[i] = dust[i] + a.dust * out.y;
    all_ozone[i] = ozone[i] + a.ozone * out.z;
    by_air[i] = lit ? length[i] * a.air * here.x * rayleigh[i] : 0.0f;
    by_dust[i] = lit ? length[i] * a.dust * here.y * mie[i] * MIE : 0.0f;
  }
  for (int k = 0; k < WAVELENGTHS; k++) {
    Band band = BANDS[k];
    float *spectrum = r.spectrum.data() + size_t(k) * n;
#pragma omp simd
    for (int i = 0; i < n; i++) {
      float depth = all_air[i] * band.rayleigh + all_dust[i] * MIE_EXTINCTION + all_ozone[i] * band.ozone;
      spectrum[i] += exp_real(-depth) * (by_air[i] * band.rayleigh + by_dust[i]) * band.irradiance;
    }
  }
}

void to_xyz(const float *spectrum, size_t apart, float *xyz) {
  xyz[0] = xyz[1] = xyz[2] = 0.0f;
  for (int k = 0; k < WAVELENGTHS; k++) {
    float power = STEP * spectrum[size_t(k) * apart];
    xyz[0] += BANDS[k].x * power;
    xyz[1] += BANDS[k].y * power;
    xyz[2] += BANDS[k].z * power;
  }
}

}  // namespace

void scatter_once(Atmosphere a, const float *latitudes, int rows, const float *longitudes, int columns, int threads,
                  float *xyz) {
  real3 sun = direction_of(a.sun_elevation, 0.0f);
#pragma omp parallel num_threads(threads)
  {
    Row r(columns);
#pragma omp for schedule(dynamic)
    for (int row = 0; row < rows; row++) {
      start_row(r, a, sun, latitudes[row], longitudes, columns);
      for (int segment = 0; segment < SEGMENTS; segment++) add_segment(r, a, sun, segment, columns);
      for (int i = 0; i < columns; i++) to_xyz(r.spectrum.data() + i, size_t(columns), xyz + 3 * (size_t(row) * columns + i));
    }
  }
}

void shine_once(Atmosphere a, const float *elevations, int count, float *xyz) {
  for (int i = 0; i < count; i++) {
    real3 depth = depth_to_space(make_real3(0.0f, 0.0f, a.altitude), direction_of(elevations[i], 0.0f));
    float spectrum[WAVELENGTHS];
    for (int k = 0; k < WAVELENGTHS; k++) { /* of the disc Cycles forgets the ozone */
      float dimmed = BANDS[k].rayleigh * depth.x * a.air + MIE_EXTINCTION * depth.y * a.dust;
      spectrum[k] = BANDS[k].irradiance * exp_real(-dimmed);
    }
    to_xyz(spectrum, 1, xyz + 3 * i);
  }
}

}  // namespace isophote
