/* THE list of closures. isophote/materials.py names the same operations with the same numbers. */
#ifndef ISOPHOTE_BSDF_BSDF_H
#define ISOPHOTE_BSDF_BSDF_H
#include "anisotropic.h"
#include "ashikhmin_shirley.h"
#include "beckmann.h"
#include "beckmann_glass.h"
#include "conductor.h"
#include "diffuse.h"
#include "film_glass.h"
#include "film_specular.h"
#include "glass.h"
#include "glossy.h"
#include "holdout.h"
#include "layer.h"
#include "metal.h"
#include "principled_glass.h"
#include "refraction.h"
#include "rough_diffuse.h"
#include "sheen.h"
#include "specular.h"
#include "subsurface.h"
#include "toon.h"
#include "translucent.h"
#include "transparent.h"
#include "velvet.h"

#define OP_EMISSION 0
#define OP_DIFFUSE 1
#define OP_GLOSSY 2
#define OP_REFRACTION 3
#define OP_GLASS 4
#define OP_TRANSPARENT 5
#define OP_METAL 6
#define OP_SPECULAR 7
#define OP_PRINCIPLED_GLASS 8
#define OP_LAYER_SPECULAR 9
#define OP_ROUGH_DIFFUSE 10
#define OP_TRANSLUCENT 11
#define OP_DIFFUSE_TOON 12
#define OP_GLOSSY_TOON 13
#define OP_SHEEN 14
#define OP_VELVET 15
#define OP_LAYER_SHEEN 16
#define OP_LAYER_ABSORPTION 17
#define OP_LAYER_RESET 18
#define OP_BECKMANN 19
#define OP_ASHIKHMIN_SHIRLEY 20
#define OP_CONDUCTOR 21
#define OP_ANISO_GLOSSY 22
#define OP_ANISO_METAL 23
#define OP_ANISO_SPECULAR 24
#define OP_ANISO_CONDUCTOR 25
#define OP_FILM_SPECULAR 26
#define OP_FILM_GLASS 27
#define OP_LAYER_FILM_SPECULAR 28
#define OP_BECKMANN_GLASS 29
#define OP_HOLDOUT 30
#define OP_SUBSURFACE 31
/* Of volumes (volume.h), whose programs hold no others. */
#define OP_EXTINCTION 64
#define OP_SCATTERING 65

/* X(number, name, class of its labels): eval_NAME, sample_NAME and albedo_NAME exist. */
#define CLOSURES(X)                                                    \
  X(OP_DIFFUSE, diffuse, LABEL_DIFFUSE)                                \
  X(OP_GLOSSY, glossy, LABEL_GLOSSY)                                   \
  X(OP_REFRACTION, refraction, LABEL_GLOSSY)                           \
  X(OP_GLASS, glass, LABEL_GLOSSY)                                     \
  X(OP_TRANSPARENT, transparent, LABEL_TRANSPARENT)                    \
  X(OP_METAL, metal, LABEL_GLOSSY)                                     \
  X(OP_SPECULAR, specular, LABEL_GLOSSY)                               \
  X(OP_PRINCIPLED_GLASS, principled_glass, LABEL_GLOSSY)               \
  X(OP_ROUGH_DIFFUSE, rough_diffuse, LABEL_DIFFUSE)                    \
  X(OP_TRANSLUCENT, translucent, LABEL_DIFFUSE)                        \
  X(OP_DIFFUSE_TOON, diffuse_toon, LABEL_DIFFUSE)                      \
  X(OP_GLOSSY_TOON, glossy_toon, LABEL_GLOSSY)                         \
  X(OP_SHEEN, sheen, LABEL_DIFFUSE)                                    \
  X(OP_VELVET, velvet, LABEL_DIFFUSE)                                  \
  X(OP_BECKMANN, beckmann, LABEL_GLOSSY)                               \
  X(OP_ASHIKHMIN_SHIRLEY, ashikhmin_shirley, LABEL_GLOSSY)             \
  X(OP_CONDUCTOR, conductor, LABEL_GLOSSY)                             \
  X(OP_ANISO_GLOSSY, aniso_glossy, LABEL_GLOSSY)                       \
  X(OP_ANISO_METAL, aniso_metal, LABEL_GLOSSY)                         \
  X(OP_ANISO_SPECULAR, aniso_specular, LABEL_GLOSSY)                   \
  X(OP_ANISO_CONDUCTOR, aniso_conductor, LABEL_GLOSSY)                 \
  X(OP_FILM_SPECULAR, film_specular, LABEL_GLOSSY)                     \
  X(OP_FILM_GLASS, film_glass, LABEL_GLOSSY)                           \
  X(OP_BECKMANN_GLASS, beckmann_glass, LABEL_GLOSSY)                   \
  X(OP_HOLDOUT, holdout, LABEL_GLOSSY)                                 \
  X(OP_SUBSURFACE, subsurface, LABEL_SUBSURFACE)

/* X(number, name): layer_NAME exists; makes the layer weight of what follows in the program. */
#define LAYERS(X)                          \
  X(OP_LAYER_SPECULAR, specular)           \
  X(OP_LAYER_SHEEN, sheen)                 \
  X(OP_LAYER_ABSORPTION, absorption)       \
  X(OP_LAYER_RESET, reset)                 \
  X(OP_LAYER_FILM_SPECULAR, film_specular)

/* X(number, name): transmitted_NAME exists, the part of albedo_NAME that goes through. */
#define TRANSMITTERS(X)                   \
  X(OP_REFRACTION, refraction)            \
  X(OP_GLASS, glass)                      \
  X(OP_PRINCIPLED_GLASS, principled_glass) \
  X(OP_FILM_GLASS, film_glass)            \
  X(OP_BECKMANN_GLASS, beckmann_glass)

/* Operations that the scene's programs hold, as bits: what is not used is not compiled (OpenCL). */
#ifndef CLOSURES_USED
#define CLOSURES_USED 0xffffffffu
#endif
#define IS_USED(number) ((CLOSURES_USED >> (number)) & 1u)

/* One switch for devices where each path may be at another closure. */
FN BsdfValue eval_closure(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 wi) {
  switch (c.op) {
#define X(number, name, labels) \
  case number: if (IS_USED(number)) return eval_##name(c, backfacing, tables, wo, wi); break;
    CLOSURES(X)
#undef X
    default: break;
  }
  return make_value(zero3(), REAL(0.0));
}

FN BsdfSample sample_closure(Closure c, int backfacing, GLOBAL const float *tables, real3 wo,
                             real u_choice, real2 u) {
  switch (c.op) {
#define X(number, name, labels) \
  case number: if (IS_USED(number)) return sample_##name(c, backfacing, tables, wo, u_choice, u); break;
    CLOSURES(X)
#undef X
    default: break;
  }
  return make_sample(zero3(), zero3(), 0, 0, 0);
}

FN real3 albedo_closure(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  switch (c.op) {
#define X(number, name, labels) \
  case number: if (IS_USED(number)) return albedo_##name(c, backfacing, tables, wo); break;
    CLOSURES(X)
#undef X
    default: break;
  }
  return zero3();
}

FN real3 transmitted_closure(Closure c, int backfacing, GLOBAL const float *tables, real3 wo) {
  switch (c.op) {
#define X(number, name) \
  case number: if (IS_USED(number)) return transmitted_##name(c, backfacing, tables, wo); break;
    TRANSMITTERS(X)
#undef X
    default: break;
  }
  return zero3();
}

FN real3 layer_closure(Closure c, int backfacing, GLOBAL const float *tables, real3 wo, real3 layer) {
  switch (c.op) {
#define X(number, name) \
  case number: if (IS_USED(number)) return layer_##name(c, backfacing, tables, wo, layer); break;
    LAYERS(X)
#undef X
    default: break;
  }
  return layer;
}

/* Product of a closure's roughnesses along and across: 0 of mirrors and of what is transparent, 1 of what is no
 * microfacet closure. */
FN real roughness_product(Closure c) {
  switch (c.op) {
    case OP_TRANSPARENT: return REAL(0.0);
    case OP_DIFFUSE:
    case OP_ROUGH_DIFFUSE:
    case OP_TRANSLUCENT:
    case OP_DIFFUSE_TOON:
    case OP_GLOSSY_TOON:
    case OP_SHEEN:
    case OP_VELVET:
    case OP_SUBSURFACE: return REAL(1.0);
    case OP_BECKMANN:
    case OP_ASHIKHMIN_SHIRLEY: return param(c, 0) * param(c, 1);
    case OP_ANISO_GLOSSY: return param(c, 0) * param(c, ANISO_GLOSSY_ROUGHNESS_Y);
    case OP_ANISO_METAL: return param(c, 0) * param(c, ANISO_METAL_ROUGHNESS_Y);
    case OP_ANISO_SPECULAR: return param(c, 0) * param(c, ANISO_SPECULAR_ROUGHNESS_Y);
    case OP_ANISO_CONDUCTOR: return param(c, 0) * param(c, ANISO_CONDUCTOR_ROUGHNESS_Y);
    case OP_FILM_SPECULAR: return param(c, FILM_SPECULAR_ROUGHNESS_X) * param(c, FILM_SPECULAR_ROUGHNESS_Y);
    default: return param(c, 0) * param(c, 0);
  }
}

#endif
