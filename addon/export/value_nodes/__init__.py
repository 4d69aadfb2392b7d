# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that make values: bl_idname -> function of (values, node, output socket, stack).

Each returns the output's value, a number or an array of three objects (values.py), or None where it cannot. What it
cannot express in part it says by values.note.
"""

from __future__ import annotations

from . import arithmetic, colours, curves, images, inputs, lamps, normals, skies, textures, vectors, voronoi

NODES = {**inputs.NODES, **arithmetic.NODES, **vectors.NODES, **colours.NODES, **curves.NODES, **images.NODES,
         **lamps.NODES, **normals.NODES, **skies.NODES, **textures.NODES, **voronoi.NODES}
