# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture of patches: squares side by side, each glowing with what a node graph computes at each of its points.

An orthographic camera looks at them, and the pixel filter is as narrow as can be: a pixel is the value at its centre.
"""

from __future__ import annotations

import math

import bpy


class Patches:
    """Adds square after square, row by row; `save` writes the file."""

    def __init__(self, columns: int, rows: int, pixels: int = 12):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.columns, self.rows, self.names = columns, rows, []
        scene = bpy.context.scene
        scene.render.engine = "CYCLES"
        scene.render.resolution_x, scene.render.resolution_y = columns * pixels, rows * pixels
        scene.cycles.filter_width = 0.01
        scene.world = bpy.data.worlds.new("black")
        scene.world.color = (0.0, 0.0, 0.0)
        camera = bpy.data.cameras.new("camera")
        camera.type, camera.ortho_scale = "ORTHO", float(max(columns, rows))
        placed = bpy.data.objects.new("camera", camera)
        placed.location = (columns / 2.0, rows / 2.0, 5.0)
        scene.camera = placed
        scene.collection.objects.link(placed)
        self.square = bpy.data.meshes.new("square")
        self.square.from_pydata([(-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0)], [], [(0, 1, 2, 3)])

    def add(self, name: str, build) -> None:
        """`build(graph)` returns the socket whose value is shown; numbers of any size are squeezed into [0, 1]."""
        column, row = len(self.names) % self.columns, len(self.names) // self.columns
        if row >= self.rows:
            raise IndexError(f"{name}: there is no room for more than {len(self.names)} patches")
        material = bpy.data.materials.new(name)
        material.use_nodes = True
        material.node_tree.nodes.clear()
        graph = Graph(material.node_tree)
        graph.show(build(graph))
        patch = bpy.data.objects.new(name, self.square.copy())
        patch.data.materials.append(material)
        patch.location = (column + 0.5, row + 0.5, 0.0)
        bpy.context.scene.collection.objects.link(patch)
        self.names.append(name)

    def save(self, path) -> None:
        bpy.ops.wm.save_as_mainfile(filepath=str(path))


class Graph:
    """Nodes of one material. Inputs are sockets, numbers or tuples; `varying` ones differ from point to point."""

    def __init__(self, tree):
        self.tree = tree

    def node(self, kind: str, *, outputs=None, settings=None, **inputs):
        """A node's first output, or that named `outputs`; input names are identifiers, with _ for spaces."""
        made = self.tree.nodes.new("ShaderNode" + kind)
        for name, value in (settings or {}).items():
            setattr(made, name, value)
        for name, value in inputs.items():
            socket = next(s for s in made.inputs if s.identifier in (name, name.replace("_", " ")))
            self.feed(socket, value)
        if outputs is None:
            return next(s for s in made.outputs if s.enabled)
        return next(s for s in made.outputs if outputs in (s.identifier, s.name) and s.enabled)

    def feed(self, socket, value) -> None:
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        elif isinstance(value, tuple):
            socket.default_value = (*value, 1.0)[:len(socket.default_value)]
        else:
            socket.default_value = value

    def math(self, operation: str, *values):
        names = ("Value", "Value_001", "Value_002")
        return self.node("Math", settings={"operation": operation}, **dict(zip(names, values, strict=False)))

    def vector(self, x, y, z):
        return self.node("CombineXYZ", X=x, Y=y, Z=z)

    def place(self, axis: int):
        """The patch's own x or y, from -1/2 to 1/2."""
        return self.node("SeparateXYZ", outputs="XY"[axis], Vector=self.node("TexCoord", outputs="Object"))

    def show(self, socket) -> None:
        parts = self.node("SeparateXYZ", Vector=socket).node.outputs
        squeezed = [self.math("MULTIPLY_ADD", self.math("ARCTANGENT", part), 1.0 / math.pi, 0.5) for part in parts]
        color = self.node("CombineXYZ", **dict(zip("XYZ", squeezed, strict=True)))
        output = self.tree.nodes.new("ShaderNodeOutputMaterial")
        self.feed(output.inputs["Surface"], self.node("Emission", Color=color))
