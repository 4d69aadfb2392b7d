/* Which tracer the OpenMP loops use: the wide tree in float, the BVH2 of the kernels in double. Included
 * once a variant. */
#pragma once
#ifndef ISOPHOTE_REFERENCE
#include "few_triangles.h"
#endif
#include "../kernels/shadow_catcher.h"
#include "../kernels/shine.h"
#include "../kernels/tracking.h"
#include "wide_tree.h"

namespace isophote {
namespace ISOPHOTE_VARIANT {

/* How alike the rays are: any order, or neighbours that go much the same way; or that each is within one object. */
enum Rays { SCATTERED, COHERENT, INSIDE };

/* Traces the rays source.ray(0) to source.ray(count - 1) and gives their hits to source.store(number, hit). */
template <typename Source>
static void trace_all(Scene s, Source &source, uint count, int any, Rays kind = SCATTERED) {
#ifdef ISOPHOTE_REFERENCE
  for (uint i = 0; i < count; i++) source.store(i, trace(s, source.ray(i), any));
#else
  const WideTree &tree = *static_cast<const WideTree *>(s.accelerator);
  bool triangles_only = !(s.world[0].features & (FEATURE_INSTANCES | FEATURE_SPHERES));
  if (triangles_only && kind != INSIDE && tree.blocks.size() <= FEW_BLOCKS)
    trace_few(tree, source, count);
  else if (triangles_only && kind == COHERENT && !any)
    trace_packets(tree, s, source, count);
  else
    trace_wide(tree, s, source, count, any);
#endif
}

}  // namespace ISOPHOTE_VARIANT
}  // namespace isophote
