"""Makes a scene of balls on a floor under lamps.

    python blend_scenes/nodes/make_lamps.py -- OUT.blend CASE        (or blender -b --python ...)

CASE: a name of CASES below.
"""

import sys
from math import radians
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import bpy
from make_worlds import add, new_scene, shader


def lamp(kind, **settings):
    data = bpy.data.lights.new(kind, kind)
    for name, value in settings.items():
        setattr(data if hasattr(data, name) else data.cycles, name, value)
    return data


def dark(scene):
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0


# ------------------------------------------------------------------ shapes


def spread(scene):
    """A rectangle, an ellipse and a disk, the last one seen by the camera."""
    add(scene, "rectangle", lamp("AREA", shape="RECTANGLE", size=2.0, size_y=0.7, energy=120.0, spread=radians(60.0)),
        (-2, 0, 3), (0.1, -0.3, 0.3))
    add(scene, "ellipse", lamp("AREA", shape="ELLIPSE", size=1.5, size_y=0.8, energy=90.0, color=(0.5, 0.7, 1.0),
                               spread=radians(25.0)), (1.5, 0, 3.5), (0, 0.1, 0))
    seen = add(scene, "disk", lamp("AREA", shape="DISK", size=1.0, energy=60.0, color=(1.0, 0.6, 0.4),
                                   spread=radians(100.0)), (0, 2, 1.5), (radians(80.0), 0, 0))
    seen.visible_camera = True


def narrow(scene):
    add(scene, "beam", lamp("AREA", shape="SQUARE", size=1.5, energy=30.0, spread=radians(3.0)), (-1, -0.5, 4),
        (0.1, 0.2, 0))
    add(scene, "disk", lamp("AREA", shape="DISK", size=2.5, energy=60.0, spread=radians(10.0)), (1.5, 0, 3))


def stretched(scene):
    add(scene, "spot", lamp("SPOT", energy=600.0, spot_size=radians(50.0), spot_blend=0.4, shadow_soft_size=0.2),
        (-1, -1, 4), (0.3, -0.2, 0.4), (2.0, 0.7, 1.0))
    add(scene, "ball", lamp("SPOT", energy=300.0, spot_size=radians(70.0), spot_blend=0.0, shadow_soft_size=0.3,
                            use_soft_falloff=False), (2, -1, 3), (0.3, 0.4, 0), (1.0, 1.0, 1.8))


# ------------------------------------------------------------------ limits


def hidden(scene):
    """Each of three lamps hidden from a kind of rays."""
    for name, x in (("diffuse", -3), ("glossy", 0), ("transmission", 3)):
        placed = add(scene, name, lamp("AREA", shape="SQUARE", size=1.5, energy=100.0), (x, -1, 4), (0, 0.2 * x, 0))
        setattr(placed, f"visible_{name}", False)


def hidden_mixed(scene):
    """The same beside a ball that is diffuse and glossy at once; rays find no lamps, for Cycles' weights do not add up to
    1 there."""
    hidden(scene)
    mixed = shader("mixed", "ShaderNodeBsdfPrincipled", Roughness=0.4, Metallic=0.3)
    bpy.data.objects["diffuse"].data.materials[0] = mixed
    for light in bpy.data.lights:
        light.cycles.use_multiple_importance_sampling = False


def bounces(scene):
    """Limits of 0 and 1; without a size, for Cycles' rays find lamps beyond their limits."""
    for x, most in ((-2, 0), (2, 1)):
        color = (1.0, 0.5 + 0.2 * x, 0.3)
        made = lamp("POINT", energy=200.0, shadow_soft_size=0.0, max_bounces=most, color=color)
        add(scene, f"{most}", made, (x, -1, 3))


CASES = {
    "spread": spread,
    "narrow": narrow,
    "stretched": stretched,
    "hidden": hidden,
    "hidden_mixed": hidden_mixed,
    "bounces": bounces,
}


if __name__ == "__main__":
    out, case = sys.argv[sys.argv.index("--") + 1:]
    made = new_scene()
    dark(made)
    CASES[case](made)
    bpy.ops.wm.save_as_mainfile(filepath=out)
