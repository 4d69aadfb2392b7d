# SPDX-License-Identifier: GPL-3.0-or-later
"""What the last render of each scene said of what its settings cost, for the panel; gone with Blender."""

from __future__ import annotations

from isophote.ledger import ledger_lines

from .log import taken

_sentences: dict[str, list[str]] = {}  # by name of the scene


def keep(scene: str, result: dict) -> None:
    """Keep the ledger of a render; `result` is Session.result()."""
    _sentences[scene] = ledger_lines(taken(result))


def sentences(scene: str) -> list[str]:
    """Of the scene's last render, none before it."""
    return _sentences.get(scene, [])
