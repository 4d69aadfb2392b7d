/* Vectors in registers, and the packed records that lie in memory.
 *
 * Records hold 4-byte scalars only, so that their layout is the same for OpenCL, C++ and numpy.
 * Lengths are metres (Blender units), directions are unit length unless a comment says otherwise,
 * radiance is linear scene RGB in W / (m^2 sr). */
#ifndef ISOPHOTE_TYPES_H
#define ISOPHOTE_TYPES_H
#include "portable.h"

#define PI REAL(3.14159265358979323846)
#define INV_PI REAL(0.31830988618379067154)
#define TWO_PI REAL(6.28318530717958647692)

typedef struct {
  float x, y, z;
} packed3;

FN packed3 pack3(real3 v) {
  packed3 p;
  p.x = to_float(v.x);
  p.y = to_float(v.y);
  p.z = to_float(v.z);
  return p;
}

/* A macro: reads the three scalars where they lie, which a vectorised loop turns into gathers. */
#define load3(p) make_real3(to_real((p).x), to_real((p).y), to_real((p).z))

FN real dot3(real3 a, real3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
/* Strict in fast builds too: fused, equal products leave a rest, and with its sign normals and frames turn over. */
FN real3 cross3(real3 a, real3 b) {
  STRICT_FP
  return make_real3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
FN real3 abs3(real3 a) { return make_real3(fabs(a.x), fabs(a.y), fabs(a.z)); }
FN real3 normalize3(real3 a) { return a * (REAL(1.0) / sqrt(dot3(a, a))); }
FN real max_of3(real3 a) { return max_real(a.x, max_real(a.y, a.z)); }
FN real min_of3(real3 a) { return min_real(a.x, min_real(a.y, a.z)); }
FN real3 positive3(real3 a) {
  return make_real3(max_real(a.x, REAL(0.0)), max_real(a.y, REAL(0.0)), max_real(a.z, REAL(0.0)));
}
FN real3 zero3(void) { return make_real3(REAL(0.0), REAL(0.0), REAL(0.0)); }
FN real3 splat3(real x) { return make_real3(x, x, x); }
FN real3 select3(int c, real3 a, real3 b) {
  return make_real3(c ? a.x : b.x, c ? a.y : b.y, c ? a.z : b.z);
}
FN real square(real x) { return x * x; }
FN real mix_real(real a, real b, real t) { return a + (b - a) * t; }
FN real clamp01(real x) { return min_real(max_real(x, REAL(0.0)), REAL(1.0)); }
FN real safe_sqrt(real x) { return sqrt(max_real(x, REAL(0.0))); }
/* Rec. 709 luminance: for probabilities and the ledger, never for the picture. */
FN real luminance(real3 c) { return REAL(0.2126) * c.x + REAL(0.7152) * c.y + REAL(0.0722) * c.z; }

/* An orthonormal frame; z is the shading normal. */
typedef struct {
  real3 x, y, z;
} Frame;

/* Duff et al. 2017, "Building an Orthonormal Basis, Revisited", listing 3. */
FN Frame make_frame(real3 n) {
  Frame f;
  real s = n.z < REAL(0.0) ? REAL(-1.0) : REAL(1.0);
  real a = REAL(-1.0) / (s + n.z);
  real b = n.x * n.y * a;
  f.x = make_real3(REAL(1.0) + s * n.x * n.x * a, s * b, -s * n.x);
  f.y = make_real3(b, s + n.y * n.y * a, -n.y);
  f.z = n;
  return f;
}
/* The frame of n whose x is as near to t as can be; make_frame's where t is along n. */
FN Frame make_frame_along(real3 n, real3 t) {
  Frame f = make_frame(n);
  real3 y = cross3(n, t);
  real square = dot3(y, y);
  int use = square > REAL(1e-20) * dot3(t, t);
  y = y * (REAL(1.0) / sqrt(use ? square : REAL(1.0)));
  f.x = select3(use, cross3(y, n), f.x);
  f.y = select3(use, y, f.y);
  return f;
}
FN real3 to_local(Frame f, real3 v) { return make_real3(dot3(f.x, v), dot3(f.y, v), dot3(f.z, v)); }
FN real3 to_world(Frame f, real3 v) { return f.x * v.x + f.y * v.y + f.z * v.z; }

#endif
