#define REGISTER_STRIDE 1u
#include "emission.h"

#include <vector>

#include "../kernels/shine.h"
#include "../kernels/volume.h"
#include "host_scene.h"

namespace isophote {

/* Three numbers each of n, in parallel: what `emitted` gives for the k-th with registers of its thread. */
template <typename Emitted>
static void evaluate_each(long n, int threads, float *radiance, const Emitted &emitted) {
#pragma omp parallel num_threads(threads)
  {
    FlushGuard guard;
    std::vector<real> registers(MOST_REGISTERS);
#pragma omp for schedule(dynamic, 1024)
    for (long k = 0; k < n; k++) {
      real3 made = emitted(k, registers.data());
      radiance[3 * k] = made.x;
      radiance[3 * k + 1] = made.y;
      radiance[3 * k + 2] = made.z;
    }
  }
}

static real3 vector_at(const float *vectors, long k) {
  return make_real3(vectors[3 * k], vectors[3 * k + 1], vectors[3 * k + 2]);
}

void evaluate_emission(const void *const *scene, const unsigned *ids, const float *places, const float *directions, long n,
                       int threads, float *radiance) {
  Scene s = make_scene(scene, nullptr);
  evaluate_each(n, threads, radiance, [&](long k, real *registers) {
    Ray ray = ray_at(free_ray(zero3(), vector_at(directions, k), 0.0f, FAR_AWAY), 0.5f); /* the shutter's middle */
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
    compute_values(s, m, m.steps, at, ray, h, 0u, 0u, registers);
    return material_emission(m, registers);
  });
}

void evaluate_lamps(const void *const *scene, const unsigned *lamps, const float *origins, const float *directions, long n,
                    int threads, float *emission) {
  Scene s = make_scene(scene, nullptr);
  evaluate_each(n, threads, emission, [&](long k, real *registers) {
    Light l = s.lights[lamps[k]];
    Ray ray = free_ray(vector_at(origins, k), vector_at(directions, k), 0.0f, FAR_AWAY);
    real t = hit_lamp(l, ray, FAR_AWAY, 1, 0u, 0u).t;
    return lamp_emission(s, l, ray, t, 1u, 0u, registers);
  });
}

void evaluate_volumes(const void *const *scene, const unsigned *ids, const float *places, long n, int threads,
                      float *extinction) {
  Scene s = make_scene(scene, nullptr);
  evaluate_each(n, threads, extinction, [&](long k, real *registers) {
    Track track = track_of_path(Path{});
    Ray ray = free_ray(vector_at(places, k), make_real3(0.0f, 0.0f, 1.0f), 0.0f, FAR_AWAY);
    track.ray = ray_at(ray, real_of(hash_uint(uint(k)) & 255u) * (1.0f / 255.0f)); /* at all times of the shutter */
    Volumes v;
    v.count = 0u;
    enter_volume(&v, ids[2 * k + 1], ids[2 * k]);
    return extinction_at(s, &v, track, 0.0f, registers);
  });
}

}  // namespace isophote
