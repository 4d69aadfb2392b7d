# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials as programs: a shader graph becomes a short list of weighted closures.

Node types are dispatched by the table SHADERS. Mix and Add Shader fold into the weights; closures
whose weight is zero are dropped; a shader that is not supported names itself in a note.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from isophote.material_program import Displacement, MaterialProgram, make_displacement, make_material
from isophote.materials import make_instruction
from isophote.values import Number, ProgramTooLarge, clamp, is_number, varies

from .. import compat
from .anisotropy import glossy_ratio, principled_ratio, stretched, two_roughnesses
from .aovs import shown_values
from .closures import (
    Closure,
    arrange,
    diffuse_closure,
    framed,
    ior,
    multiscatter,
    note_unless,
    rgb,
    roughness,
)
from .lookups import Lookups
from .nodes import find_input, source_of
from .principled import principled
from .subsurface import subsurface_scattering
from .value_nodes.normals import displaced_normal, moved_normal
from .values import Values, as_triple, each, grey, not_negative, saturate
from .volume import has_volume

DEFAULT_GREY = 0.8  # Cycles' surface of objects without a material


TOO_LARGE = (1.0, 0.0, 1.0)  # radiance of a material that could not be compiled


def material_program(material, notes, lookups: Lookups,
                     aovs: tuple[str, ...] = ()) -> tuple[MaterialProgram, Displacement | None]:
    """The program of a bpy Material, or of None, with what it has for AOVs (aovs.aovs_of); how it moves surfaces."""
    return program_of(material, notes, lookups, aovs, lambda closures: closures)


def held_out_program(material, notes, lookups: Lookups,
                     aovs: tuple[str, ...] = ()) -> tuple[MaterialProgram, Displacement | None]:
    """The same as a hole: all that is not transparent of it is a holdout."""
    return program_of(material, notes, lookups, aovs, held_out)


def strand_program(material, notes, lookups: Lookups,
                   aovs: tuple[str, ...] = ()) -> tuple[MaterialProgram, Displacement | None]:
    """The same on strands, below whose surface no light wanders."""
    return program_of(material, notes, lookups, aovs, on_strands)


def on_strands(closures: list[Closure]) -> list[Closure]:
    return [replace(each, operation="diffuse", params={}) if each.operation == "subsurface" else each
            for each in closures]


def held_out(closures: list[Closure]) -> list[Closure]:
    """As Cycles, surface_shader_apply_holdout."""
    passing = [closure for closure in closures if closure.operation == "transparent"]
    share = as_triple(1.0)
    for closure in passing:
        share = each(lambda rest, passed: rest - passed, share, closure.weight)
    return [*passing, Closure("holdout", share)]


def program_of(material, notes, lookups: Lookups, aovs: tuple[str, ...],
               changed) -> tuple[MaterialProgram, Displacement | None]:
    """`changed` makes the closures that count of those that the nodes have."""
    if material is None:
        return make_material(arrange(changed([Closure("diffuse", np.full(3, DEFAULT_GREY))]))), None
    values = Values("material", material.name, notes, lookups)
    values.material_index = material.pass_index
    if not compat.uses_nodes(material):
        # Cycles shades such materials with a Diffuse BSDF; metallic and roughness do not count.
        return make_material(arrange(changed([Closure("diffuse", np.array(material.diffuse_color[:3]))]))), None
    try:
        displacement = displace(material, values)
        closures = arrange(changed(surface_closures(material, values)))
        if not closures and has_volume(material.node_tree) and not is_boundary(material):
            closures = [make_instruction("diffuse", (0.0, 0.0, 0.0))]
        return make_material(closures, shown_values(material, values, aovs)), displacement
    except ProgramTooLarge as error:
        values.note(f"its node graph is too large ({error}): rendered magenta")
        return make_material(arrange([Closure("emission", np.array(TOO_LARGE))])), None


def displace(material, values: Values) -> Displacement | None:
    """How the output moves the surface, None where it does not. What it bends becomes the values' surface normal."""
    output = material.node_tree.get_output_node("CYCLES")
    if output is None or not values.is_linked(output, (), "Displacement"):
        return None
    method, vector = compat.displacement_method(material), values.vector(output, (), "Displacement")
    if method == "BUMP":
        values.surface_normal = displaced_normal(values, vector)
        return None
    if method == "BOTH":
        values.surface_normal = moved_normal(values, vector)
    return make_displacement(vector, turns_normals=method == "DISPLACEMENT")


def surface_closures(material, values: Values) -> list[Closure]:
    """Closures of the output that Cycles would use."""
    output = material.node_tree.get_output_node("CYCLES")
    if output is None:
        values.note("no active output for this engine: rendered black")
        return []
    return closures_of(values, find_input(output, "Surface"), (), 1.0)


def is_boundary(material) -> bool:
    """Whether a material with a volume has no surface, as Cycles has it: whatever feeds one makes it black at least."""
    output = material.node_tree.get_output_node("CYCLES")
    return source_of(find_input(output, "Surface")).node is None


def closures_of(values: Values, socket, stack, weight: Number) -> list[Closure]:
    """The closures that feed a shader input, times a weight."""
    source = source_of(socket, stack)
    if source.node is None or is_number(weight, 0.0):
        return []
    shader = SHADERS.get(source.node.bl_idname)
    if shader is None:
        values.note(f"{source.node.name} ({source.node.bl_idname}): not supported, left out")
        return []
    closures = shader(values, source.node, source.stack, weight)
    return framed(closures, values, source.node, source.stack)


def emitted_radiance(values: Values, socket) -> np.ndarray:
    """Of all that the shaders of a world or a lamp emit, as objects [3]; nothing else of them counts."""
    total = grey(0.0)
    for closure in closures_of(values, socket, (), 1.0):
        if closure.operation == "emission":
            total = each(lambda a, b: a + b, total, closure.weight)
        else:
            values.note(f"a shader that does not emit ({closure.operation}): not seen in a {values.kind}")
    return total


# --- shader nodes ----------------------------------------------------------------------------------
# Each takes (values, node, stack, weight) and returns closures.


def mix_shader(values, node, stack, weight):
    factor = clamp(values.number(node, stack, "Fac"))
    first = closures_of(values, node.inputs[1], stack, weight * (1.0 - factor))
    return first + closures_of(values, node.inputs[2], stack, weight * factor)


def add_shader(values, node, stack, weight):
    return closures_of(values, node.inputs[0], stack, weight) + closures_of(values, node.inputs[1], stack, weight)


def diffuse(values, node, stack, weight):
    return [diffuse_closure(weight, values.color(node, stack, "Color"), values.number(node, stack, "Roughness"))]


def translucent(values, node, stack, weight):
    return [Closure("translucent", weight * values.color(node, stack, "Color"))]


def toon(values, node, stack, weight):
    operation = {"DIFFUSE": "diffuse_toon", "GLOSSY": "glossy_toon"}[node.component]
    params = {"size": values.number(node, stack, "Size"), "smooth": values.number(node, stack, "Smooth")}
    return [Closure(operation, weight * values.color(node, stack, "Color"), params)]


def sheen(values, node, stack, weight):
    """Sheen BSDF, which was the Velvet BSDF before 4.0."""
    rough = values.number(node, stack, "Roughness", "Sigma")
    color = weight * values.color(node, stack, "Color")
    if getattr(node, "distribution", "ASHIKHMIN") == "ASHIKHMIN":
        return [Closure("velvet", color, {"sigma": rough})]
    return [Closure("sheen", color, {"roughness": rough})]


PHONG_AND_BECKMANN = {"BECKMANN": "beckmann", "ASHIKHMIN_SHIRLEY": "ashikhmin_shirley"}


def glossy(values, node, stack, weight):
    color, rough = values.color(node, stack, "Color"), {"roughness": roughness(values, node, stack)}
    ratio = glossy_ratio(values, node, stack)
    other = PHONG_AND_BECKMANN.get(node.distribution)
    if other:
        return [Closure(other, weight * color, two_roughnesses(rough, ratio))]
    operation, params = stretched("glossy", rough | {"multiscatter": multiscatter(values, node)}, ratio)
    return [tinted(operation, weight, color, params)]


def tinted(operation, weight, color, params) -> Closure:
    """A closure whose colour counts at every bounce between microfacets; none where the colour is black."""
    color = not_negative(color)
    return Closure(operation, as_triple(weight if varies(color) or color.any() else 0.0), params | rgb("tint", color))


def refraction(values, node, stack, weight):
    params = {"roughness": roughness(values, node, stack), "ior": ior(values, node, stack)}
    color = weight * values.color(node, stack, "Color")
    if node.distribution == "BECKMANN":
        return [Closure("beckmann_glass", color, params | {"reflects": 0.0})]
    return [Closure("refraction", color, params)]


def glass(values, node, stack, weight):
    note_unless(values, node, stack, "Thin Film Thickness", 0.0, "thin film is not supported: left out")
    params = {"roughness": roughness(values, node, stack), "ior": ior(values, node, stack)}
    color = values.color(node, stack, "Color")
    if node.distribution == "BECKMANN":
        return [tinted("beckmann_glass", weight, color, params | {"reflects": 1.0})]
    return [tinted("glass", weight, color, params | {"multiscatter": multiscatter(values, node)})]


def metallic(values, node, stack, weight):
    """Metallic BSDF of 4.3 and newer."""
    note_unless(values, node, stack, "Thin Film Thickness", 0.0, "thin film is not supported: left out")
    ratio = principled_ratio(values, node, stack)
    params = {"roughness": roughness(values, node, stack), "multiscatter": multiscatter(values, node)}
    if node.fresnel_type == "F82":
        f0, f82 = values.color(node, stack, "Base Color"), values.color(node, stack, "Edge Tint")
        operation, params = stretched("metal", params | rgb("f0", saturate(f0)) | rgb("f82", saturate(f82)), ratio)
        return [Closure(operation, as_triple(weight), params)]
    n, k = values.color(node, stack, "IOR"), values.color(node, stack, "Extinction")
    operation, params = stretched("conductor", params | rgb("n", not_negative(n)) | rgb("k", not_negative(k)), ratio)
    return [Closure(operation, as_triple(weight), params)]


def transparent(values, node, stack, weight):
    return [Closure("transparent", weight * values.color(node, stack, "Color"))]


def holdout(values, node, stack, weight):
    return [Closure("holdout", as_triple(weight))]


def emission(values, node, stack, weight):
    color = values.color(node, stack, "Color") * values.number(node, stack, "Strength")
    if not varies(color) and np.any(color < 0.0):
        values.note(f"{node.name}: negative emission is left out")
    return [Closure("emission", weight * color)]


def background(values, node, stack, weight):
    """Emission of a world; in a surface Cycles draws nothing there."""
    return emission(values, node, stack, weight) if values.kind == "world" else []


def as_diffuse(values, node, stack, weight):
    values.note(f"{node.name} ({node.bl_idname}): not supported, rendered as Diffuse")
    return [Closure("diffuse", weight * values.color(node, stack, "Color", "Base Color"))]


SHADERS = {
    "ShaderNodeMixShader": mix_shader,
    "ShaderNodeAddShader": add_shader,
    "ShaderNodeBsdfDiffuse": diffuse,
    "ShaderNodeBsdfGlossy": glossy,
    "ShaderNodeBsdfAnisotropic": glossy,
    "ShaderNodeBsdfRefraction": refraction,
    "ShaderNodeBsdfGlass": glass,
    "ShaderNodeBsdfMetallic": metallic,
    "ShaderNodeBsdfTransparent": transparent,
    "ShaderNodeBsdfPrincipled": principled,
    "ShaderNodeEmission": emission,
    "ShaderNodeHoldout": holdout,
    "ShaderNodeBackground": background,
    "ShaderNodeBsdfTranslucent": translucent,
    "ShaderNodeBsdfVelvet": sheen,
    "ShaderNodeBsdfSheen": sheen,
    "ShaderNodeBsdfToon": toon,
    "ShaderNodeBsdfHair": as_diffuse,
    "ShaderNodeBsdfHairPrincipled": as_diffuse,
    "ShaderNodeSubsurfaceScattering": subsurface_scattering,
    "ShaderNodeEeveeSpecular": as_diffuse,
}
