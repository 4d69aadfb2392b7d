"""Kernel functions that no film shows on their own, over arrays: a body of kernel code compiled for each device."""

from __future__ import annotations

import ctypes

import numpy as np

from tests.kernel_lib import ROOT, compiled, source_digest

# The body reads in[k] and writes out[k] of one element.
CPP = """#include "{header}"
extern "C" void probe(int n, int inputs, int outputs, const real *all_in, real *all_out) {{
  for (int i = 0; i < n; i++) {{
    const real *in = all_in + i * inputs;
    real *out = all_out + i * outputs;
    {body}
  }}
}}
"""
CL = """#include "{header}"
__kernel void probe(int inputs, int outputs, __global const float *all_in, __global float *all_out) {{
  __global const float *in = all_in + get_global_id(0) * inputs;
  __global float *out = all_out + get_global_id(0) * outputs;
  {body}
}}
"""


def run_cpp(header: str, body: str, values: np.ndarray, outputs: int, reference: bool = False) -> np.ndarray:
    """(n, outputs) of (n, inputs); float32, or float64 in the reference build."""
    text = CPP.format(header=header, body=body)
    library = compiled(text, ("-O2", *(["-DISOPHOTE_REFERENCE"] if reference else [])))
    real = np.float64 if reference else np.float32
    made, given = np.empty((len(values), outputs), real), np.ascontiguousarray(values, real)
    library.probe(len(values), given.shape[1], outputs, *(
        array.ctypes.data_as(ctypes.c_void_p) for array in (given, made)))
    return made


def run_opencl(header: str, body: str, values: np.ndarray, outputs: int) -> np.ndarray:
    """The same on PoCL. Raises LookupError where there is none."""
    import pyopencl as cl

    from tests.kernel_lib import OpenclKernels

    device = OpenclKernels.first_device()
    context = cl.Context([device])
    queue, flags = cl.CommandQueue(context), cl.mem_flags
    options = ["-cl-std=CL1.2", f"-I{ROOT / 'kernels'}", "-cl-fp32-correctly-rounded-divide-sqrt",
               f"-DSOURCES={source_digest()}"]
    program = cl.Program(context, CL.format(header=header, body=body)).build(options=options)
    made, given = np.empty((len(values), outputs), np.float32), np.ascontiguousarray(values, np.float32)
    source = cl.Buffer(context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=given)
    target = cl.Buffer(context, flags.WRITE_ONLY, made.nbytes)
    shape = np.int32(given.shape[1]), np.int32(outputs)
    cl.Kernel(program, "probe")(queue, (len(values),), None, *shape, source, target)
    cl.enqueue_copy(queue, made, target)
    return made
