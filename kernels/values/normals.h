/* Normals and tangents that closures get instead of the surface's own, and what depends on the angle to the viewer. */
#ifndef ISOPHOTE_VALUES_NORMALS_H
#define ISOPHOTE_VALUES_NORMALS_H
#include "../bsdf/fresnel.h"
#include "geometry.h"
#include "value.h"

/* X(number, name, inputs, outputs) */
#define VALUES_NORMALS(X)        \
  X(240, fresnel, 4, 1)          \
  X(241, facing, 4, 1)           \
  X(242, frame_tangent, 3, 3)    \
  X(243, turned_tangent, 7, 3)   \
  X(244, tangent_space, 10, 3)   \
  X(245, blended_normal, 4, 3)   \
  X(246, bump, 8, 3)             \
  X(247, visible_normal, 3, 4)   \
  X(248, unit_normal, 3, 3)

/* Fresnel's reflectance of an index of refraction, seen against a normal. */
VALUE(fresnel) {
  real ior = max_real(IN(0), REAL(1e-5));
  real c = min_real(fabs(dot3(at.direction, IN3(1))), REAL(1.0));
  OUT(0) = fresnel_dielectric(c, at.backfacing ? REAL(1.0) / ior : ior).f;
}

/* 1 - |cos|^x: Layer Weight's curve, x from 0 to infinity as the blend goes from 0 to 1. */
VALUE(facing) {
  real blend = min_real(max_real(IN(0), REAL(0.0)), REAL(0.99999));
  real c = min_real(fabs(dot3(at.direction, IN3(1))), REAL(1.0));
  real exponent = blend < REAL(0.5) ? REAL(2.0) * blend : REAL(0.5) / (REAL(1.0) - blend);
  OUT(0) = REAL(1.0) - (exponent == REAL(1.0) ? c : pow_real(c, exponent));
}

/* A direction of the object's space, turned as normals are, within the surface: 0 where it stands on it. */
VALUE(frame_tangent) {
  real3 t = normal_to_world(s, at, IN3(0));
  OUT3(0, cross3(at.ns, unit_or(cross3(t, at.ns), zero3())))
}

/* A tangent turned about a normal, by so many turns: Rodrigues' rotation. */
VALUE(turned_tangent) {
  real3 t = IN3(0), n = IN3(3);
  real2 turn = sin_cos_real(TWO_PI * (IN(6) - floor(IN(6))));
  OUT3(0, t * turn.y + cross3(n, t) * turn.x + n * (dot3(n, t) * (REAL(1.0) - turn.y)))
}

/* A vector given along a tangent, the bitangent and a normal of the object's space (neither unit, as they are
 * interpolated: Mikkelsen 2008, "Simulation of Wrinkled Surfaces Revisited"), in the world, on the viewer's side. The
 * surface's own normal where there is no tangent. Inputs: the vector, tangent and sign of the bitangent, the normal. */
VALUE(tangent_space) {
  real3 v = IN3(0), t = IN3(3), n = IN3(7);
  real3 b = cross3(n, t) * IN(6);
  real3 made = normal_to_world(s, at, unit_or(t * v.x + b * v.y + n * v.z, zero3()));
  made = at.backfacing ? zero3() - made : made;
  OUT3(0, unit_or(select3(dot3(t, t) > REAL(0.0), made, at.ns), at.ns))
}

/* From the surface's own normal to another, given for the front, by a factor that may be above 1. */
VALUE(blended_normal) {
  real3 n = unit_or(IN3(0), zero3());
  n = at.backfacing ? zero3() - n : n;
  n = unit_or(n, at.ns);
  OUT3(0, unit_or(at.ns + (n - at.ns) * max_real(IN(3), REAL(0.0)), at.ns))
}

/* A normal bent by the slope of a height: Mikkelsen 2010, "Bump Mapping Unparametrized Surfaces on the GPU". The slope is
 * that of two steps along the surface, o.number footprints long. Inputs: the normal; heights here and after each of the
 * steps; strength; distance. */
VALUE(bump) {
  real3 n = IN3(0);
  real h = IN(3), strength = max_real(IN(6), REAL(0.0));
  real scale = IN(7) / (footprint_width(s, at) * to_real(o.number));
  Frame frame = surface_axes(at.ng);
  real3 rx = cross3(frame.y, n), ry = cross3(n, frame.x);
  real det = dot3(frame.x, rx);
  real3 slope = (rx * (IN(4) - h) + ry * (IN(5) - h)) * scale;
  real3 bent = unit_or(n * fabs(det) - slope * (det < REAL(0.0) ? REAL(-1.0) : REAL(1.0)), zero3());
  int fine = dot3(bent, bent) > REAL(0.0);
  OUT3(0, select3(fine, unit_or(bent * strength + n * (REAL(1.0) - strength), n), n))
}

/* A normal for closures that mirror: bent towards the surface's own as far as it takes for the mirrored view to leave the
 * surface, by the angle that Cycles chooses (kernel/closure/bsdf_util.h, ensure_valid_specular_reflection).
 *
 * The fourth output is 0 where the viewer is behind the normal all the same, and nothing is mirrored.
 *
 * With z along ng and the normal (x, 0, z), the mirrored view leaves at cosine t if 2 (x vx + z vz) z - vz = t. Squared,
 * with x^2 = 1 - z^2, that is 4 a z^4 - 2 b z^2 + c = 0. */
VALUE(visible_normal) {
  real3 n = IN3(0), view = zero3() - at.direction;
  real vz = dot3(view, at.ng);
  real t = min_real(REAL(0.9) * vz, REAL(0.01));
  real leaves = REAL(2.0) * dot3(n, view) * dot3(n, at.ng) - vz;
  real3 x_axis = unit_or(n - at.ng * dot3(n, at.ng), n);
  real vx = dot3(view, x_axis);
  real a = vx * vx + vz * vz;
  real b = REAL(2.0) * (a + vz * t);
  real c = square(t + vz);
  real root = safe_sqrt(b * b - REAL(4.0) * a * c);
  real z2 = REAL(0.25) * (vx < REAL(0.0) ? b + root : b - root) / max_real(a, REAL(1e-20));
  real3 bent = x_axis * safe_sqrt(REAL(1.0) - z2) + at.ng * safe_sqrt(z2);
  real3 made = select3(leaves < t, bent, n);
  OUT3(0, face_viewer(made, view))
  OUT(3) = dot3(made, view) > REAL(0.0) ? REAL(1.0) : REAL(0.0);
}

/* Unit, or the surface's own where it has no direction. */
VALUE(unit_normal) { OUT3(0, unit_or(IN3(0), at.ns)) }

#endif
