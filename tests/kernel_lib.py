"""The kernels' functions over numpy arrays, compiled by the first C++ compiler found or through OpenCL.

`CppKernels` and `OpenclKernels` have the same methods. Arrays are float32, or float64 in the reference
build; directions have shape (n, 3), random numbers (n, 3) = (choice, u.x, u.y).
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np

from isophote.materials import OF_VOLUMES, OPERATIONS, PARAMS, make_instruction
from isophote.prepare import loaded_albedo_tables
from isophote.values import operations

ROOT = Path(__file__).parents[1]
PROBES = ROOT / "tests" / "native"
BUILD = ROOT / "build" / "test_kernels"
STRICT = ("-std=c++20", "-shared", "-fPIC", "-ffp-contract=off", "-fno-math-errno", "-Wall", "-Wno-unknown-pragmas",
          "-Wdouble-promotion", "-Werror")
FUNCTIONS = ("sin", "cos", "exp", "log", "acos", "atan2", "pow", "log1p", "expm1", "asin", "sinh", "cosh", "tanh",
             "wide_sin", "wide_cos", "modulo")
CLOSURES = tuple(name for name in OPERATIONS
                 if name not in ("emission", *OF_VOLUMES) and not name.startswith("layer_"))
INSTRUCTION = np.dtype([("op", "i4"), ("flags", "u4"), ("weight", "f4", 3), ("params", "f4", PARAMS)])


def instruction(operation: str, **params) -> np.ndarray:
    """One Instruction record of weight 1."""
    op, weight, values = make_instruction(operation, (1, 1, 1), **params)[:3]
    return np.array([(op, 0, weight, values + [0.0] * (PARAMS - len(values)))], INSTRUCTION)


def source_digest() -> str:
    """Changes whenever a header of the kernels or a probe does."""
    files = sorted([*(ROOT / "kernels").rglob("*.h"), *PROBES.glob("*_probe.*")])
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()[:16]


def find_compiler(names=("clang++-19", "clang++", "clang++-16", "g++", "c++")) -> str | None:
    return next((name for name in names if shutil.which(name)), None)


def compiled(source: str, flags: tuple[str, ...] = ("-O2",), compiler: str | None = None) -> ctypes.CDLL:
    """C++ that may include the kernels' headers and the probes, compiled once for these flags and sources."""
    compiler = compiler or find_compiler()
    command = [compiler, *STRICT, *flags, f"-I{ROOT / 'kernels'}", f"-I{PROBES}", "-x", "c++", "-"]
    key = hashlib.sha256(repr((command, source, source_digest())).encode()).hexdigest()[:16]
    library = BUILD / f"{key}.so"
    if not library.exists():
        BUILD.mkdir(parents=True, exist_ok=True)
        partial = library.with_suffix(f".{os.getpid()}.partial")
        subprocess.run([*command, "-o", str(partial)], input=source, text=True, check=True)
        partial.replace(library)  # tests run side by side
    return ctypes.CDLL(str(library))


class CppKernels:
    """`flags` are added to strict floating point; reference=True computes in double."""

    def __init__(self, reference: bool = False, compiler: str | None = None, flags: tuple[str, ...] = ("-O2",)):
        if reference:
            flags = (*flags, "-DISOPHOTE_REFERENCE")
        self.library = compiled('#include "bsdf_probe.cpp"', flags, compiler)
        self.real = np.float64 if reference else np.float32
        assert self.library.probe_real_size() == np.dtype(self.real).itemsize
        self.tables = loaded_albedo_tables()

    def _in(self, array) -> np.ndarray:
        return np.ascontiguousarray(array, self.real)

    def _call(self, name, *arguments):
        """Arrays by pointer, numbers as int; a local name keeps every array alive during the call."""
        getattr(self.library, name)(*[a.ctypes.data_as(ctypes.c_void_p) if isinstance(a, np.ndarray)
                                      else ctypes.c_int(a) for a in arguments])

    def eval(self, c, wo, wi, backfacing=0):
        """(f (n, 3), pdf (n,))."""
        wo, wi = self._in(wo), self._in(wi)
        f, pdf = np.empty_like(wo), np.empty(len(wo), self.real)
        self._call("probe_eval", c, backfacing, self.tables, len(wo), wo, wi, f, pdf)
        return f, pdf

    def sample(self, c, wo, u, backfacing=0):
        """(wi (n, 3), f (n, 3), flags (n, 3): delta, label, valid)."""
        wo, u = self._in(wo), self._in(u)
        wi, f, flags = np.empty_like(wo), np.empty_like(wo), np.empty(wo.shape, np.int32)
        self._call("probe_sample", c, backfacing, self.tables, len(wo), wo, u, wi, f, flags)
        return wi, f, flags

    def albedo(self, c, wo, backfacing=0):
        """(n, 3): albedo of a closure, or what a layer lets pass."""
        wo = self._in(wo)
        albedo = np.empty_like(wo)
        self._call("probe_albedo", c, backfacing, self.tables, len(wo), wo, albedo)
        return albedo

    def function(self, name, x, y=0.0):
        """One of FUNCTIONS, elementwise."""
        x, y = (self._in(a) for a in np.broadcast_arrays(x, y))
        out = np.empty_like(x)
        self._call("probe_function", FUNCTIONS.index(name), x.size, x, y, out)
        return out


class ValueKernels:
    """The operations on values of kernels/values, in float32."""

    def __init__(self):
        self.library = compiled('#include "value_probe.cpp"')

    def run(self, name: str, inputs, number: float = 0.0, tables=(0.0,)) -> np.ndarray:
        """Outputs (n, outputs) of an operation for inputs (n, inputs); a table begins at tables[0]."""
        operation = operations()[name]
        inputs = np.ascontiguousarray(inputs, np.float32).reshape(-1, operation.inputs)
        out = np.empty((len(inputs), operation.outputs), np.float32)
        arrays = [np.float32([number]), np.ascontiguousarray(tables, np.float32), inputs, out]
        self.library.probe_value(operation.number, len(inputs), operation.inputs, operation.outputs,
                                 *(a.ctypes.data_as(ctypes.c_void_p) for a in arrays))
        return out


class OpenclKernels:
    """The same through the first device of a platform; raises LookupError where there is none."""

    real = np.float32

    def __init__(self, platform: str = "Portable Computing Language"):
        import pyopencl as cl
        device = self.first_device(platform)
        self.cl, self.context = cl, cl.Context([device])
        self.queue = cl.CommandQueue(self.context)
        rounded = device.single_fp_config & cl.device_fp_config.CORRECTLY_ROUNDED_DIVIDE_SQRT
        options = ["-cl-std=CL1.2", f"-I{PROBES}", f"-DSOURCES={source_digest()}"]  # the digest defeats driver caches
        options += ["-cl-fp32-correctly-rounded-divide-sqrt"] if rounded else []
        self.program = cl.Program(self.context, (PROBES / "bsdf_probe.cl").read_text()).build(options=options)
        self.tables = loaded_albedo_tables()

    @staticmethod
    def first_device(platform: str = "Portable Computing Language"):
        import pyopencl as cl
        devices = [d for p in cl.get_platforms() if p.name == platform for d in p.get_devices()]
        if not devices:
            raise LookupError(f"no OpenCL platform {platform!r}")
        return devices[0]

    def _call(self, name, n, *arguments):
        """Numbers and input arrays first; arrays of `outputs` (shape, dtype) are made here and returned."""
        flags = self.cl.mem_flags
        outputs, passed = [], []
        for a in arguments:
            if isinstance(a, tuple):
                host = np.empty(*a)
                outputs.append((host, self.cl.Buffer(self.context, flags.WRITE_ONLY, host.nbytes)))
                passed.append(outputs[-1][1])
            elif isinstance(a, np.ndarray):
                passed.append(self.cl.Buffer(self.context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=a))
            else:
                passed.append(np.int32(a))
        self.cl.Kernel(self.program, name)(self.queue, (n,), None, *passed)
        for host, buffer in outputs:
            self.cl.enqueue_copy(self.queue, host, buffer)
        return [host for host, _ in outputs]

    def _in(self, array):
        return np.ascontiguousarray(array, np.float32)

    def eval(self, c, wo, wi, backfacing=0):
        wo, wi = self._in(wo), self._in(wi)
        return self._call("probe_eval", len(wo), c, backfacing, self.tables, wo, wi,
                          (wo.shape, np.float32), (len(wo), np.float32))

    def sample(self, c, wo, u, backfacing=0):
        wo, u = self._in(wo), self._in(u)
        return self._call("probe_sample", len(wo), c, backfacing, self.tables, wo, u,
                          (wo.shape, np.float32), (wo.shape, np.float32), (wo.shape, np.int32))

    def albedo(self, c, wo, backfacing=0):
        wo = self._in(wo)
        return self._call("probe_albedo", len(wo), c, backfacing, self.tables, wo, (wo.shape, np.float32))[0]

    def function(self, name, x, y=0.0):
        x, y = (self._in(a) for a in np.broadcast_arrays(x, y))
        return self._call("probe_function", x.size, FUNCTIONS.index(name), x, y, (x.shape, np.float32))[0]
