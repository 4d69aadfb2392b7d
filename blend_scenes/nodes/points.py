# SPDX-License-Identifier: GPL-3.0-or-later
"""What the scripts that show textures share: points on a slant through space, and numbers that go across a patch."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from patches import Patches

COLUMNS = 10


def point(g):
    """About from 0 to 1 in each coordinate, on no plane of the axes."""
    x, y = (g.math("ADD", g.place(axis), 0.5) for axis in (0, 1))
    return g.vector(x, y, g.math("MULTIPLY_ADD", x, 0.5, g.math("MULTIPLY_ADD", y, 0.3, 0.1)))


def across(low: float, high: float):
    """A function of a graph: a number that goes from low to high from left to right."""
    return lambda g: g.math("MULTIPLY_ADD", g.place(0), high - low, 0.5 * (low + high))


def linked(g, inputs: dict) -> dict:
    """Inputs of a node: functions are asked for a socket of the graph, what is None is left out."""
    return {name: value(g) if callable(value) else value for name, value in inputs.items() if value is not None}


def make_patches(name: str, entries: list, columns: int = COLUMNS, pixels: int = 12) -> None:
    """Save NAME.blend of (name, build) in the folder that the script was given after `--`."""
    folder = Path(sys.argv[sys.argv.index("--") + 1])
    folder.mkdir(parents=True, exist_ok=True)
    patches = Patches(columns, -(-len(entries) // columns), pixels)
    for entry in entries:
        patches.add(*entry)
    patches.save(folder / f"{name}.blend")
