# SPDX-License-Identifier: GPL-3.0-or-later
"""Closures and the order in which they stand in a material's program, and the parameters nodes share."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from isophote.materials import Instruction, make_instruction
from isophote.values import clamp, maximum, varies

from .nodes import find_input, source_of
from .values import not_negative, saturate

CUTOFF = 1e-5  # Cycles' CLOSURE_WEIGHT_CUTOFF
ROUGH_FROM = 1e-5  # of diffuse reflection


@dataclass(eq=False)
class Layer:
    """What lies over closures and takes some of their light: a layer_* operation."""

    operation: str
    weight: np.ndarray
    params: dict = field(default_factory=dict)


@dataclass
class Closure:
    """One closure of a program, and the layers over it from the outermost on: those of a node share these objects."""

    operation: str
    weight: np.ndarray
    params: dict = field(default_factory=dict)
    layers: tuple[Layer, ...] = ()


def arrange(closures: list[Closure]) -> list[Instruction]:
    """Instructions in order: closures under nothing first, then stack by stack, layers before what lies under them."""
    kept = [replace(c, weight=not_negative(c.weight)) for c in closures]
    kept = [c for c in kept if varies(c.weight) or c.weight.mean() >= CUTOFF]
    program, above = [], ()
    for closure in sorted(kept, key=lambda c: len(c.layers) > 0):
        if closure.layers[:len(above)] != above:
            program.append(make_instruction("layer_reset", (1.0, 1.0, 1.0)))
            above = ()
        for step in (*closure.layers[len(above):], closure):
            program.append(make_instruction(step.operation, step.weight, **step.params))
        above = closure.layers
    return program


def diffuse_closure(weight, color, rough, layers: tuple[Layer, ...] = ()) -> Closure:
    """Diffuse reflection, rough where Cycles takes it for rough."""
    if not varies(rough) and rough < ROUGH_FROM:
        return Closure("diffuse", weight * color, layers=layers)
    params = {"roughness": clamp(rough)} | rgb("albedo", saturate(color))
    return Closure("rough_diffuse", weight * color, params, layers)


MULTISCATTER = {"GGX": 0.0, "SHARP": 0.0, "MULTI_GGX": 1.0}


def roughness(values, node, stack):
    """Blender's roughness (its square is GGX' alpha), 0 for the distribution SHARP of versions before 4.0."""
    if getattr(node, "distribution", "") == "SHARP":
        return 0.0
    return clamp(values.number(node, stack, "Roughness"))


def multiscatter(values, node) -> float:
    kind = getattr(node, "distribution", "GGX")
    if kind not in MULTISCATTER:
        values.note(f"{node.name}: distribution {kind.lower()} is not supported: rendered as GGX")
    return MULTISCATTER.get(kind, 0.0)


def ior(values, node, stack):
    return maximum(values.number(node, stack, "IOR"), 1e-5)


def rgb(name: str, color) -> dict:
    return {f"{name}_{c}": v for c, v in zip("rgb", color, strict=False)}


def note_normal(values, node, *names: str) -> None:
    names = names or ("Normal",)
    socket = find_input(node, *names)
    if socket is not None and socket.is_linked:
        source = source_of(socket).node
        if source is not None and source.bl_idname != "ShaderNodeNewGeometry":
            values.note(f"{source.name} ({source.bl_idname}) into {node.name}, {socket.name}: not supported, left out")


def note_unless(values, node, stack, name, neutral, what) -> None:
    """Note `what` where an optional input exists and is not at the value at which it does nothing."""
    if find_input(node, name) is None:
        return
    given = values.number(node, stack, name)
    if varies(given) or abs(given - neutral) > 1e-6:
        values.note(f"{node.name}, {name}: {what}")
