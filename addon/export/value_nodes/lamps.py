# SPDX-License-Identifier: GPL-3.0-or-later
"""IES Texture and Light Falloff: nodes for lamps, though surfaces may have them, too."""

from __future__ import annotations

import math

from isophote.values import call1, select

from ... import compat
from ..photometry import NotPhotometric, parse_photometry
from ..values import source
from .inputs import to_object_normal
from .vectors import normalize

UNREADABLE = 100.0  # watts, what Cycles takes where a file cannot be read
FAR = 1e30  # metres: suns and worlds are at no distance


def ies_texture(values, node, socket, stack):
    """How bright a luminaire is in the direction of a vector, by default of whoever looks, in the lamp's space."""
    if values.lookups is None:
        return None
    linked = values.is_linked(node, stack, "Vector")
    towards = values.vector(node, stack, "Vector") if linked else to_object_normal(values, source("incoming"))
    x, y, z = normalize(towards)
    strength = values.number(node, stack, "Strength")
    try:
        table = values.lookups.table(parse_photometry(compat.ies_text(node)))
    except (NotPhotometric, OSError) as error:
        values.note(f"{node.name}: {error}: {UNREADABLE:g} in all directions")
        return strength * UNREADABLE
    return strength * call1("photometry", call1("arctangent", x, y) + math.pi, call1("arccosine", -z), data=table)


def light_falloff(values, node, socket, stack):
    """A strength that makes up for the distance of whoever looks, from which light falls off as its square."""
    strength, smooth = (values.number(node, stack, name) for name in ("Strength", "Smooth"))
    length = call1("ray_length")
    squared = length * length
    made = strength * {"Quadratic": 1.0, "Linear": length, "Constant": squared}[socket.name]
    softened = made * (squared / (smooth + squared))
    return select(call1("less_than", length, FAR), select(call1("less_than", 0.0, smooth), softened, made), strength)


NODES = {
    "ShaderNodeTexIES": ies_texture,
    "ShaderNodeLightFalloff": light_falloff,
}
