/* Connections in columns, a path each, until `connect` traces them; part of wavefront.cl. */
#define LIGHT_TIME_COLUMN (CLAMPS ? 11u : 10u)
#define CONNECTION_BOUNCES 3u /* column of light_uints, where there are volumes */
FN void store_connection(LIGHT_PARAMETERS, uint stride, uint i, Connection c) {
  light_reals[i] = c.ray.origin.x;
  light_reals[stride + i] = c.ray.origin.y;
  light_reals[2u * stride + i] = c.ray.origin.z;
  light_reals[3u * stride + i] = c.ray.direction.x;
  light_reals[4u * stride + i] = c.ray.direction.y;
  light_reals[5u * stride + i] = c.ray.direction.z;
  light_reals[6u * stride + i] = c.ray.t_max;
  light_reals[7u * stride + i] = c.brought.light.x;
  light_reals[8u * stride + i] = c.brought.light.y;
  light_reals[9u * stride + i] = c.brought.light.z;
  if (CLAMPS) light_reals[10u * stride + i] = c.brought.cut;
#if SCENE_FEATURES & FEATURE_MOTION
  light_reals[LIGHT_TIME_COLUMN * stride + i] = c.ray.time;
#endif
  light_uints[i] = c.ray.skip_instance;
  light_uints[stride + i] = c.ray.skip_primitive;
  light_uints[2u * stride + i] = c.passed | c.bounces << 8; /* without those of transmission: the others tell, */
#if SCENE_FEATURES & FEATURE_VOLUME
  light_uints[CONNECTION_BOUNCES * stride + i] = c.bounces; /* but for bounces in volumes */
#endif
}

FN Connection load_connection(LIGHT_PARAMETERS, uint stride, uint i) {
  Connection c;
  real time = REAL(0.0);
#if SCENE_FEATURES & FEATURE_MOTION
  time = light_reals[LIGHT_TIME_COLUMN * stride + i];
#endif
  c.ray = shadow_ray(make_real3(light_reals[i], light_reals[stride + i], light_reals[2u * stride + i]),
                     make_real3(light_reals[3u * stride + i], light_reals[4u * stride + i], light_reals[5u * stride + i]),
                     light_reals[6u * stride + i], light_uints[i], light_uints[stride + i], time);
  c.brought.light =
      make_real3(light_reals[7u * stride + i], light_reals[8u * stride + i], light_reals[9u * stride + i]);
  c.brought.cut = CLAMPS ? light_reals[10u * stride + i] : REAL(0.0);
  c.passed = light_uints[2u * stride + i] & 255u;
  uint bounces = light_uints[2u * stride + i] >> 8, all = bounces & 255u;
  c.bounces = bounces | (all - (bounces >> 8 & 255u) - (bounces >> 16)) << 24;
#if SCENE_FEATURES & FEATURE_VOLUME
  c.bounces = light_uints[CONNECTION_BOUNCES * stride + i];
#endif
  c.brought.indirect = all > 0u;
  return c;
}
