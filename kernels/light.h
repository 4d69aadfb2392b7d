/* Lamps and emissive triangles: drawing a point of one, and what a ray that runs into one sees. */
#ifndef ISOPHOTE_LIGHT_H
#define ISOPHOTE_LIGHT_H
#include "bsdf/bsdf.h"
#include "surface.h"

typedef struct {
  real3 direction; /* unit, from the shaded point */
  real distance;   /* FAR_AWAY for suns */
  real3 radiance;  /* of points and sharp suns: divided by pdf already stands for their intensity */
  real pdf;        /* per solid angle, with the choice of the light; 0: nothing to gain */
  int can_be_hit;  /* rays drawn from closures may run into it: MIS applies */
  uint instance, primitive; /* emissive triangle that must not stop the shadow ray; else NONE */
  uint flags;
} LightSample;

/* 1 - cos of the cone under which a sphere is seen, without cancellation for small ones. */
FN real cone_of_sphere(real radius, real distance2) {
  real sin2 = radius * radius / distance2;
  return sin2 / (REAL(1.0) + safe_sqrt(REAL(1.0) - sin2));
}

/* Uniform direction in the cone of 1 - cos = size around axis. */
FN real3 sample_cone(real3 axis, real size, real2 u) {
  real h = u.x * size;
  real sine = safe_sqrt(h * (REAL(2.0) - h));
  Frame f = make_frame(axis);
  real2 phi = sin_cos_real(TWO_PI * u.y);
  return normalize3(f.x * (sine * phi.y) + f.y * (sine * phi.x) + axis * (REAL(1.0) - h));
}

/* Shirley and Chiu 1997, "A Low Distortion Map Between Disk and Square". */
FN real2 sample_disk(real2 u) {
  real a = REAL(2.0) * u.x - REAL(1.0), b = REAL(2.0) * u.y - REAL(1.0);
  int wide = fabs(a) > fabs(b);
  real r = wide ? a : b;
  real ratio = wide ? b / a : a / (b != REAL(0.0) ? b : REAL(1.0));
  real quarter = REAL(0.25) * PI * ratio;
  real2 phi = sin_cos_real(wide ? quarter : REAL(0.5) * PI - quarter);
  return make_real2(r * phi.y, r * phi.x);
}

/* A lamp's light as a function of direction: Blender's spot is 0 outside the cone, a smooth step towards its edge. */
FN real spot_falloff(Light l, real cos_axis) {
  real x = clamp01((cos_axis - to_real(l.spot_cos)) * to_real(l.spot_smooth));
  return l.kind == LIGHT_SPOT ? x * x * (REAL(3.0) - REAL(2.0) * x) : REAL(1.0);
}

/* Number of a light, drawn in proportion to power. */
FN uint pick_light(Scene s, real u, uint count) {
  real scaled = u * real_of(count);
  uint i = min_uint(uint_of(scaled), count - 1u);
  uint other = s.light_alias[i].alias;
  return scaled - real_of(i) < to_real(s.light_alias[i].keep) ? i : other;
}

/* Draws a point of a light as seen from p. */
FN LightSample sample_light(Light l, real3 p, real2 u) {
  LightSample r;
  real3 center = load3(l.position), axis = load3(l.normal);
  real chance = to_real(l.probability);
  real3 radiance = load3(l.radiance);
  int is_sun = l.kind == LIGHT_SUN;
  int is_ball = (l.kind == LIGHT_POINT) | (l.kind == LIGHT_SPOT);
  int is_triangle = l.kind == LIGHT_TRIANGLE;
  real size_u = to_real(l.size_u), size_v = to_real(l.size_v);
  r.flags = l.flags;
  r.instance = is_triangle ? l.instance : NONE;
  r.primitive = is_triangle ? l.primitive : NONE;
  int is_disk = is_ball & ((l.flags & LIGHT_DISK) != 0u);
  if (is_sun | is_ball) {
    real3 to = center - p;
    real d2 = is_sun ? REAL(1.0) : dot3(to, to);
    real d = sqrt(d2);
    real3 toward = select3(is_sun, zero3() - axis, to * (REAL(1.0) / d));
    int sharp = size_u <= REAL(0.0);
    int inside = is_ball & !is_disk & (d2 <= size_u * size_u);
    /* size_v of a sun holds 1 - cos of its half angle */
    real cone = is_sun ? size_v : cone_of_sphere(size_u, d2);
    real3 drawn = sample_cone(toward, sharp ? REAL(0.0) : cone, u);
    /* A point of the disk: |to| stays its height, so the cosine on the disk is d / distance. */
    real2 disk = sample_disk(u);
    Frame facing = make_frame(toward);
    real3 on_disk = to + facing.x * (size_u * disk.x) + facing.y * (size_u * disk.y);
    real disk_d2 = dot3(on_disk, on_disk);
    real disk_d = sqrt(disk_d2);
    drawn = select3(is_disk, on_disk * (REAL(1.0) / disk_d), drawn);
    r.direction = select3(sharp, toward, drawn);
    real along = dot3(to, r.direction);
    real3 miss = to - r.direction * along;
    real t = along - safe_sqrt(size_u * size_u - dot3(miss, miss));
    r.distance = is_sun ? FAR_AWAY : (sharp ? d : (is_disk ? disk_d : t));
    real falloff = spot_falloff(l, -dot3(r.direction, axis));
    real inverse_square = is_sun ? REAL(1.0) : REAL(1.0) / d2;
    r.radiance = radiance * (falloff * (sharp ? inverse_square : REAL(1.0)));
    real solid = is_disk ? PI * size_u * size_u * d / (disk_d2 * disk_d) : TWO_PI * cone;
    r.pdf = inside ? REAL(0.0) : (sharp ? chance : chance / solid);
    r.can_be_hit = !sharp;
  } else {
    real2 disk = sample_disk(u);
    /* Triangles: Heitz 2019, "A Low-Distortion Map Between Triangle and Square". */
    int upper = u.y > u.x;
    real half_x = REAL(0.5) * u.x, half_y = REAL(0.5) * u.y;
    real bu = upper ? half_x : u.x - half_y;
    real bv = upper ? u.y - half_x : half_y;
    int is_ellipse = l.kind == LIGHT_ELLIPSE;
    real au = is_triangle ? bu : size_u * (is_ellipse ? disk.x : REAL(2.0) * u.x - REAL(1.0));
    real av = is_triangle ? bv : size_v * (is_ellipse ? disk.y : REAL(2.0) * u.y - REAL(1.0));
    real3 to = center + load3(l.u) * au + load3(l.v) * av - p;
    real d2 = dot3(to, to);
    real d = sqrt(d2);
    r.direction = to * (REAL(1.0) / d);
    r.distance = d;
    real facing = -dot3(r.direction, axis);
    real cosine = is_triangle ? fabs(facing) : facing;
    int sees = (cosine > REAL(0.0)) & (d2 > REAL(0.0));
    r.radiance = radiance;
    r.pdf = sees ? chance * d2 / (cosine * to_real(l.area)) : REAL(0.0);
    r.can_be_hit = 1;
  }
  r.can_be_hit = r.can_be_hit & !(l.flags & LIGHT_NO_MIS);
  /* A lamp without shadows: a shadow ray of no length meets nothing. */
  r.distance = (l.flags & LIGHT_NO_SHADOW) ? REAL(0.0) : r.distance;
  return r;
}

typedef struct {
  int hit;
  real3 radiance;
  real pdf; /* with which light sampling would have drawn the direction from the ray's origin */
} LightHit;

/* What a ray sees of lamp l in front of t_max: lamps do not stop rays. */
FN LightHit hit_lamp(Light l, Ray ray, real t_max, int missed) {
  LightHit r;
  real3 center = load3(l.position), axis = load3(l.normal);
  real size_u = to_real(l.size_u), size_v = to_real(l.size_v), chance = to_real(l.probability);
  int is_sun = l.kind == LIGHT_SUN;
  int is_ball = (l.kind == LIGHT_POINT) | (l.kind == LIGHT_SPOT);
  int wanted = (size_u > REAL(0.0)) & !(l.flags & LIGHT_NO_MIS) & ((l.visibility & ray.kind) != 0u);
  real cos_axis = -dot3(ray.direction, axis);
  r.radiance = load3(l.radiance);
  real3 to = center - ray.origin;
  if (is_sun) {
    real3 off = ray.direction + axis; /* |off|^2 = 2 (1 - cos), exact for small angles */
    r.hit = wanted & missed & (REAL(0.5) * dot3(off, off) <= size_v);
    r.pdf = chance / (TWO_PI * size_v);
  } else if (is_ball) {
    SphereHit h = sphere_hit(center, size_u, ray.origin, ray.direction);
    real d2 = dot3(to, to);
    int is_disk = (l.flags & LIGHT_DISK) != 0u;
    real along = dot3(to, ray.direction);
    real disk_t = d2 / (along != REAL(0.0) ? along : REAL(1.0));
    real3 off = ray.direction * disk_t - to;
    int in_disk = (along > REAL(0.0)) & (dot3(off, off) <= size_u * size_u);
    real t = is_disk ? disk_t : h.t_near;
    int in_sphere = h.hit & (d2 > size_u * size_u);
    r.hit = wanted & (is_disk ? in_disk : in_sphere) & (t > ray.t_min) & (t < t_max);
    r.radiance = r.radiance * spot_falloff(l, cos_axis);
    real solid = is_disk ? PI * size_u * size_u * sqrt(d2) / (disk_t * disk_t * disk_t) : TWO_PI * cone_of_sphere(size_u, d2);
    r.pdf = chance / solid;
  } else {
    real t = -dot3(to, axis) / (cos_axis != REAL(0.0) ? cos_axis : REAL(1.0));
    real3 on_plane = ray.direction * t - to;
    real a = dot3(on_plane, load3(l.u)), b = dot3(on_plane, load3(l.v));
    int in_rectangle = (fabs(a) <= size_u) & (fabs(b) <= size_v);
    int in_ellipse = square(a / size_u) + square(b / size_v) <= REAL(1.0);
    int in_shape = l.kind == LIGHT_ELLIPSE ? in_ellipse : in_rectangle;
    r.hit = wanted & in_shape & (cos_axis > REAL(0.0)) & (t > ray.t_min) & (t < t_max);
    r.pdf = chance * t * t / (max_real(cos_axis, REAL(1e-30)) * to_real(l.area));
  }
  return r;
}

/* Veach 1997, power heuristic with exponent 2, from the ratio so that no square overflows. */
FN real mis_weight(real pdf, real other) {
  real ratio = other / pdf;
  return REAL(1.0) / (REAL(1.0) + ratio * ratio);
}

#endif
