# SPDX-License-Identifier: GPL-3.0-or-later
"""The Principled BSDF: one node, up to eight closures, in the order of Cycles 4.5 (svm/closure.h).

Files of Blender 3.x hold the first version of the node. It is read as Blender 4 reads such a file
(versioning_400.cc), so that one file is one picture in every version: Specular is the Specular IOR Level,
Specular Tint mixes from white to the base colour, IOR stays, Clearcoat and Sheen are weaker and of one kind.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from isophote.values import call1, clamp, is_number, maximum, minimum, mix, square_root, varies

from .anisotropy import principled_ratio, stretched, two_roughnesses
from .closures import (
    CUTOFF,
    Closure,
    Layer,
    diffuse_closure,
    multiscatter,
    normal_for,
    normal_of,
    note_unless,
    rgb,
    roughness,
)
from .nodes import find_input
from .subsurface import principled_share, principled_subsurface
from .values import as_triple, each, grey, not_negative, source

# Inputs that are not supported, by their names in both versions, and the value at which they do nothing.
LEFT_OUT = {
    "Transmission Roughness": "not supported (gone since Blender 4): Roughness is used",
}


THINNEST_FILM = 0.1  # nm, Cycles' THINFILM_THICKNESS_CUTOFF


def principled(values, node, stack, weight) -> list[Closure]:
    """Closures of a Principled BSDF, times a weight."""
    for name, what in LEFT_OUT.items():
        note_unless(values, node, stack, name, 0.0, what)

    def unit(*names):
        return clamp(values.number(node, stack, *names))

    base = not_negative(values.color(node, stack, "Base Color"))
    below, scale, base = principled_share(values, node, stack, base)
    tint = specular_tint(values, node, stack, base)
    ior = maximum(values.number(node, stack, "IOR"), 1e-5)
    level = maximum(values.number(node, stack, "Specular IOR Level", "Specular"), 0.0)
    alpha, metallic = unit("Alpha"), unit("Metallic")
    transmission = unit("Transmission Weight", "Transmission")
    rough = {"roughness": roughness(values, node, stack), "multiscatter": multiscatter(values, node)}
    ratio = principled_ratio(values, node, stack)

    closures = [Closure("transparent", as_triple(weight * (1.0 - alpha)))]
    weight = weight * alpha
    above = ()
    for closure, layers in (sheen(values, node, stack), coat(values, node, stack)):
        if closure is not None:
            closures.append(replace(closure, weight=weight * closure.weight, layers=above))
            above += layers
    emitted = values.color(node, stack, "Emission Color", "Emission") * values.number(node, stack, "Emission Strength")
    if above and (varies(emitted) or emitted.any()):
        values.note(f"{node.name}: sheen and coat do not weaken its emission")
    closures.append(Closure("emission", weight * emitted))
    if matters(metallic):
        params = rough | rgb("f0", at_most_1(base)) | rgb("f82", at_most_1(tint))
        operation, params = stretched("metal", params, ratio)
        closures.append(Closure(operation, as_triple(weight * metallic), params, above))
        weight = weight * (1.0 - metallic)
    film = thin_film(values, node, stack)
    if matters(transmission):
        # Light passes the surface twice, going in and coming out: each time the colour's square root.
        params = rough | {"ior": ior} | rgb("tint", tint) | rgb("transmission", each(square_root, at_most_1(base)))
        closures.append(Closure("film_glass" if film else "principled_glass", as_triple(weight * transmission),
                                params | film, above))
        weight = weight * (1.0 - transmission)
    eta = adjusted_ior(ior, level)
    if (film or not is_number(eta, 1.0)) and matters(weight):
        layer, params = "layer_specular", rough | {"ior": eta} | rgb("tint", tint)
        operation, own = stretched("specular", params, ratio)
        if film:
            operation, own = "film_specular", two_roughnesses(params, ratio) | film
            layer, params = "layer_film_specular", own
        closures.append(Closure(operation, as_triple(weight), own, above))
        above += (Layer(layer, np.ones(3), params),)
    if matters(below):
        closures += principled_subsurface(values, node, stack, weight * below, at_most_1(base), scale, eta,
                                          rough["roughness"], above)
        weight = weight * (1.0 - below)
    closures.append(diffuse_closure(weight, base, optional(values, node, stack, "Diffuse Roughness", 0.0), above))
    return closures


def matters(share) -> bool:
    return varies(share) or share > CUTOFF


def at_most_1(color) -> np.ndarray:
    return each(lambda x: minimum(x, 1.0), color)


def optional(values, node, stack, name: str, default: float):
    """A number that only newer versions of the node have."""
    return values.number(node, stack, name) if find_input(node, name) is not None else default


def thin_film(values, node, stack) -> dict:
    """Parameters of the film; none where it is too thin to show."""
    thickness = optional(values, node, stack, "Thin Film Thickness", 0.0)
    if not varies(thickness) and thickness <= THINNEST_FILM:
        return {}
    return {"thickness": thickness, "film_ior": maximum(values.number(node, stack, "Thin Film IOR"), 1e-5)}


def sheen(values, node, stack) -> tuple[Closure | None, tuple[Layer, ...]]:
    """The sheen, of weight 1 for the whole node, and what it leaves for the rest; (None, ()) where there is none."""
    weight = maximum(values.number(node, stack, "Sheen Weight", "Sheen"), 0.0)
    if find_input(node, "Sheen Weight") is not None:
        tint = not_negative(values.color(node, stack, "Sheen Tint"))
    else:  # of 3.x: white, a fifth
        tint = grey(0.2)
    if not matters(weight):
        return None, ()
    params = {"roughness": clamp(optional(values, node, stack, "Sheen Roughness", 0.5))}
    return Closure("sheen", weight * tint, params), (Layer("layer_sheen", weight * tint, params),)


def coat(values, node, stack) -> tuple[Closure | None, tuple[Layer, ...]]:
    """The coat, likewise. Its reflection is white and keeps its energy; what lies below is seen through its tint."""
    weight = maximum(values.number(node, stack, "Coat Weight", "Clearcoat"), 0.0)
    rough = clamp(values.number(node, stack, "Coat Roughness", "Clearcoat Roughness"))
    if find_input(node, "Coat Weight") is not None:
        ior = maximum(values.number(node, stack, "Coat IOR"), 1.0)
        tint = not_negative(values.color(node, stack, "Coat Tint"))
    else:  # of 3.x: a quarter, or where another node makes it of an index that reflects about a quarter
        linked = values.is_linked(node, stack, "Clearcoat")
        weight, ior, tint = weight if linked else 0.25 * weight, 1.2 if linked else 1.5, grey(1.0)
    if not matters(weight):
        return None, ()
    normal, seen = coat_normal(values, node, stack)
    weight = weight * seen
    params = {"roughness": rough, "multiscatter": 1.0, "ior": ior}
    layers = (Layer("layer_specular", grey(weight), params, normal),)
    if varies(tint) or (tint != 1.0).any():
        layers += (Layer("layer_absorption", grey(weight), {"ior": ior} | rgb("tint", tint), normal),)
    return Closure("specular", grey(weight), params, normal=normal), layers


def coat_normal(values, node, stack):
    """As normal_for. The coat lies smooth over a bent normal below, unless it has its own."""
    normal = normal_of(values, node, stack, "Coat Normal", "Clearcoat Normal")
    if normal is None and normal_of(values, node, stack) is not None:
        return tuple(source("facing_normal")), 1.0
    return (None, 1.0) if normal is None else normal_for("specular", normal)


def specular_tint(values, node, stack, base) -> np.ndarray:
    """RGB; a number in files of 3.x, from white (0) to the base colour (1)."""
    if find_input(node, "Specular IOR Level") is not None:
        return not_negative(values.color(node, stack, "Specular Tint"))
    amount = clamp(values.number(node, stack, "Specular Tint"))
    return each(lambda x: mix(1.0, x, amount), base)


def adjusted_ior(ior, level):
    """IOR of the specular layer: its reflectance at normal incidence is 2 x level that of `ior`."""
    if is_number(level, 0.5):
        return ior
    root = (ior - 1.0) / (ior + 1.0)
    root = square_root(clamp(2.0 * level * root * root, 0.0, 0.99))
    eta = (1.0 + root) / (1.0 - root)
    if varies(ior):
        return call1("select", call1("less_than", ior, 1.0), 1.0 / eta, eta)
    return 1.0 / eta if ior < 1.0 else eta
