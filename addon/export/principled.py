# SPDX-License-Identifier: GPL-3.0-or-later
"""The Principled BSDF: one node, up to seven closures, in the order of Cycles 4.5 (svm/closure.h).

Files of Blender 3.x hold the first version of the node. It is read as Blender 4 reads such a file, so
that one file is one picture in every version: Specular is the Specular IOR Level, Specular Tint mixes
from white to the base colour, IOR stays.
"""

from __future__ import annotations

import numpy as np

from .closures import CUTOFF, Closure, multiscatter, note_normal, note_unless, rgb, roughness
from .nodes import find_input

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
    emitted = values.color(node, stack, "Emission Color", "Emission")
    closures.append(Closure("emission", weight * emitted * values.number(node, stack, "Emission Strength")))
    if metallic > CUTOFF:
        params = rough | rgb("f0", np.minimum(base, 1.0)) | rgb("f82", np.minimum(tint, 1.0))
        closures.append(Closure("metal", np.full(3, weight * metallic), params))
        weight *= 1.0 - metallic
    if transmission > CUTOFF:
        # Light passes the surface twice, going in and coming out: each time the colour's square root.
        params = rough | {"ior": ior} | rgb("tint", tint) | rgb("transmission", np.sqrt(np.minimum(base, 1.0)))
        closures.append(Closure("principled_glass", np.full(3, weight * transmission), params))
        weight *= 1.0 - transmission
    coat = None
    eta = adjusted_ior(ior, level)
    if eta != 1.0 and weight >= CUTOFF:
        coat = rough | {"ior": eta} | rgb("tint", tint)
        closures.append(Closure("specular", np.full(3, weight), coat))
    closures.append(Closure("diffuse", weight * base, coat=coat))
    return closures


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
