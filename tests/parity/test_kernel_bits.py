"""Closures and elementary functions give the same bits through OpenCL and through every C++ compiler."""

import shutil

import numpy as np
import pytest

from isophote.materials import OPERATIONS
from tests.bsdf_cases import METAL, Case, random_directions, unit
from tests.kernel_lib import CLOSURES, FUNCTIONS, CppKernels, OpenclKernels, instruction

COUNT = 1 << 17
PARAMS = {
    "roughness": lambda rng: rng.choice([0.0, 1e-3, 0.004, 0.02, 0.2, 0.6, 1.0]),
    "ior": lambda rng: rng.choice([1.0, 1.0001, 1.02, 1.45, 2.4, 10.0]),
    "multiscatter": lambda rng: rng.integers(2),
}
NATIVE = ("-O3", "-march=native", "-fopenmp-simd")
VECTOR = (*NATIVE, "-mprefer-vector-width=512", "-Werror=pass-failed")


@pytest.fixture(scope="module", params=[("clang++-19", VECTOR), ("clang++-16", NATIVE), ("g++", ("-O2",)),
                                        ("g++", NATIVE), "opencl"], ids=str)
def other(request):
    if request.param == "opencl":
        pytest.importorskip("pyopencl")
        try:
            return OpenclKernels()
        except LookupError as error:
            pytest.skip(str(error))
    compiler, flags = request.param
    if not shutil.which(compiler):
        pytest.skip(f"no {compiler}")
    return CppKernels(compiler=compiler, flags=flags)


@pytest.fixture(scope="module")
def plain():
    return CppKernels(flags=("-O2",))


def same_bits(a, b) -> bool:
    return np.array_equal(np.ascontiguousarray(a).view(np.uint32), np.ascontiguousarray(b).view(np.uint32))


def random_case(rng, closure: str, names) -> Case:
    values = {name: float(PARAMS[kind](rng)) if (kind := name.split("_")[0]) in PARAMS
              else METAL.get(name, float(rng.random())) for name in names}
    return Case(closure, values, int(rng.integers(2)))


@pytest.mark.parametrize("closure", [*CLOSURES, *(name for name in OPERATIONS if name.startswith("layer_"))])
def test_closures(plain, other, closure):
    rng = np.random.default_rng(41)
    for _ in range(6):
        case = random_case(rng, closure, OPERATIONS[closure][1])
        c, back = case.instruction, case.backfacing
        wo = unit(random_directions(rng, COUNT).astype(np.float32))
        assert same_bits(plain.albedo(c, wo, back), other.albedo(c, wo, back)), str(case)
        if closure.startswith("layer_"):
            continue
        u = rng.random((COUNT, 3), np.float32)
        sampled, also = plain.sample(c, wo, u, back), other.sample(c, wo, u, back)
        for mine, others in zip(sampled, also, strict=True):
            assert same_bits(mine, others), str(case)
        for wi in (sampled[0], unit(random_directions(rng, COUNT, lower=True).astype(np.float32))):
            for mine, others in zip(plain.eval(c, wo, wi, back), other.eval(c, wo, wi, back), strict=True):
                assert same_bits(mine, others), str(case)


@pytest.mark.parametrize("function", FUNCTIONS)
def test_functions(plain, other, function):
    rng = np.random.default_rng(43)
    x = (rng.normal(size=1 << 20) * 10.0 ** rng.uniform(-6, 3, 1 << 20)).astype(np.float32)
    y = rng.normal(size=1 << 20).astype(np.float32)
    assert same_bits(plain.function(function, x, y), other.function(function, x, y))


def test_instruction_has_the_layout_of_the_kernels():
    assert instruction("diffuse").dtype.itemsize == 64
