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
  X(uint, groups) /* mask of PLANE_GROUPS, and of GROUPS_ that are none of them */               \
  X(int, named_planes) /* behind the groups': AOV outputs and light groups */                    \
  X(int, light_plane) /* first of them of a light group */                                       \
  X(uint, matte_rows) /* of the table of mattes in the film's last planes (mattes.h) */           \
  X(int, catching) /* CATCHING_ number: whether shadows are caught, and how often paths have begun (shadow_catcher.h) */ \
  X(int, listed) /* 1: `width` pixels of a list in one row, instead of a region's */

typedef struct {
#define X(type, name) type name;
  PARAMS(X)
#undef X
} Params;

#define CATCHING_NONE 0
#define CATCHING_FIRST 1
#define CATCHING_ALONE 2 /* for the second time, to see catchers alone */

/* A pixel of a list: where it lies in the frame, and the sample from which the item's count. */
typedef struct {
  int x, y;
  uint first;
} ListedPixel;

/* Planes of the film's sums: Combined's, then the groups of PLANE_GROUPS that the film has, AOV outputs, light groups,
 * those of clamping, then a table of mattes. */
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
  X(7, vector, 5)                 \
  X(8, mist, 1)                   \
  X(9, denoising_normal, 3)       \
  X(10, denoising_albedo, 3)      \
  X(11, denoising_depth, 1)       \
  X(12, ambient_occlusion, 3)     \
  X(13, diffuse_color, 3)         \
  X(14, glossy_color, 3)          \
  X(15, transmission_color, 3)    \
  X(16, diffuse_direct, 3)        \
  X(17, diffuse_indirect, 3)      \
  X(18, glossy_direct, 3)         \
  X(19, glossy_indirect, 3)       \
  X(20, transmission_direct, 3)   \
  X(21, transmission_indirect, 3) \
  X(22, emission, 3)              \
  X(23, environment, 3)           \
  X(24, shadow_catcher, 8) /* matte and what it lacks of alpha, catchers alone, samples that have met one */
enum {
#define X(number, name, planes) GROUP_##name = number,
  PLANE_GROUPS(X)
#undef X
};
#define GROUPS_AOVS 0x80000000u
#define GROUPS_LIGHT_GROUPS 0x40000000u
#define GROUPS_MATTE_OBJECT 0x08000000u /* kinds of mattes (mattes.h) */
#define GROUPS_MATTE_MATERIAL 0x10000000u
#define GROUPS_MATTE_ASSET 0x20000000u
#define GROUPS_MATTES 0x38000000u
#define GROUPS_OF_SAMPLE_0 4
/* Whether code is compiled for films with the Vector pass (its four numbers, and how many samples there were of it), and
 * for those with Ambient Occlusion. */
#ifdef GROUPS_USED
#define VECTORS_USED (GROUPS_USED >> 7 & 1u)
#define OCCLUSION_USED (GROUPS_USED >> 12 & 1u)
#else
#define VECTORS_USED 1
#define OCCLUSION_USED 1
#endif
/* Luminance cut from direct and from indirect light of replicate 0, then of 1. */
#define PLANES_CUT 4
enum { /* without those that are named */
#define X(number, name, planes) + planes
  MOST_PLANES = PLANES_COMBINED + PLANES_CUT PLANE_GROUPS(X)
#undef X
};
#define SHARE_COLUMNS 12u /* of a path where GROUPS_SPLIT are told apart (passes.h) */
#define GUIDE_COLUMNS 4u  /* and where denoisers are guided */
#define MATTE_RECORDS 8u  /* rows of a path's table of mattes */
#define MATTE_UNITS 16384 /* of a matte's weight in the film, to 1 */
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

/* Kinds of mattes that are told apart. */
FN uint matte_kinds(uint groups) {
  return ((groups & GROUPS_MATTE_OBJECT) ? 1u : 0u) + ((groups & GROUPS_MATTE_MATERIAL) ? 1u : 0u) +
         ((groups & GROUPS_MATTE_ASSET) ? 1u : 0u);
}
/* Numbers of a table of so many rows; 0 where there are no mattes. */
FN uint matte_numbers(uint groups, uint rows) { return (groups & GROUPS_MATTES) ? rows * (1u + matte_kinds(groups)) + 1u : 0u; }

/* Planes that an item adds to, and the first of mattes among them. */
FN uint first_matte_plane(Params p) {
  return planes_end(film_groups(p)) + uint_of(p.named_planes) + (p.cut_plane ? PLANES_CUT : 0u);
}
FN uint film_planes(Params p) { return first_matte_plane(p) + matte_numbers(film_groups(p), p.matte_rows); }

#endif
