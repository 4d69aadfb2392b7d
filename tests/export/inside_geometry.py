"""Meshes, normals, slots, instances and visibility."""

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import bpy
import numpy as np
from common import NAMES, add, cube, export, material, mesh, near, node, notes_of, run_all, square


def test_ngon_becomes_triangles():
    corners = [(np.cos(a), np.sin(a), 0.0) for a in np.arange(7) * 2 * np.pi / 7]
    add("ngon", mesh(corners, [tuple(range(7))]))
    scene = export()
    assert len(scene.triangles) == 5 and len(scene.vertices) == 7
    a, b, c = np.moveaxis(scene.vertices[scene.triangles].astype(float), 1, 0)
    normals = np.cross(b - a, c - a)
    assert np.all(normals[:, 2] > 0)  # the winding is kept
    near(normals[:, 2].sum() / 2, 3.5 * np.sin(2 * np.pi / 7))


def test_memory_holds_what_the_interface_says():
    from addon import compat
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=120, y_subdivisions=100)
    data = bpy.context.object.data
    places = np.random.default_rng(3).uniform(-1, 1, 3 * len(data.vertices)).astype(np.float32)
    data.vertices.foreach_set("co", places)  # quads are cut this way and that
    data.polygons.foreach_set("use_smooth", np.arange(len(data.polygons)) % 3 > 0)
    data.update()
    data.calc_loop_triangles()
    cases = [(data.loop_triangles, "loops", 3, np.int32)]
    if not data.attributes.get(".corner_vert"):
        cases += [(data.loops, "vertex_index", 1, np.int32), (data.vertex_normals, "vector", 3, np.float32),
                  (data.polygon_normals, "vector", 3, np.float32)]
    for collection, name, columns, dtype in cases:
        read = compat.in_memory(collection, name, columns, dtype)
        wanted = np.empty(columns * len(collection), dtype)
        collection.foreach_get(name, wanted)
        assert read is not None and np.array_equal(read.reshape(-1), wanted), name
    # Not an array of such items: refused.
    assert compat.in_memory(data.polygons, "area", 1, np.float32) is None


def test_modifiers_are_evaluated_for_rendering():
    ob = add("cube", cube())
    modifier = ob.modifiers.new("s", "SUBSURF")
    modifier.levels, modifier.render_levels = 0, 2
    assert len(export().triangles) == 6 * 16 * 2


def test_flat_meshes_have_no_normals_and_smooth_ones_do():
    add("flat", cube())
    add("smooth", cube(smooth=True), (3, 0, 0))
    scene = export()
    assert sorted(scene.mesh_normals.tolist()) == [-1, 0] and len(scene.normals) == 8 and len(scene.vertices) == 16
    smooth = int(np.flatnonzero(scene.mesh_normals == 0)[0])
    places = scene.vertices[scene.mesh_vertices[smooth]:scene.mesh_vertices[smooth + 1]]
    near(scene.normals, places / np.linalg.norm(places, axis=1, keepdims=True), 1e-3)


def test_mixed_faces_keep_flat_ones():
    data = cube(smooth=True)
    data.polygons[1].use_smooth = False  # the one above
    data.update()
    add("mixed", data)
    scene = export()
    corners = scene.vertices[scene.triangles]
    top = np.all(corners[:, :, 2] == 1, axis=1)
    assert len(scene.vertices) == 12  # those above are there twice
    near(scene.normals[scene.triangles[top]], np.broadcast_to([0, 0, 1], (2, 3, 3)))
    near(np.linalg.norm(scene.normals[scene.triangles[~top]], axis=2), 1.0, 1e-5)


def test_custom_normals():
    data = square(smooth=True)
    wanted = np.array([0.6, 0.0, 0.8])
    if hasattr(data, "use_auto_smooth"):
        data.use_auto_smooth = True
    data.normals_split_custom_set([wanted] * 4)
    add("custom", data)
    near(export().normals, np.broadcast_to(wanted, (4, 3)), 1e-3)  # Blender keeps 16 bits


def test_slots_on_mesh_and_object():
    red, green, blue = (material(name) for name in ("red", "green", "blue"))
    data = mesh([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (2, 1, 0)], [(0, 1, 2, 3), (1, 4, 5, 2)],
                materials=(red, green), indices=[1, 0])
    add("first", data)
    second = add("second", data)
    second.material_slots[1].link = "OBJECT"
    second.material_slots[1].material = blue
    add("third", data)
    scene = export()
    assert len(scene.mesh_triangles) == 2 and len(scene.instance_mesh) == 3  # one mesh, three instances
    assert scene.triangle_slots.tolist() == [1, 1, 0, 0]
    names = scene.names["materials"]
    used = {name: [names[scene.slot_materials[first + k]] for k in range(2)]
            for name, first in zip(scene.names["instances"], scene.instance_slots, strict=False)}
    assert used == {"first": ["red", "green"], "second": ["red", "blue"], "third": ["red", "green"]}
    assert len(scene.slot_materials) == 4  # equal lists are kept once


def test_slots_out_of_range_take_the_last():
    add("one", square(materials=(material("only"),), indices=[5]))
    scene = export()
    slots = scene.instance_slots[0] + scene.triangle_slots
    assert [scene.names["materials"][scene.slot_materials[s]] for s in slots] == ["only", "only"]


def test_collection_instances_and_mirrored_matrix():
    inner = bpy.data.collections.new("inner")
    add("cube", cube(), (0.5, 0, 0), collection=inner)
    for k, scale in enumerate(((1, 1, 1), (-2, 1, 1))):
        empty = add(f"empty {k}", None, (0, 0, 3 * k), scale=scale)
        empty.instance_type, empty.instance_collection = "COLLECTION", inner
    scene = export()
    assert len(scene.mesh_triangles) == 2 and len(scene.instance_mesh) == 2
    matrix = scene.instance_to_world[np.argsort(scene.instance_to_world[:, 2, 3])]
    near(matrix[:, :, 3] + scene.origin, [(0.5, 0, 0), (-1, 0, 3)])
    near(np.linalg.det(matrix[:, :, :3]), (1, -2))


def test_vertex_instances_and_particles_are_instances():
    points = np.random.default_rng(1).uniform(-2, 2, (300, 3)).tolist()
    parent = add("parent", mesh(points, []))
    parent.instance_type = "VERTS"
    add("child", cube()).parent = parent
    emitter = add("emitter", square(), (0, 0, -9))
    system = emitter.modifiers.new("p", "PARTICLE_SYSTEM").particle_system.settings
    system.type, system.count = "HAIR", 50
    system.render_type, system.instance_object = "OBJECT", add("leaf", cube(), (9, 9, 9))
    scene = export()
    counts = np.bincount(scene.instance_mesh)
    assert sorted(counts.tolist()) == [1, 51, 300] and len(scene.triangles) == 26


def test_geometry_node_instances():
    tree = bpy.data.node_groups.new("nodes", "GeometryNodeTree")
    if hasattr(tree, "interface"):
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        tree.outputs.new("NodeSocketGeometry", "Geometry")
    output = tree.nodes.new("NodeGroupOutput")
    points, copies, ball = (tree.nodes.new(kind) for kind in (
        "GeometryNodeMeshGrid", "GeometryNodeInstanceOnPoints", "GeometryNodeMeshIcoSphere"))
    points.inputs["Vertices X"].default_value = points.inputs["Vertices Y"].default_value = 20
    paint = tree.nodes.new("GeometryNodeSetMaterial")
    paint.inputs["Material"].default_value = material("painted")
    tree.links.new(ball.outputs[0], paint.inputs["Geometry"])
    tree.links.new(points.outputs[0], copies.inputs["Points"])
    tree.links.new(paint.outputs[0], copies.inputs["Instance"])
    tree.links.new(copies.outputs[0], output.inputs[0])
    add("nodes", square()).modifiers.new("n", "NODES").node_group = tree
    scene = export()
    assert len(scene.instance_mesh) == 400 and len(scene.triangles) == 20
    used = scene.slot_materials[scene.instance_slots + scene.triangle_slots[0]]
    assert {scene.names["materials"][m] for m in used} == {"painted"}


def test_text_and_curves_have_triangles():
    text = bpy.data.curves.new("text", "FONT")
    text.body, text.extrude = "ISO", 0.1
    add("text", text)
    curve = bpy.data.curves.new("curve", "CURVE")
    curve.dimensions, curve.bevel_depth = "3D", 0.1
    curve.splines.new("POLY").points.add(3)
    for k, point in enumerate(curve.splines[0].points):
        point.co = (k, 0, 0, 1)
    add("curve", curve)
    scene = export()
    assert len(scene.instance_mesh) == 2 and np.all(np.diff(scene.mesh_triangles.astype(int)) > 50)


def test_hidden_objects_and_ray_visibility():
    add("seen", cube())
    add("hidden", cube()).hide_render = True
    away = bpy.data.collections.new("away")
    bpy.context.scene.collection.children.link(away)
    add("excluded", cube(), collection=away)
    bpy.context.view_layer.layer_collection.children["away"].exclude = True
    part = add("part", cube())
    part.visible_camera = part.visible_shadow = False
    nothing = add("nothing", cube())
    for name in ("camera", "diffuse", "glossy", "transmission", "shadow"):
        setattr(nothing, f"visible_{name}", False)
    scene = export()
    seen = dict(zip(scene.names["instances"], scene.instance_visibility.tolist(), strict=True))
    assert seen == {"seen": 31, "part": 2 + 4 + 8}


def test_zero_scale_is_kept():
    add("flat", cube(), scale=(1, 1, 0))
    near(export().instance_to_world[0, :, 2], (0, 0, 0))


def test_render_as_sphere():
    ob = add("ball", cube(), (1, 2, 3), (0.3, 0.2, 0.1), (0.5, 0.5, 0.5))
    ob["isophote_as_sphere"] = True
    egg = add("egg", cube(), (0, 0, 9), scale=(1, 1, 2))
    egg["isophote_as_sphere"] = True
    scene = export()
    order = [scene.names["spheres"].index(name) for name in ("ball", "egg")]
    assert len(scene.triangles) == 0
    near(scene.sphere_radius[order], (0.5, 2.0))
    near(scene.sphere_center[order] + scene.origin, [(1, 2, 3), (0, 0, 9)])
    assert not notes_of(scene, "ball") and "sphere" in notes_of(scene, "egg")[0]


def test_far_from_the_origin_nothing_is_lost():
    bpy.context.scene.camera.location = (1e5, 0, 0)
    add("near", square(), (1e5 + 0.5, 5, 0))
    scene = export()
    near(scene.instance_to_world[0, :, 3] - scene.camera_to_world[:, 3], (0.5, 5, 0), 1e-9)
    assert np.abs(scene.camera_to_world[:, 3]).max() <= 32


def test_held_out_objects_are_holes_to_the_camera():
    def veil(tree, output):
        mix = node(tree, "ShaderNodeMixShader", output.inputs["Surface"], Fac=0.25)
        node(tree, "ShaderNodeBsdfTransparent", mix.inputs[1])
        node(tree, "ShaderNodeEmission", mix.inputs[2])

    add("veil", square(materials=[material("veil", veil)])).is_holdout = True
    ball = add("ball", cube())
    ball["isophote_as_sphere"] = ball.is_holdout = True
    unseen = add("unseen", square())
    unseen.is_holdout, unseen.visible_camera = True, False
    layer = in_collection(add("by collection", square()))
    layer.holdout = layer.indirect_only = True
    scene = export()
    assert sorted(zip(scene.names["instances"], scene.instance_visibility, strict=True)) == [
        ("by collection", 1), ("by collection", 30), ("unseen", 30), ("veil", 1), ("veil", 30)]
    assert scene.names["spheres"] == ["ball", "ball"] and scene.sphere_visibility.tolist() == [1, 30]
    programs = [p for p in range(len(scene.names["materials"])) if scene.names["materials"][p] == "veil"]
    hole = scene.slot_materials[scene.instance_slots[scene.names["instances"].index("veil")]]
    assert hole in programs and len(programs) == 2
    steps = range(scene.material_first[hole], scene.material_first[hole + 1])
    assert {NAMES[int(scene.instruction_op[k])][0]: scene.instruction_weight[k][0] for k in steps} == {
        "transparent": 0.75, "holdout": 0.25}
    assert not scene.notes


def test_what_instances_ask_for_is_there_twice_of_held_out_objects():
    def numbered(tree, output):
        info = tree.nodes.new("ShaderNodeObjectInfo")
        shine = node(tree, "ShaderNodeEmission", output.inputs["Surface"])
        tree.links.new(info.outputs["Object Index"], shine.inputs["Strength"])

    for index in (3, 4, 5):
        made = add(f"{index}", square(materials=[bpy.data.materials.get("numbered") or material("numbered", numbered)]))
        made.pass_index, made.is_holdout = index, index == 4
    assert export().instance_values[:, 0].tolist() == [3, 4, 4, 5]


def test_indirect_only_collections_are_hidden_from_the_camera():
    in_collection(add("hidden", square())).indirect_only = True
    assert export().instance_visibility.tolist() == [30]


def test_shadow_catchers():
    """Their visibility stands there twice; a note says where a transparent film, or a pass of its own, is missing."""
    add("catcher", square()).is_shadow_catcher = True
    held = add("held out", square())
    held.is_shadow_catcher = held.is_holdout = True
    add("usual", square())
    scene = export()
    assert "transparent film" in notes_of(scene, "catcher")[0]
    assert sorted(zip(scene.names["instances"], scene.instance_visibility, strict=True)) == [
        ("catcher", 31 | 31 << 10), ("held out", 1), ("held out", 30 | 30 << 10), ("usual", 31)]
    assert scene.catches
    bpy.context.scene.render.film_transparent = True
    assert not export().notes


def in_collection(ob):
    """The layer collection of a collection that holds nothing else."""
    made = bpy.data.collections.new(ob.name)
    bpy.context.scene.collection.children.link(made)
    bpy.context.scene.collection.objects.unlink(ob)
    made.objects.link(ob)
    return bpy.context.view_layer.layer_collection.children[made.name]


def test_left_out_objects_are_named():
    add("smoke", bpy.data.volumes.new("smoke"))
    bpy.context.scene.render.use_motion_blur = True
    ball = add("ball", cube())
    ball["isophote_as_sphere"] = True
    growing = add("growing", cube())
    count = growing.modifiers.new("array", "ARRAY")
    for frame in (0, 2):
        ball.location.x = frame
        ball.keyframe_insert("location", frame=frame)
        count.count = 1 + 6 * frame
        count.keyframe_insert("count", frame=frame)
    bpy.context.scene.cycles.rolling_shutter_type = "TOP"
    scene = export()
    for name, word in (("smoke", "volume"), ("ball", "sphere"), ("growing", "other vertices"),
                       ("Scene", "rolling shutter")):
        assert any(word in what for what in notes_of(scene, name)), (name, scene.notes)


def test_no_camera_and_empty_scene():
    assert len(export().triangles) == 0
    bpy.context.scene.camera = None
    try:
        export()
    except ValueError as error:
        assert str(error) == "no camera in scene 'Scene'"
    else:
        raise AssertionError("exported without a camera")


def test_a_million_triangles_in_seconds():
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=708, y_subdivisions=708)
    bpy.context.object.data.polygons.foreach_set("use_smooth", [True] * 708 * 708)
    from addon.run_export import render_to_scene
    best = min(render_to_scene(bpy.context.scene)[1] for _ in range(2))
    start = time.perf_counter()
    scene = export()
    print(f"{len(scene.triangles)} triangles in {best:.2f} s (with evaluation {time.perf_counter() - start:.2f} s)")
    assert len(scene.triangles) > 1e6 and best < 4.0  # about 1 s when nothing else runs


if __name__ == "__main__":
    run_all(sys.modules[__name__])
