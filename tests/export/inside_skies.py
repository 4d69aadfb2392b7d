"""Skies: all types without a note, the sun found wherever directions are turned to, pictures kept once."""

import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import bpy
import numpy as np
from common import export, run_all

from isophote.emission import radiance_from
from isophote.prepare import prepare
from isophote.validate import clean

TYPES = [item.identifier for item in bpy.types.ShaderNodeTexSky.bl_rna.properties["sky_type"].enum_items]
SCATTERED = [kind for kind in TYPES if kind not in ("PREETHAM", "HOSEK_WILKIE")]
PLAIN = {"sun_elevation": 0.5, "sun_rotation": 0.8, "sun_size": 0.02}


def under(*skies):
    """The scene of an empty world that is the sum of skies: settings of each, `turn` of its own mapping."""
    world = bpy.data.worlds.new("world")
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    bpy.context.scene.world, tree = world, world.node_tree
    tree.nodes.clear()
    total = None
    for settings in skies:
        turn, background, sky = settings.pop("turn", (0, 0, 0)), *(
            tree.nodes.new(f"ShaderNode{kind}") for kind in ("Background", "TexSky"))
        for name, value in settings.items():
            setattr(sky, name, value)
        sky.texture_mapping.rotation = turn
        tree.links.new(sky.outputs[0], background.inputs["Color"])
        add = tree.nodes.new("ShaderNodeAddShader")
        tree.links.new(background.outputs[0], add.inputs[0])
        if total:
            tree.links.new(total.outputs[0], add.inputs[1])
        total = add
    tree.links.new(total.outputs[0], tree.nodes.new("ShaderNodeOutputWorld").inputs["Surface"])
    scene = export()
    assert not scene.notes, scene.notes
    return scene


def luminance(scene, directions):
    ready = prepare(clean(scene)[0])
    return radiance_from(ready.buffers, np.asarray(directions, np.float32)) @ (0.2, 0.7, 0.1)


def test_all_types_shine():
    for kind in TYPES:
        scene = under({"sky_type": kind})
        assert len(scene.world_material) == 1
        up, side = luminance(scene, [(0.0, 0.0, 1.0), (0.6, 0.0, 0.8)])
        assert up > 0.0 and side > 0.0, (kind, up, side)


def test_the_sun_is_where_it_shines():
    for kind in SCATTERED:
        for turn in ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.3, -0.2, 0.4)):
            scene = under({"sky_type": kind, "turn": turn, **PLAIN})
            (found,) = scene.world_sun
            middle, half = found[:3], found[3]
            assert math.isclose(half, 0.01, rel_tol=1e-6) and math.isclose(np.linalg.norm(middle), 1.0, rel_tol=1e-6)
            across = np.cross(middle, (0.6, 0.0, 0.8))
            across /= np.linalg.norm(across)
            inside, outside = (middle * math.cos(a) + across * math.sin(a) for a in (0.99 * half, 1.01 * half))
            bright, edge, dark = luminance(scene, [middle, inside, outside])
            assert bright > edge > 100.0 * dark, (kind, turn, bright, edge, dark)


def test_blenders_rotation_goes_from_y_to_x():
    scene = under({"sky_type": SCATTERED[0], **PLAIN})
    level = math.cos(0.5)
    np.testing.assert_allclose(scene.world_sun[0, :3], (level * math.sin(0.8), level * math.cos(0.8), math.sin(0.5)),
                               atol=1e-6)


def test_no_sun_is_drawn_apart_that_is_not_alone():
    for kind in SCATTERED:
        sky = {"sky_type": kind, **PLAIN}
        assert not len(under({**sky, "sun_disc": False}).world_sun)
        assert not len(under(sky | {}, {**sky, "sun_rotation": 2.0}).world_sun)
        assert len(under(sky | {}, sky | {}).world_sun) == 1


def test_a_sun_below_the_horizon_does_not_shine():
    kind = SCATTERED[0]  # of light scattered once
    assert not len(under({"sky_type": kind, **PLAIN, "sun_elevation": -0.1}).world_sun)


def test_equal_skies_are_one_picture():
    for kind in SCATTERED:
        sky = {"sky_type": kind, **PLAIN}
        assert len(under(sky | {}, {**sky, "sun_rotation": 2.0, "sun_disc": False}).images) == 1
        assert len(under(sky | {}, {**sky, "altitude": 2000.0}).images) == 2


run_all(sys.modules[__name__])
