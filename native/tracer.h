/* Which tracer the OpenMP loops use: the wide tree in float, the BVH2 of the kernels in double. Included
 * before stages.h, once a variant. */
#pragma once
#ifdef ISOPHOTE_REFERENCE
#include "../kernels/bvh.h"
#else
#include "wide_trace.h"
#define TRACE(scene, ray, any) \
  isophote::ISOPHOTE_VARIANT::trace_wide(*static_cast<const isophote::WideTree *>((scene).accelerator), scene, ray, any)
#endif
#include "../kernels/stages.h"
