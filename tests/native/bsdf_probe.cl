/* The probes of bsdf_probe.cpp through OpenCL, with the switches that wavefront.cl uses. */
#include "bsdf_probe.h"

__kernel void probe_eval(__global const Instruction *instruction, int backfacing,
                         __global const float *tables, __global const float *wo,
                         __global const float *wi, __global float *f, __global float *pdf) {
  int i = get_global_id(0);
  Closure c = make_closure(*instruction);
  PROBE_EVAL(closure)
}

__kernel void probe_sample(__global const Instruction *instruction, int backfacing,
                           __global const float *tables, __global const float *wo,
                           __global const float *u, __global float *wi, __global float *f,
                           __global int *flags) {
  int i = get_global_id(0);
  Closure c = make_closure(*instruction);
  PROBE_SAMPLE(closure)
}

__kernel void probe_albedo(__global const Instruction *instruction, int backfacing,
                           __global const float *tables, __global const float *wo,
                           __global float *albedo) {
  int i = get_global_id(0);
  Closure c = make_closure(*instruction);
  real3 v = get3(wo, i);
#define X(number, name) | (c.op == number)
  int is_layer = 0 LAYERS(X);
#undef X
  put3(albedo, i, is_layer ? layer_closure(c, backfacing, tables, v, splat3(REAL(1.0)))
                           : albedo_closure(c, backfacing, tables, v));
}

__kernel void probe_function(int function, __global const float *xs, __global const float *ys,
                             __global float *out) {
  int i = get_global_id(0);
  float x = xs[i], y = ys[i];
  switch (function) {
#define X(number, name, value) \
  case number: out[i] = value; break;
    PROBE_FUNCTIONS(X)
#undef X
  }
}
