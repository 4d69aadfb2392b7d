// One operation on values over rows of inputs, for tests/kernel_lib.py: registers of one path, run after run.
#define REGISTER_STRIDE 1u
#include "../../kernels/values/program.h"

extern "C" {

int probe_real_size() { return sizeof(real); }

// Inputs (n, inputs) and outputs (n, outputs); `tables` are the scene's value_tables.
void probe_value(int op, int n, int inputs, int outputs, const float *number, const float *tables, const real *in,
                 real *out) {
  Scene scene{};
  scene.value_tables = tables;
  ValueStep step{};
  step.op = op;
  step.to = STEP_INPUTS;
  step.repeat = 1;
  step.number = *number;
  for (int k = 0; k < inputs; ++k) step.from[k] = k;
  real registers[MOST_REGISTERS] = {};
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < inputs; ++k) registers[k] = in[inputs * i + k];
    run_step(scene, step, Point{}, registers, 0);
    for (int k = 0; k < outputs; ++k) out[outputs * i + k] = registers[STEP_INPUTS + k];
  }
}
}
