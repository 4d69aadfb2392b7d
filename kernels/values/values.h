/* THE list of operations on values, by family; isophote/values.py reads it from these headers.
 *
 * A number is 32 times its family's and the place in it, so that programs can be compiled with the families and
 * operations that a scene uses: bit k of VALUES_USED_n stands for number 32 n + k. */
#ifndef ISOPHOTE_VALUES_VALUES_H
#define ISOPHOTE_VALUES_VALUES_H
#include "attribute.h"
#include "hash.h"
#include "value.h"

#ifndef VALUES_USED_0
#define VALUES_USED_0 0xffffffffu
#define VALUES_USED_1 0xffffffffu
#define VALUES_USED_2 0xffffffffu
#define VALUES_USED_3 0xffffffffu
#define VALUES_USED_4 0xffffffffu
#define VALUES_USED_5 0xffffffffu
#define VALUES_USED_6 0xffffffffu
#define VALUES_USED_7 0xffffffffu
#endif

/* Headers that several families include stand above: opencl.py puts each into the program once, where it comes first. */
#if VALUES_USED_0
#include "source.h"
#else
#define VALUES_SOURCE(X)
#endif
#if VALUES_USED_1
#include "math.h"
#else
#define VALUES_MATH(X)
#endif
#if VALUES_USED_2
#include "vector_math.h"
#else
#define VALUES_VECTOR_MATH(X)
#endif
#if VALUES_USED_3
#include "colour.h"
#else
#define VALUES_COLOUR(X)
#endif
#if VALUES_USED_4
#include "noise.h"
#include "pattern.h"
#else
#define VALUES_NOISE(X)
#define VALUES_PATTERN(X)
#endif
#if VALUES_USED_5
#include "voronoi.h"
#else
#define VALUES_VORONOI(X)
#endif
#if VALUES_USED_6
#include "image.h"
#include "photometry.h"
#include "space.h"
#include "table.h"
#else
#define VALUES_IMAGE(X)
#define VALUES_PHOTOMETRY(X)
#define VALUES_SPACE(X)
#define VALUES_TABLE(X)
#endif
#if VALUES_USED_6 & 0xf00u /* other scenes with pictures have none of it */
#include "sky.h"
#else
#define VALUES_SKY(X)
#endif
#if VALUES_USED_7
#include "geometry.h"
#include "normals.h"
#else
#define VALUES_GEOMETRY(X)
#define VALUES_NORMALS(X)
#endif

/* X(number, name, inputs, outputs): value_NAME exists. */
#define VALUES(X) \
  VALUES_SOURCE(X) \
  VALUES_MATH(X) \
  VALUES_VECTOR_MATH(X) \
  VALUES_COLOUR(X) \
  VALUES_NOISE(X) \
  VALUES_PATTERN(X) \
  VALUES_VORONOI(X) \
  VALUES_IMAGE(X) \
  VALUES_SKY(X) \
  VALUES_PHOTOMETRY(X) \
  VALUES_SPACE(X) \
  VALUES_TABLE(X) \
  VALUES_GEOMETRY(X) \
  VALUES_NORMALS(X)

#define VALUES_USED(family) \
  ((family) == 0 ? VALUES_USED_0 : (family) == 1 ? VALUES_USED_1 : (family) == 2 ? VALUES_USED_2 : \
   (family) == 3 ? VALUES_USED_3 : (family) == 4 ? VALUES_USED_4 : (family) == 5 ? VALUES_USED_5 : \
   (family) == 6 ? VALUES_USED_6 : VALUES_USED_7)
#define IS_VALUE_USED(number) ((VALUES_USED((number) / 32) >> ((number) % 32)) & 1u)

#endif
