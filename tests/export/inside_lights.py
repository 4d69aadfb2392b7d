"""Lamps and the world: strengths, sizes, flags, visibility."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import bpy
import numpy as np
from common import add, export, near, node, notes_of, run_all, square

AREA_UNIT = 1.0 if bpy.app.version >= (4, 0, 0) else np.pi / 4  # docs/units.md


def lamp(kind, **settings):
    data = bpy.data.lights.new(kind, kind)
    data.color, data.energy = (1.0, 0.5, 0.25), 20.0
    for name, value in settings.items():
        setattr(data, name, value)
    return data


DISK = 4  # LIGHT_DISK of kernels/scene_records.h: soft falloff, which lamps have unless asked


def test_light_linking():
    """Sets by what collections include and exclude; masks of emitters; instancers' sets count before their objects'."""
    if bpy.app.version < (4, 0, 0):
        return

    def listed(included=(), excluded=()):
        made = bpy.data.collections.new("listed")
        for each in (*included, *excluded):
            made.objects.link(each)
        for row, each in zip(made.collection_objects, made.objects, strict=True):
            row.light_linking.link_state = "EXCLUDE" if each in excluded else "INCLUDE"
        return made

    a, b, c = (add(name, square()) for name in "abc")
    group = bpy.data.collections.new("group")
    group.objects.link(add("member", square(), collection=bpy.data.collections.new("elsewhere")))
    instancer = add("instancer", None)
    instancer.instance_type, instancer.instance_collection = "COLLECTION", group
    only, but = (add(name, lamp("POINT")) for name in ("only", "but"))
    add("plain", lamp("SUN"))
    only.light_linking.receiver_collection = listed([a, instancer])
    outer = listed([a])
    outer.children.link(listed([c]))  # whose own states do not count
    outer.collection_children[0].light_linking.link_state = "EXCLUDE"
    but.light_linking.receiver_collection, but.light_linking.blocker_collection = outer, listed(excluded=[b])
    c.light_linking.receiver_collection = listed(excluded=[a])
    scene = export()
    receivers, blockers = (dict(zip(scene.names["instances"], column, strict=True)) for column in scene.instance_sets.T)
    assert receivers["b"] == 0 and len({receivers[name] for name in ("a", "b", "c", "member")}) == 4
    assert blockers["b"] == 1 and blockers["a"] == blockers["c"] == blockers["member"] == 0
    masks = dict(zip(scene.names["lights"], scene.light_unlinked.tolist(), strict=True))
    bit = {name: 1 << int(number) for name, number in receivers.items()}
    assert masks["only"] == [bit["b"] | bit["c"], 0] and masks["plain"] == [0, 0]
    assert masks["but"] == [bit["b"] | bit["c"] | bit["member"], 0b10]
    assert dict(zip(scene.names["instances"], scene.instance_unlinked[:, 0], strict=True))["c"] == bit["a"]
    assert not scene.notes


def test_nothing_linked_is_nothing():
    add("a", square())
    add("lamp", lamp("POINT"))
    scene = export()
    assert not scene.instance_sets.any() and not scene.light_unlinked.any()


def test_point_and_spot():
    add("point", lamp("POINT", shadow_soft_size=0.1), (1, 2, 3), scale=(2, 2, 2))
    add("spot", lamp("SPOT", shadow_soft_size=0.0, spot_size=0.7, spot_blend=0.3), rotation=(np.pi / 2, 0, 0))
    scene = export()
    order = [scene.names["lights"].index(name) for name in ("point", "spot")]
    assert scene.light_kind[order].tolist() == [0, 1]
    near(scene.light_strength[order], [(20, 10, 5)] * 2)
    near(scene.light_size[order], [(0.1, 0), (0, 0)])  # the radius does not scale
    near(scene.light_spot[order], [(0, 0), (0.7, 0.3)])
    near(scene.light_to_world[order[0], :, 3] + scene.origin, (1, 2, 3))
    near(-scene.light_to_world[order[1], :, 2], (0, 1, 0))
    assert not scene.notes


def test_sun():
    add("sun", lamp("SUN", angle=0.02))
    scene = export()
    assert scene.light_kind.tolist() == [2]
    near(scene.light_strength, [(20, 10, 5)])
    near(scene.light_size, [(0.02, 0)])


def test_area_shapes_scale_with_the_object():
    for shape in ("SQUARE", "RECTANGLE", "DISK", "ELLIPSE"):
        add(shape, lamp("AREA", shape=shape, size=2.0, size_y=0.5), scale=(3, 2, 1))
    scene = export()
    found = {name: (kind, *size) for name, kind, size in
             zip(scene.names["lights"], scene.light_kind.tolist(), scene.light_size.round(5).tolist(), strict=False)}
    assert found == {"SQUARE": (3, 6, 4), "RECTANGLE": (3, 6, 1), "DISK": (4, 6, 4), "ELLIPSE": (4, 6, 1)}
    near(scene.light_strength, [np.array((20, 10, 5)) * AREA_UNIT] * 4)
    near(np.linalg.norm(scene.light_to_world[:, :, :3], axis=1), np.ones((4, 3)))


def test_lamps_are_hidden_from_the_camera_unless_asked():
    add("hidden", lamp("POINT"))
    add("seen", lamp("POINT")).visible_camera = True
    scene = export()
    assert dict(zip(scene.names["lights"], scene.light_visibility.tolist(), strict=False)) == {"hidden": 30, "seen": 31}


def test_flags():
    data = lamp("POINT")
    if hasattr(data.cycles, "cast_shadow"):
        data.cycles.cast_shadow = False
    else:
        data.use_shadow = False
    add("no shadow", data)
    add("no mis", lamp("POINT")).data.cycles.use_multiple_importance_sampling = False
    wanted = {"no shadow": 1 | DISK, "no mis": 2 | DISK}
    if hasattr(data, "use_soft_falloff"):
        add("ball", lamp("POINT")).data.use_soft_falloff = False
        wanted["ball"] = 0
    scene = export()
    assert dict(zip(scene.names["lights"], scene.light_flags.tolist(), strict=True)) == wanted


def test_emission_node():
    data = lamp("POINT")
    data.use_nodes = True
    data.node_tree.nodes.clear()
    output = data.node_tree.nodes.new("ShaderNodeOutputLight")
    node(data.node_tree, "ShaderNodeEmission", output.inputs[0], Color=(0.5, 1.0, 1.0), Strength=3.0)
    add("nodes", data)
    near(export().light_strength, [(30, 30, 15)])


def test_temperature_exposure_and_normalize():
    if not hasattr(bpy.types.Light, "bl_rna") or "exposure" not in bpy.types.Light.bl_rna.properties:
        return  # versions before 4.5
    add("exposed", lamp("SUN", exposure=2.0))
    add("warm", lamp("POINT", use_temperature=True, temperature=3000))
    add("plain", lamp("AREA", normalize=False, size=2.0, shape="SQUARE"))
    scene = export()
    strength = dict(zip(scene.names["lights"], scene.light_strength, strict=False))
    near(strength["exposed"], (80, 40, 20))
    near(strength["plain"], np.array((20, 10, 5)) * 4.0)
    assert strength["warm"][0] / strength["warm"][2] > 6.0


def test_what_is_left_out_is_named():
    portal = lamp("AREA")
    portal.cycles.is_portal = True
    add("portal", portal)
    scene = export()
    assert not scene.names.get("lights")
    assert "portal" in notes_of(scene, "portal")[0]


def test_spread_and_stretched_cone():
    parallel = lamp("AREA", spread=0.0)
    add("parallel", parallel)
    add("narrow", lamp("AREA", spread=1.0))
    add("spot", lamp("SPOT"), scale=(2, 1, 3))
    add("point", lamp("POINT"), scale=(2, 1, 3))
    scene = export()
    spread = dict(zip(scene.names["lights"], scene.light_spread, strict=True))
    near([spread[name] for name in ("narrow", "parallel", "spot")],
         (1.0, max(parallel.spread, 1e-3), 0.0))  # Blender 3.4 has a degree at least
    lengths = dict(zip(scene.names["lights"], np.linalg.norm(scene.light_to_world[:, :, :3], axis=1), strict=True))
    near(lengths["spot"], (2, 1, 3))
    near(lengths["point"], np.ones(3))
    assert not scene.notes


def world(build=None):
    made = bpy.context.scene.world = bpy.data.worlds.new("world")
    made.use_nodes = True
    made.node_tree.nodes.clear()
    output = made.node_tree.nodes.new("ShaderNodeOutputWorld")
    background = node(made.node_tree, "ShaderNodeBackground", output.inputs[0], Color=(0.1, 0.2, 0.4), Strength=2.0)
    if build:
        build(made.node_tree, background)


def test_world():
    near(export().world_radiance, (0, 0, 0))
    world()
    near(export().world_radiance, (0.2, 0.4, 0.8))


def test_unknown_nodes_of_worlds_are_named():
    world(lambda tree, background: node(tree, "ShaderNodeShaderToRGB", background.inputs["Color"]))
    scene = export()
    near(scene.world_radiance, (0.2, 0.4, 0.8))
    assert "Shader to RGB" in notes_of(scene, "world")[0]


def test_lamp_radiances():
    from isophote.lights import light_records

    add("point", lamp("POINT", shadow_soft_size=0.1))
    add("area", lamp("AREA", shape="DISK", size=2.0))
    scene = export()
    records = light_records(scene)
    order = [scene.names["lights"].index(name) for name in ("point", "area")]
    near(records["radiance"][order, 0], (20 / (4 * np.pi ** 2 * 0.01), 20 * AREA_UNIT / np.pi ** 2), 1e-4)


run_all(sys.modules[__name__])
