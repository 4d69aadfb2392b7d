# SPDX-License-Identifier: GPL-3.0-or-later
"""The Principled BSDF: one node, up to seven closures, in the order of Cycles 4.5 (svm/closure.h).

Files of Blender 3.x hold the first version of the node. It is read as Blender 4 reads such a file, so
that one file is one picture in every version: Specular is the Specular IOR Level, Specular Tint mixes
from white to the base colour, IOR stays.
"""

from __future__ import annotations

import numpy as np

from isophote.values import call1, clamp, is_number, maximum, minimum, mix, square_root, varies

from .closures import CUTOFF, Closure, multiscatter, note_unless, rgb, roughness
from .nodes import find_input
from .values import as_triple, each, not_negative

# Inputs that are not supported, by their names in both versions, and the value at which they do nothing.
LEFT_OUT = {
    "Subsurface Weight": "subsurface scattering is not supported: rendered diffuse",
    "Subsurface": "subsurface scattering is not supported: rendered diffuse",
    "Sheen Weight": "sheen is not supported: left out",
    "Sheen": "sheen is not supported: left out",
    "Coat Weight": "coat is not supported: left out",
    "Clearcoat": "coat is not supported: left out",
    "Anisotropic": "anisotropy is not supported: rendered isotropic",
    "Diffuse Roughness": "Oren-Nayar roughness is not supported: rendered Lambertian",
    "Thin Film Thickness": "thin film is not supported: left out",
    "Transmission Roughness": "not supported (gone since Blender 4): Roughness is used",
}


def principled(values, node, stack, weight) -> list[Closure]:
    """Closures of a Principled BSDF, times a weight."""
    for name, what in LEFT_OUT.items():
        note_unless(values, node, stack, name, 0.0, what)

    def unit(*names):
        return clamp(values.number(node, stack, *names))

    base = not_negative(values.color(node, stack, "Base Color"))
    tint = specular_tint(values, node, stack, base)
    ior = maximum(values.number(node, stack, "IOR"), 1e-5)
    level = maximum(values.number(node, stack, "Specular IOR Level", "Specular"), 0.0)
    alpha, metallic = unit("Alpha"), unit("Metallic")
    transmission = unit("Transmission Weight", "Transmission")
    rough = {"roughness": roughness(values, node, stack), "multiscatter": multiscatter(values, node)}

    closures = [Closure("transparent", as_triple(weight * (1.0 - alpha)))]
    weight = weight * alpha
    emitted = values.color(node, stack, "Emission Color", "Emission")
    closures.append(Closure("emission", weight * emitted * values.number(node, stack, "Emission Strength")))
    if matters(metallic):
        params = rough | rgb("f0", at_most_1(base)) | rgb("f82", at_most_1(tint))
        closures.append(Closure("metal", as_triple(weight * metallic), params))
        weight = weight * (1.0 - metallic)
    if matters(transmission):
        # Light passes the surface twice, going in and coming out: each time the colour's square root.
        params = rough | {"ior": ior} | rgb("tint", tint) | rgb("transmission", each(square_root, at_most_1(base)))
        closures.append(Closure("principled_glass", as_triple(weight * transmission), params))
        weight = weight * (1.0 - transmission)
    coat = None
    eta = adjusted_ior(ior, level)
    if not is_number(eta, 1.0) and matters(weight):
        coat = rough | {"ior": eta} | rgb("tint", tint)
        closures.append(Closure("specular", as_triple(weight), coat))
    closures.append(Closure("diffuse", weight * base, coat=coat))
    return closures


def matters(share) -> bool:
    return varies(share) or share > CUTOFF


def at_most_1(color) -> np.ndarray:
    return each(lambda x: minimum(x, 1.0), color)


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
