/* Operations on values where all inputs are constants. */
#pragma once

namespace isophote {

/* Runs operation `op` of kernels/values/values.h `repeat` times in double; it must not read the scene. */
void fold_value(int op, const double *inputs, unsigned inputs_count, unsigned repeat, float number, double *outputs,
                unsigned outputs_count);

}  // namespace isophote
