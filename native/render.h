/* The interface between the binding and the OpenMP loops, which are compiled once for each variant
 * (precision and instruction set). */
#pragma once
#include <atomic>
#include <cstdint>

#include "wide_tree.h"

namespace isophote {

/* scene: one pointer for each entry of SCENE_BUFFERS, in its order; tree: made of them. params: a Params
 * and its listed pixels. sums: planes of
 * width x height floats (kernels/params.h), to which samples are added in their order. rays: paths' rays and
 * shadow rays, to which those traced are added; limits: paths that each of the LIMITS has ended, likewise.
 * Returns false where it was cancelled; sums then hold no complete result. */
using RenderFunction = bool (*)(const void *const *scene, const WideTree *tree, const void *params, int threads,
                                float *sums, uint64_t *rays, uint64_t *limits, const std::atomic<int> *cancelled);

/* Closest hits (any = 0) or occlusion (any = 1) of n rays, for tests and benchmarks, in the wide tree or where there
 * is none in the BVH2; packets != 0: sixteen neighbours at a time where they go much the same way. rays: n x 8 floats,
 * origin, direction, t_min, t_max. hits: n x 3 floats t, u, v; ids: n x 2,
 * instance and primitive. */
using TraceFunction = void (*)(const void *const *scene, const WideTree *tree, const float *rays, long n, int any,
                               int threads, int packets, float *hits, unsigned *ids);

struct Variant {
  const char *name;
  const char *precision; /* strict, fast, reference */
  int level;             /* needs x86-64-v<level>; 0: nothing beyond the baseline */
  RenderFunction render;
  TraceFunction trace;
  size_t (*batch_bytes)(); /* of the paths of one thread */
};

}  // namespace isophote
