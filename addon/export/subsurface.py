# SPDX-License-Identifier: GPL-3.0-or-later
"""Subsurface scattering, of its own node and of Principled, as Cycles 4.5 sets it up (closure/bssrdf.h)."""

from __future__ import annotations

import math

import bpy

from isophote.values import call1, clamp, is_number, maximum, mix, square_root, varies

from .closures import Closure, rgb
from .nodes import find_input
from .values import each, grey, not_negative

# By Blender's names since 4.0. Mean free paths of both but the skin's are scaled to look like older falloffs did.
RANDOM_WALK, SKIN = "RANDOM_WALK", "RANDOM_WALK_SKIN"
# Of versions before 4.0, whose RANDOM_WALK is today's skin.
OLDER = {"RANDOM_WALK_FIXED_RADIUS": RANDOM_WALK, "RANDOM_WALK": SKIN}
DIPOLE_HALVINGS = 12
SMALLEST_RADIUS = 1e-8  # metres, Cycles' BSSRDF_MIN_RADIUS: channels below are diffuse


def method(values, node, name: str) -> str:
    """RANDOM_WALK or SKIN; a note where it is neither."""
    chosen = OLDER.get(name, name) if bpy.app.version < (4, 0, 0) else name
    if chosen not in (RANDOM_WALK, SKIN):
        values.note(f"{node.name}: {name.replace('_', ' ').title()} is rendered as Random Walk")
    return SKIN if chosen == SKIN else RANDOM_WALK


def subsurface_closures(weight, color, radius, kind, ior, rough, anisotropy, layers=()) -> list[Closure]:
    """Closures of weight times colour: the walk, and diffuse ones for channels without a radius.

    `radius`: RGB in metres, as users give it. `rough`: Blender's roughness of the surface where light enters.
    """
    color, radius = not_negative(color), not_negative(radius)
    reaches = each(lambda r: 1.0 - call1("less_than", r, SMALLEST_RADIUS), radius)
    closures = []
    if varies(*reaches) or not all(reaches):
        closures.append(Closure("diffuse", weight * color * (1.0 - reaches), layers=layers))
    ior = clamp(ior, 1.01, 3.8)
    if kind == SKIN:
        scale, rough = each(lambda c: call1("dipole_length", c, ior, repeat=DIPOLE_HALVINGS), color), 1.0
    else:
        scale = grey(0.25 / math.pi)
    free_path = each(lambda r, s: maximum(r, SMALLEST_RADIUS) * maximum(s, 1e-4), radius, scale)
    params = {"anisotropy": clamp(anisotropy, 0.0, 0.9), "ior": ior, "roughness": rough,
              "diffuse": 0.5 if kind == SKIN else 0.0} | rgb("radius", free_path) | rgb("albedo", color)
    closures.append(Closure("subsurface", weight * color * reaches, params, layers))
    return closures


def subsurface_scattering(values, node, stack, weight) -> list[Closure]:
    """The node Subsurface Scattering."""
    radius = values.vector(node, stack, "Radius") * values.number(node, stack, "Scale")
    alpha = clamp(values.number(node, stack, "Roughness")) if find_input(node, "Roughness") is not None else 1.0
    return subsurface_closures(
        weight, values.color(node, stack, "Color"), radius, method(values, node, node.falloff),
        values.number(node, stack, "IOR"), square_root(alpha), values.number(node, stack, "Anisotropy"))


def principled_share(values, node, stack, base):
    """(share of Principled's diffuse light that goes below, its scale, the base colour).

    In files of 3.x the share is the scale: where there is some, all goes below, and the colour is mixed with another.
    """
    share = clamp(values.number(node, stack, "Subsurface Weight", "Subsurface"))
    if find_input(node, "Subsurface Scale") is not None:
        return share, values.number(node, stack, "Subsurface Scale"), base
    if is_number(share, 0.0):
        return 0.0, 0.0, base
    own = not_negative(values.color(node, stack, "Subsurface Color"))
    return 1.0, share, each(lambda a, b: mix(a, b, share), base, own)


def principled_subsurface(values, node, stack, weight, base, scale, eta, rough, layers) -> list[Closure]:
    """Of Principled, whose own index of refraction and roughness count for all but skin."""
    kind = method(values, node, node.subsurface_method)
    return subsurface_closures(
        weight, base, values.vector(node, stack, "Subsurface Radius") * scale, kind,
        values.number(node, stack, "Subsurface IOR") if kind == SKIN else eta, rough,
        values.number(node, stack, "Subsurface Anisotropy"), layers)
