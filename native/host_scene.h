/* The scene's arrays as kernels take them, and the state of a thread that runs kernels. */
#pragma once
#if defined(__SSE__)
#include <immintrin.h>
#endif

#include "../kernels/scene_buffers.h"

namespace isophote {

/* Hosts set flush-to-zero in their threads; bits must not depend on it (MXCSR on x86). */
struct FlushGuard {
#if defined(__SSE__)
  unsigned before = _mm_getcsr();
  FlushGuard() { _mm_setcsr(before & ~0x8040u); }
  ~FlushGuard() { _mm_setcsr(before); }
#endif
};

/* From pointers in the order of scene_buffers.h. */
static Scene make_scene(const void *const *pointers, const void *tree) {
  Scene s;
  s.accelerator = tree;
  int k = 0;
#define X(type, name, comment) s.name = static_cast<const type *>(pointers[k++]);
  SCENE_BUFFERS(X)
#undef X
  return s;
}

}  // namespace isophote
