# SPDX-License-Identifier: GPL-3.0-or-later
"""What the values of materials read beside the shaded point: attributes of meshes, pictures, tables of curves."""

from __future__ import annotations

import numpy as np

# Of the keys (kind, name) by which attributes are asked for.
ATTRIBUTE_KINDS = ("uv", "named", "generated", "color", "tangent", "island", "pointiness")


class Lookups:
    """Numbers what materials ask for; collected while they are exported.

    `view_layer_value(name)` is the value of a property of the view layer, the scene or the world, four numbers.
    """

    def __init__(self, view_layer_value):
        self.view_layer_value = view_layer_value
        self.instance_columns: dict[tuple[str, str, int], int] = {}
        self.attributes: dict[tuple[str, str], int] = {}
        self._tables: dict[bytes, int] = {}
        self._entries: list[np.ndarray] = []
        self._length = 0

    def attribute(self, kind: str, name: str = "") -> int:
        """The number of an attribute: kind "uv" with a map's name ("": the active one), "tangent" with that of the map
        along which it runs, "color" likewise, "named" with an attribute's, "generated", "island" or "pointiness"."""
        assert kind in ATTRIBUTE_KINDS
        return self.attributes.setdefault((kind, name), len(self.attributes))

    def instance(self, kind: str, name: str = "", part: int = 0) -> int:
        """The column of what is known of each instance (instance_values.py has the kinds)."""
        return self.instance_columns.setdefault((kind, name, part), len(self.instance_columns))

    def table(self, entries) -> int:
        """Where a row of numbers begins in value_tables; equal rows are kept once."""
        entries = np.ascontiguousarray(entries, np.float32).ravel()
        key = entries.tobytes()
        if key not in self._tables:
            self._tables[key] = self._length
            self._entries.append(entries)
            self._length += len(entries)
        return self._tables[key]

    def arrays(self) -> dict[str, np.ndarray]:
        """The scene's arrays."""
        return {"value_tables": np.concatenate(self._entries)} if self._entries else {}
