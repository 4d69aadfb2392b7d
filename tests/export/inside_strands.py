"""Hair of particle systems and of Curves objects as strands: points, radii, materials, what hides them."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import bpy
import numpy as np
from common import add, export, mesh, near, notes_of, run_all

SQUARE = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]


def coloured(name, shader="ShaderNodeBsdfDiffuse"):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output, made = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new(shader)
    tree.links.new(made.outputs[0], output.inputs["Surface"])
    return material


def hairy(count=20, materials=(), **settings):
    ob = add("hairy", mesh(SQUARE, [(0, 1, 2, 3)], materials=materials), (0.5, 0.0, 0.0), scale=(2.0, 1.0, 1.0))
    made = ob.modifiers.new("p", "PARTICLE_SYSTEM").particle_system.settings
    made.type, made.count, made.hair_length, made.render_step = "HAIR", count, 1.0, 2
    made.root_radius, made.tip_radius, made.radius_scale, made.use_close_tip = 1.0, 0.5, 0.2, False
    for name, value in settings.items():
        setattr(made, name, value)
    return ob


def strands_of(scene):
    """(points f4 [n, 3], radii f4 [n], segments i8 [m, 2]) of the one mesh of strands."""
    (number,) = np.flatnonzero(scene.mesh_radii)
    first, end = scene.mesh_vertices[number:number + 2].tolist()
    own = slice(*scene.mesh_triangles[number:number + 2].tolist())
    radius = int(scene.mesh_radii[number]) - 1
    return (scene.vertices[first:end], scene.radii[radius:radius + end - first],
            scene.triangles[own, :2].astype(int) - first)


def test_hair_grows_from_its_emitter_in_its_space():
    hairy()
    scene = export()
    points, radii, segments = strands_of(scene)
    assert len(points) == 20 * 5 and len(segments) == 20 * 4 and not notes_of(scene, "hairy")
    roots = points[::5]
    assert (np.abs(roots) <= 1.0001).all() and np.ptp(roots[:, 0]) > 1.0
    near(roots[:, 2], 0.0)
    near(points[4::5] - roots, np.broadcast_to(points[4] - points[0], (20, 3)))  # straight up, all of one length
    near(radii, 0.1 - 0.05 * points[:, 2])
    near(scene.instance_to_world[np.flatnonzero(scene.mesh_radii[scene.instance_mesh])[0], :, 3] + scene.origin,
         (0.5, 0.0, 0.0))


def test_shorter_children_end_where_they_end():
    """Blender has no points beyond their ends; nothing runs to the world's origin."""
    ob = hairy(5, child_type="SIMPLE", rendered_child_count=6, child_length=0.5)
    ob.location = 50.0, 40.0, 30.0
    points, _, segments = strands_of(export())
    assert len(segments) and np.abs(points).max() < 2.5 and points[:, 2].max() < 0.8


def test_an_emitter_without_extent_has_no_hair():
    hairy().scale = 0.0, 1.0, 1.0
    assert not export().mesh_radii.any()


def test_hair_without_length_is_none():
    hairy(hair_length=0.0)
    assert not export().mesh_radii.any()


def test_view_layers_may_leave_hair_out():
    hairy()
    bpy.context.view_layer.use_strand = False
    assert not export().mesh_radii.any()


def test_children_stand_in_for_parents():
    hairy(5, child_type="SIMPLE", rendered_child_count=6)
    points, _, _ = strands_of(export())
    assert len(points) == 30 * 5


def test_the_material_is_that_of_the_systems_slot():
    hairy(materials=(coloured("skin"), coloured("fur")), material=2)
    scene = export()
    row = int(np.flatnonzero(scene.mesh_radii[scene.instance_mesh])[0])
    assert scene.names["materials"][int(scene.slot_materials[scene.instance_slots[row]])] == "fur"


def test_emitter_and_hair_are_shown_apart():
    ob = hairy()
    ob.show_instancer_for_render = False
    scene = export()
    assert len(scene.instance_mesh) == 1 and scene.mesh_radii[scene.instance_mesh[0]]
    ob.show_instancer_for_render = True
    ob.modifiers[0].show_render = False
    scene = export()
    assert len(scene.instance_mesh) == 1 and not scene.mesh_radii.any()


def test_nothing_wanders_below_strands():
    hairy(materials=(coloured("wax", "ShaderNodeSubsurfaceScattering"),))
    scene = export()
    from isophote.materials import OPERATIONS
    ops = [int(op) for op in scene.instruction_op]
    assert OPERATIONS["subsurface"][0] in ops and OPERATIONS["diffuse"][0] in ops  # of the emitter, and of its hair
    row = int(np.flatnonzero(scene.mesh_radii[scene.instance_mesh])[0])
    material = int(scene.slot_materials[scene.instance_slots[row]])
    own = ops[scene.material_first[material]:scene.material_first[material + 1]]
    assert OPERATIONS["subsurface"][0] not in own


def test_hair_follows_its_object_while_the_shutter_is_open():
    ob = hairy()
    for frame in (0, 2):
        ob.location.x = frame
        ob.keyframe_insert("location", frame=frame)
    bpy.context.scene.render.use_motion_blur = True
    scene = export()
    assert scene.instance_keys.tolist() == [3, 3] and not scene.mesh_keys.any()
    near(scene.key_to_world[:3], scene.key_to_world[3:])
    assert scene.mesh_radii[scene.instance_mesh].astype(bool).tolist() == [False, True]
    assert any("follow their object" in what for what in notes_of(scene, "hairy"))


def test_a_system_without_hair_is_no_strands():
    hairy(0)
    scene = export()
    assert not scene.mesh_radii.any() and len(scene.instance_mesh) == 1


def test_curves_objects():
    curves = bpy.data.hair_curves.new("curves")
    if not hasattr(curves, "add_curves"):  # Blender 4.3 and newer make them from Python
        return
    curves.add_curves([2, 3])
    curves.points.foreach_set("position", [0, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0, 1, 1, 0, 2])
    add("curves", curves)
    points, radii, segments = strands_of(export())
    near(points, [(0, 0, 0), (0, 0, 1), (1, 0, 0), (1, 0, 1), (1, 0, 2)])
    assert segments.tolist() == [[0, 1], [2, 3], [3, 4]]
    curves.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", [0.1, 0.2, 0.3, 0.4, 0.5])
    near(strands_of(export())[1], (0.1, 0.2, 0.3, 0.4, 0.5))


run_all(sys.modules[__name__])
