"""Operations of material programs and what their constants mean: one table, kept in step with
kernels/bsdf/bsdf.h by a test.

A program runs from its first instruction to its last. Each path carries a layer weight, 1 at the
start; a closure's weight is its RGB times the layer weight; OP_LAYER_* multiply the layer weight by
what the layer above lets through, so a coated closure comes after its coat. layer_reset makes it 1
again: what follows is another stack.

A colour that light takes on at every bounce between microfacets (the Color socket of Glossy and
Glass) is the closure's tint: multiscatter compensation saturates it. What scales the closure as a
whole (mix and add nodes, alpha, Principled's shares) is the instruction's weight.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from isophote.values import Value

PARAMS = 11

FILM_SPECULAR = ("roughness_x", "multiscatter", "ior", "tint_r", "tint_g", "tint_b", "thickness", "film_ior",
                 "roughness_y")

# name -> (number, names of the parameters). Roughness is Blender's socket, 0 to 1: alpha = roughness^2.
# multiscatter: 1 for Multiscatter GGX, 0 for GGX. ior: of the medium behind the front side.
OPERATIONS: dict[str, tuple[int, tuple[str, ...]]] = {
    "emission": (0, ()),  # weight = radiance; folded into the material's record when prepared
    "diffuse": (1, ()),
    "glossy": (2, ("roughness", "multiscatter", "tint_r", "tint_g", "tint_b")),  # GGX, Fresnel 1
    "refraction": (3, ("roughness", "ior")),
    "glass": (4, ("roughness", "ior", "multiscatter", "tint_r", "tint_g", "tint_b")),
    "transparent": (5, ()),
    "metal": (6, ("roughness", "multiscatter", "f0_r", "f0_g", "f0_b", "f82_r", "f82_g", "f82_b")),
    # Principled's dielectric layer; ior is the one adjusted by Specular IOR Level, tint scales F0
    "specular": (7, ("roughness", "multiscatter", "ior", "tint_r", "tint_g", "tint_b")),
    # transmission: tint of one crossing, the square root of Principled's base colour
    "principled_glass": (8, ("roughness", "multiscatter", "ior", "tint_r", "tint_g", "tint_b",
                             "transmission_r", "transmission_g", "transmission_b")),
    # what follows keeps 1 - weight * albedo of such a layer
    "layer_specular": (9, ("roughness", "multiscatter", "ior", "tint_r", "tint_g", "tint_b")),
    # albedo: the colour, for the light of further bounces between facets
    "rough_diffuse": (10, ("roughness", "albedo_r", "albedo_g", "albedo_b")),
    "translucent": (11, ()),
    "diffuse_toon": (12, ("size", "smooth")),
    "glossy_toon": (13, ("size", "smooth")),
    "sheen": (14, ("roughness",)),  # of microfibres
    "velvet": (15, ("sigma",)),
    "layer_sheen": (16, ("roughness",)),
    # what a tinted coat takes on the viewer's way through it; weight 0 is no coat, 1 all of it
    "layer_absorption": (17, ("ior", "tint_r", "tint_g", "tint_b")),
    "layer_reset": (18, ()),  # what follows lies under nothing
    "beckmann": (19, ("roughness_x", "roughness_y")),
    "ashikhmin_shirley": (20, ("roughness_x", "roughness_y")),
    "conductor": (21, ("roughness", "multiscatter", "n_r", "n_g", "n_b", "k_r", "k_g", "k_b")),
    # along x and y of a frame whose x axis is the tangent
    "aniso_glossy": (22, ("roughness_x", "multiscatter", "tint_r", "tint_g", "tint_b", "roughness_y")),
    "aniso_metal": (23, ("roughness_x", "multiscatter", "f0_r", "f0_g", "f0_b", "f82_r", "f82_g", "f82_b",
                         "roughness_y")),
    "aniso_specular": (24, ("roughness_x", "multiscatter", "ior", "tint_r", "tint_g", "tint_b", "roughness_y")),
    "aniso_conductor": (25, ("roughness_x", "multiscatter", "n_r", "n_g", "n_b", "k_r", "k_g", "k_b",
                             "roughness_y")),
    # under a film `thickness` nanometres thick
    "film_specular": (26, FILM_SPECULAR),
    "film_glass": (27, ("roughness", "multiscatter", "ior", "tint_r", "tint_g", "tint_b", "transmission_r",
                        "transmission_g", "transmission_b", "thickness", "film_ior")),
    "layer_film_specular": (28, FILM_SPECULAR),
    # reflects: 1 for glass, 0 for refraction alone
    "beckmann_glass": (29, ("roughness", "ior", "reflects", "tint_r", "tint_g", "tint_b")),
    "holdout": (30, ()),  # black, and transparent to a transparent film
    # radius: reduced mean free paths in metres. albedo: the colour that comes out, which is in the weight, too. ior and
    # roughness: of the surface where light enters. diffuse: chance that it enters by Lambert's law instead. out: 1
    "subsurface": (31, ("radius_r", "radius_g", "radius_b", "albedo_r", "albedo_g", "albedo_b", "anisotropy", "ior",
                        "roughness", "diffuse", "out")),
    # of volumes, which have no others but emission (per metre): weight is 1/m; extinction is folded into the material's
    # record, and is what absorbs and what scatters together
    "extinction": (64, ()),
    "scattering": (65, ("anisotropy", "alpha")),  # of Draine's phase function (kernels/phase.h)
}

OF_VOLUMES = ("extinction", "scattering")


def closure_mask(used: Iterable[int]) -> int:
    """A bit for each of these operations that surfaces have: what kernels are compiled for."""
    return sum(1 << number for number in set(used) - {OPERATIONS[name][0] for name in OF_VOLUMES})


# These may be left out.
DEFAULTS = {name: 1.0 for name in ("tint_r", "tint_g", "tint_b", "out")} | {"alpha": 0.0}

# alpha^2 at and below which a GGX lobe is a mirror (kernels/bsdf/microfacet.h).
DELTA_ALPHA2 = 2e-10
DELTA_PHONG = 1e-4  # alpha, of Ashikhmin and Shirley's lobe


class Instruction(NamedTuple):
    """A closure or layer: RGB weight and parameters, numbers or Values (values.py). `normal` and `tangent` (its frame's
    x axis), each three of them, stand in for the surface's own. `softened`: where the two normals of a diffuse closure
    disagree about light, its edge is softened."""

    op: int
    weight: tuple
    params: list
    normal: tuple | None = None
    tangent: tuple | None = None
    softened: bool = True


def make_instruction(operation: str, weight, normal=None, tangent=None, softened=True, **params) -> Instruction:
    """An Instruction.

    Raises KeyError for an unknown operation, TypeError for an unknown or missing parameter.
    """
    number, names = OPERATIONS[operation]
    given = {name: DEFAULTS[name] for name in names if name in DEFAULTS} | params
    if set(given) != set(names):
        raise TypeError(f"{operation} takes {', '.join(names) or 'no parameters'}, got {', '.join(params)}")
    values = [as_number(given[name]) for name in names]
    return Instruction(number, tuple(as_number(w) for w in weight), values, normal, tangent, softened)


def as_number(x):
    return x if isinstance(x, Value) else float(x)


def is_delta(op: int, constants, varies: bool = False) -> bool:
    """Whether every lobe of the closure is a delta from both sides, so that it is sampled but never evaluated.

    Where parameters vary that is not known of those that have a roughness.
    """
    name, names = next((name, names) for name, (number, names) in OPERATIONS.items() if number == op)
    if not {"multiscatter", "roughness_x"} & set(names) and name not in ("refraction", "beckmann_glass"):
        return name in ("transparent", "holdout", "subsurface")
    if varies:
        return False
    values = dict(zip(names, constants, strict=False))  # constants are padded
    if "roughness_x" in names:
        alphas = [min(max(values[axis], 0.0), 1.0) ** 2 for axis in ("roughness_x", "roughness_y")]
        return max(alphas) <= DELTA_PHONG if name == "ashikhmin_shirley" else alphas[0] * alphas[1] <= DELTA_ALPHA2
    spread = min(max(values["roughness"], 0.0), 1.0) ** 4
    if name == "refraction":  # bends microfacets' tilts by 1 - 1/ior: nothing is rough at ior 1
        ior = max(values["ior"], 1e-5)
        spread *= min(max(abs(1 - 1 / ior), abs(1 - ior)), 1.0) ** 2
    return spread <= DELTA_ALPHA2
