# SPDX-License-Identifier: GPL-3.0-or-later
"""Light groups of a view layer: which lamps, objects and world belong to which."""

from __future__ import annotations


class LightGroups:
    """Numbers them from 1, in the view layer's order; 0: none. Blender's objects and worlds name theirs."""

    def __init__(self, view_layer):
        self.names = tuple(group.name for group in view_layer.lightgroups)

    def of(self, thing) -> int:
        """The group of an object or a world, or of None."""
        name = getattr(thing, "lightgroup", "")
        return self.names.index(name) + 1 if name in self.names else 0
