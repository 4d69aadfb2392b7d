#define REGISTER_STRIDE 1u
#include "emission.h"

#include <vector>

#include "../kernels/shine.h"
#include "host_scene.h"

namespace isophote {

void evaluate_emission(const void *const *scene, const unsigned *ids, const float *places, const float *directions, long n,
                       int threads, float *radiance) {
  Scene s = make_scene(scene, nullptr);
#pragma omp parallel num_threads(threads)
  {
    FlushGuard guard;
    std::vector<real> registers(MOST_REGISTERS);
#pragma omp for schedule(dynamic, 1024)
    for (long k = 0; k < n; k++) {
      Ray ray = free_ray(zero3(), make_real3(directions[3 * k], directions[3 * k + 1], directions[3 * k + 2]), 0.0f, FAR_AWAY);
      ray.kind = 0u;
      bool is_world = ids[2 * k] == NONE;
      Hit h = background_hit(FAR_AWAY);
      if (!is_world) {
        h.instance = ids[2 * k];
        h.primitive = ids[2 * k + 1];
        h.u = places[2 * k];
        h.v = places[2 * k + 1];
      }
      Surface at = is_world ? make_background(s, ray.direction) : make_surface(s, ray, h, s.world[0].features);
      Material m = s.materials[at.material];
      compute_values(s, m, m.steps, at, ray, h, 0u, 0u, registers.data());
      real3 made = material_emission(m, registers.data());
      radiance[3 * k] = made.x;
      radiance[3 * k + 1] = made.y;
      radiance[3 * k + 2] = made.z;
    }
  }
}

void evaluate_lamps(const void *const *scene, const unsigned *lamps, const float *origins, const float *directions, long n,
                    int threads, float *emission) {
  Scene s = make_scene(scene, nullptr);
#pragma omp parallel num_threads(threads)
  {
    FlushGuard guard;
    std::vector<real> registers(MOST_REGISTERS);
#pragma omp for schedule(dynamic, 1024)
    for (long k = 0; k < n; k++) {
      const float *o = origins + 3 * k, *d = directions + 3 * k;
      Light l = s.lights[lamps[k]];
      Ray ray = free_ray(make_real3(o[0], o[1], o[2]), make_real3(d[0], d[1], d[2]), 0.0f, FAR_AWAY);
      real t = hit_lamp(l, ray, FAR_AWAY, 1, 0u, 0u).t;
      real3 made = lamp_emission(s, l, ray, t, 1u, 0u, registers.data());
      emission[3 * k] = made.x;
      emission[3 * k + 1] = made.y;
      emission[3 * k + 2] = made.z;
    }
  }
}

}  // namespace isophote
