# SPDX-License-Identifier: GPL-3.0-or-later
"""What the values of materials read beside the shaded point: attributes of meshes, pictures, tables of curves."""

from __future__ import annotations

import numpy as np

ATTRIBUTE_KINDS = ("uv", "named", "generated")  # of the keys (kind, name) by which attributes are asked for


class Lookups:
    """Numbers what materials ask for; collected while they are exported."""

    def __init__(self):
        self.attributes: dict[tuple[str, str], int] = {}
        self._tables: dict[bytes, int] = {}
        self._entries: list[np.ndarray] = []
        self._length = 0

    def attribute(self, kind: str, name: str = "") -> int:
        """The number of an attribute: kind "uv" with a map's name ("": the active one), "named" with an attribute's, or
        "generated"."""
        assert kind in ATTRIBUTE_KINDS
        return self.attributes.setdefault((kind, name), len(self.attributes))

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
