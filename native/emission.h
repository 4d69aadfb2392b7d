/* What materials emit at points of triangles and in directions of the world, for choosing lights; and how dense volumes
 * are. */
#pragma once

namespace isophote {

/* n places: (instance, primitive) and the weights (u, v) of the second and third corner, or NONE and a direction of the
 * world; `directions` are those of rays that meet them. Radiances, three each, in strict arithmetic, whatever the
 * precision of the render: what follows from them is the same on all machines. */
void evaluate_emission(const void *const *scene, const unsigned *ids, const float *places, const float *directions, long n,
                       int threads, float *radiance);

/* n rays towards lamps, by their numbers; what their materials emit to whoever looks along these. */
void evaluate_lamps(const void *const *scene, const unsigned *lamps, const float *origins, const float *directions, long n,
                    int threads, float *emission);

/* n points: (material of a volume, what encloses it as kernels/volume.h counts) and places; extinctions, three each. */
void evaluate_volumes(const void *const *scene, const unsigned *ids, const float *places, long n, int threads,
                      float *extinction);

}  // namespace isophote
