"""Each operation on values that reads numbers only: the same bits in OpenCL as in C++, whatever the numbers are."""

import numpy as np
import pytest

from bench.parity import differing_floats, full_frame, opened, render_in_parts
from isophote.film import COMBINED_PLANES
from isophote.settings import Settings
from isophote.values import ARITHMETIC, SOURCES, minimum, operations
from tests.parity.test_devices import pocl
from tests.scenes import Builder, program, quad, ready
from tests.unit.test_values import position

FAMILIES = sorted({each.number // 32 for name, each in operations().items() if name not in SOURCES} - {0})
SIZE = 12  # pixels of an operation's square


def inputs_of(count: int, number: int) -> list:
    """Numbers that differ over the plane: some near 1, some negative, the first ones also far away."""
    x, y, _ = position()
    near = [x * (0.3 + 0.1 * k) + y * (0.7 - 0.2 * k) + 0.37 * (k + number) for k in range(count)]
    return [each * 1e6 for each in near[:1]] + near[1:] if number == 4 else near


def scene_of(family: int):
    """A square for each operation and for each of a few numbers of its steps."""
    names = [name for name, each in operations().items() if each.number // 32 == family and name not in SOURCES]
    builder = Builder(size=(SIZE * 5, SIZE * len(names)))
    builder.look((2.5, 0.5 * len(names), 3), (2.5, 0.5 * len(names), 0), tangent=2.5, orthographic=True, up=(0, 1, 0))
    for row, name in enumerate(names):
        for number in range(5):
            out = ARITHMETIC.call(name, inputs_of(operations()[name].inputs, number), repeat=4, number=float(number))
            builder.add(quad((number + 0.5, row + 0.5, 0), (0.5, 0, 0), (0, 0.5, 0)),
                        program(("emission", [minimum(out[k % len(out)], 1e3) for k in range(3)])))
    return builder.make()


@pytest.mark.parametrize("family", FAMILIES)
def test_opencl_has_the_same_bits(family):
    scene = scene_of(family)
    prepared, settings = ready(scene), Settings(samples=2)
    films = []
    for device in ("openmp", pocl()):
        holder = opened(device, settings, prepared)
        films.append(render_in_parts(holder, full_frame(scene), settings))
        holder.close()
    assert not any(differing_floats(*(film.sum(plane) for film in films)) for plane in range(COMBINED_PLANES))
    assert len(np.unique(films[0].sum(0))) > 100
