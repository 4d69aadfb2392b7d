/* Lights whose radiance a program computes: of the world, of lamps, and of triangles with textures. It is computed for a
 * connection once it is known that it would bring something. */
#ifndef ISOPHOTE_SHINE_H
#define ISOPHOTE_SHINE_H
#include "stages.h"

/* Where a shadow ray ends on the emissive triangle that it goes to. */
FN Hit find_lit_point(Scene s, Ray ray, uint features) {
  Hit h = no_hit(ray.t_max);
  Light l = s.lights[find_triangle_light(s, ray.skip_instance, ray.skip_primitive)];
  l = light_at(s, l, ray_time(ray), features);
  real3 e1 = load3(l.u), e2 = load3(l.v), n = cross3(e1, e2);
  real3 p = ray.origin + ray.direction * ray.t_max - load3(l.position);
  real scale = REAL(1.0) / dot3(n, n);
  real b1 = clamp01(dot3(cross3(p, e2), n) * scale), b2 = clamp01(dot3(cross3(e1, p), n) * scale);
  int swapped = (s.instances[l.instance].visibility & INSTANCE_MIRRORED) != 0u;
  h.u = swapped ? b2 : b1;
  h.v = swapped ? b1 : b2;
  h.instance = ray.skip_instance;
  h.primitive = ray.skip_primitive;
  return h;
}

/* The connection with the radiance of its light, of which it lacks only what is computed, and clamped. */
FN Connection shine(Scene s, Params params, Connection c, uint features, real *r) {
  Ray ray = c.ray;
  ray.kind = 0u; /* to the program no ray has come: as in Cycles, which tells it PATH_RAY_EMISSION alone */
  int is_world = is_to_world(ray);
  if ((features & FEATURE_LAMP_PROGRAMS) && is_to_lamp(ray) && is_computed_lamp(s.lights[ray.skip_primitive - TO_LAMP])) {
    Light l = s.lights[ray.skip_primitive - TO_LAMP];
    real t = hit_lamp(l, ray, FAR_AWAY, 1, 0u, features).t;
    c.brought.light = c.brought.light * lamp_emission(s, l, ray, t, c.bounces + 1u, c.passed, r);
  } else if (is_world || ray.skip_instance != NONE) {
    Surface at;
    Hit h;
    if (is_world) {
      h = background_hit(FAR_AWAY);
      at = make_background(s, ray.direction);
    } else {
      h = find_lit_point(s, ray, features);
      at = make_surface(s, ray, h, features);
    }
    Material m = s.materials[at.material];
    if (m.flags & MATERIAL_EMISSION_VARIES) {
      compute_values(s, m, m.steps, at, ray, h, c.bounces + 1u, c.passed, r);
      c.brought.light = c.brought.light * material_emission(m, r);
    }
  }
  c.brought = clamp_light(params, c.brought.light, c.brought.indirect);
  return c;
}

#endif
