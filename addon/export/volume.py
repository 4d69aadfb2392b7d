# SPDX-License-Identifier: GPL-3.0-or-later
"""Volumes of materials and of the world as programs: what they absorb, scatter and emit per metre.

Node types are dispatched by the table VOLUMES, as in material.py for surfaces.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from isophote.material_program import MaterialProgram, make_material
from isophote.materials import Instruction, make_instruction
from isophote.values import Number, ProgramTooLarge, clamp, is_number, operations, rewritten, square_root, varies
from isophote.volumes import OF_SURFACES

from .. import compat
from .lookups import Lookups
from .nodes import find_input, source_of
from .values import Values, call3, each, grey, not_negative

CUTOFF = 1e-5  # Cycles' CLOSURE_WEIGHT_CUTOFF, of densities and emission
STEFAN_BOLTZMANN = 5.670373e-8 * 1e-6 / math.pi  # as Cycles scales it
RAYLEIGH = (0.0, 1.0)  # as Draine's phase function


@dataclass
class Parts:
    """Sums by name of what a volume does, objects [3], 1/m; lobes are (scattering, anisotropy, alpha)."""

    absorption: np.ndarray = field(default_factory=lambda: grey(0.0))
    emission: np.ndarray = field(default_factory=lambda: grey(0.0))
    lobes: list[tuple[np.ndarray, Number, Number]] = field(default_factory=list)

    def absorb(self, coefficient) -> None:
        self.absorption = self.absorption + not_negative(coefficient)

    def emit(self, radiance) -> None:
        self.emission = self.emission + not_negative(radiance)

    def scatter(self, coefficient, lobes) -> None:
        """`lobes`: (share, anisotropy, alpha)."""
        self.lobes += [(not_negative(coefficient) * share, g, alpha) for share, g, alpha in lobes]

    def instructions(self) -> list:
        """Equal lobes are one."""
        together: dict[tuple, np.ndarray] = {}
        for coefficient, g, alpha in self.lobes:
            together[g, alpha] = together.get((g, alpha), grey(0.0)) + coefficient
        extinction = sum(together.values(), self.absorption)
        made = [("extinction", extinction, {}), ("emission", self.emission, {})]
        made += [("scattering", total, {"anisotropy": g, "alpha": alpha}) for (g, alpha), total in together.items()]
        return [make_instruction(name, weight, **params) for name, weight, params in made
                if varies(weight) or weight.any()]


def has_volume(tree) -> bool:
    """Whether something feeds the Volume of a node tree's output."""
    output = tree.get_output_node("CYCLES")
    return output is not None and source_of(find_input(output, "Volume")).node is not None


def volume_program(owner, tree, kind: str, notes, lookups: Lookups) -> MaterialProgram | None:
    """Of a material or a world with nodes; None where it has no volume."""
    if not has_volume(tree):
        return None
    values, parts = Values(kind, owner.name, notes, lookups), Parts()
    values.fills = True
    values.material_index = getattr(owner, "pass_index", 0)  # worlds have none
    add_parts(parts, values, find_input(tree.get_output_node("CYCLES"), "Volume"), (), 1.0)
    try:
        return make_material(without_surface(values, parts.instructions()))
    except ProgramTooLarge as error:
        values.note(f"its volume's node graph is too large ({error}): left out")
        return make_material([])


def without_surface(values: Values, instructions: list[Instruction]) -> list[Instruction]:
    """The instructions with 0 for what only a surface has, as in Cycles: normals, UV maps, attributes of elements."""
    box = {values.lookups.attributes.get((kind, "")) for kind in ("box_low", "box_sizes")}

    def change(call, _):
        if call.name in OF_SURFACES or (call.name == "attribute" and call.data not in box):
            values.note(f"{call.name.replace('_', ' ')} in a volume, where there is no surface: 0, as in Cycles")
            return (0.0,) * operations()[call.name].outputs
        return None

    return [each._replace(weight=tuple(rewritten(number, change) for number in each.weight),
                          params=[rewritten(number, change) for number in each.params]) for each in instructions]


def material_volume(material, notes, lookups: Lookups) -> MaterialProgram | None:
    """Of a bpy Material, or of None."""
    if material is None or not compat.uses_nodes(material):
        return None
    return volume_program(material, material.node_tree, "material", notes, lookups)


def add_parts(parts: Parts, values: Values, socket, stack, weight: Number) -> None:
    """Adds what feeds a shader input, times a weight."""
    source = source_of(socket, stack)
    if source.node is None or is_number(weight, 0.0):
        return
    volume = VOLUMES.get(source.node.bl_idname)
    if volume is None:
        values.note(f"{source.node.name} ({source.node.bl_idname}) in a volume: not supported, left out")
        return
    volume(parts, values, source.node, source.stack, weight)


# --- nodes -------------------------------------------------------------------------------------------


def mix_shader(parts, values, node, stack, weight):
    factor = clamp(values.number(node, stack, "Fac"))
    add_parts(parts, values, node.inputs[1], stack, weight * (1.0 - factor))
    add_parts(parts, values, node.inputs[2], stack, weight * factor)


def add_shader(parts, values, node, stack, weight):
    for socket in node.inputs[:2]:
        add_parts(parts, values, socket, stack, weight)


def density(values, node, stack, weight):
    return weight * not_negative(grey(values.number(node, stack, "Density")))


def absorption(parts, values, node, stack, weight):
    parts.absorb(density(values, node, stack, weight) * (1.0 - values.color(node, stack, "Color")))


def scattering(parts, values, node, stack, weight):
    coefficient = density(values, node, stack, weight) * values.color(node, stack, "Color")
    parts.scatter(coefficient, phases(values, node, stack))


def coefficients(parts, values, node, stack, weight):
    """Volume Coefficients of 4.5 and newer."""
    parts.absorb(weight * values.vector(node, stack, "Absorption Coefficients"))
    parts.scatter(weight * values.vector(node, stack, "Scatter Coefficients"), phases(values, node, stack))
    parts.emit(weight * values.vector(node, stack, "Emission Coefficients"))


def emission(parts, values, node, stack, weight):
    parts.emit(weight * values.color(node, stack, "Color") * values.number(node, stack, "Strength"))


def principled(parts, values, node, stack, weight):
    """Color scatters; of what it leaves, what the square root of Absorption Color leaves is absorbed."""
    dense, color = density(values, node, stack, weight), values.color(node, stack, "Color")
    root = each(square_root, not_negative(values.color(node, stack, "Absorption Color")))
    parts.scatter(dense * color, [(1.0, values.number(node, stack, "Anisotropy"), 0.0)])
    parts.absorb(dense * not_negative(1.0 - color) * not_negative(1.0 - root))
    parts.emit(weight * values.number(node, stack, "Emission Strength") * values.color(node, stack, "Emission Color"))
    glow = values.number(node, stack, "Blackbody Intensity")
    if is_number(glow, 0.0):
        return
    kelvin = not_negative(grey(values.number(node, stack, "Temperature")))[0]
    power = STEFAN_BOLTZMANN * (1.0 + (kelvin * kelvin * kelvin * kelvin - 1.0) * glow)
    if varies(power) or power > CUTOFF:
        parts.emit(weight * power * values.color(node, stack, "Blackbody Tint") * call3("blackbody", kelvin))


def phases(values, node, stack) -> list[tuple]:
    """(share, anisotropy, alpha) of the node's phase function."""
    kind = getattr(node, "phase", "HENYEY_GREENSTEIN")
    if kind == "RAYLEIGH":
        return [(1.0, *RAYLEIGH)]
    if kind == "DRAINE":
        return [(1.0, values.number(node, stack, "Anisotropy"), values.number(node, stack, "Alpha"))]
    if kind == "MIE":
        diameter = values.number(node, stack, "Diameter")
        if varies(diameter):
            values.note(f"{node.name}: a diameter that differs from point to point is not supported: 20 is used")
        return droplets(20.0 if varies(diameter) else diameter)
    if kind == "FOURNIER_FORAND":
        values.note(f"{node.name}: Fournier-Forand is not supported: rendered as Henyey-Greenstein of anisotropy 0.9")
        return [(1.0, 0.9, 0.0)]
    return [(1.0, values.number(node, stack, "Anisotropy"), 0.0)]


def droplets(diameter: float) -> list[tuple]:
    """Water droplets of a diameter in micrometres as Henyey and Greenstein's and Draine's phase functions.

    Jendersie and d'Eon 2023, "An Approximate Mie Scattering Function for Fog and Cloud Rendering", equations 7 to 22.
    """
    d = max(diameter, 0.0)
    if d <= 0.1:
        g, draine, alpha = 13.8 * d * d, 1.1456 * d * math.sin(9.29044 * d), 250.0
        share = 0.252977 - 312.983 * d ** 4.3
    elif d < 1.5:
        x = math.log(d)
        turn = math.cos((x - 0.238604) * (x + 1.00667) / (0.507522 - 0.15677 * x))
        g, alpha = 0.862 - 0.143 * x * x, 250.0
        draine = 0.379685 * math.cos(1.19692 * turn + 1.37932 * x + 0.0625835) + 0.344213
        share = 0.146209 * math.cos(3.38707 * x + 2.11193) + 0.316072 + 0.0778917 * x
    elif d < 5.0:
        x = math.log(d)
        g, alpha = 0.0604931 * math.log(x) + 0.940256, 7.30354 * x + 6.31675
        draine = 0.500411 - 0.081287 / (-2.0 * x + math.tan(x) + 1.27551)
        share = 0.026914 * (x - math.cos(5.68947 * (math.log(x) - 0.0292149))) + 0.3764
    else:
        g, draine = math.exp(-0.0990567 / (d - 1.67154)), math.exp(-2.20679 / (d + 3.91029) - 0.428934)
        alpha = math.exp(3.62489 - 8.29288 / (d + 5.52825))
        share = math.exp(-0.599085 / (d - 0.641583) - 0.665888)
    return [(1.0 - share, g, 0.0), (share, draine, alpha)]


VOLUMES = {
    "ShaderNodeMixShader": mix_shader,
    "ShaderNodeAddShader": add_shader,
    "ShaderNodeVolumeAbsorption": absorption,
    "ShaderNodeVolumeScatter": scattering,
    "ShaderNodeVolumePrincipled": principled,
    "ShaderNodeVolumeCoefficients": coefficients,
    "ShaderNodeEmission": emission,
}
