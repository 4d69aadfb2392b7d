# SPDX-License-Identifier: GPL-3.0-or-later
"""Closures and the order in which they stand in a material's program, and the parameters nodes share."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from isophote.materials import Instruction, make_instruction
from isophote.values import clamp, maximum, varies

from .anisotropy import is_stretched, tangent_of
from .nodes import find_input
from .values import Values, not_negative, outputs, saturate, source

CUTOFF = 1e-5  # Cycles' CLOSURE_WEIGHT_CUTOFF
ROUGH_FROM = 1e-5  # of diffuse reflection
WITHOUT_NORMAL = {"transparent", "emission", "holdout"}
UNSEEN = {"diffuse", "rough_diffuse", "diffuse_toon", "translucent"}  # seen from behind their normal, too


@dataclass(eq=False)
class Layer:
    """What lies over closures and takes some of their light: a layer_* operation."""

    operation: str
    weight: np.ndarray
    params: dict = field(default_factory=dict)
    normal: tuple | None = None  # its own, numbers or Values; None: the surface's
    tangent: tuple | None = None
    softened: bool = True  # materials.Instruction


@dataclass
class Closure:
    """One closure of a program, and the layers over it from the outermost on: those of a node share these objects."""

    operation: str
    weight: np.ndarray
    params: dict = field(default_factory=dict)
    layers: tuple[Layer, ...] = ()
    normal: tuple | None = None
    tangent: tuple | None = None
    softened: bool = True


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
            frame = (step.normal, step.tangent, step.softened)
            program.append(make_instruction(step.operation, step.weight, *frame, **step.params))
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


def framed(closures: list[Closure], values: Values, node, stack) -> list[Closure]:
    """The closures of a node, and the layers over them, with its normal where they have none."""
    if find_input(node, "Normal") is None:  # mixes of other nodes' closures, and those without a direction
        return closures
    normal, linked = normal_of(values, node, stack), values.is_linked(node, stack, "Normal")
    layers: dict[Layer, Layer] = {}

    def turned(each):
        made = each
        if normal is not None and not each.normal:  # that of a displacement is the surface's own for whoever asks
            own, seen = normal_for(each.operation, normal)
            made = replace(each, weight=each.weight * seen, normal=own, softened=linked)
        if is_stretched(each.params):
            tangent = tangent_of(values, node, stack, made.normal)
            made = replace(made, tangent=None if tangent is None else tuple(tangent))
        return made

    for each in closures:
        layers |= {layer: turned(layer) for layer in each.layers if layer not in layers}
    return [replace(turned(each), layers=tuple(layers[layer] for layer in each.layers)) for each in closures]


def normal_for(operation: str, normal) -> tuple:
    """(normal of a closure, factor of its weight): what mirrors or refracts needs one that its viewer sees, and does
    nothing where there is none."""
    if operation in WITHOUT_NORMAL:
        return None, 1.0
    if operation in UNSEEN:
        return tuple(normal), 1.0
    *visible, seen = outputs("visible_normal", *normal)
    return tuple(visible), seen


def normal_of(values: Values, node, stack, *names: str):
    """The normal of a shader node, unit; None where it is the surface's own."""
    names = names or ("Normal",)
    if find_input(node, *names) is None:
        return None
    normal = values.vector(node, stack, *names) if values.is_linked(node, stack, *names) else values.surface_normal
    own = source("shading_normal")
    if not varies(normal) and not any(normal) or all(a == b for a, b in zip(normal, own, strict=True)):
        return None
    return source("unit_normal", *normal)


def note_unless(values, node, stack, name, neutral, what) -> None:
    """Note `what` where an optional input exists and is not at the value at which it does nothing."""
    if find_input(node, name) is None:
        return
    given = values.number(node, stack, name)
    if varies(given) or abs(given - neutral) > 1e-6:
        values.note(f"{node.name}, {name}: {what}")
