"""A scene whose materials compute with every operation on numbers, vectors, colours, tables and spaces."""

import numpy as np

from isophote.scene import Scene
from isophote.values import ARITHMETIC, Value, add, call1, multiply, operations
from tests.scenes import RECTANGLE, Builder, look_at, place, program, quad

FAMILIES = (1, 2, 3)
TABLE = np.float32([0.1, 0.9, 0.3, 0.7])
LENGTH = dict(number=float(len(TABLE)))
LOOKUPS = {"table": LENGTH, "table_extended": LENGTH, "table_stepped": LENGTH, "to_object": dict(data=0),
           "from_object": dict(data=1), "to_camera": dict(data=2), "from_camera": dict(data=0)}  # read the scene
AT_ONCE = 6  # operations of a material


def conversions() -> Scene:
    b = Builder((24, 20))
    b.look((0, -1, 6), (0, 0, 0), 0.55)
    b.world = 0.3
    names = [name for name, each in operations().items() if each.number // 32 in FAMILIES] + list(LOOKUPS)
    groups = [names[k:k + AT_ONCE] for k in range(0, len(names), AT_ONCE)]
    columns = int(np.ceil(np.sqrt(len(groups))))
    half = 3.0 / columns
    shape = b.mesh(quad((0, 0, 0), (1, 0, 0), (0, 1, 0)))
    for k, group in enumerate(groups):
        tones = [squeezed(output) for name in group for output in outputs_of(name)]
        mean = sum(tones[1:], tones[0]) * (1.0 / len(tones))
        material = b.material(program(("diffuse", [mean, tones[0], tones[-1]]), ("emission", [tones[0], mean, mean])))
        corner = (half * (2 * (k % columns) + 1) - 3.0, half * (2 * (k // columns) + 1) - 3.0, 0.1 * (k % 3))
        b.instance(shape, material, matrix=place(corner, (half, -half, 1.0), 0.1 * k))
    b.lamp(RECTANGLE, 5.0, look_at((1, -3, 3), (0, 0, 0)), (0.4, 0.2))
    return b.make(value_tables=TABLE)


def outputs_of(name: str) -> list[Value]:
    """Of an operation whose inputs are different mixtures of the point's coordinates."""
    position = [Value(call1("position").call, k) for k in range(3)]
    inputs = [add(multiply(position[k % 3], 1.7 - 0.4 * k), 0.3 * k - 0.2) for k in range(operations()[name].inputs)]
    return list(ARITHMETIC.call(name, inputs, **LOOKUPS.get(name, {})))


def squeezed(x: Value) -> Value:
    return add(multiply(call1("tanh", x), 0.4), 0.5)
