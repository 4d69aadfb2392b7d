/* All of a path in one work-item, as in the report's first version. */
__kernel void megakernel(SCENE_PARAMETERS, RESULT_PARAMETERS, uint stride, uint first_pixel, uint count) {
  MAKE_SCENE
  uint i = get_global_id(0);
  if (i >= count) return;
  Path p = start_path(s, params_buffer, results, columns, stride, first_pixel, i);
  for (int alive = 1; alive;) {
    Shaded r = shade_path(s, params, p, trace(s, path_ray(p), 0), results, columns, limits, stride);
    if (r.connected) {
      real registers[REGISTERS];
      Shadow d = trace_connection(s, params, r.connection, SCENE_FEATURES, registers);
      add_result(results, columns, stride, i, params, behind_shadow(r.connection.brought, d), FROM_LIGHT);
    }
    p = r.path;
    alive = r.alive;
  }
}
