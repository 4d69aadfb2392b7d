"""Programs that compute values for each shaded point: built as expressions, written as steps and registers.

The list of operations is that of kernels/values/*.h. An expression whose inputs are constants is one itself: the
kernels' own function computes it when it is made, in float64, so no arithmetic exists twice. Equal expressions are one.
Registers are given out by a linear scan in the order of the steps (Poletto and Sarkar 1999).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from isophote.records import header, header_path, numbers


class ProgramTooLarge(ValueError):
    """A program needs more registers than there are."""


@dataclass(frozen=True)
class Operation:
    """One of kernels/values: its number, and how many registers it reads and writes."""

    number: int
    inputs: int
    outputs: int


@cache
def operations() -> dict[str, Operation]:
    """All operations on values by name."""
    found = {}
    for path in sorted(header_path("values").glob("*.h")):
        listed = re.findall(r"X\((\d+), (\w+), (\d+), (\d+)\)", header(f"values/{path.name}"))
        found |= {name: Operation(*map(int, (number, *counts))) for number, name, *counts in listed}
    return found


@cache
def operation_of(number: int) -> str | None:
    """The name of the operation with a number, None where there is none."""
    return next((name for name, each in operations().items() if each.number == number), None)


# The families that read the shaded point or the scene's data, and so are never constant.
SOURCES = {name for name, each in operations().items() if each.number // 32 in (0, 6, 7) and name != "constant"}


@dataclass(frozen=True, eq=False)
class Call:
    """An operation with its inputs, numbers or Values; `data`, `repeat` and `number` are those of a step."""

    name: str
    inputs: tuple
    data: int
    repeat: int
    number: float


@dataclass(frozen=True)
class Value:
    """Output `output` of a call: a number that differs from point to point.

    Arithmetic with numbers and other Values makes Values, with arrays of them arrays.
    """

    call: Call
    output: int = 0

    def __add__(self, other):
        return add(self, other) if is_scalar(other) else NotImplemented

    __radd__ = __add__

    def __sub__(self, other):
        return subtract(self, other) if is_scalar(other) else NotImplemented

    def __rsub__(self, other):
        return subtract(other, self)

    def __mul__(self, other):
        return multiply(self, other) if is_scalar(other) else NotImplemented

    __rmul__ = __mul__

    def __truediv__(self, other):
        return divide(self, other) if is_scalar(other) else NotImplemented

    def __rtruediv__(self, other):
        return divide(other, self)

    def __neg__(self):
        return subtract(0.0, self)

    def __bool__(self):
        raise TypeError("a value that differs from point to point is neither true nor false")

    __lt__ = __le__ = __gt__ = __ge__ = __float__ = __bool__


Number = float | Value


def is_scalar(x) -> bool:
    """Whether x is no array: these do arithmetic element by element themselves."""
    return not isinstance(x, np.ndarray)


class Graph:
    """Makes expressions; equal ones are made once."""

    def __init__(self):
        self._calls: dict[tuple, Call] = {}

    def call(self, name: str, inputs: Sequence[Number] = (), *, data: int = 0, repeat: int = 1,
             number: float = 0.0) -> tuple[Number, ...]:
        """The outputs of an operation.

        Raises KeyError for one that is not known, TypeError for a wrong number of inputs.
        """
        operation = operations()[name]
        if len(inputs) != operation.inputs:
            raise TypeError(f"{name} takes {operation.inputs} inputs, got {len(inputs)}")
        inputs = tuple(each if isinstance(each, Value) else float(each) for each in inputs)
        if name not in SOURCES and not any(isinstance(each, Value) for each in inputs):
            return fold(name, inputs, repeat, number)
        key = (name, tuple((id(i.call), i.output) if isinstance(i, Value) else i for i in inputs), data, repeat, number)
        call = self._calls.setdefault(key, Call(name, inputs, data, repeat, number))
        return tuple(Value(call, k) for k in range(operation.outputs))


def fold(name: str, inputs: tuple[float, ...], repeat: int = 1, number: float = 0.0) -> tuple[float, ...]:
    """Outputs of an operation on constants, as the kernels' reference build computes them."""
    from isophote import _native  # the add-on loads without it, to say what is wrong

    operation = operations()[name]
    out = np.zeros(operation.outputs)
    _native.fold_value(operation.number, np.array(inputs, np.float64), repeat, number, out)
    return tuple(out.tolist())


# ------------------------------------------------------------------ arithmetic
# Of numbers it is Python's own, so that what is constant stays exact and costs nothing; 0 and 1 fold away.

ARITHMETIC = Graph()  # calls without a scene's data: equal ones may be shared by all materials of a process


def add(a: Number, b: Number) -> Number:
    if not isinstance(a, Value) and not isinstance(b, Value):
        return float(a) + float(b)
    return b if is_number(a, 0.0) else a if is_number(b, 0.0) else call1("add", a, b)


def subtract(a: Number, b: Number) -> Number:
    if not isinstance(a, Value) and not isinstance(b, Value):
        return float(a) - float(b)
    return a if is_number(b, 0.0) else call1("subtract", a, b)


def multiply(a: Number, b: Number) -> Number:
    if not isinstance(a, Value) and not isinstance(b, Value):
        return float(a) * float(b)
    if is_number(a, 0.0) or is_number(b, 0.0):
        return 0.0
    return b if is_number(a, 1.0) else a if is_number(b, 1.0) else call1("multiply", a, b)


def divide(a: Number, b: Number) -> Number:
    """0 where b is 0, as shader nodes have it."""
    if not isinstance(a, Value) and not isinstance(b, Value):
        return float(a) / float(b) if b else 0.0
    return a if is_number(b, 1.0) else call1("divide", a, b)


def minimum(a: Number, b: Number) -> Number:
    if not isinstance(a, Value) and not isinstance(b, Value):
        return min(float(a), float(b))
    return call1("minimum", a, b)


def maximum(a: Number, b: Number) -> Number:
    if not isinstance(a, Value) and not isinstance(b, Value):
        return max(float(a), float(b))
    return call1("maximum", a, b)


def clamp(x: Number, low: float = 0.0, high: float = 1.0) -> Number:
    if varies(x, low, high):
        return call1("clamp", x, low, high)
    return min(max(float(x), low), high)


def square_root(x: Number) -> Number:
    """0 where x is negative."""
    return call1("square_root", x) if isinstance(x, Value) else math.sqrt(max(x, 0.0))


def mix(a: Number, b: Number, t: Number) -> Number:
    """a (1 - t) + b t."""
    if is_number(t, 0.0) or (not isinstance(a, Value) and not isinstance(b, Value) and float(a) == float(b)):
        return a
    if is_number(t, 1.0):
        return b
    if is_number(a, 0.0) or is_number(b, 0.0) or not varies(a, b, t):
        return add(multiply(a, subtract(1.0, t)), multiply(b, t))
    return call1("mix", a, b, t)


def select(which: Number, a: Number, b: Number) -> Number:
    """a where `which` is not 0, else b."""
    if not isinstance(which, Value):
        return a if which else b
    return call1("select", which, a, b)


def is_number(x: Number, number: float) -> bool:
    """Whether x is this constant."""
    return not isinstance(x, Value) and float(x) == number


def varies(*numbers) -> bool:
    """Whether any of some numbers, or of arrays of them, differs from point to point."""
    return any(varies(*each) if isinstance(each, np.ndarray | tuple | list) else isinstance(each, Value)
               for each in numbers)


def call1(name: str, *inputs: Number, **data) -> Number:
    """The one output of an operation."""
    return ARITHMETIC.call(name, inputs, **data)[0]


# ------------------------------------------------------------------ programs


@dataclass
class Program:
    """Steps of a material: rows (op, to, from, repeat, data, number); of them `shadow_steps` for its transparency.

    `register_of` maps what was wanted, numbers and Values, to the registers that hold it at the end.
    """

    steps: list[tuple]
    shadow_steps: int
    registers: int
    _registers: dict

    def register_of(self, wanted: Number) -> int:
        return self._registers[key_of(wanted)]


def key_of(number: Number):
    return (id(number.call), number.output) if isinstance(number, Value) else float(number)


def compile_program(shadow: Iterable[Number], others: Iterable[Number]) -> Program:
    """The steps that compute what is wanted, `shadow` first: what shadow rays ask for.

    Raises ProgramTooLarge where MOST_REGISTERS do not hold it.
    """
    shadow, others = list(shadow), list(others)
    scheduled = Schedule()
    for wanted in shadow:
        scheduled.add(wanted)
    shadow_steps = len(scheduled.calls)
    for wanted in others:
        scheduled.add(wanted)
    return scheduled.allocate(shadow_steps, [*shadow, *others])


class Schedule:
    """Calls in an order in which each comes after its inputs."""

    def __init__(self):
        self.calls: list[Call] = []
        self._placed: set[int] = set()
        self._constants: dict[float, Call] = {}

    def call_of(self, number: Number) -> Call:
        if isinstance(number, Value):
            return number.call
        number = float(number)
        return self._constants.setdefault(number, Call("constant", (), 0, 1, number))

    def add(self, wanted: Number) -> None:
        stack = [(self.call_of(wanted), False)]
        while stack:
            call, ready = stack.pop()
            if id(call) in self._placed:
                continue
            if ready:
                self._placed.add(id(call))
                self.calls.append(call)
            else:
                stack.append((call, True))
                stack += [(self.call_of(each), False) for each in reversed(call.inputs)]

    def allocate(self, shadow_steps: int, wanted: list[Number]) -> Program:
        """Give each call registers from its step to its last use; those of what is wanted stay."""
        end = len(self.calls)
        last = {id(call): step for step, call in enumerate(self.calls)}
        for step, call in enumerate(self.calls):
            for each in call.inputs:
                last[id(self.call_of(each))] = step
        for each in wanted:
            last[id(self.call_of(each))] = end
        free, first, steps, used = [True] * numbers()["MOST_REGISTERS"], {}, [], 0
        ending: dict[int, list[Call]] = {}
        for call in self.calls:
            ending.setdefault(last[id(call)], []).append(call)
        for step, call in enumerate(self.calls):
            operation = operations()[call.name]
            first[id(call)] = place = find_run(free, operation.outputs)
            used = max(used, place + operation.outputs)
            free[place:place + operation.outputs] = [False] * operation.outputs
            inputs = [first[id(self.call_of(each))] + (each.output if isinstance(each, Value) else 0)
                      for each in call.inputs]
            inputs += [0] * (numbers()["STEP_INPUTS"] - len(inputs))
            steps.append((operation.number, place, inputs, call.repeat, call.data, call.number))
            for done in ending.get(step, ()):
                outputs = operations()[done.name].outputs
                free[first[id(done)]:first[id(done)] + outputs] = [True] * outputs
        registers = {key_of(each): first[id(self.call_of(each))] + (each.output if isinstance(each, Value) else 0)
                     for each in wanted}
        return Program(steps, shadow_steps, used, registers)


def rewritten(wanted: Number, change) -> Number:
    """The expression with some of its calls replaced: change(call, inputs) returns the numbers that stand for a call's
    outputs, or None where it stays what it is; `inputs` are the call's, rewritten already."""
    schedule, outputs = Schedule(), {}
    schedule.add(wanted)
    for call in schedule.calls:
        inputs = tuple(outputs[id(each.call)][each.output] if isinstance(each, Value) else each for each in call.inputs)
        made = change(call, inputs)
        if made is None:
            same = all(a is b or a == b for a, b in zip(inputs, call.inputs, strict=True))
            made = (tuple(Value(call, k) for k in range(operations()[call.name].outputs)) if same else
                    ARITHMETIC.call(call.name, inputs, data=call.data, repeat=call.repeat, number=call.number))
        outputs[id(call)] = made
    return outputs[id(wanted.call)][wanted.output] if isinstance(wanted, Value) else wanted


def find_run(free: list[bool], count: int) -> int:
    """The first of `count` free registers in a row."""
    run = 0
    for place, is_free in enumerate(free):
        run = run + 1 if is_free else 0
        if run == count:
            return place - count + 1
    raise ProgramTooLarge(f"its values need more than {len(free)} registers")
