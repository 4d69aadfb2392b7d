# SPDX-License-Identifier: GPL-3.0-or-later
"""The Principled BSDF: one node, up to eight closures, in the order of Cycles 4.5 (svm/closure.h).

Files of Blender 3.x hold the first version of the node. It is read as Blender 4 reads such a file
(versioning_400.cc), so that one file is one picture in every version: Specular is the Specular IOR Level,
Specular Tint mixes from white to the base colour, IOR stays, Clearcoat and Sheen are weaker and of one kind.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .closures import CUTOFF, Closure, Layer, diffuse_closure, multiscatter, note_normal, note_unless, rgb, roughness
from .nodes import find_input, live_link

# Inputs that are not supported, by their names in both versions, and the value at which they do nothing.
LEFT_OUT = {
    "Subsurface Weight": "subsurface scattering is not supported: rendered diffuse",
    "Subsurface": "subsurface scattering is not supported: rendered diffuse",
    "Anisotropic": "anisotropy is not supported: rendered isotropic",
    "Transmission Roughness": "not supported (gone since Blender 4): Roughness is used",
}


THINNEST_FILM = 0.1  # nm, Cycles' THINFILM_THICKNESS_CUTOFF


def principled(values, node, stack, weight) -> list[Closure]:
    """Closures of a Principled BSDF, times a weight."""
    note_normal(values, node)
    for name, what in LEFT_OUT.items():
        note_unless(values, node, stack, name, 0.0, what)

    def unit(*names):
        return min(max(values.number(node, stack, *names), 0.0), 1.0)

    base = np.maximum(values.color(node, stack, "Base Color"), 0.0)
    tint = specular_tint(values, node, stack, base)
    ior = max(values.number(node, stack, "IOR"), 1e-5)
    level = max(values.number(node, stack, "Specular IOR Level", "Specular"), 0.0)
    alpha, metallic = unit("Alpha"), unit("Metallic")
    transmission = unit("Transmission Weight", "Transmission")
    rough = {"roughness": roughness(values, node, stack), "multiscatter": multiscatter(values, node)}

    closures = [Closure("transparent", np.full(3, weight * (1.0 - alpha)))]
    weight *= alpha
    above = ()
    for closure, layers in (sheen(values, node, stack), coat(values, node, stack)):
        if closure is not None:
            closures.append(replace(closure, weight=weight * closure.weight, layers=above))
            above += layers
    emitted = values.color(node, stack, "Emission Color", "Emission") * values.number(node, stack, "Emission Strength")
    if above and emitted.any():
        values.note(f"{node.name}: sheen and coat do not weaken its emission")
    closures.append(Closure("emission", weight * emitted))
    if metallic > CUTOFF:
        params = rough | rgb("f0", np.minimum(base, 1.0)) | rgb("f82", np.minimum(tint, 1.0))
        closures.append(Closure("metal", np.full(3, weight * metallic), params, above))
        weight *= 1.0 - metallic
    film = thin_film(values, node, stack)
    if transmission > CUTOFF:
        # Light passes the surface twice, going in and coming out: each time the colour's square root.
        params = rough | {"ior": ior} | rgb("tint", tint) | rgb("transmission", np.sqrt(np.minimum(base, 1.0)))
        closures.append(Closure("film_glass" if film else "principled_glass", np.full(3, weight * transmission),
                                params | film, above))
        weight *= 1.0 - transmission
    eta = adjusted_ior(ior, level)
    if (eta != 1.0 or film) and weight >= CUTOFF:
        operation, params = "specular", rough | {"ior": eta} | rgb("tint", tint)
        if film:
            operation, params = "film_specular", two_roughnesses(params) | film
        closures.append(Closure(operation, np.full(3, weight), params, above))
        above += (Layer(f"layer_{operation}", np.ones(3), params),)
    closures.append(diffuse_closure(weight, base, optional(values, node, stack, "Diffuse Roughness", 0.0), above))
    return closures


def optional(values, node, stack, name: str, default: float) -> float:
    """A number that only newer versions of the node have."""
    return values.number(node, stack, name) if find_input(node, name) is not None else default


def thin_film(values, node, stack) -> dict:
    """Parameters of the film; none where it is too thin to show."""
    thickness = optional(values, node, stack, "Thin Film Thickness", 0.0)
    if thickness <= THINNEST_FILM:
        return {}
    return {"thickness": thickness, "film_ior": max(values.number(node, stack, "Thin Film IOR"), 1e-5)}


def two_roughnesses(params: dict) -> dict:
    """A roughness as one along the tangent and one across it."""
    others = {name: value for name, value in params.items() if name != "roughness"}
    return others | {"roughness_x": params["roughness"], "roughness_y": params["roughness"]}


def sheen(values, node, stack) -> tuple[Closure | None, tuple[Layer, ...]]:
    """The sheen, of weight 1 for the whole node, and what it leaves for the rest; (None, ()) where there is none."""
    weight = max(values.number(node, stack, "Sheen Weight", "Sheen"), 0.0)
    if find_input(node, "Sheen Weight") is not None:
        color = weight * np.maximum(values.color(node, stack, "Sheen Tint"), 0.0)
    else:  # of 3.x: a fifth, white
        color = np.full(3, 0.2 * weight)
    if not color.any():
        return None, ()
    params = {"roughness": optional(values, node, stack, "Sheen Roughness", 0.5)}
    return Closure("sheen", color, params), (Layer("layer_sheen", color, params),)


def coat(values, node, stack) -> tuple[Closure | None, tuple[Layer, ...]]:
    """The coat, likewise. Its reflection is white and keeps its energy; what lies below is seen through its tint."""
    weight = max(values.number(node, stack, "Coat Weight", "Clearcoat"), 0.0)
    rough = min(max(values.number(node, stack, "Coat Roughness", "Clearcoat Roughness"), 0.0), 1.0)
    if find_input(node, "Coat Weight") is not None:
        ior = max(values.number(node, stack, "Coat IOR"), 1.0)
        tint = np.maximum(values.color(node, stack, "Coat Tint"), 0.0)
    else:  # of 3.x: a quarter, or where it is no constant of an index that reflects about a quarter
        linked = live_link(find_input(node, "Clearcoat")) is not None
        weight, ior, tint = weight if linked else 0.25 * weight, 1.2 if linked else 1.5, np.ones(3)
    if weight <= CUTOFF:
        return None, ()
    note_normal(values, node, "Coat Normal", "Clearcoat Normal")
    params = {"roughness": rough, "multiscatter": 1.0, "ior": ior}
    amount = np.full(3, weight)
    layers = (Layer("layer_specular", amount, params),)
    if (tint != 1.0).any():
        layers += (Layer("layer_absorption", amount, {"ior": ior} | rgb("tint", tint)),)
    return Closure("specular", amount, params), layers


def specular_tint(values, node, stack, base) -> np.ndarray:
    """RGB; a number in files of 3.x, from white (0) to the base colour (1)."""
    if find_input(node, "Specular IOR Level") is not None:
        return np.maximum(values.color(node, stack, "Specular Tint"), 0.0)
    amount = min(max(values.number(node, stack, "Specular Tint"), 0.0), 1.0)
    return 1.0 - amount + amount * base


def adjusted_ior(ior: float, level: float) -> float:
    """IOR of the specular layer: its reflectance at normal incidence is 2 x level that of `ior`."""
    if level == 0.5:
        return ior
    f0 = 2.0 * level * ((ior - 1.0) / (ior + 1.0)) ** 2
    root = min(max(f0, 0.0), 0.99) ** 0.5
    eta = (1.0 + root) / (1.0 - root)
    return 1.0 / eta if ior < 1.0 else eta
