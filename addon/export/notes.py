# SPDX-License-Identifier: GPL-3.0-or-later
"""Notes: what a scene holds that is approximated or left out, one line each, said once."""

from __future__ import annotations


class Notes:
    """Collects {"kind", "name", "what"}; a note that was made before is not repeated."""

    def __init__(self):
        self.entries: list[dict] = []
        self._seen: set[tuple] = set()

    def add(self, kind: str, name: str, what: str) -> None:
        """`kind` is a word such as object, light, material, camera, world, scene; `what` says what was done."""
        key = (kind, name, what)
        if key not in self._seen:
            self._seen.add(key)
            self.entries.append({"kind": kind, "name": name, "what": what})
