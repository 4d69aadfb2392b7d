/* Panoramic cameras: from a point of the window to a direction of the camera's space, and back.
 *
 * Projections and spaces are Cycles' (src/kernel/camera/projection.h), so that Camera Data and texture coordinates agree:
 * x points forward, y left, z up; of a mirror ball x right, y back, z up. The window counts in what makes a projection
 * simple, with a distance of 1 in the middle being an angle of 1 (but for polynomials):
 *
 *   equirectangular  longitude, latitude
 *   cylinder         longitude, height over radius
 *   cube face        angles about two axes, equal steps of which are pixels
 *   fisheyes         the angle from the axis is that from the middle (equidistant), or twice the arcsine of half of it
 *                    (equisolid; a mirror ball is one that sees everything), or a polynomial of millimetres */
#ifndef ISOPHOTE_PANORAMA_H
#define ISOPHOTE_PANORAMA_H
#include "elementary.h"
#include "scene_records.h"

#if SCENE_FEATURES & FEATURE_PANORAMA
#define NEWTON_STEPS 8

FN int is_panorama(int kind) { return kind >= CAMERA_EQUIRECTANGULAR; }

/* The angle from the axis of a polynomial fisheye at r millimetres from the middle, and its derivative. */
FN real2 polynomial_angle(Camera c, real r) {
  real k1 = to_real(c.polynomial[1]), k2 = to_real(c.polynomial[2]);
  real k3 = to_real(c.polynomial[3]), k4 = to_real(c.polynomial[4]);
  real angle = to_real(c.polynomial[0]) + r * (k1 + r * (k2 + r * (k3 + r * k4)));
  real slope = k1 + r * (REAL(2.0) * k2 + r * (REAL(3.0) * k3 + r * (REAL(4.0) * k4)));
  return make_real2(-angle, -slope);
}

/* The direction of a point of a fisheye's window, 0 beyond what it sees. */
FN real3 fisheye_direction(Camera c, int kind, real x, real y) {
  real reach = to_real(c.reach);
  real square = x * x + y * y, r = sqrt(square);
  real cosine, sine; /* the latter over r */
  int seen;
  if (kind == CAMERA_EQUISOLID || kind == CAMERA_MIRROR_BALL) {
    cosine = REAL(1.0) - REAL(0.5) * square;
    sine = safe_sqrt(REAL(1.0) - REAL(0.25) * square);
    seen = (r <= reach) & (r <= REAL(2.0));
  } else {
    real angle = kind == CAMERA_POLYNOMIAL ? polynomial_angle(c, r).x : r;
    seen = fabs(angle) <= reach;
    real2 turned = sin_cos_real(seen ? angle : REAL(0.0));
    cosine = turned.y;
    sine = r > REAL(0.0) ? turned.x / r : REAL(0.0);
  }
  return select3(seen, make_real3(cosine, -x * sine, y * sine), zero3());
}

/* Where a fisheye's window shows the unit direction d. */
FN real2 fisheye_window(Camera c, int kind, real3 d) {
  real across = sqrt(d.y * d.y + d.z * d.z);
  real r;
  if (kind == CAMERA_EQUISOLID || kind == CAMERA_MIRROR_BALL) {
    /* Twice the sine of half the angle, each half without cancellation. */
    r = d.x > REAL(0.0) ? across / sqrt(REAL(0.5) + REAL(0.5) * d.x) : sqrt(REAL(2.0) - REAL(2.0) * d.x);
  } else {
    real angle = atan2_real(across, d.x);
    r = angle;
    if (kind == CAMERA_POLYNOMIAL) {
      r = (-angle - to_real(c.polynomial[0])) / to_real(c.polynomial[1]);
      UNROLL
      for (int k = 0; k < NEWTON_STEPS; k++) {
        real2 there = polynomial_angle(c, r);
        r = r + (angle - there.x) / there.y;
      }
    }
  }
  real scale = across > REAL(0.0) ? r / across : REAL(0.0);
  return make_real2(-d.y * scale, d.z * scale);
}

/* Unit; 0 beyond what the camera sees. */
FN real3 panorama_direction(Camera c, int kind, real x, real y) {
  if (kind >= CAMERA_MIRROR_BALL) {
    real3 d = fisheye_direction(c, kind, x, y);
    return select3(kind == CAMERA_MIRROR_BALL, make_real3(-d.y, -d.x, d.z), d);
  }
  real2 across = sin_cos_real(x);
  if (kind == CAMERA_CYLINDER) return normalize3(make_real3(across.y, -across.x, y));
  real2 up = sin_cos_real(y);
  if (kind == CAMERA_EQUIRECTANGULAR) return make_real3(up.y * across.y, -up.y * across.x, up.x);
  real both = across.y * up.y; /* (1, -tan x, tan y) without a division by 0 */
  real3 d = make_real3(both, -across.x * up.y, up.x * across.y);
  return normalize3(d) * (both < REAL(0.0) ? REAL(-1.0) : REAL(1.0));
}

/* Where the window shows the unit direction d. */
FN real2 panorama_window(Camera c, int kind, real3 d) {
  if (kind >= CAMERA_MIRROR_BALL)
    return fisheye_window(c, kind, select3(kind == CAMERA_MIRROR_BALL, make_real3(-d.y, -d.x, d.z), d));
  real x = -atan2_real(d.y, d.x);
  if (kind == CAMERA_CUBE_FACE) return make_real2(x, atan2_real(d.z, d.x));
  real level = sqrt(d.x * d.x + d.y * d.y);
  return make_real2(x, kind == CAMERA_CYLINDER ? d.z / level : atan2_real(d.z, level));
}

/* How wide a pixel is in the unit direction d: the mean of the differences to both neighbours, towards the middle. As in
 * the middle where the window does not show d, which a camera that moves or has a lens may see. */
FN real panorama_pixel(Camera c, int kind, real3 d) {
  real2 at = panorama_window(c, kind, d);
  real left = to_real(c.left), right = to_real(c.right), bottom = to_real(c.bottom), top = to_real(c.top);
  real middle_x = REAL(0.5) * (left + right), step_x = (right - left) / real_of(c.width);
  real middle_y = REAL(0.5) * (bottom + top), step_y = (top - bottom) / real_of(c.height);
  real3 beside = panorama_direction(c, kind, at.x > middle_x ? at.x - step_x : at.x + step_x, at.y);
  real3 above = panorama_direction(c, kind, at.x, at.y > middle_y ? at.y - step_y : at.y + step_y);
  int shown = min_real(dot3(beside, beside), dot3(above, above)) > REAL(0.0); /* not where they are no numbers */
  real3 dx = beside - d, dy = above - d;
  return shown ? REAL(0.5) * (sqrt(dot3(dx, dx)) + sqrt(dot3(dy, dy))) : to_real(c.pixel);
}

#else
#define is_panorama(kind) 0
#endif

/* Where the camera sees a point of its own space (camera_space.h), in the numbers of its window; `direction` is p made
 * unit. */
FN real2 seen_by_camera(Camera c, real3 p, real3 direction) {
  real scale = c.kind == CAMERA_PERSPECTIVE ? REAL(1.0) / p.z : REAL(1.0);
  real2 seen = make_real2(p.x * scale, p.y * scale);
#if SCENE_FEATURES & FEATURE_PANORAMA
  if (is_panorama(c.kind)) seen = panorama_window(c, c.kind, direction);
#endif
  return seen;
}
/* The same from the lower left of the window, 0 to 1. */
FN real2 share_of_window(Camera c, real2 seen) {
  real left = to_real(c.left), bottom = to_real(c.bottom);
  return make_real2((seen.x - left) / (to_real(c.right) - left), (seen.y - bottom) / (to_real(c.top) - bottom));
}

#endif
