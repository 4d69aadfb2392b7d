# SPDX-License-Identifier: GPL-3.0-or-later
"""AOV Output nodes: values of materials that a view layer's AOVs of the same name show."""

from __future__ import annotations

from collections.abc import Iterator

from isophote.material_program import Shown
from isophote.passes import PASSES, channels_of
from isophote.settings import MOST_LEVELS

from .. import compat
from .values import Values, triple

OUTPUT = "ShaderNodeOutputAOV"


def aovs_of(view_layer) -> tuple[str, ...]:
    """AOVs of a view layer as isophote.planes names them, color:NAME or value:NAME: but for those that are taken."""
    return tuple(f"{'color' if aov.type == 'COLOR' else 'value'}:{aov.name}" for aov in view_layer.aovs
                 if aov.is_valid and not is_taken(aov.name))


def is_taken(name: str) -> bool:
    """Whether a pass of Isophote or of a light group has the name."""
    return name.startswith("Combined_") or name in map(compat.pass_name, channels_of(PASSES, MOST_LEVELS))


def outputs_of(tree, stack: tuple = ()) -> Iterator[tuple]:
    """(node, stack) of the AOV Output nodes of a tree and of the groups in it, as nodes.py has stacks."""
    for node in tree.nodes:
        if node.mute:
            continue
        if node.bl_idname == OUTPUT:
            yield node, stack
        elif getattr(node, "node_tree", None):
            yield from outputs_of(node.node_tree, (*stack, node))


def shown_values(material, values: Values, aovs: tuple[str, ...]) -> list[Shown | None]:
    """What a material's AOV Output nodes have for each AOV; nothing where it has no node of its name."""
    nodes = {}
    for node, stack in outputs_of(material.node_tree):
        nodes.setdefault(compat.aov_name(node), (node, stack))
    made = []
    for kind, _, name in (aov.partition(":") for aov in aovs):
        node, stack = nodes.get(name, (None, ()))
        if node is None:
            made.append(None)
        elif kind == "color":
            made.append(tuple(values.color(node, stack, "Color")))
        else:
            made.append(tuple(triple(values.number(node, stack, "Value"), 0.0, 0.0)))
    return made
