# SPDX-License-Identifier: GPL-3.0-or-later
"""Anisotropy: roughnesses along and across a tangent, and the tangent, as Cycles 4.5 has them (svm/closure.h)."""

from __future__ import annotations

from isophote.values import Number, call1, clamp, is_number, maximum, square_root, varies

from .nodes import find_input
from .value_nodes.normals import default_tangent
from .values import source

ANISOTROPIC = {"glossy": "aniso_glossy", "metal": "aniso_metal", "specular": "aniso_specular",
               "conductor": "aniso_conductor"}


def stretched(operation: str, params: dict, ratio: Number) -> tuple[str, dict]:
    """(operation, parameters) of a closure whose roughness is `ratio` times as large along the tangent, and as much
    smaller across it."""
    return (operation, params) if is_number(ratio, 1.0) else (ANISOTROPIC[operation], two_roughnesses(params, ratio))


def two_roughnesses(params: dict, ratio: Number = 1.0) -> dict:
    """A roughness as one along the tangent and one across it."""
    others = {name: value for name, value in params.items() if name != "roughness"}
    return others | {"roughness_x": params["roughness"] * ratio, "roughness_y": params["roughness"] / ratio}


def is_stretched(params: dict) -> bool:
    return params.get("roughness_x") != params.get("roughness_y")


def glossy_ratio(values, node, stack) -> Number:
    """Of Glossy BSDF's Anisotropy, -1 to 1: rougher along the tangent where it is negative, across it else."""
    if find_input(node, "Anisotropy") is None:
        return 1.0
    amount = clamp(values.number(node, stack, "Anisotropy"), -0.99, 0.99)
    root = square_root(1.0 - maximum(amount, -amount))
    if varies(amount):
        return call1("select", call1("less_than", amount, 0.0), 1.0 / root, root)
    return 1.0 if abs(amount) <= 1e-4 else 1.0 / root if amount < 0.0 else root


def principled_ratio(values, node, stack) -> Number:
    """Of Principled's and Metallic BSDF's, 0 to 1: rougher along the tangent."""
    amount = clamp(values.number(node, stack, "Anisotropic", "Anisotropy"))
    return 1.0 / square_root(square_root(1.0 - 0.9 * amount))


def tangent_of(values, node, stack, normal=None):
    """The tangent along which an anisotropic closure's first roughness runs; None where the surface has none.

    `normal` is that of the closure, None for the surface's own.
    """
    linked = values.is_linked(node, stack, "Tangent")
    tangent = values.vector(node, stack, "Tangent") if linked else default_tangent(values)
    rotation = values.number(node, stack, "Rotation", "Anisotropic Rotation")
    if tangent is None or is_number(rotation, 0.0):
        return tangent
    return source("turned_tangent", *tangent, *(source("shading_normal") if normal is None else normal), rotation)
