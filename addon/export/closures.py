# SPDX-License-Identifier: GPL-3.0-or-later
"""Closures and the order in which they stand in a material's program, and the parameters nodes share."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from isophote.materials import Instruction, make_instruction
from isophote.values import clamp, is_number, maximum, varies

from .nodes import find_input
from .value_nodes.normals import default_tangent
from .values import Values, not_negative, source

CUTOFF = 1e-5  # Cycles' CLOSURE_WEIGHT_CUTOFF
WITHOUT_NORMAL = {"transparent", "emission"}
UNSEEN = {"diffuse", "translucent"}  # the same whatever the angle to the viewer


@dataclass
class Closure:
    """One closure of a program; `coat` holds the parameters of the layer_specular above it, if any."""

    operation: str
    weight: np.ndarray
    params: dict = field(default_factory=dict)
    coat: dict | None = None
    normal: tuple | None = None  # its own, numbers or Values


def arrange(closures: list[Closure], values: Values | None) -> list[Instruction]:
    """Instructions in order: closures under no coat first, then those under one, after it.

    A program has one layer weight, so one coat: where several coats are mixed, the closures under
    the lighter ones are weakened by their coat's normal reflectance instead, which is noted.
    """
    kept = [replace(c, weight=not_negative(c.weight)) for c in closures]
    kept = [c for c in kept if varies(c.weight) or c.weight.mean() >= CUTOFF]
    coats = []
    for closure in kept:
        if closure.coat is not None and closure.coat not in coats:
            coats.append(closure.coat)
    if len(coats) > 1:
        values.note("mixes several coated shaders: all but one are layered approximately")
        kept = [uncoat(c) if c.coat is not None and c.coat != coats[0] else c for c in kept]
    program = [make_instruction(c.operation, c.weight, c.normal, **c.params) for c in kept if c.coat is None]
    coated = [c for c in kept if c.coat is not None]
    if coated:
        program.append(make_instruction("layer_specular", (1.0, 1.0, 1.0), coated[0].normal, **coated[0].coat))
        program += [make_instruction(c.operation, c.weight, c.normal, **c.params) for c in coated]
    return program


def uncoat(closure: Closure) -> Closure:
    root = (closure.coat["ior"] - 1.0) / (closure.coat["ior"] + 1.0)
    return replace(closure, weight=closure.weight * (1.0 - root * root), coat=None)


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
    """The closures of a node with its normal; who mirrors or refracts needs one that its viewer sees."""
    normal = normal_of(values, node, stack)
    if normal is None:
        return closures
    visible = tuple(source("visible_normal", *normal))
    return [c if c.normal or c.operation in WITHOUT_NORMAL else
            replace(c, normal=tuple(normal) if c.operation in UNSEEN else visible) for c in closures]


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


def tangent_of(values: Values, node, stack, normal=None):
    """The tangent along which an anisotropic closure's first roughness runs; None where the surface has none.

    `normal` is that of the closure, None for the surface's own.
    """
    linked = values.is_linked(node, stack, "Tangent")
    tangent = values.vector(node, stack, "Tangent") if linked else default_tangent(values)
    rotation = values.number(node, stack, "Rotation", "Anisotropic Rotation")
    if tangent is None or is_number(rotation, 0.0):
        return tangent
    return source("turned_tangent", *tangent, *(source("shading_normal") if normal is None else normal), rotation)


def note_unless(values, node, stack, name, neutral, what) -> None:
    """Note `what` where an optional input exists and is not at the value at which it does nothing."""
    if find_input(node, name) is None:
        return
    given = values.number(node, stack, name)
    if varies(given) or abs(given - neutral) > 1e-6:
        values.note(f"{node.name}, {name}: {what}")
