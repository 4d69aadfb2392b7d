"""Expressions and their programs: what is constant folds, registers hold what they should until it was read."""

import re

import numpy as np
import pytest

from isophote.material_program import make_material
from isophote.materials import make_instruction
from isophote.records import header, header_path, numbers
from isophote.values import (
    ARITHMETIC,
    ProgramTooLarge,
    Value,
    add,
    call1,
    clamp,
    compile_program,
    fold,
    mix,
    operation_of,
    operations,
    varies,
)
from tests.scenes import Builder, pixels, place, program, quad, render


def position() -> list[Value]:
    return [Value(call1("position").call, k) for k in range(3)]


def interpret(steps, point) -> np.ndarray:
    """Registers after the steps, each run by the kernels' own function on numbers; position is `point`."""
    registers = np.full(numbers()["MOST_REGISTERS"], np.nan)
    for op, to, read, repeat, _, number in steps:
        name = operation_of(op)
        given = tuple(registers[k] for k in read[:operations()[name].inputs])
        out = point if name == "position" else (number,) if name == "constant" else fold(name, given, repeat, number)
        registers[to:to + len(out)] = out
    return registers


def test_operations_that_ask_where_the_object_is_are_listed():
    """OBJECT_VALUES has all that call, themselves or through others, what tells it from its time."""
    folder = header_path("values")
    text = "".join(header(f"values/{path.name}") for path in sorted(folder.glob("*.h")))
    bodies = {}
    function = r"\n(?:FN [^(;]*?(?=\b\w+\()|VALUE\()(\w+)[^;{]*\{(.*?)(?=\n(?:FN|VALUE|#)|$)"
    for name, body in re.findall(function, text, re.S):
        bodies[name] = bodies.get(name, "") + body
    asking = {"vertex_at", *re.findall(r"\w+(?=\(Scene s, Point at, )", header("values/object_space.h"))}
    assert len(asking) == 8
    while True:
        callers = {name for name, body in bodies.items() if any(re.search(rf"\b{each}\(", body) for each in asking)}
        if callers <= asking:
            break
        asking |= callers
    body = re.search(r"OBJECT_VALUES\(X\)(.*?)\n\n", header("values/object_space.h"), re.S)[1]
    listed = {operation_of(int(number)) for number in re.findall(r"X\((\d+)\)", body)}
    assert listed == asking & operations().keys()


def test_operations_are_numbered_once_and_fit():
    listed = operations()
    assert len({each.number for each in listed.values()}) == len(listed) > 10
    assert all(each.inputs <= numbers()["STEP_INPUTS"] and each.outputs >= 1 for each in listed.values())
    assert all(each.number // 32 < 8 for each in listed.values())


def test_constants_fold_in_double():
    assert call1("divide", 1.0, 3.0) == 1.0 / 3.0
    assert call1("divide", 1.0, 0.0) == 0.0
    assert mix(2.0, 4.0, 0.25) == 2.5 and clamp(7.0) == 1.0
    assert not varies(add(1.0, 2.0))


def test_neutral_numbers_make_no_step():
    x = position()[0]
    assert x + 0.0 == x and 1.0 * x == x and x / 1.0 == x and x * 0.0 == 0.0
    assert varies([1.0, x]) and not varies([1.0, 2.0])


def test_equal_expressions_are_one():
    x, y, _ = position()
    assert x * y + 1.0 == x * y + 1.0
    program = compile_program([], [x * y + 1.0, (x * y + 1.0) * x])
    names = [operation_of(step[0]) for step in program.steps]
    assert names.count("multiply") == 2 and names.count("add") == 1 and names.count("constant") == 1


def test_a_value_is_no_truth():
    with pytest.raises(TypeError):
        bool(position()[0])
    with pytest.raises(TypeError):
        min(position()[0], 1.0)
    with pytest.raises(TypeError):
        ARITHMETIC.call("add", (1.0,))


@pytest.mark.parametrize("seed", range(8))
def test_registers_hold_what_is_wanted(seed):
    """Random expressions, with many values alive at once, against the same arithmetic in Python."""
    random = np.random.default_rng(seed)
    point = (0.7, -1.3, 2.1)
    pool, truth = [*position(), 0.5, -2.0], [*point, 0.5, -2.0]
    for _ in range(200):
        a, b = random.integers(0, len(pool), 2)
        name = ("add", "subtract", "minimum", "maximum")[random.integers(4)]
        python = {"add": lambda x, y: x + y, "subtract": lambda x, y: x - y, "minimum": min, "maximum": max}[name]
        pool.append(call1(name, pool[a], pool[b]) if varies(pool[a], pool[b]) else python(pool[a], pool[b]))
        truth.append(python(truth[a], truth[b]))
    chosen = random.choice(len(pool), 20)
    program = compile_program([pool[k] for k in chosen[:5]], [pool[k] for k in chosen[5:]])
    registers = interpret(program.steps, point)
    for k in chosen:
        assert registers[program.register_of(pool[k])] == pytest.approx(truth[k], rel=1e-12)
    shadowed = interpret(program.steps[:program.shadow_steps], point)
    for k in chosen[:5]:
        assert shadowed[program.register_of(pool[k])] == pytest.approx(truth[k], rel=1e-12)


def test_too_many_values_are_an_error():
    x = position()[0]
    with pytest.raises(ProgramTooLarge, match="more than 192 registers"):
        compile_program([], [x + float(k) for k in range(300)])


def test_too_many_closures_are_an_error():
    diffuse = make_instruction("diffuse", (0.01, 0.01, 0.01))
    assert len(make_material([diffuse] * 32).instructions) == 32
    with pytest.raises(ProgramTooLarge, match="33 closures and layers, 32 are possible"):
        make_material([diffuse] * 33)


def test_several_transparent_closures_become_one():
    x, y, z = position()
    instructions = [make_instruction("transparent", (x, x, x)), make_instruction("diffuse", (0.5, 0.5, 0.5)),
                    make_instruction("transparent", (0.25, y, z))]
    made = make_material(instructions)
    assert [row[0] for row in made.instructions] == [1, 5]
    assert made.shadow_steps == len(made.steps)
    registers = interpret(made.steps, (0.5, 2.0, 3.0))
    np.testing.assert_allclose(registers[list(made.instructions[1][2])], (0.75, 2.5, 3.5))


def test_a_tangent_may_lie_in_the_first_registers():
    x, y, z = position()
    along = ARITHMETIC.call("frame_tangent", (x, y, z))
    made = make_material([make_instruction("diffuse", (x * y, y, z), None, along)])
    flags, tangent = made.instructions[0][1], operations()["frame_tangent"].number
    place = next(to for op, to, *_ in made.steps if op == tangent)
    assert flags >> 16 == place + 1


# ------------------------------------------------------------------ in pictures


def glowing(weight) -> np.ndarray:
    """Radiances (8, 8, 3) of a plane from -1 to 1 at z = 0 that fills the picture, seen from above, at its pixels."""
    builder = Builder(size=(8, 8))
    builder.look((0, 0, 3), (0, 0, 0), tangent=1.0, orthographic=True, up=(0, 1, 0))
    builder.add(quad((0, 0, 0), (1, 0, 0), (0, 1, 0)), program(("emission", weight)))
    return pixels(render(builder.make(), 16, filter_width=0.001))[..., :3]


def test_emission_varies_in_the_picture():
    x, y, _ = position()
    across = (np.arange(8) - 3.5) / 4
    seen = glowing([x * x, y + 1.0, 0.25])
    np.testing.assert_allclose(seen[..., 0], np.broadcast_to(across ** 2, (8, 8)), atol=1e-3)
    np.testing.assert_allclose(seen[..., 1], np.broadcast_to(across[:, None] + 1.0, (8, 8)), atol=1e-3)
    assert (seen[..., 2] == 0.25).all()


def test_attributes_are_interpolated_by_domain():
    """A mesh of two triangles with an attribute of each domain, plain and mirrored."""
    n = numbers()
    for mirror in (1, -1):
        builder = Builder(size=(8, 8))
        builder.look((0, 0, 3), (0, 0, 0), tangent=0.99, orthographic=True, up=(0, 1, 0))
        red, green, by_triangle, constant = (Value(call1("attribute", data=k).call, 0) for k in range(4))
        shape = quad((0, 0, 0), (1, 0, 0), (0, 1, 0))
        x = shape[0][:, 0]  # in object space
        mesh = builder.mesh(shape, attributes=[
            (n["DOMAIN_VERTEX"], x[:, None]), (n["DOMAIN_CORNER"], x[shape[1].ravel()][:, None] + 2.0),
            (n["DOMAIN_TRIANGLE"], [[3.0], [5.0]]), (n["DOMAIN_MESH"], [[7.0]])])
        glow = program(("emission", [red + 2.0, green, by_triangle + constant]))
        builder.instance(mesh, builder.material(glow), matrix=place(scale=(mirror, 1, 1)))
        scene = builder.make()
        picture = np.moveaxis(pixels(render(scene, 64, filter_width=0.01)), -1, 0)
        across = mirror * 0.99 * (np.arange(8) - 3.5) / 4
        np.testing.assert_allclose(picture[0].mean(axis=0), 2.0 + across, atol=0.01)
        np.testing.assert_allclose(picture[1], picture[0], atol=1e-5)
        off_diagonal = picture[2, [0, 7], [7, 0]] if mirror == 1 else picture[2, [0, 7], [0, 7]]
        assert off_diagonal.tolist() == [10.0, 12.0]
