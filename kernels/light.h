/* Lamps and emissive triangles: drawing a point of one, and what a ray that runs into one sees. */
#ifndef ISOPHOTE_LIGHT_H
#define ISOPHOTE_LIGHT_H
#include "bsdf/bsdf.h"
#include "disk.h"
#include "light_tree.h"
#include "spherical_triangle.h"
#include "surface.h"
#include "world.h"

typedef struct {
  real3 direction; /* unit, from the shaded point */
  real distance;   /* FAR_AWAY for suns */
  real3 radiance;  /* of points and sharp suns: divided by pdf already stands for their intensity */
  real pdf;        /* per solid angle; 0: nothing to gain */
  int can_be_hit;  /* rays drawn from closures may run into it: MIS applies */
  uint instance, primitive; /* emissive triangle that must not stop the shadow ray; else NONE */
  uint hidden; /* kinds of rays that do not see it: closures that would send one bring nothing of its light */
} LightSample;

/* Whether a material's emission multiplies a lamp's radiance. */
FN int is_computed_lamp(Light l) { return ((l.flags & LIGHT_COMPUTED) != 0u) & (l.kind < LIGHT_TRIANGLE); }

/* Whether a ray of a kind is one of those that do not see a light. Diffuse transmission counts as both. */
FN int is_hidden(uint hidden, uint kind) { return (hidden & (kind | ((kind & RAY_SOFT) ? RAY_DIFFUSE : 0u))) != 0u; }

/* Whether a lamp's own limit ends paths of so many bounces before they reach it. */
FN int is_beyond(Light l, uint bounces) { return (LIGHT_BOUNCES(l.flags) > 0u) & (bounces > LIGHT_BOUNCES(l.flags)); }

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

/* A lamp's light as a function of the unit direction towards it: Blender's spot is 0 outside the cone, a smooth step
 * towards its edge. The cone of a stretched one is round in a space where the axes have the lengths of u and v. */
FN real spot_falloff(Light l, real3 direction, uint features) {
  real cos_axis = -dot3(direction, load3(l.normal));
  if (features & FEATURE_LAMP_SHAPES) {
    real3 in_cone = make_real3(dot3(direction, load3(l.u)), dot3(direction, load3(l.v)), cos_axis);
    cos_axis = cos_axis / ((l.flags & LIGHT_STRETCHED) ? sqrt(dot3(in_cone, in_cone)) : REAL(1.0));
  }
  real x = clamp01((cos_axis - to_real(l.cone)) * to_real(l.cone_scale));
  return l.kind == LIGHT_SPOT ? x * x * (REAL(3.0) - REAL(2.0) * x) : REAL(1.0);
}

/* What an area lamp with a spread sends towards who looks at it in a direction, in parts of its radiance: like light
 * behind a grid of slats, the tangent of the angle counts. docs/units.md has the formula. */
FN real spread_falloff(Light l, real3 direction, uint features) {
  if (!(features & FEATURE_LAMP_SHAPES)) return REAL(1.0);
  real cosine = -dot3(direction, load3(l.normal));
  real3 across = direction + load3(l.normal) * cosine; /* keeps the digits of small angles */
  real tangent = sqrt(dot3(across, across)) / max_real(cosine, REAL(1e-30));
  real passed = max_real(to_real(l.cone) - tangent, REAL(0.0)) * to_real(l.cone_scale);
  return l.cone_scale > 0.0f ? passed : REAL(1.0);
}

/* The part of a rectangle or an ellipse that is drawn, in the plane of the lamp. */
typedef struct {
  real3 center;
  real half_u, half_v, area;
  int is_ellipse;
} FlatPart;

/* The part that lights p. With a spread p has light from a disk around its foot: of a rectangle that is the rectangle
 * around both, of an ellipse the smallest of it, the disk and the rectangle; Cycles does so, too (light/area.h). Its
 * area is 0 where nothing lights p. */
FN FlatPart lit_part(Light l, real3 p, uint features) {
  FlatPart r;
  r.center = load3(l.position);
  r.half_u = to_real(l.size_u);
  r.half_v = to_real(l.size_v);
  r.area = to_real(l.area);
  r.is_ellipse = l.kind == LIGHT_ELLIPSE;
  if (features & FEATURE_LAMP_SHAPES) {
    real3 axis_u = load3(l.u), axis_v = load3(l.v), from = p - r.center;
    real reach = max_real(dot3(from, load3(l.normal)), REAL(0.0)) * to_real(l.cone);
    real foot_u = dot3(from, axis_u), foot_v = dot3(from, axis_v);
    real low_u = max_real(foot_u - reach, -r.half_u), high_u = min_real(foot_u + reach, r.half_u);
    real low_v = max_real(foot_v - reach, -r.half_v), high_v = min_real(foot_v + reach, r.half_v);
    real wide = max_real(high_u - low_u, REAL(0.0)), tall = max_real(high_v - low_v, REAL(0.0));
    real box = wide * tall, disk = PI * reach * reach;
    int spreads = l.cone_scale > 0.0f;
    int takes_box = spreads & (!r.is_ellipse | (box < min_real(r.area, disk)));
    int takes_disk = spreads & !takes_box & (disk < r.area);
    real u = takes_box ? REAL(0.5) * (low_u + high_u) : (takes_disk ? foot_u : REAL(0.0));
    real v = takes_box ? REAL(0.5) * (low_v + high_v) : (takes_disk ? foot_v : REAL(0.0));
    r.center = r.center + axis_u * u + axis_v * v;
    r.half_u = takes_box ? REAL(0.5) * wide : (takes_disk ? reach : r.half_u);
    r.half_v = takes_box ? REAL(0.5) * tall : (takes_disk ? reach : r.half_v);
    r.area = takes_box ? box : (takes_disk ? disk : r.area);
    r.is_ellipse = r.is_ellipse & !takes_box;
  }
  return r;
}

FN int is_in_ellipse(Light l, real3 from_center) {
  real a = dot3(from_center, load3(l.u)) / to_real(l.size_u), b = dot3(from_center, load3(l.v)) / to_real(l.size_v);
  return a * a + b * b <= REAL(1.0);
}

/* Number of the light that an emissive triangle is; light_count where it is none. Triangles follow the lamps in
 * the order of (instance, primitive). */
FN uint find_triangle_light(Scene s, uint instance, uint primitive) {
  uint low = s.world[0].lamp_count, high = s.world[0].light_count;
  while (low < high) {
    uint middle = low + (high - low) / 2u;
    uint at_instance = s.lights[middle].instance, at_primitive = s.lights[middle].primitive;
    int before = (at_instance < instance) | ((at_instance == instance) & (at_primitive < primitive));
    low = before ? middle + 1u : low;
    high = before ? high : middle;
  }
  uint found = min_uint(low, s.world[0].light_count - 1u);
  int same = (s.lights[found].instance == instance) & (s.lights[found].primitive == primitive);
  return same ? found : s.world[0].light_count;
}

/* Polygons are drawn by solid angle between these limits: below, the density by area varies little over
 * the light (a few per cent) and float32 corners leave no digits; above, the viewer lies as good as in it. */
#define SMALLEST_SOLID_ANGLE REAL(3e-4)
#define LARGEST_SOLID_ANGLE REAL(6.2)

/* A triangle or rectangle as seen from a point: one or two spherical triangles that share the corners a and c. */
typedef struct {
  SphericalTriangle first, second;
  real solid_angle; /* of both; 0 where it is to be drawn by area */
} SphericalPolygon;

/* part: of the light, if it is no triangle. */
FN SphericalPolygon make_spherical_polygon(Light l, FlatPart part, real3 p, uint features) {
  SphericalPolygon r;
  int is_triangle = !(features & FEATURE_LAMPS) | (l.kind == LIGHT_TRIANGLE);
  real scale_u = is_triangle ? REAL(1.0) : REAL(2.0) * part.half_u;
  real scale_v = is_triangle ? REAL(1.0) : REAL(2.0) * part.half_v;
  real3 side_u = load3(l.u) * scale_u, side_v = load3(l.v) * scale_v;
  real3 a = part.center - p;
  real volume = fabs(dot3(a, load3(l.normal))) * part.area;
  if (!(features & FEATURE_LAMPS)) {
    r.first = make_spherical_triangle(a, a + side_u, a + side_v, REAL(2.0) * volume);
    r.second = r.first;
    r.solid_angle = r.first.solid_angle;
  } else {
    a = a - (side_u + side_v) * (is_triangle ? REAL(0.0) : REAL(0.5));
    real3 b = a + side_u, d = a + side_v;
    real3 c = is_triangle ? d : b + side_v;
    r.first = make_spherical_triangle(a, b, c, is_triangle ? REAL(2.0) * volume : volume);
    r.second = make_spherical_triangle(a, d, c, volume);
    r.solid_angle = r.first.solid_angle + (is_triangle ? REAL(0.0) : r.second.solid_angle);
  }
  int fits = (r.solid_angle > SMALLEST_SOLID_ANGLE) & (r.solid_angle < LARGEST_SOLID_ANGLE) & !part.is_ellipse;
  r.solid_angle = fits ? r.solid_angle : REAL(0.0);
  return r;
}

/* Density per solid angle with which a polygon or an ellipse of some area, once it is chosen, gives a direction from p
 * that meets it at distance t under `cosine`. */
FN real flat_light_pdf(real area, SphericalPolygon polygon, real t, real cosine) {
  real by_area = t * t / (max_real(cosine, REAL(1e-30)) * area);
  return polygon.solid_angle > REAL(0.0) ? REAL(1.0) / polygon.solid_angle : by_area;
}

/* Draws a point of a light as seen from p. features: of the scene; without FEATURE_LAMPS l is a triangle. */
FN LightSample sample_light(Light l, real3 p, real2 u, uint features) {
  LightSample r;
  real3 center = load3(l.position), axis = load3(l.normal);
  real3 radiance = load3(l.radiance);
  int estimated = ((l.flags & LIGHT_COMPUTED) != 0u) & !is_computed_lamp(l);
  if (features & FEATURE_SHINES) radiance = select3(estimated, splat3(REAL(1.0)), radiance);
  int lamps = (features & FEATURE_LAMPS) != 0u;
  int is_sun = lamps & (l.kind == LIGHT_SUN);
  int is_ball = lamps & ((l.kind == LIGHT_POINT) | (l.kind == LIGHT_SPOT));
  int is_triangle = !lamps | (l.kind == LIGHT_TRIANGLE);
  real size_u = to_real(l.size_u), size_v = to_real(l.size_v);
  r.hidden = (features & FEATURE_LIGHT_LIMITS) ? RAY_INDIRECT & ~l.visibility : 0u;
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
    real falloff = spot_falloff(l, r.direction, features);
    real inverse_square = is_sun ? REAL(1.0) : REAL(1.0) / d2;
    r.radiance = radiance * (falloff * (sharp ? inverse_square : REAL(1.0)));
    real solid = is_disk ? PI * size_u * size_u * d / (disk_d2 * disk_d) : TWO_PI * cone;
    r.pdf = inside ? REAL(0.0) : (sharp ? REAL(1.0) : REAL(1.0) / solid);
    r.can_be_hit = !sharp;
  } else {
    FlatPart lit = lit_part(l, p, features);
    SphericalPolygon polygon = make_spherical_polygon(l, lit, p, features);
    int by_angle = polygon.solid_angle > REAL(0.0);
    real part = u.x * polygon.solid_angle, rest = part - polygon.first.solid_angle;
    int in_second = !is_triangle & (rest > REAL(0.0));
    SphericalTriangle part_of = polygon.first;
    if (lamps) {
      part_of.b = select3(in_second, polygon.second.b, part_of.b);
      part_of.height = in_second ? polygon.second.height : part_of.height;
      part_of.side = in_second ? polygon.second.side : part_of.side;
      part_of.base = in_second ? polygon.second.base : part_of.base;
      part = in_second ? rest : part;
    }
    real3 in_angle = sample_spherical_triangle(part_of, part, u.y);

    /* Triangles: Heitz 2019, "A Low-Distortion Map Between Triangle and Square". */
    int upper = u.y > u.x;
    real half_x = REAL(0.5) * u.x, half_y = REAL(0.5) * u.y;
    real au = upper ? half_x : u.x - half_y;
    real av = upper ? u.y - half_x : half_y;
    if (lamps) {
      real2 disk = sample_disk(u);
      au = is_triangle ? au : lit.half_u * (lit.is_ellipse ? disk.x : REAL(2.0) * u.x - REAL(1.0));
      av = is_triangle ? av : lit.half_v * (lit.is_ellipse ? disk.y : REAL(2.0) * u.y - REAL(1.0));
    }
    real3 to = lit.center - p;
    real3 on_light = to + load3(l.u) * au + load3(l.v) * av;
    real3 in_area = on_light * (REAL(1.0) / sqrt(dot3(on_light, on_light)));
    r.direction = select3(by_angle, in_angle, in_area);
    real facing = -dot3(r.direction, axis), height = -dot3(to, axis);
    real cosine = is_triangle ? fabs(facing) : facing;
    real flat = sqrt(dot3(on_light, on_light));
    r.distance = by_angle ? height / (facing != REAL(0.0) ? facing : REAL(1.0)) : flat;
    int sees = (cosine > REAL(0.0)) & (r.distance > REAL(0.0));
    if (features & FEATURE_LAMP_SHAPES) {
      int whole = (l.kind != LIGHT_ELLIPSE) | !(l.cone_scale > 0.0f);
      sees = sees & (lit.area > REAL(0.0)) & (whole | is_in_ellipse(l, p + r.direction * r.distance - center));
    }
    r.radiance = radiance * spread_falloff(l, r.direction, features);
    r.pdf = sees ? flat_light_pdf(lit.area, polygon, r.distance, cosine) : REAL(0.0);
    r.can_be_hit = 1;
  }
  r.can_be_hit = r.can_be_hit & !(l.flags & LIGHT_NO_MIS);
  /* A lamp without shadows: a shadow ray of no length meets nothing. */
  r.distance = (l.flags & LIGHT_NO_SHADOW) ? REAL(0.0) : r.distance;
  return r;
}

/* A shadow ray that goes to the world skips this primitive of no instance, one that goes to a computed lamp, or where
 * lights are linked to any, this plus the lamp's number. */
#define TO_WORLD 0u
#define TO_LAMP 1u
FN int is_to_world(Ray ray) { return (ray.skip_instance == NONE) & (ray.skip_primitive == TO_WORLD); }
FN int is_to_lamp(Ray ray) {
  return (ray.skip_instance == NONE) & (ray.skip_primitive != TO_WORLD) & (ray.skip_primitive != NONE);
}

#if SCENE_FEATURES & FEATURE_MOTION
/* A light as it is at a time: triangles are where their instances and vertices are then. What the light tree knows of them
 * is of the middle of the shutter's time, as in Cycles. */
FN Light light_at(Scene s, Light l, real time, uint features) {
  if (l.kind != LIGHT_TRIANGLE || !is_moving(s, l.instance, features)) return l;
  GLOBAL const uint *corner = &s.indices[3u * l.primitive];
  real3 v0 = vertex_at(s, l.instance, corner[0], time, features);
  real3 e1 = vertex_at(s, l.instance, corner[1], time, features) - v0;
  real3 e2 = vertex_at(s, l.instance, corner[2], time, features) - v0;
  if (in_motion(s, l.instance, features)) {
    Placement m = placement_at(s, s.motions[l.instance], time);
    v0 = placed_point(m, v0);
    e1 = placed_vector(m, e1);
    e2 = placed_vector(m, e2);
  } else {
    GLOBAL const float *to_world = s.instances[l.instance].to_world;
    v0 = transform_point(to_world, v0);
    e1 = transform_vector(to_world, e1);
    e2 = transform_vector(to_world, e2);
  }
  real3 n = cross3(e1, e2);
  real length = sqrt(dot3(n, n));
  n = n * (length > REAL(0.0) ? REAL(1.0) / length : REAL(0.0));
  l.position = pack3(v0);
  l.u = pack3(e1);
  l.v = pack3(e2);
  l.normal = pack3(n);
  l.area = to_float(length * REAL(0.5));
  return l;
}
#else
FN Light light_at(Scene s, Light l, real time, uint features) { return l; }
#endif

/* Draws a point of the light at which a walk has arrived. The steps have stretched the number that they used:
 * `fine`, of its own, fills the digits that this has emptied. `bounces`: of a path that would run into it from here. */
FN LightSample finish_light(Scene s, LightWalk walk, real3 p, real u_y, real fine, uint bounces, real time, uint features) {
  real u_x = min_real(walk.u + fine * (REAL(5.9604644775390625e-8) / walk.chance), REAL(0.99999994));
  uint light = walk.at & ~CLUSTER_LIGHT; /* a single light is number 0, where walks start */
  LightSample r;
  if (features & FEATURE_MOTION) { /* a copy of the light, which keeps the loops of other scenes from vectorising */
    Light l = light_at(s, s.lights[light], time, features);
    r = sample_light(l, p, make_real2(u_x, u_y), features);
    if (l.kind == LIGHT_TRIANGLE && !(l.area > 0.0f)) r.pdf = REAL(0.0);
  } else {
    r = sample_light(s.lights[light], p, make_real2(u_x, u_y), features);
  }
  if (features & FEATURE_WORLD_LIGHT) {
    WorldSample w = sample_world(s, make_real2(u_x, u_y), features);
    int is_world = s.lights[light].kind == LIGHT_WORLD;
    r.direction = select3(is_world, w.direction, r.direction);
    r.pdf = is_world ? w.pdf : r.pdf;
    r.distance = is_world ? FAR_AWAY : r.distance;
    r.can_be_hit = is_world | r.can_be_hit;
    r.primitive = is_world ? TO_WORLD : r.primitive;
  }
  if (features & FEATURE_LAMP_PROGRAMS) {
    r.primitive = is_computed_lamp(s.lights[light]) ? TO_LAMP + light : r.primitive;
  }
  r.pdf = r.pdf * walk.chance;
  if (features & FEATURE_LIGHT_LIMITS) r.pdf = is_beyond(s.lights[light], bounces) ? REAL(0.0) : r.pdf;
  return r;
}

/* The sample of a light as a receiver of a set has it, in scenes with FEATURE_LINKING. */
FN LightSample link_sample(Scene s, LightSample r, uint light, uint set) {
  uint link = link_of_light(s, light);
  r.pdf = is_in_mask(s.links[link].unlit, set) ? REAL(0.0) : r.pdf;
  r.can_be_hit = r.can_be_hit & !is_shadow_linked(s, link); /* only shadow rays pass what does not stop it */
  r.primitive = s.lights[light].kind < LIGHT_TRIANGLE ? TO_LAMP + light : r.primitive;
  return r;
}

typedef struct {
  int hit;
  real t; /* where the ray meets it, if it does */
  real3 radiance;
  real pdf; /* with which sample_light would have drawn the direction from the ray's origin */
} LightHit;

/* What a ray of a path of so many bounces sees of lamp l in front of t_max: lamps do not stop rays. */
FN LightHit hit_lamp(Light l, Ray ray, real t_max, int missed, uint bounces, uint features) {
  LightHit r;
  real3 center = load3(l.position), axis = load3(l.normal);
  real size_u = to_real(l.size_u), size_v = to_real(l.size_v);
  int is_sun = l.kind == LIGHT_SUN;
  int is_ball = (l.kind == LIGHT_POINT) | (l.kind == LIGHT_SPOT);
  int wanted = (size_u > REAL(0.0)) & !(l.flags & LIGHT_NO_MIS) & ((l.visibility & ray.kind) != 0u);
  if (features & FEATURE_LIGHT_LIMITS) wanted = wanted & !is_hidden(RAY_INDIRECT & ~l.visibility, ray.kind) & !is_beyond(l, bounces);
  real cos_axis = -dot3(ray.direction, axis);
  r.radiance = load3(l.radiance);
  real3 to = center - ray.origin;
  if (is_sun) {
    real3 off = ray.direction + axis; /* |off|^2 = 2 (1 - cos), exact for small angles */
    r.t = FAR_AWAY;
    r.hit = wanted & missed & (REAL(0.5) * dot3(off, off) <= size_v);
    r.pdf = REAL(1.0) / (TWO_PI * size_v);
  } else if (is_ball) {
    SphereHit h = sphere_hit(center, size_u, ray.origin, ray.direction);
    real d2 = dot3(to, to);
    int is_disk = (l.flags & LIGHT_DISK) != 0u;
    real along = dot3(to, ray.direction);
    real disk_t = d2 / (along != REAL(0.0) ? along : REAL(1.0));
    real3 off = ray.direction * disk_t - to;
    int in_disk = (along > REAL(0.0)) & (dot3(off, off) <= size_u * size_u);
    r.t = is_disk ? disk_t : h.t_near;
    int in_sphere = h.hit & (d2 > size_u * size_u);
    r.hit = wanted & (is_disk ? in_disk : in_sphere) & (r.t > ray.t_min) & (r.t < t_max);
    r.radiance = r.radiance * spot_falloff(l, ray.direction, features);
    real solid = is_disk ? PI * size_u * size_u * sqrt(d2) / (disk_t * disk_t * disk_t) : TWO_PI * cone_of_sphere(size_u, d2);
    r.pdf = REAL(1.0) / solid;
  } else {
    r.t = -dot3(to, axis) / (cos_axis != REAL(0.0) ? cos_axis : REAL(1.0));
    real3 on_plane = ray.direction * r.t - to;
    real a = dot3(on_plane, load3(l.u)), b = dot3(on_plane, load3(l.v));
    int in_rectangle = (fabs(a) <= size_u) & (fabs(b) <= size_v);
    int in_shape = l.kind == LIGHT_ELLIPSE ? is_in_ellipse(l, on_plane) : in_rectangle;
    FlatPart lit = lit_part(l, ray.origin, features);
    r.radiance = r.radiance * spread_falloff(l, ray.direction, features);
    r.hit = wanted & in_shape & (cos_axis > REAL(0.0)) & (r.t > ray.t_min) & (r.t < t_max);
    SphericalPolygon polygon = make_spherical_polygon(l, lit, ray.origin, FEATURE_LAMPS);
    r.pdf = flat_light_pdf(max_real(lit.area, REAL(1e-30)), polygon, r.t, cos_axis);
  }
  return r;
}

/* Where a ray meets a lamp at distance t, for the lamp's program: as Cycles has it (kernel/light/point.h, spot.h, area.h,
 * distant.h). Of a sun the place, too, is the direction in which it shines. */
FN Surface make_lamp_surface(Light l, Ray ray, real t) {
  Surface r;
  int is_ball = (l.kind <= LIGHT_SPOT) & !(l.flags & LIGHT_DISK) & (l.size_u > 0.0f);
  int is_flat = (l.kind == LIGHT_RECTANGLE) | (l.kind == LIGHT_ELLIPSE);
  real3 back = zero3() - ray.direction, p = ray.origin + ray.direction * t;
  real3 outward = normalize3(is_ball ? p - load3(l.position) : back);
  r.p = l.kind == LIGHT_SUN ? back : p;
  r.ng = is_flat ? load3(l.normal) : is_ball ? outward : back;
  r.ns = r.ng;
  r.offset = REAL(0.0);
  r.backfacing = 0;
  r.material = l.primitive;
  return r;
}

/* With which density light sampling would have drawn a ray's hit at distance t on an emissive triangle; 0 where
 * it never does. */
FN real emission_pdf(Scene s, Hit h, Receiver from, real3 direction, real time) {
  uint i = s.world[0].light_count > 0u ? find_triangle_light(s, h.instance, h.primitive) : 0u;
  if (i >= s.world[0].light_count) return REAL(0.0);
  Light l = light_at(s, s.lights[i], time, SCENE_FEATURES & s.world[0].features);
  real cosine = fabs(dot3(load3(l.normal), direction));
  SphericalPolygon polygon = make_spherical_polygon(l, lit_part(l, from.p, 0u), from.p, 0u);
  return light_chance(s, l, from) * flat_light_pdf(to_real(l.area), polygon, h.t, cosine);
}

/* Veach 1997, power heuristic with exponent 2, from the ratio so that no square overflows. */
FN real mis_weight(real pdf, real other) {
  real ratio = other / pdf;
  return REAL(1.0) / (REAL(1.0) + ratio * ratio);
}

#endif
