# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the scenes that compare the nodes of Blender's Converter, Color and Vector menus with Cycles.

    python blend_scenes/nodes/make_conversions.py -- FOLDER     (a Python with bpy; or blender -b --python ...)

numbers.blend, vectors.blend and colours.blend show each node in each of its modes as a patch, once with inputs that
vary over the patch and once with constant ones. spaces.blend holds tilted squares before a perspective camera.
"""

from __future__ import annotations

import random
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from patches import Patches


def modes(kind: str, name: str) -> list[str]:
    """All values that an enumeration of a node has in this version of Blender."""
    return [item.identifier for item in getattr(bpy.types, "ShaderNode" + kind).bl_rna.properties[name].enum_items]


class Inputs:
    """What the patches feed into their nodes: numbers a, b, c, vectors u, v, w, colours p, q, a factor t."""

    def __init__(self, graph, varying: bool):
        if varying:
            x, y = graph.place(0), graph.place(1)
        else:
            x, y = (graph.node("Value") for _ in range(2))
            x.default_value, y.default_value = 0.37, -0.21
        self.x, self.y = x, y
        self.a, self.b = graph.math("MULTIPLY", x, 6.3), graph.math("MULTIPLY", y, 5.1)
        self.c = graph.math("MULTIPLY_ADD", x, y, 0.7)
        self.u = graph.vector(self.a, self.b, self.c)
        self.v = graph.vector(self.c, self.a, graph.math("MULTIPLY_ADD", y, -3.0, 0.3))
        self.w = graph.vector(self.b, 0.4, graph.math("MULTIPLY", x, -2.0))
        self.p = self.color(graph, x, y, graph.math("SUBTRACT", x, y))
        self.q = self.color(graph, y, graph.math("MULTIPLY", x, y), x)
        self.t = graph.math("MULTIPLY_ADD", graph.math("ADD", x, y), 0.8, 0.5)

    @staticmethod
    def color(graph, *parts):
        """Mostly in [0, 1], also beyond."""
        return graph.node("CombineXYZ", **{axis: graph.math("MULTIPLY_ADD", part, 1.3, 0.5)
                                           for axis, part in zip("XYZ", parts, strict=True)})


def numbers() -> dict:
    """Name -> function of (graph, inputs) that returns the socket shown."""
    made = {f"Math {mode}": lambda g, i, mode=mode: g.math(mode, i.a, i.b, i.c) for mode in modes("Math", "operation")}
    made |= {f"Math {mode} clamped": lambda g, i, mode=mode: g.node(
        "Math", settings={"operation": mode, "use_clamp": True}, Value=i.a, Value_001=i.b) for mode in ("ADD", "SINE")}
    made |= {f"Math {mode} over many periods": lambda g, i, mode=mode: g.math(
        mode, g.math("MULTIPLY", i.a, 4.0), 0.7) for mode in ("SINE", "MODULO", "WRAP", "PINGPONG")}
    made |= {f"Math POWER {exponent}": lambda g, i, exponent=exponent: g.math("POWER", i.a, exponent)
             for exponent in (2.0, 3.0, -1.0, 0.5, 0.0)}
    made |= {f"Clamp {mode}": lambda g, i, mode=mode: g.node(
        "Clamp", settings={"clamp_type": mode}, Value=i.a, Min=i.b, Max=i.c) for mode in modes("Clamp", "clamp_type")}
    for mode in modes("MapRange", "interpolation_type"):
        for clamped in (False, True):
            made[f"Map Range {mode} {'clamped' if clamped else ''}"] = lambda g, i, mode=mode, clamped=clamped: g.node(
                "MapRange", settings={"interpolation_type": mode, "clamp": clamped}, Value=i.a, From_Min=i.b,
                From_Max=i.c, To_Min=i.y, To_Max=i.x, Steps=g.math("ADD", i.b, 2.0))
    made["Map Range of nothing"] = lambda g, i: g.node("MapRange", Value=i.a, From_Min=1.0, From_Max=1.0, To_Min=0.5)
    return made


def vectors() -> dict:
    made = {f"Vector Math {mode}": lambda g, i, mode=mode: g.node(
        "VectorMath", settings={"operation": mode}, Vector=i.u, Vector_001=i.v, Vector_002=i.w, Scale=i.c)
        for mode in modes("VectorMath", "operation")}
    for mode in modes("MapRange", "interpolation_type"):
        for clamped in (False, True):
            settings = {"interpolation_type": mode, "clamp": clamped, "data_type": "FLOAT_VECTOR"}
            made[f"Map Range vector {mode} {clamped}"] = lambda g, i, settings=settings: g.node(
                "MapRange", settings=settings, Vector=i.u, From_Min_FLOAT3=i.v, From_Max_FLOAT3=i.w,
                To_Min_FLOAT3=(-0.3, 0.2, 1.0), To_Max_FLOAT3=i.p, Steps_FLOAT3=(3.0, 0.0, 4.5))
    for mode in modes("VectorRotate", "rotation_type"):
        for inverted in (False, True):
            made[f"Vector Rotate {mode} {inverted}"] = lambda g, i, mode=mode, inverted=inverted: g.node(
                "VectorRotate", settings={"rotation_type": mode, "invert": inverted}, Vector=i.u,
                **({"Rotation": i.w} if mode == "EULER_XYZ" else {"Angle": i.a}),
                **({"Axis": i.v} if mode == "AXIS_ANGLE" else {}), Center=(0.2, -0.4, 0.1))
    made["Vector Rotate about nothing"] = lambda g, i: g.node(
        "VectorRotate", settings={"rotation_type": "AXIS_ANGLE"}, Vector=i.u, Axis=(0.0, 0.0, 0.0), Angle=i.a)
    for mode in modes("Mapping", "vector_type"):
        settings = {"vector_type": mode}
        moved = {"Location": (0.3, -0.2, 0.5)} if mode in ("POINT", "TEXTURE") else {}
        made[f"Mapping {mode}"] = lambda g, i, settings=settings, moved=moved: g.node(
            "Mapping", settings=settings, Vector=i.u, Rotation=(0.3, -0.7, 1.1), Scale=(2.0, 0.5, 0.0), **moved)
        moved = {"Location": "w"} if moved else {}
        made[f"Mapping {mode} linked"] = lambda g, i, settings=settings, moved=moved: g.node(
            "Mapping", settings=settings, Vector=i.u, Rotation=i.v, Scale=i.p, **{name: i.w for name in moved})
    for output in ("Normal", "Dot"):
        made[f"Normal {output}"] = lambda g, i, output=output: direction(g, i.u, output)
    made["Normal Dot unlinked"] = lambda g, i: direction(g, None, "Dot")
    made["Combine XYZ"] = lambda g, i: g.vector(i.a, i.b, i.c)
    for axis in "XYZ":
        made[f"Separate XYZ {axis}"] = lambda g, i, axis=axis: g.node("SeparateXYZ", outputs=axis, Vector=i.u)
    for mode in ("UNIFORM", "NON_UNIFORM"):
        for clamped in (False, True):
            settings = {"data_type": "VECTOR", "factor_mode": mode, "clamp_factor": clamped}
            made[f"Mix vector {mode} {clamped}"] = lambda g, i, settings=settings, mode=mode: g.node(
                "Mix", outputs="Result_Vector", settings=settings, A_Vector=i.u, B_Vector=i.v,
                **({"Factor_Float": i.t} if mode == "UNIFORM" else {"Factor_Vector": i.w}))
    for clamped in (False, True):
        made[f"Mix number {clamped}"] = lambda g, i, clamped=clamped: g.node(
            "Mix", outputs="Result_Float", settings={"data_type": "FLOAT", "clamp_factor": clamped}, A_Float=i.a,
            B_Float=i.b, Factor_Float=i.t)
    return made


def direction(graph, normal, output: str):
    made = graph.node("Normal", outputs=output, **({} if normal is None else {"Normal": normal}))
    made.node.outputs["Normal"].default_value = (0.3, -0.5, 0.8)
    return made


def colours() -> dict:
    made = {}
    for mode in modes("MixRGB", "blend_type"):
        made[f"Mix {mode}"] = lambda g, i, mode=mode: g.node(
            "Mix", outputs="Result_Color", settings={"data_type": "RGBA", "blend_type": mode, "clamp_factor": False},
            A_Color=i.p, B_Color=i.q, Factor_Float=i.t)
        made[f"Mix RGB {mode}"] = lambda g, i, mode=mode: g.node(
            "MixRGB", settings={"blend_type": mode, "use_clamp": True}, Color1=i.p, Color2=i.q, Fac=i.t)
    made["Mix clamped"] = lambda g, i: g.node(
        "Mix", outputs="Result_Color", settings={"data_type": "RGBA", "clamp_result": True, "blend_type": "ADD"},
        A_Color=i.p, B_Color=i.q, Factor_Float=i.t)
    for mode in modes("SeparateColor", "mode"):
        for output in ("Red", "Green", "Blue"):
            made[f"Separate Color {mode} {output}"] = lambda g, i, mode=mode, output=output: g.node(
                "SeparateColor", outputs=output, settings={"mode": mode}, Color=i.p)
        made[f"Combine Color {mode}"] = lambda g, i, mode=mode: g.node(
            "CombineColor", settings={"mode": mode}, Red=i.t, Green=i.c, Blue=g.math("ADD", i.y, 0.5))
    made["Hue Saturation Value"] = lambda g, i: g.node(
        "HueSaturation", Hue=i.a, Saturation=g.math("ADD", i.b, 1.0), Value=i.c, Fac=i.t, Color=i.p)
    made["Bright Contrast"] = lambda g, i: g.node("BrightContrast", Color=i.p, Bright=i.x, Contrast=i.b)
    for exponent in (2.2, 0.0, None):
        made[f"Gamma {exponent}"] = lambda g, i, exponent=exponent: g.node(
            "Gamma", Color=i.p, Gamma=i.a if exponent is None else exponent)
    made["Invert"] = lambda g, i: g.node("Invert", Color=i.p, Fac=i.t)
    made["RGB to BW"] = lambda g, i: g.node("RGBToBW", Color=i.p)
    made["Blackbody"] = lambda g, i: g.node("Blackbody", Temperature=g.math("MULTIPLY_ADD", i.x, 13000.0, 6400.0))
    made["Blackbody, cool"] = lambda g, i: g.node("Blackbody", Temperature=g.math("MULTIPLY_ADD", i.x, 1400.0, 1400.0))
    made["Wavelength"] = lambda g, i: g.node("Wavelength", Wavelength=g.math("MULTIPLY_ADD", i.x, 460.0, 580.0))
    return made | ramps() | curves()


def ramps() -> dict:
    made = {}
    for mode in ("RGB", "HSV", "HSL"):
        interpolations = ("EASE", "CARDINAL", "LINEAR", "B_SPLINE", "CONSTANT") if mode == "RGB" else (
            "NEAR", "FAR", "CW", "CCW")
        for interpolation in interpolations:
            made[f"Color Ramp {mode} {interpolation}"] = lambda g, i, mode=mode, interpolation=interpolation: ramp(
                g, i.t, mode, interpolation, "Color")
    made["Color Ramp alpha"] = lambda g, i: ramp(g, i.t, "RGB", "LINEAR", "Alpha")
    return made


def ramp(graph, factor, mode: str, interpolation: str, output: str):
    made = graph.node("ValToRGB", outputs=output, Fac=factor)
    colors = made.node.color_ramp
    colors.color_mode = mode
    setattr(colors, "interpolation" if mode == "RGB" else "hue_interpolation", interpolation)
    colors.elements[0].color, colors.elements[1].color = (0.9, 0.1, 0.2, 0.3), (0.2, 0.7, 1.0, 1.0)
    colors.elements.new(0.4).color = (0.1, 0.9, 0.3, 0.8)
    return made


def curves() -> dict:
    made = {}
    for extend in ("HORIZONTAL", "EXTRAPOLATED"):
        made[f"Float Curve {extend}"] = lambda g, i, extend=extend: bent(
            g.node("FloatCurve", Value=g.node("SeparateXYZ", Vector=i.p), Factor=i.t), extend, 0.0)
        made[f"RGB Curves {extend}"] = lambda g, i, extend=extend: bent(
            g.node("RGBCurve", Color=i.p, Fac=i.t), extend, 0.0)
        made[f"Vector Curves {extend}"] = lambda g, i, extend=extend: bent(
            g.node("VectorCurve", Vector=i.p, Fac=i.t), extend, -1.0)
    return made


def bent(socket, extend: str, low: float):
    """Other points for each of a node's curves."""
    mapping = socket.node.mapping
    mapping.extend = extend
    for number, curve in enumerate(mapping.curves):
        curve.points[0].location = (low, 0.1 * number)
        curve.points.new(0.3 + 0.1 * number, 0.8 - 0.15 * number)
    mapping.update()
    return socket


def make_patches(path: Path, entries: dict, columns: int) -> None:
    patches = Patches(columns, -(-2 * len(entries) // columns))
    for name, build in entries.items():
        patches.add(f"{name} varying", lambda g, build=build: build(g, Inputs(g, True)))
        patches.add(f"{name} constant", lambda g, build=build: build(g, Inputs(g, False)))
    patches.save(path)


def make_spaces(path: Path) -> None:
    """Vector Transform, each kind between all spaces, on squares that are turned, stretched and mirrored."""
    patches, chance = Patches(6, 4, 24), random.Random(3)
    scene, spaces = bpy.context.scene, modes("VectorTransform", "convert_from")
    for kind in modes("VectorTransform", "vector_type"):
        for one in spaces:
            for other in spaces:
                if one != other:
                    settings = {"vector_type": kind, "convert_from": one, "convert_to": other}
                    patches.add(f"{kind} {one} {other}", lambda g, settings=settings: g.node(
                        "VectorTransform", settings=settings, Vector=g.node("NewGeometry", outputs="Position")))
    for patch in (o for o in scene.objects if o.type == "MESH"):
        patch.rotation_euler = [chance.uniform(-0.5, 0.5) for _ in range(3)]
        patch.scale = (0.9, chance.choice((-0.7, 0.7)), 1.5)
    camera = scene.camera
    camera.data.type = "PERSP"
    camera.location, camera.rotation_euler = (3.5, 1.0, 7.0), (0.15, 0.1, 0.4)
    patches.save(path)


if __name__ == "__main__":
    folder = Path(sys.argv[sys.argv.index("--") + 1])
    folder.mkdir(parents=True, exist_ok=True)
    make_patches(folder / "numbers.blend", numbers(), 12)
    make_patches(folder / "vectors.blend", vectors(), 12)
    make_patches(folder / "colours.blend", colours(), 14)
    make_spaces(folder / "spaces.blend")
