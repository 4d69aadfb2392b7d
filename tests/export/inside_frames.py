"""Frames of an engine that lives on (Persistent Data): what is not read again is what reading again would give."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import bpy
import numpy as np
from common import add, cube, material, mesh, near, run_all, square

from addon.export import changes, export_scene
from isophote.scene import FIELDS


class Follower(bpy.types.RenderEngine):
    """Exports each frame with what the frame before left, and once more without."""

    bl_idname = "ISOPHOTE_FOLLOWER"
    bl_label = "Isophote follower"
    changes = None
    frames: list = []

    def render(self, depsgraph):
        self.changes = self.changes or changes.Changes()
        followed = export_scene(depsgraph, changes=self.changes)
        self.frames.append((followed, export_scene(depsgraph), depsgraph.view_layer.name))


def render(layers=1):
    """(scene, whether its meshes were taken over) of the current frame; equal to one that was read anew."""
    scene = bpy.context.scene
    if not Follower.is_registered:
        bpy.utils.register_class(Follower)
    if scene.render.engine != Follower.bl_idname:  # setting it ends the engine that there is
        scene.render.engine, scene.render.use_persistent_data = Follower.bl_idname, True
    scene.render.use_compositing = scene.render.use_sequencer = False
    before = Follower.frames[-1][0].vertices if Follower.frames else None
    bpy.ops.render.render(scene=scene.name)
    for followed, fresh, _ in Follower.frames[-layers:]:
        for name in FIELDS:
            same(followed.arrays[name], fresh.arrays[name], name)
        assert followed.names == fresh.names and followed.notes == fresh.notes
    return Follower.frames[-1][0], Follower.frames[-1][0].vertices is before


def same(a, b, name):
    assert a.shape == b.shape, name
    if name == "normals" and bpy.app.version < (4, 0):  # those of a copy are summed up again, in parallel
        near(a, b)
    else:
        assert a.tobytes() == b.tobytes(), name


def changed(change):
    """Frame after frame: nothing changes, and the meshes are taken over; the change; nothing changes again."""
    render()
    before, taken = render()
    assert taken
    change()
    bpy.context.view_layer.update()
    after, taken = render()
    assert not taken
    differing = [name for name in ("vertices", "triangles", "triangle_slots", "mesh_triangles")
                 if not np.array_equal(before.arrays[name], after.arrays[name])]
    assert differing, "the change is to be seen"
    assert render()[1]
    return differing


def test_camera_objects_materials_and_lamps_leave_meshes():
    ob = add("cube", cube(materials=[material("m")]))
    lamp = add("lamp", bpy.data.lights.new("lamp", "POINT"))
    render()
    moves = [lambda: setattr(bpy.context.scene.camera.location, "x", 1.0), lambda: setattr(ob.location, "x", 0.5),
             lambda: setattr(lamp.data, "energy", 5.0), lambda: setattr(ob, "visible_shadow", False)]
    for move in moves:
        before = Follower.frames[-1][0]
        move()
        after, taken = render()
        assert taken and before.content_hash != after.content_hash


def test_vertex():
    data = cube()
    add("cube", data)
    changed(lambda: setattr(data.vertices[0], "co", (3.0, 2.0, 1.0)))


def test_vertices_at_once():
    data = cube()
    add("cube", data)

    def change():
        data.vertices.foreach_set("co", np.arange(24, dtype=np.float32))
        data.update()

    changed(change)


def test_modifier():
    ob = add("cube", cube())
    modifier = ob.modifiers.new("s", "SUBSURF")
    modifier.render_levels = 1
    changed(lambda: setattr(modifier, "subdivision_type", "SIMPLE"))
    # Of what counts for rendering only, Blender tells its dependency graph nothing: its own mesh stays as it was, too.
    changed(lambda: setattr(modifier, "render_levels", 2) or ob.update_tag())
    changed(lambda: setattr(modifier, "show_render", False) or ob.update_tag())
    changed(lambda: setattr(ob.modifiers.new("d", "DISPLACE"), "strength", 0.3))


def test_slots():
    data = cube(materials=[material("a"), material("b")])
    add("cube", data)
    changed(lambda: data.polygons.foreach_set("material_index", [1, 0, 1, 0, 1, 0]) or data.update())


def test_custom_normals():
    data = square(smooth=True)
    if hasattr(data, "use_auto_smooth"):
        data.use_auto_smooth = True
    add("square", data)
    render()
    assert render()[1]
    data.normals_split_custom_set([(0.6, 0.0, 0.8)] * 4)
    data.update()
    assert not render()[1]


def test_shape_key():
    ob = add("cube", cube())
    ob.shape_key_add(name="Basis")
    key = ob.shape_key_add(name="key")
    key.data[0].co = (5.0, 5.0, 5.0)
    changed(lambda: setattr(key, "value", 0.5))


def test_driver():
    other = add("other", None)
    ob = add("cube", cube())
    modifier = ob.modifiers.new("d", "DISPLACE")
    variable = modifier.driver_add("strength").driver.variables.new()
    variable.type, variable.targets[0].id = "TRANSFORMS", other
    modifier.id_data.animation_data.drivers[0].driver.expression = variable.name
    changed(lambda: setattr(other.location, "x", 0.7))


def test_keyed_modifier():
    ob = add("cube", cube())
    modifier = ob.modifiers.new("d", "DISPLACE")
    for frame, strength in ((1, 0.0), (2, 0.0), (3, 1.0), (4, 1.0)):
        modifier.strength = strength
        modifier.keyframe_insert("strength", frame=frame)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 4
    render()
    Follower.frames.clear()
    bpy.ops.render.render(animation=True)
    vertices = [followed.vertices for followed, _, _ in Follower.frames]
    for followed, fresh, _ in Follower.frames:
        same(followed.vertices, fresh.vertices, "vertices")
    assert np.array_equal(vertices[0], vertices[1]) and not np.array_equal(vertices[1], vertices[2])


def test_object_that_a_modifier_looks_at():
    other = add("other", None)
    modifier = add("cube", cube()).modifiers.new("m", "ARRAY")
    modifier.use_object_offset, modifier.offset_object = True, other
    changed(lambda: setattr(other.location, "x", 3.0))


def test_image_that_displaces():
    image = bpy.data.images.new("image", 4, 4)
    texture = bpy.data.textures.new("texture", "IMAGE")
    texture.image = image
    ob = add("cube", cube())
    modifier = ob.modifiers.new("d", "DISPLACE")
    modifier.texture = texture

    def change():
        image.pixels = [0.9] * 64
        image.update()
        texture.update_tag()
        ob.update_tag()

    changed(change)


def test_geometry_nodes():
    group = bpy.data.node_groups.new("nodes", "GeometryNodeTree")
    if hasattr(group, "interface"):
        group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        group.outputs.new("NodeSocketGeometry", "Geometry")
    made = group.nodes.new("GeometryNodeMeshUVSphere")
    group.links.new(made.outputs[0], group.nodes.new("NodeGroupOutput").inputs[0])
    add("made", cube()).modifiers.new("nodes", "NODES").node_group = group
    changed(lambda: setattr(made.inputs["Segments"], "default_value", 7))


def test_instances_of_geometry_nodes():
    """Meshes that belong to no object: their memory is the evaluated instancer's."""
    group = bpy.data.node_groups.new("nodes", "GeometryNodeTree")
    if hasattr(group, "interface"):
        group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        group.outputs.new("NodeSocketGeometry", "Geometry")
    points, made, scatter = (group.nodes.new(f"GeometryNode{name}")
                             for name in ("MeshGrid", "MeshCube", "InstanceOnPoints"))
    group.links.new(points.outputs[0], scatter.inputs["Points"])
    group.links.new(made.outputs[0], scatter.inputs["Instance"])
    group.links.new(scatter.outputs[0], group.nodes.new("NodeGroupOutput").inputs[0])
    add("made", cube()).modifiers.new("nodes", "NODES").node_group = group
    changed(lambda: setattr(made.inputs["Size"], "default_value", (0.1, 0.2, 0.3)))


def test_swapped_mesh():
    ob = add("cube", cube())
    changed(lambda: setattr(ob, "data", square()))


def test_hidden_changed_and_shown_again():
    add("other", square())
    data = cube()
    ob = add("cube", data)
    changed(lambda: setattr(ob, "hide_render", True))
    data.vertices[0].co = (9.0, 9.0, 9.0)
    render()
    after = changed_back(ob)
    assert after.vertices.max() == 9.0


def changed_back(ob):
    ob.hide_render = False
    after, taken = render()
    assert not taken
    return after


def test_objects_come_and_go():
    ob = add("cube", cube())
    changed(lambda: add("new", square()))
    changed(lambda: bpy.data.objects.remove(ob))
    changed(lambda: (bpy.data.meshes.remove(bpy.data.meshes[0]), add("newer", mesh([(0, 0, 0), (1, 0, 0), (0, 2, 0)],
                                                                                  [(0, 1, 2)]))))


def test_text_and_metaballs():
    curve = bpy.data.curves.new("text", "FONT")
    curve.body = "a"
    add("text", curve)
    changed(lambda: setattr(curve, "body", "bc"))
    ball = bpy.data.metaballs.new("ball")
    ball.elements.new()
    other = add("ball.001", bpy.data.metaballs.new("more"))
    other.data.elements.new().co = (1.0, 0.0, 0.0)
    add("ball", ball)
    render()
    assert not render()[1]  # metaballs are always read
    other.location.x = 0.3
    render()


def test_reading_again_after_edit_mode():
    data = cube()
    bpy.context.view_layer.objects.active = add("cube", data)
    render()
    bpy.ops.object.mode_set(mode="EDIT")
    render()
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    render()
    bpy.ops.object.mode_set(mode="OBJECT")
    assert len(render()[0].triangles) == 6 * 4 * 2


def test_undo_and_redo():
    add("cube", cube())
    bpy.ops.ed.undo_push(message="cube")
    render()
    bpy.data.objects["cube"].data.vertices[0].co = (4.0, 4.0, 4.0)
    bpy.ops.ed.undo_push(message="vertex")
    for step, largest in ((bpy.ops.ed.undo, 1.0), (bpy.ops.ed.redo, 4.0)):
        render()
        step()
        assert render()[0].vertices.max() == largest


def test_two_layers():
    """They share a dependency graph, which tells of a change to the layer that is rendered first only."""
    ob = add("cube", cube())
    bpy.context.scene.view_layers.new("two")
    render(2)
    assert render(2)[1]
    ob.data.vertices[0].co = (4.0, 4.0, 4.0)
    render(2)
    (first, _, one), (second, _, two) = Follower.frames[-2:]
    assert one != two and first.vertices.max() == second.vertices.max() == 4.0


def test_an_export_that_failed_leaves_nothing():
    ob = add("cube", cube())
    render()
    follower = changes.Changes()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    export_scene(depsgraph, changes=follower)
    camera, bpy.context.scene.camera = bpy.context.scene.camera, None
    ob.data.vertices[0].co = (4.0, 4.0, 4.0)
    depsgraph.update()
    try:
        export_scene(depsgraph, changes=follower)
        raise AssertionError("no camera")
    except Exception as error:
        assert "camera" in str(error)
    bpy.context.scene.camera = camera
    depsgraph.update()
    assert follower.unchanged_meshes(depsgraph) is None


def test_displacement_follows_its_nodes():
    """Meshes are taken over as they were before they were displaced."""
    def build(tree, output):
        tree.nodes.new("ShaderNodeValue").outputs[0].default_value = 0.25
        tree.links.new(tree.nodes["Value"].outputs[0], output.inputs["Displacement"])
    moving = material("moving", build)
    owner = moving if hasattr(moving, "displacement_method") else moving.cycles
    owner.displacement_method = "DISPLACEMENT"
    add("square", square(materials=(moving,)))
    first = render()[0].vertices
    moving.node_tree.nodes["Value"].outputs[0].default_value = 1.0
    second = render()[0].vertices
    near(second - first, np.full((4, 3), 0.75))


run_all(sys.modules[__name__])
