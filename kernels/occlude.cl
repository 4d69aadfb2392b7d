/* The entry point, launched before `shade`, for what surrounds the surfaces that the camera sees; part of wavefront.cl. */
#include "occlusion.h"

__kernel void occlude(SCENE_PARAMETERS, PATH_PARAMETERS, HIT_PARAMETERS, GLOBAL real *columns, GLOBAL const uint *queue,
                      GLOBAL const uint *counts, uint bounce) {
  MAKE_SCENE
  uint k = get_global_id(0);
  if (k >= counts[2u * bounce]) return;
  Path p = load_whole_path(reals, uints, stride, queue[k]);
  Hit h = load_hit(hit_reals, hit_uints, stride, queue[k]);
  if (is_alone(params) || !is_seen(p, h)) return;
  real registers[REGISTERS];
  Surface at = make_surface(s, path_ray(p), h, SCENE_FEATURES);
  Material m = s.materials[at.material];
  compute_values(s, m, occlusion_steps(m), at, path_ray(p), h, p.bounces, uint_of(path_passed(p)), registers);
  Connection c = connect_surroundings(s, m, at, p, h, registers);
#if SCENE_FEATURES & FEATURE_VOLUME
  Volumes v;
  load_volumes(volumes_of_paths(uints, stride), stride, queue[k], &v);
  cross_towards(&v, m, h, at, c.ray.origin - at.p);
  Shadow d = trace_in_volumes(s, params, make_shadow(c.ray, c.passed, c.bounces), &v, registers);
#else
  Shadow d = trace_connection(s, params, c, SCENE_FEATURES, registers);
#endif
  show_occlusion(columns, stride, p.slot, film_groups(params), c.brought.light, d);
}
