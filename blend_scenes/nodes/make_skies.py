# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes skies.blend, patches of Sky Textures of all kinds, and worlds with them: under_NAME.blend for each of WORLDS.

    python blend_scenes/nodes/make_skies.py -- FOLDER     (a Python with bpy; or blender -b --python ...)
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import bpy
from mathutils import Euler, Vector

sys.path.insert(0, str(Path(__file__).parent))
from make_worlds import new_scene
from points import make_patches, point

BLENDER_5 = bpy.app.version >= (5, 0, 0)
SCATTERED = ("SINGLE_SCATTERING", "MULTIPLE_SCATTERING") if BLENDER_5 else ("NISHITA",)
DUST = "aerosol_density" if BLENDER_5 else "dust_density"
SUN = (0.3, -0.5, 0.6)


def toward(g, elevation=0.0, rotation=0.0, width=2.0 * math.pi, height=math.pi):
    """Directions around one, `width` by `height` radians of longitude and latitude."""
    longitude = g.math("MULTIPLY_ADD", g.place(0), width, math.pi / 2.0 - rotation)
    latitude = g.math("MULTIPLY_ADD", g.place(1), 0.999 * height, elevation)
    level = g.math("COSINE", latitude)
    return g.vector(g.math("MULTIPLY", level, g.math("COSINE", longitude)),
                    g.math("MULTIPLY", level, g.math("SINE", longitude)), g.math("SINE", latitude))


def everywhere(g):
    return toward(g)


def sky(kind, vector=everywhere, brightness=1.0, **settings):
    """A patch that shows a sky in the directions of `vector`; None: of the texture's own coordinates."""
    def build(g):
        inputs = {"Vector": vector(g)} if vector else {}
        color = g.node("TexSky", settings={"sky_type": kind, **settings}, **inputs)
        return g.node("VectorMath", outputs="Vector", settings={"operation": "SCALE"}, Vector=color, Scale=brightness)
    return build


def analytic():
    for kind in ("PREETHAM", "HOSEK_WILKIE"):
        for turbidity in (1.0, 2.2, 6.7, 10.0):
            yield f"{kind} turbidity {turbidity}", sky(kind, sun_direction=SUN, turbidity=turbidity)
        for height in (0.02, 0.3, 3.0):
            yield f"{kind} sun {height}", sky(kind, sun_direction=(0.6, 0.5, height))
        yield f"{kind} sun below", sky(kind, sun_direction=(-0.6, 0.5, -0.1))
        yield f"{kind} sun overhead", sky(kind, sun_direction=(0.0, 0.0, 1.0))
        yield f"{kind} generated", sky(kind, None, sun_direction=SUN)
        yield f"{kind} points", sky(kind, point, sun_direction=SUN)
    for albedo in (0.0, 0.55, 1.0):
        yield f"HOSEK_WILKIE albedo {albedo}", sky("HOSEK_WILKIE", turbidity=3.5, ground_albedo=albedo)


def scattered(kind):
    plain = {"sun_disc": False, "sun_rotation": 0.7}
    for degrees in (90.0, 45.0, 15.0, 2.0, 0.0, -3.0, -12.0, 120.0, -170.0):
        yield f"{kind} elevation {degrees}", sky(kind, sun_elevation=math.radians(degrees), **plain)
    for rotation in (-1.0, 2.0, 4.0, 9.0):
        yield f"{kind} rotation {rotation}", sky(kind, sun_disc=False, sun_rotation=rotation)
    for altitude in (0.0, 3000.0, 30000.0, 60000.0):
        yield f"{kind} altitude {altitude}", sky(kind, altitude=altitude, **plain)
    for name in ("air_density", DUST, "ozone_density"):
        for density in (0.0, 2.5, 10.0):
            yield f"{kind} {name} {density}", sky(kind, **{name: density}, **plain)
    yield f"{kind} generated", sky(kind, None, **plain)
    yield f"{kind} points", sky(kind, point, **plain)


def discs(kind):
    """The sun's disc from near by. With it the texture has no Vector, but still the mapping that it holds itself."""
    for degrees, size in ((60, 0.545), (15, 0.545), (15, 10), (1, 4), (-1, 4), (0.1, 0.545), (30, 90)):
        elevation, size = math.radians(degrees), math.radians(size)
        for intensity in (1.0, 0.3):
            yield f"{kind} sun {degrees} {math.degrees(size):.3g} {intensity}", disc(
                kind, sun_elevation=elevation, sun_rotation=0.7, sun_size=size, sun_intensity=intensity)


def disc(kind, **settings):
    """Of such a brightness that its middle is about 1."""
    size = settings["sun_size"]

    def build(g):
        socket = sky(kind, None, 5e-3 * size ** 2, **settings)(g)
        texture = socket.node.inputs["Vector"].links[0].from_node
        turn = Euler((math.pi / 2.0 - texture.sun_elevation, 0.0, math.pi - texture.sun_rotation))
        width = 2.0 * math.tan(0.7 * size)
        mapping = texture.texture_mapping
        mapping.rotation, mapping.scale = turn, (width, width, 0.0)
        mapping.translation = turn.to_matrix() @ Vector((-0.5 * width, -0.5 * width, 1.0))
        return socket
    return build


def mapped(kind):
    """By the mapping that the node itself holds."""
    def build(g):
        socket = sky(kind, sun_disc=False)(g)
        texture = socket.node.inputs["Vector"].links[0].from_node
        texture.texture_mapping.rotation = (0.3, -0.5, 0.8)
        return socket
    return build


def patches():
    yield from analytic()
    for kind in SCATTERED:
        yield from scattered(kind)
        yield from discs(kind)
        yield f"{kind} mapped", mapped(kind)


# ------------------------------------------------------------------ worlds


def add_sky(tree, kind=SCATTERED[-1], **settings):
    node = tree.nodes.new("ShaderNodeTexSky")
    for name, value in {"sky_type": kind, "sun_elevation": 0.6, "sun_rotation": 2.5, **settings}.items():
        setattr(node, name, value)
    return node


def plain(tree, **settings):
    return add_sky(tree, **settings).outputs[0]


def turned(tree):
    node = add_sky(tree)
    node.texture_mapping.rotation = (0.2, 0.3, -0.4)
    return node.outputs[0]


def second_sun(tree):
    return plain(tree, sun_rotation=4.0, sun_size=0.05)


def two_suns(tree):
    add = tree.nodes.new("ShaderNodeMixRGB")
    add.blend_type = "ADD"
    add.inputs[0].default_value = 1.0
    tree.links.new(plain(tree), add.inputs[1])
    tree.links.new(second_sun(tree), add.inputs[2])
    return add.outputs[0]


WORLDS = {
    "sun": plain,
    "low_sun": lambda tree: plain(tree, sun_elevation=0.05),
    "large_sun": lambda tree: plain(tree, sun_size=0.2),
    "dim_sun": lambda tree: plain(tree, sun_intensity=0.01),
    "no_sun": lambda tree: plain(tree, sun_disc=False),
    "turned": turned,
    "second_sun": second_sun,
    "two_suns": two_suns,
    "preetham": lambda tree: plain(tree, kind="PREETHAM", sun_direction=SUN),
    "hosek_wilkie": lambda tree: plain(tree, kind="HOSEK_WILKIE", sun_direction=SUN),
}


if __name__ == "__main__":
    make_patches("skies", list(patches()))
    for name, make in WORLDS.items():
        tree = new_scene().world.node_tree
        background = tree.nodes["Background"]
        background.inputs["Strength"].default_value = 0.1
        tree.links.new(make(tree), background.inputs["Color"])
        bpy.ops.wm.save_as_mainfile(filepath=str(Path(sys.argv[sys.argv.index("--") + 1]) / f"under_{name}.blend"))
