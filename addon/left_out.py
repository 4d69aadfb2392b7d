# SPDX-License-Identifier: GPL-3.0-or-later
"""What the last render of each view layer left out or made otherwise, for the panel. Gone with Blender."""

from __future__ import annotations

_lines: dict[tuple[str, str], list[str]] = {}  # by names of scene and view layer


def keep(scene: str, layer: str, lines: list[str]) -> None:
    """Keep the notes of a render, as the log has them."""
    _lines[scene, layer] = lines


def lines(scene: str, layer: str) -> list[str] | None:
    """None before a render."""
    return _lines.get((scene, layer))
