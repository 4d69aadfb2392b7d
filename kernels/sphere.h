/* Where a ray hits a sphere. Haines, Guenther and Akenine-Moeller 2019, "Precision Improvements for
 * Ray/Sphere Intersection" (Ray Tracing Gems, chapter 7): the discriminant from the distance of the
 * centre to the ray, the nearer root without cancellation. */
#ifndef ISOPHOTE_SPHERE_H
#define ISOPHOTE_SPHERE_H
#include "ray.h"

typedef struct {
  int hit;
  real t_near, t_far;
} SphereHit;

/* direction must be unit length. */
FN SphereHit sphere_hit(real3 center, real radius, real3 origin, real3 direction) {
  STRICT_FP
  SphereHit h;
  real3 f = origin - center;
  real b = -dot3(f, direction);
  real3 nearest = f + direction * b;
  real discriminant = radius * radius - dot3(nearest, nearest);
  real q = b + (b < REAL(0.0) ? -sqrt(max_real(discriminant, REAL(0.0))) : sqrt(max_real(discriminant, REAL(0.0))));
  real c = dot3(f, f) - radius * radius;
  real other = q != REAL(0.0) ? c / q : REAL(0.0);
  h.hit = discriminant >= REAL(0.0);
  h.t_near = min_real(q, other);
  h.t_far = max_real(q, other);
  return h;
}

#endif
