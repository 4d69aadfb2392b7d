/* The rays from a group's surfaces to the lights drawn for them, traced together. Included once a variant. */
#pragma once
#include "batch.h"

namespace isophote {
namespace ISOPHOTE_VARIANT {

FN Ray light_ray(const Batch &b, Columns columns, uint at) {
  return shadow_ray(make_real3(b.cox[at], b.coy[at], b.coz[at]), make_real3(b.ldx[at], b.ldy[at], b.ldz[at]),
                    b.distance[at], b.light_instance[at], b.light_primitive[at], path_time(path_at(columns, at)));
}

/* The shadow rays of a group's connections that bring light: their paths in key. */
struct ShadowRays {
  Batch &b;
  Columns columns;
  Params params;
  Ray ray(uint i) const { return among_catchers(light_ray(b, columns, b.key[i]), is_alone(params)); }
  void store(uint i, const Hit &h) {
    uint at = b.key[i];
    if (h.instance == NONE) add_light(b, params, at, load_brought(b, params, at), FROM_LIGHT);
  }
};

/* The same in scenes with transparent surfaces, which take their part: order has the shadows still on their way. */
struct PassingRays {
  Batch &b;
  Scene s;
  Params params;
  uint features;
  Ray ray(uint i) const { return among_catchers(b.shadows[b.order[i]].ray, is_alone(params)); }
  void store(uint i, const Hit &h) {
    Shadow &shadow = b.shadows[b.order[i]];
    real *registers = b.shadow_registers.data();
    shadow = features & FEATURE_VOLUME
                 ? shade_shadow(s, params, shadow, &b.shadow_volumes[b.order[i]], h, features, registers)
                 : pass_shadow(s, params, shadow, h, features, registers);
  }
};

/* Those that a shadow ray of a path of the group begins in: the side of the surface is that of the ray's origin. */
static Volumes volumes_from(const Batch &b, Scene s, Group g, Path p, uint i, Ray ray) {
  Volumes v;
  load_volumes(b.volumes.data(), CAPACITY, p.slot, &v);
  if (g.material != SCATTERED_BY_VOLUMES && s.materials[g.material].volume != NONE) {
    Surface at = load_surface(b, i, g.material);
    cross_towards(&v, s.materials[g.material], load_hit(b, i), at, ray.origin - at.p);
  }
  return v;
}

/* Takes the first `count` shadows to their end. */
static void trace_shadows(Batch &b, Scene s, Params params, uint count, uint features) {
  for (uint i = 0; i < count; i++) b.order[i] = i;
  PassingRays passing{b, s, params, features};
  for (uint going = count; going > 0;) {
    trace_all(s, passing, going, !(features & FEATURE_TRANSPARENT));
    uint left = 0;
    for (uint i = 0; i < going; i++) {
      b.order[left] = b.order[i];
      left += b.shadows[b.order[i]].going != 0;
    }
    going = left;
  }
}

static void connect_batch(Batch &b, Scene s, Params params, Group g, uint features) {
  Columns columns = b.columns();
  uint count = 0;
  for (uint i = g.first; i < g.end; i++) {
    b.key[count] = i;
    count += !is_dark(make_real3(b.cr[i], b.cg[i], b.cb[i]));
  }
  b.shadow += count;
  ShadowRays rays{b, columns, params};
  if (!(features & FEATURE_TRANSPARENT)) {
    trace_all(s, rays, count, 1);
    return;
  }
  for (uint i = 0; i < count; i++) {
    Path p = path_at(columns, b.key[i]);
    Ray ray = light_ray(b, columns, b.key[i]);
    b.shadows[i] = make_shadow(ray, uint_of(path_passed(p)), p.bounces);
    if (features & FEATURE_VOLUME) b.shadow_volumes[i] = volumes_from(b, s, g, p, b.key[i], ray);
  }
  trace_shadows(b, s, params, count, features);
  for (uint i = 0; i < count; i++) {
    uint at = b.key[i];
    add_light(b, params, at, behind_shadow(load_brought(b, params, at), b.shadows[i]), FROM_LIGHT);
    b.limits[LIMITS - 1] += uint64_t(b.shadows[i].limited);
  }
}

}  // namespace ISOPHOTE_VARIANT
}  // namespace isophote
