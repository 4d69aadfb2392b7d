/* The Ambient Occlusion pass: how much of the hemisphere over a surface that the camera sees is free of others within a
 * distance, as in Cycles (kernel/integrator/shade_surface.h, integrate_surface_ao). */
#ifndef ISOPHOTE_OCCLUSION_H
#define ISOPHOTE_OCCLUSION_H
#include "passes.h"

/* The mean of the normals of diffuse closures; the shading normal where there are none. */
FN real3 diffuse_normal(Scene s, Material m, Surface at, Path p, const real *r) {
  if (!((SCENE_FEATURES & FEATURE_BUMP) && (m.flags & MATERIAL_BUMPS))) return at.ns;
  real3 sum = zero3();
  Choice choice = make_choice(REAL(0.0));
  for (uint k = 0u; k < m.count; k++) {
    Instruction i = s.instructions[m.first + k];
    Closure c = closure_of(i, r);
    Frame frame = frame_of(i, at, r);
    if (is_diffuse(i.op)) sum = sum + frame.z * average3(abs3(closure_weight(c, choice)));
    if (is_closure(i.op)) continue;
    choice.layer = layer_closure(c, at.backfacing, s.albedo_tables, to_local(frame, make_real3(-p.dx, -p.dy, -p.dz)), choice.layer);
  }
  return dot3(sum, sum) > REAL(0.0) ? normalize3(sum) : at.ns;
}

/* Whether a path's hit counts, and how many of the material's steps then do. */
FN int is_seen(Path p, Hit h) { return path_bounce(p) == 0 && !is_inside(p) && h.instance != NONE && h.instance != IN_VOLUME; }
FN uint occlusion_steps(Material m) {
  return (m.flags & (MATERIAL_BUMPS | MATERIAL_HOLDS_OUT)) ? m.steps : m.shadow_steps;
}

/* A ray that is drawn in proportion to the cosine, and what the pass gets where it is free. */
FN Connection connect_surroundings(Scene s, Material m, Surface at, Path p, Hit h, const real *r) {
  Connection c;
  real2 u = sample_bounce(p.seed, p.index, path_vertex(p), PAIR_BSDF);
  real3 direction = to_world(make_frame(diffuse_normal(s, m, at, p, r)), sample_cosine(u));
  real3 through = (m.flags & MATERIAL_TRANSPARENT) ? material_transparency(m, r) : zero3();
  c.ray = shadow_ray(offset_origin(at, direction), direction, FAR_AWAY, NONE, NONE, path_time(p));
  if (SCENE_FEATURES & s.world[0].features & FEATURE_TERMINATOR) c.ray = lifted_ray(s, at, h, c.ray);
  c.ray.t_max = to_real(s.world[0].occlusion_distance);
  c.brought.light = select3(is_held_out(s, m, r), zero3(), path_throughput(p) * saturate3(splat3(REAL(1.0)) - through));
  c.passed = uint_of(path_passed(p));
  c.bounces = p.bounces;
  return c;
}

FN void show_occlusion(GLOBAL real *columns, uint stride, uint slot, uint groups, real3 light, Shadow d) {
  add_to_plane(columns, stride, slot, groups, GROUP_ambient_occlusion, light * d.kept);
}

#endif
