/* Arithmetic of vectors: what Blender's Vector Math, Vector Rotate and Mapping need beyond math.h, part by part. */
#ifndef ISOPHOTE_VALUES_VECTOR_MATH_H
#define ISOPHOTE_VALUES_VECTOR_MATH_H
#include "value.h"

/* X(number, name, inputs, outputs) */
#define VALUES_VECTOR_MATH(X) \
  X(64, dot, 6, 1)            \
  X(65, cross, 6, 3)          \
  X(66, length, 3, 1)         \
  X(67, normalize, 3, 3)      \
  X(68, refract, 7, 3)        \
  X(69, turn, 4, 2)           \
  X(70, rotate_about, 8, 3)

VALUE(dot) { OUT(0) = dot3(IN3(0), IN3(3)); }
VALUE(cross) { OUT3(0, cross3(IN3(0), IN3(3))) }
VALUE(length) {
  real3 v = IN3(0);
  OUT(0) = sqrt(dot3(v, v));
}
/* 0 stays 0. */
VALUE(normalize) {
  real3 v = IN3(0);
  real length = sqrt(dot3(v, v));
  OUT3(0, v * (REAL(1.0) / (length == REAL(0.0) ? REAL(1.0) : length)))
}
/* Snell's law for the first vector on a surface with the second, unit, as its normal; the last is the ratio of the
 * indices. 0 where all light is reflected. */
VALUE(refract) {
  real3 incident = IN3(0), normal = IN3(3);
  real ratio = IN(6), cosine = dot3(normal, incident);
  real square_of_other = REAL(1.0) - ratio * ratio * (REAL(1.0) - cosine * cosine);
  real3 bent = incident * ratio - normal * (ratio * cosine + safe_sqrt(square_of_other));
  OUT3(0, select3(square_of_other < REAL(0.0), zero3(), bent))
}
/* The plane's point (first, second) by the angle whose sine and cosine follow. */
VALUE(turn) {
  real x = IN(0), y = IN(1), sine = IN(2), cosine = IN(3);
  OUT(0) = cosine * x - sine * y;
  OUT(1) = sine * x + cosine * y;
}
/* The first vector about the second, unit, by the angle whose sine and cosine follow (Rodrigues). */
VALUE(rotate_about) {
  real3 v = IN3(0), axis = IN3(3);
  real sine = IN(6), cosine = IN(7);
  OUT3(0, v * cosine + cross3(axis, v) * sine + axis * (dot3(axis, v) * (REAL(1.0) - cosine)))
}

#endif
