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
  X(int, volume_bounces)                                                                       \
  X(int, transparent_bounces)                                                                  \
  X(float, filter_width) /* pixels */                                                          \
  X(float, clamp_direct) /* sum of the three channels above which light is scaled; 0: off */   \
  X(float, clamp_indirect)                                                                     \
  X(int, cut_plane) /* the film's first plane of what clamping cuts off; 0: nothing is clamped */ \
  X(int, film_transparent)                                                                     \
  X(uint, groups) /* mask of PLANE_GROUPS, GROUPS_AOVS and GROUPS_LIGHT_GROUPS */                \
  X(int, named_planes) /* behind the groups': AOV outputs and light groups */                    \
  X(int, light_plane) /* first of them of a light group */                                       \
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

/* Planes of the film's sums: Combined's, then the groups of PLANE_GROUPS that the film has, AOV outputs, light groups,
 * then those of clamping. */
#define PLANE_COMBINED 0 /* red, green, blue, alpha of replicate 0, then of replicate 1 */
#define PLANE_INVALID 8  /* how many samples were no numbers and count as 0 */
#define PLANES_COMBINED 9
/* X(number, name, planes). Groups that only sample 0 makes come first (isophote/records.py reads this list), those of
 * light last. */
#define PLANE_GROUPS(X)           \
  X(0, depth, 1)                  \
  X(1, position, 3)               \
  X(2, object_index, 1)           \
  X(3, material_index, 1)         \
  X(4, normal, 3)                 \
  X(5, albedo, 3)                 \
  X(6, uv, 3)                     \
  X(7, mist, 1)                   \
  X(8, denoising_normal, 3)       \
  X(9, denoising_albedo, 3)       \
  X(10, denoising_depth, 1)       \
  X(11, diffuse_color, 3)         \
  X(12, glossy_color, 3)          \
  X(13, transmission_color, 3)    \
  X(14, diffuse_direct, 3)        \
  X(15, diffuse_indirect, 3)      \
  X(16, glossy_direct, 3)         \
  X(17, glossy_indirect, 3)       \
  X(18, transmission_direct, 3)   \
  X(19, transmission_indirect, 3) \
  X(20, emission, 3)              \
  X(21, environment, 3)
enum {
#define X(number, name, planes) GROUP_##name = number,
  PLANE_GROUPS(X)
#undef X
};
#define GROUPS_AOVS 0x80000000u
#define GROUPS_LIGHT_GROUPS 0x40000000u
#define GROUPS_OF_SAMPLE_0 4
/* Luminance cut from direct and from indirect light of replicate 0, then of 1. */
#define PLANES_CUT 4
enum { /* without those that are named */
#define X(number, name, planes) + planes
  MOST_PLANES = PLANES_COMBINED + PLANES_CUT PLANE_GROUPS(X)
#undef X
};
#define SHARE_COLUMNS 12u /* of a path where GROUPS_SPLIT are told apart (passes.h) */
#define GUIDE_COLUMNS 4u  /* and where denoisers are guided */
#define LIMITS 6 /* bounce limits of Params, in their order: all, diffuse, glossy, transmission, volume, transparent */

#define DEPTH_NOTHING REAL(1e10) /* as Cycles writes where the camera sees nothing */

/* The film's groups: code that is compiled for one film knows them. */
#ifdef GROUPS_USED
FN uint film_groups(Params p) { return GROUPS_USED; }
#else
FN uint film_groups(Params p) { return p.groups; }
#endif
FN int has_group(uint groups, uint group) { return (groups >> group & 1u) != 0u; }

/* First plane of a group, or where it would be. */
FN uint plane_of(uint groups, uint group) {
  uint at = PLANES_COMBINED;
#define X(number, name, planes) at += number < group ? (groups >> number & 1u) * planes : 0u;
  PLANE_GROUPS(X)
#undef X
  return at;
}
/* The plane behind those of all groups. */
FN uint planes_end(uint groups) { return plane_of(groups, 32u); }

/* Planes that an item adds to. */
FN uint film_planes(Params p) { return planes_end(film_groups(p)) + uint_of(p.named_planes) + (p.cut_plane ? PLANES_CUT : 0u); }

#endif
