"""A material's instructions and the steps that compute their values, as the scene's arrays hold them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from isophote.materials import OPERATIONS, PARAMS, Instruction, make_instruction
from isophote.records import numbers
from isophote.values import Number, Program, ProgramTooLarge, Value, add, call1, compile_program, operations, varies

Shown = tuple[Number, Number, Number]  # what an AOV output shows
NOT_SHOWN = (0, (0.0, 0.0, 0.0))


@dataclass
class MaterialProgram:
    """Rows (op, flags, weight, parameters) of instructions, rows of steps as values.Program has them, rows (AOV_
    flags, numbers or registers) of what AOV outputs show."""

    instructions: list[tuple]
    steps: list[tuple]
    shadow_steps: int
    shown: list[tuple] = field(default_factory=list)

    @property
    def attributes(self) -> set[int]:
        """Numbers of the attributes that its steps read."""
        reading = {operations()[name].number for name in ("attribute", "attribute_at")}
        return {data for op, _, _, _, data, _ in self.steps if op in reading}


@dataclass(frozen=True)
class Displacement:
    """Where a material moves its surface: a program whose emission is the displacement, metres in the world.

    `turns_normals`: normals are those of the moved surface; else they stay, for bump to bend them.
    """

    program: MaterialProgram
    turns_normals: bool


def make_displacement(vector: Sequence[Number], turns_normals: bool) -> Displacement:
    """Raises values.ProgramTooLarge as make_material."""
    return Displacement(make_material([make_instruction("emission", vector)]), turns_normals)


# No light is evaluated against their normals. Where another closure has one of its own, all others are looked at in
# frames of their own, too.
FRAMELESS = {OPERATIONS[name][0] for name in ("emission", "transparent")}


def make_material(instructions: list[Instruction], shown: Sequence[Shown | None] = ()) -> MaterialProgram:
    """Registers for all that varies, of instructions and of what AOV outputs show, None where there is no output.

    Raises values.ProgramTooLarge where there are too few, or too many instructions.
    """
    instructions = summed(summed(instructions, "emission"), "transparent")
    count = sum(each.op != OPERATIONS["emission"][0] for each in instructions)
    if count > numbers()["MOST_INSTRUCTIONS"]:
        raise ProgramTooLarge(f"it has {count} closures and layers, {numbers()['MOST_INSTRUCTIONS']} are possible")
    placed = [with_frame(each) for each in instructions]
    transparent = OPERATIONS["transparent"][0], OPERATIONS["extinction"][0]
    framed = any(each.normal is not None for each in placed)
    reading = [instruction_varies(each) or (framed and each.op not in FRAMELESS) for each in placed]
    shadow = [w for each in placed if each.op in transparent and varies(each.weight) for w in each.weight]
    others = [number for each, reads in zip(placed, reading, strict=True) if reads
              for number in (*each.weight, *each.params, *(each.normal or ()), *(each.tangent or ()))]
    others += [number for three in shown if three and varies(three) for number in three]
    program = compile_program(shadow, others)
    outputs = [aov_row(three, program) for three in shown]
    rows = [row_of(each, program, reads) for each, reads in zip(placed, reading, strict=True)]
    return MaterialProgram(rows, program.steps, program.shadow_steps, outputs)


def instruction_varies(each: Instruction) -> bool:
    return each.normal is not None or varies(each.weight, each.params)


def summed(instructions: list[Instruction], operation: str) -> list[Instruction]:
    """Where one of the instructions of an operation without parameters varies, one stands for all: the last."""
    number = OPERATIONS[operation][0]
    own = [each for each in instructions if each.op == number]
    if len(own) < 2 or not varies(*(each.weight for each in own)):
        return instructions
    weight = own[0].weight
    for each in own[1:]:
        weight = tuple(add(a, b) for a, b in zip(weight, each.weight, strict=True))
    return [each._replace(weight=weight) if each is own[-1] else each for each in instructions
            if each.op != number or each is own[-1]]


def with_frame(each: Instruction) -> Instruction:
    """Normal and tangent in registers that follow each other; who has a tangent has a normal."""
    if each.normal is None and each.tangent is None:
        return each
    normal = each.normal or tuple(Value(call1("facing_normal").call, k) for k in range(3))
    return each._replace(normal=in_a_row(normal), tangent=each.tangent and in_a_row(each.tangent))


def in_a_row(three: tuple[Number, ...]) -> tuple[Value, ...]:
    first = three[0]
    if all(isinstance(each, Value) and each.call is first.call and each.output == first.output + k
           for k, each in enumerate(three)):
        return three
    return tuple(Value(call1("vector", *three).call, k) for k in range(3))


def row_of(each: Instruction, program: Program, reads: bool) -> tuple:
    if not reads:
        return each.op, 0, each.weight, each.params
    n, where = numbers(), program.register_of
    flags = n["INSTRUCTION_VARIES"]
    if each.normal:
        flags |= n["INSTRUCTION_BUMPS"] | where(each.normal[0]) << 8 | each.softened * n["INSTRUCTION_SOFTENED"]
    if each.tangent:
        flags |= where(each.tangent[0]) + 1 << 16
    return each.op, flags, tuple(map(where, each.weight)), list(map(where, each.params))


def join_materials(programs: list[MaterialProgram]) -> dict[str, np.ndarray]:
    """The scene's arrays of all materials, one after the other; one without instructions is black."""
    arrays = {"material_first": starts([len(p.instructions) for p in programs]),
              "material_steps": starts([len(p.steps) for p in programs]),
              "material_shadow_steps": np.array([p.shadow_steps for p in programs], np.uint32)}
    arrays |= joined_aovs(programs)
    instructions = [row for p in programs for row in p.instructions]
    if instructions:
        operations, flags, weights, params = zip(*instructions, strict=True)
        arrays |= {"instruction_op": np.array(operations, np.int32), "instruction_flags": np.array(flags, np.uint32),
                   "instruction_weight": np.array(weights, np.float32),
                   "instruction_params": np.array([each + [0.0] * (PARAMS - len(each)) for each in params], np.float32)}
    steps = [row for p in programs for row in p.steps]
    if steps:
        op, to, read, repeat, data, number = zip(*steps, strict=True)
        arrays |= {"step_op": np.array(op, np.int32), "step_to": np.array(to, np.uint32),
                   "step_from": np.array(read, np.uint32), "step_repeat": np.array(repeat, np.uint32),
                   "step_data": np.array(data, np.uint32), "step_number": np.array(number, np.float32)}
    return arrays


def aov_row(three: Shown | None, program: Program) -> tuple:
    if three is None:
        return NOT_SHOWN
    if not varies(three):
        return numbers()["AOV_THERE"], three
    return numbers()["AOV_THERE"] | numbers()["AOV_VARIES"], tuple(map(program.register_of, three))


def joined_aovs(programs: list[MaterialProgram]) -> dict[str, np.ndarray]:
    count = max((len(p.shown) for p in programs), default=0)
    rows = [p.shown + [NOT_SHOWN] * (count - len(p.shown)) for p in programs]
    flags, values = ([[row[k] for row in of] for of in rows] for k in (0, 1))
    return {"aov_flags": np.array(flags, np.uint32).reshape(len(programs), count),
            "aov_values": np.array(values, np.float32).reshape(len(programs), count, 3)}


def starts(lengths: list[int]) -> np.ndarray:
    return np.cumsum([0, *lengths]).astype(np.uint32)
