#define ISOPHOTE_REFERENCE
#define REGISTER_STRIDE 1u
#include "fold_value.h"

#include <algorithm>

#include "../kernels/values/program.h"

namespace isophote {

void fold_value(int op, const double *inputs, unsigned inputs_count, unsigned repeat, float number, double *outputs,
                unsigned outputs_count) {
  double registers[MOST_REGISTERS] = {};
  ValueStep step{};
  step.op = op;
  step.to = STEP_INPUTS;
  step.repeat = repeat;
  step.number = number;
  for (unsigned k = 0; k < inputs_count; k++) step.from[k] = k;
  std::copy(inputs, inputs + inputs_count, registers);
  for (unsigned k = 0; k < repeat; k++) run_step(Scene{}, step, Point{}, registers, k);
  std::copy(registers + STEP_INPUTS, registers + STEP_INPUTS + outputs_count, outputs);
}

}  // namespace isophote
