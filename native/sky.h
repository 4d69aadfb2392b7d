/* Skies of a clear atmosphere, by the light that it scatters: for pictures of them that are made at export. */
#pragma once

namespace isophote {

struct Atmosphere {
  float sun_elevation; /* radians */
  float altitude;      /* of the viewer, metres */
  float air, dust, ozone; /* densities, 1 on an average day */
};

/* XYZ of the sky's radiance, W/(m^2 sr), without the sun's disc, at each pair of a latitude and a longitude from the sun
 * (radians): three floats each, rows by latitude. Bits are the same on all processors.
 *
 * Of light scattered once (Nishita, Sirai, Tadamura and Nakamae 1993, "Display of the Earth Taking into Account
 * Atmospheric Scattering") as Cycles computes it: 21 wavelengths, 32 segments, on each of which the depth towards the sun
 * is found by Gauss-Laguerre quadrature (intern/sky/source/sky_single_scattering.cpp). Above the horizon only. */
void scatter_once(Atmosphere a, const float *latitudes, int rows, const float *longitudes, int columns, int threads,
                  float *xyz);
/* Of light scattered many times (Garcia Linan 2024, https://fgarlin.com/posts/2024-12-06-spectral_sky/) as Cycles 5
 * computes it: 4 wavelengths, 64 segments, a table of transmittances (sky_multiple_scattering.cpp). */
void scatter_often(Atmosphere a, const float *latitudes, int rows, const float *longitudes, int columns, int threads,
                   float *xyz);

/* XYZ of the sun's irradiance, W/m^2, that reaches the viewer from each elevation (radians): three floats each. */
void shine_once(Atmosphere a, const float *elevations, int count, float *xyz);
void shine_often(Atmosphere a, const float *elevations, int count, float *xyz);

}  // namespace isophote
