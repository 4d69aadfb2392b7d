# SPDX-License-Identifier: GPL-3.0-or-later
"""AOV Output nodes: values of materials that a view layer's AOVs of the same name show."""

from __future__ import annotations

from isophote.material_program import Shown
from isophote.passes import PASSES

from .. import compat
from .values import Values, triple

OUTPUT = "ShaderNodeOutputAOV"


def aovs_of(view_layer) -> tuple[str, ...]:
    """AOVs of a view layer as isophote.planes names them, color:NAME or value:NAME: but for those that are taken."""
    return tuple(f"{'color' if aov.type == 'COLOR' else 'value'}:{aov.name}" for aov in view_layer.aovs
                 if aov.is_valid and not is_taken(aov.name))


def is_taken(name: str) -> bool:
    """Whether a pass of Isophote or of a light group has the name."""
    return name.startswith("Combined_") or name in {entry.blender_name for entry in PASSES.values()}


def has_output(tree) -> bool:
    """Whether a node tree or a group in it has an AOV Output."""
    return any(node.bl_idname == OUTPUT or getattr(node, "node_tree", None) and has_output(node.node_tree)
               for node in tree.nodes)


def shown_values(material, values: Values, aovs: tuple[str, ...]) -> list[Shown | None]:
    """What a material's AOV Output nodes have for each AOV; nothing where it has no node of its name."""
    nodes = {}
    for node in material.node_tree.nodes:
        if node.bl_idname == OUTPUT:
            nodes.setdefault(compat.aov_name(node), node)
            continue
        group = getattr(node, "node_tree", None)
        if group and has_output(group):
            values.note(f"{node.name}: AOV outputs in groups are not supported: left out")
    made = []
    for kind, _, name in (aov.partition(":") for aov in aovs):
        node = nodes.get(name)
        if node is None:
            made.append(None)
        elif kind == "color":
            made.append(tuple(values.color(node, (), "Color")))
        else:
            made.append(tuple(triple(values.number(node, (), "Value"), 0.0, 0.0)))
    return made
