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
  X(42, select, 3, 1)       \
  X(43, absolute, 1, 1)     \
  X(44, floor, 1, 1)        \
  X(45, truncate, 1, 1)     \
  X(46, modulo, 2, 1)       \
  X(47, wrap, 3, 1)         \
  X(48, pingpong, 2, 1)     \
  X(49, power, 2, 1)        \
  X(50, logarithm, 2, 1)    \
  X(51, sine, 1, 1)         \
  X(52, cosine, 1, 1)       \
  X(53, tangent, 1, 1)      \
  X(54, arcsine, 1, 1)      \
  X(55, arccosine, 1, 1)    \
  X(56, arctangent, 2, 1)   \
  X(57, sinh, 1, 1)         \
  X(58, cosh, 1, 1)         \
  X(59, tanh, 1, 1)         \
  X(60, exponent, 1, 1)     \
  X(61, compare, 3, 1)      \
  X(62, smooth_minimum, 3, 1) \
  X(63, clamp, 3, 1)

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
VALUE(absolute) { OUT(0) = fabs(IN(0)); }
VALUE(floor) { OUT(0) = floor(IN(0)); }
VALUE(truncate) {
  real x = IN(0), size = floor(fabs(x));
  OUT(0) = x < REAL(0.0) ? -size : size;
}
/* The rest of a division that rounds towards 0; 0 where the divisor is 0. */
VALUE(modulo) {
  real by = IN(1);
  int zero = by == REAL(0.0);
  OUT(0) = zero ? REAL(0.0) : modulo_real(IN(0), zero ? REAL(1.0) : by);
}
/* The first, moved by multiples of the range between the third and the second into it; the third where that is empty. */
VALUE(wrap) {
  real low = IN(2), range = IN(1) - low;
  int empty = range == REAL(0.0);
  real by = empty ? REAL(1.0) : range, x = IN(0);
  OUT(0) = empty ? low : x - by * floor((x - low) / by);
}
/* A wave of triangles between 0 and the second; 0 where that is 0. */
VALUE(pingpong) {
  real scale = IN(1);
  int flat = scale == REAL(0.0);
  real by = flat ? REAL(1.0) : scale, turn = (IN(0) - by) / (by * REAL(2.0));
  OUT(0) = flat ? REAL(0.0) : fabs((turn - floor(turn)) * by * REAL(2.0) - by);
}
/* Of negative numbers only whole powers, else 0. */
VALUE(power) {
  real x = IN(0), y = IN(1), half_y = y * REAL(0.5);
  real size = pow_real(fabs(x), y);
  int whole = floor(y) == y, odd = floor(half_y) != half_y;
  real of_negative = whole ? (odd ? -size : size) : REAL(0.0);
  OUT(0) = x < REAL(0.0) ? of_negative : size;
}
/* Of the first to the base of the second; 0 where either has no logarithm, or the base is 1. */
VALUE(logarithm) {
  real x = IN(0), base = IN(1);
  real below = log_real(base);
  int none = (x <= REAL(0.0)) | (base <= REAL(0.0)) | (below == REAL(0.0));
  OUT(0) = none ? REAL(0.0) : log_real(x) / (none ? REAL(1.0) : below);
}
VALUE(sine) { OUT(0) = wide_sin_cos(IN(0)).x; }
VALUE(cosine) { OUT(0) = wide_sin_cos(IN(0)).y; }
VALUE(tangent) {
  real2 both = wide_sin_cos(IN(0));
  OUT(0) = both.x / both.y;
}
VALUE(arcsine) { OUT(0) = asin_real(IN(0)); }
VALUE(arccosine) { OUT(0) = acos_real(IN(0)); }
/* The angle of the point (second, first). */
VALUE(arctangent) { OUT(0) = atan2_real(IN(0), IN(1)); }
VALUE(sinh) { OUT(0) = sinh_real(IN(0)); }
VALUE(cosh) { OUT(0) = cosh_real(IN(0)); }
VALUE(tanh) { OUT(0) = tanh_real(IN(0)); }
VALUE(exponent) { OUT(0) = exp_real(IN(0)); }
/* 1 where the first two differ by no more than the third, and never by no more than float32's epsilon. */
VALUE(compare) {
  real a = IN(0), b = IN(1), within = max_real(IN(2), REAL(1.1920928955078125e-7));
  OUT(0) = ((a == b) | (fabs(a - b) <= within)) ? REAL(1.0) : REAL(0.0);
}
/* The polynomial smooth minimum of degree 3 (Quilez 2013, "Smooth minimum"). */
VALUE(smooth_minimum) {
  real a = IN(0), b = IN(1), width = IN(2);
  int sharp = width == REAL(0.0);
  real h = max_real(width - fabs(a - b), REAL(0.0)) / (sharp ? REAL(1.0) : width);
  real lower = min_real(a, b);
  OUT(0) = sharp ? lower : lower - h * h * h * width * REAL(0.16666666666666666);
}
/* The first between the second and the third; the third where they are the wrong way round. */
VALUE(clamp) { OUT(0) = min_real(max_real(IN(0), IN(1)), IN(2)); }

#endif
