/* Arithmetic of one number: Blender's Math node, and what other nodes are made of. */
#ifndef ISOPHOTE_VALUES_MATH_H
#define ISOPHOTE_VALUES_MATH_H
#include "value.h"

/* X(number, name, inputs, outputs) */
#define VALUES_MATH(X)      \
  X(32, add, 2, 1)          \
  X(33, subtract, 2, 1)     \
  X(34, multiply, 2, 1)     \
  X(35, divide, 2, 1)       \
  X(36, minimum, 2, 1)      \
  X(37, maximum, 2, 1)      \
  X(38, square_root, 1, 1)  \
  X(39, mix, 3, 1)          \
  X(40, vector, 3, 3)       \
  X(41, less_than, 2, 1)    \
  X(42, select, 3, 1)

VALUE(add) { OUT(0) = IN(0) + IN(1); }
VALUE(subtract) { OUT(0) = IN(0) - IN(1); }
VALUE(multiply) { OUT(0) = IN(0) * IN(1); }
/* 0 where the divisor is 0. */
VALUE(divide) {
  real by = IN(1);
  int zero = by == REAL(0.0);
  OUT(0) = zero ? REAL(0.0) : IN(0) / (zero ? REAL(1.0) : by);
}
VALUE(minimum) { OUT(0) = min_real(IN(0), IN(1)); }
VALUE(maximum) { OUT(0) = max_real(IN(0), IN(1)); }
VALUE(square_root) { OUT(0) = safe_sqrt(IN(0)); }
/* From the first to the second by the third. */
VALUE(mix) {
  real t = IN(2);
  OUT(0) = IN(0) * (REAL(1.0) - t) + IN(1) * t;
}
VALUE(less_than) { OUT(0) = IN(0) < IN(1) ? REAL(1.0) : REAL(0.0); }
/* The second where the first is not 0, else the third. */
VALUE(select) {
  real a = IN(1), b = IN(2);
  OUT(0) = IN(0) != REAL(0.0) ? a : b;
}
/* Three numbers in registers that follow each other. */
VALUE(vector) { OUT3(0, IN3(0)) }

#endif
