/* A work item as kernels see it: Params, and behind them its pixels where it has a list of them. What to render, never
 * what the scene is. */
#ifndef ISOPHOTE_PARAMS_H
#define ISOPHOTE_PARAMS_H
#include "portable.h"

/* Table that names, types and order are expanded from, here and in the binding. */
#define PARAMS(X)                                                                              \
  X(int, x0) /* lower left pixel of the region */                                              \
  X(int, y0)                                                                                   \
  X(int, width) /* of the region */                                                            \
  X(int, height)                                                                               \
  X(uint, first_sample)                                                                        \
  X(uint, samples)                                                                             \
  X(uint, seed)                                                                                \
  X(int, max_bounces) /* limits are one above the user's, so that 0 there means direct light */ \
  X(int, diffuse_bounces)                                                                      \
  X(int, glossy_bounces)                                                                       \
  X(int, transmission_bounces)                                                                 \
  X(int, transparent_bounces)                                                                  \
  X(float, filter_width) /* pixels */                                                          \
  X(float, clamp_direct) /* sum of the three channels above which light is scaled; 0: off */   \
  X(float, clamp_indirect)                                                                     \
  X(int, cut_plane) /* the film's first plane of what clamping cuts off; 0: nothing is clamped */ \
  X(int, film_transparent)                                                                     \
  X(int, aovs) /* 1: planes beyond combined are wanted */                                        \
  X(int, listed) /* 1: `width` pixels of a list in one row, instead of a region's */

typedef struct {
#define X(type, name) type name;
  PARAMS(X)
#undef X
} Params;

/* A pixel of a list: where it lies in the frame, and the sample from which the item's count. */
typedef struct {
  int x, y;
  uint first;
} ListedPixel;

/* Planes of the film's sums, in the order of isophote/film.py. */
#define PLANE_COMBINED 0 /* red, green, blue, alpha of replicate 0, then of replicate 1 */
#define PLANE_INVALID 8  /* how many samples were no numbers and count as 0 */
#define PLANE_DEPTH 9
#define PLANE_NORMAL 10
#define PLANE_ALBEDO 13
#define PLANE_POSITION 16
#define PLANES_COMBINED 9
#define PLANES_ALL 19
/* Behind them where light is clamped: luminance cut from direct and from indirect light of replicate 0, then of 1. */
#define PLANES_CUT 4
#define LIMITS 5 /* bounce limits of Params, in their order: all, diffuse, glossy, transmission, transparent */

#define DEPTH_NOTHING REAL(1e10) /* as Cycles writes where the camera sees nothing */

/* Planes that an item adds to. */
FN uint film_planes(Params p) {
  return p.cut_plane ? uint_of(p.cut_plane) + PLANES_CUT : p.aovs ? PLANES_ALL : PLANES_COMBINED;
}

#endif
