"""What materials ask of meshes and objects, as it is exported: tangents, islands, pointiness, instances, properties."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import bpy
import numpy as np
from common import add, cube, export, material, mesh, near, node, notes_of, program, run_all, square

from addon.export.hashes import hash_pair, hash_text, to_unit
from isophote.records import numbers
from isophote.values import operation_of


def glowing(name, kind, output, **settings):
    """A material that emits an output of a node."""
    def build(tree, end):
        light = node(tree, "ShaderNodeEmission", end.inputs["Surface"])
        made = node(tree, kind)
        for setting, value in settings.items():
            setattr(made, setting, value)
        tree.links.new(made.outputs[output], light.inputs["Color"])
    return material(name, build)


def column(scene, name):
    """Numbers of instances for the last column of instance_values, by the instances' names."""
    return dict(zip(scene.names["instances"], scene.instance_values[:, -1].tolist(), strict=True))[name]


def attribute(scene, mesh_number=0):
    """(domain, values (elements, components)) of the first attribute of a mesh."""
    first, domain, components = scene.mesh_attributes[mesh_number, 0].tolist()
    triangles = int(scene.mesh_triangles[1] - scene.mesh_triangles[0])
    count = {1: 1, 2: int(scene.mesh_vertices[1]), 3: triangles, 4: 3 * triangles}[domain]
    return domain, scene.attribute_values[first:first + count * components].reshape(count, components)


def test_hashes():
    """Names count by their bytes, as signed numbers; both words count, each in its place."""
    assert hash_text("a") == 97 and hash_text("ab") == 97 * 37 + 98
    assert hash_text("ä") == ((0xC3 - 256) * 37 + (0xA4 - 256)) & 0xFFFFFFFF
    assert hash_pair(1, 2) != hash_pair(2, 1) and 0 <= to_unit(hash_pair(3, 4)) <= 1


def test_tangents_are_blenders_own():
    """On triangles Blender's tangents are those of the same algorithm."""
    made = cube(smooth=True, materials=(glowing("t", "ShaderNodeTangent", "Tangent", direction_type="UV_MAP"),))
    ob = add("cube", made)
    bpy.context.view_layer.objects.active = ob
    layer = made.uv_layers.new(name="map")
    random = np.random.default_rng(1)
    for each in layer.data:
        each.uv = random.random(2)
    ob.modifiers.new("triangles", "TRIANGULATE")
    scene = export()
    domain, found = attribute(scene)
    assert domain == numbers()["DOMAIN_CORNER"]
    evaluated = ob.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    evaluated.calc_tangents(uvmap="map")
    wanted = np.array([[*loop.tangent, loop.bitangent_sign] for loop in evaluated.loops])
    np.testing.assert_allclose(found, wanted, atol=2e-4)


def test_islands_have_numbers_of_their_own():
    vertices = [(x + 3 * k, y, 0) for k in range(3) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    faces = [tuple(range(4 * k, 4 * k + 4)) for k in range(3)]
    shown = glowing("i", "ShaderNodeNewGeometry", "Random Per Island")
    add("islands", mesh(vertices, faces, materials=(shown,)))
    domain, values = attribute(export())
    assert domain == numbers()["DOMAIN_TRIANGLE"] and len(values) == 6
    by_island = values.reshape(3, 2)
    assert (by_island[:, 0] == by_island[:, 1]).all() and len(set(by_island[:, 0].tolist())) == 3


def test_pointiness_of_a_cube():
    add("cube", cube(materials=(glowing("p", "ShaderNodeNewGeometry", "Pointiness"),)))
    _, values = attribute(export())
    near(values, np.full(values.shape, np.arccos(-(3.0 ** -0.5)) / np.pi), 1e-5)


def test_objects_tell_of_themselves():
    shown = glowing("o", "ShaderNodeObjectInfo", "Object Index")
    for index, name in enumerate(("first", "second")):
        ob = add(name, square(materials=(shown,)), (3 * index, 0, 0))
        ob.pass_index = index + 5
    scene = export()
    assert [column(scene, name) for name in ("first", "second")] == [5.0, 6.0]
    near(scene.instance_values.shape, (2, 1))


def test_random_numbers_follow_names():
    shown = glowing("r", "ShaderNodeObjectInfo", "Random")
    add("one", square(materials=(shown,)))
    near(column(export(), "one"), to_unit(hash_pair(hash_text("one"), 0)), 1e-6)


def test_properties_by_name():
    shown = glowing("a", "ShaderNodeAttribute", "Alpha", attribute_type="OBJECT", attribute_name="gloss")
    for name, value in (("four", (0.1, 0.2, 0.3, 0.4)), ("number", 0.7), ("text", "none")):
        add(name, square(materials=(shown,)))["gloss"] = value
    scene = export()
    near([column(scene, name) for name in ("four", "number", "text")], [0.4, 1.0, 0.0], 1e-6)


def test_what_no_material_asks_for_is_not_exported():
    add("square", square(materials=(material("plain"),)))
    scene = export()
    assert scene.instance_values.size == 0 and scene.mesh_attributes.size == 0


def bumpy(into):
    """A Bump node, its height from the object's coordinates, into the normal of a shader or the displacement."""
    def build(tree, end):
        shader = node(tree, "ShaderNodeBsdfDiffuse", end.inputs["Surface"])
        place = node(tree, "ShaderNodeTexCoord")
        made = node(tree, "ShaderNodeDisplacement" if into == "Displacement" else "ShaderNodeBump")
        tree.links.new(place.outputs["Object"], made.inputs["Height"])
        tree.links.new(made.outputs[0], end.inputs["Displacement"] if into == "Displacement" else shader.inputs[into])
    return material("bumpy", build)


def test_bump_and_displacement_bend_normals():
    for into in ("Normal", "Displacement"):
        add(into, square(materials=(bumpy(into),)))
        scene = export()
        assert (scene.instruction_flags & numbers()["INSTRUCTION_BUMPS"]).any()
        names = [operation_of(op) for op in scene.step_op.tolist()]
        assert names.count("bump") == 1 and names.count("footprint") == 1 and not notes_of(scene, "bumpy")
        bpy.data.objects.remove(bpy.data.objects[into])


def test_mixed_shaders_keep_their_frames():
    """Each closure has the normal of its own node, or the surface's, and tangents survive mixing."""
    def build(tree, end):
        mix = node(tree, "ShaderNodeMixShader", end.inputs["Surface"])
        shiny = node(tree, "ShaderNodeBsdfPrincipled", mix.inputs[1], Metallic=1.0, Anisotropic=0.5)
        node(tree, "ShaderNodeBsdfDiffuse", mix.inputs[2])
        tree.links.new(node(tree, "ShaderNodeNormalMap").outputs[0], shiny.inputs["Normal"])
    add("mixed", square(materials=(material("mixed", build),)))
    scene = export()
    names = [name for name, *_ in program(scene, "mixed")]
    flags = dict(zip(names, scene.instruction_flags.tolist(), strict=True))
    bumps = numbers()["INSTRUCTION_BUMPS"]
    assert flags["aniso_metal"] & bumps and flags["aniso_metal"] >> 16
    assert not flags["diffuse"] & bumps and not flags["diffuse"] >> 16


def displacing(method):
    """Along the normal by half of x, less 1/4."""
    made = bumpy("Displacement")
    owner = made if hasattr(made, "displacement_method") else made.cycles
    owner.displacement_method = method
    node = next(each for each in made.node_tree.nodes if each.bl_idname == "ShaderNodeDisplacement")
    node.inputs["Midlevel"].default_value, node.inputs["Scale"].default_value = 0.5, 0.5
    parts = made.node_tree.nodes.new("ShaderNodeSeparateXYZ")
    made.node_tree.links.new(node.inputs["Height"].links[0].from_socket, parts.inputs[0])
    made.node_tree.links.new(parts.outputs[0], node.inputs["Height"])
    return made


def test_displacement_moves_vertices():
    for method, smooth in (("DISPLACEMENT", True), ("DISPLACEMENT", False), ("BOTH", True)):
        ob = add("square", square(materials=(displacing(method),), smooth=smooth), scale=(2.0, 1.0, 1.0))
        scene = export()
        near(scene.vertices[:, 2], 0.5 * scene.vertices[:, 0] - 0.25)
        near(scene.vertices[:, :2], [(-1, -1), (1, -1), (1, 1), (-1, 1)])
        slope = np.array([-0.5, 0.0, 1.0]) / np.sqrt(1.25) if method == "DISPLACEMENT" else np.array([0.0, 0.0, 1.0])
        near(scene.normals, np.tile(slope, (4 if smooth else 0, 1)), 1e-6)
        bends = (scene.instruction_flags & numbers()["INSTRUCTION_BUMPS"]).any()
        assert bends == (method == "BOTH") and not scene.notes
        bpy.data.objects.remove(ob)


def test_displacement_stays_while_a_mesh_deforms():
    """A shape key lifts the square: at each time it has the displacement of the middle, which a note says."""
    ob = add("square", square(materials=(displacing("DISPLACEMENT"),)))
    ob.shape_key_add(name="rest")
    lifted = ob.shape_key_add(name="lifted")
    for point in lifted.data:
        point.co.z += 1.0
    for frame in (0, 2):
        lifted.slider_max, lifted.value = 4.0, 2.0 * frame
        lifted.keyframe_insert("value", frame=frame)
    bpy.context.scene.render.use_motion_blur, bpy.context.scene.render.motion_blur_shutter = True, 1.0
    scene = export()
    opened, middle, closed = scene.key_vertices.reshape(3, 4, 3)
    near(middle, scene.vertices)
    near(middle[:, 2], 2.0 + 0.5 * middle[:, 0] - 0.25)
    for way in (closed - middle, middle - opened):
        assert 0.5 < way[0, 2] < 2.0
        near(way, np.tile((0.0, 0.0, way[0, 2]), (4, 1)))
    assert any("displacement is that of the middle" in what for what in notes_of(scene, "square")), scene.notes


def test_objects_that_share_a_mesh_are_displaced_by_their_own_materials():
    shared = square(materials=(material("plain"),))
    _, moved, again = (add(name, shared, (3.0 * k, 0.0, 0.0)) for k, name in enumerate("abc"))
    for ob in (moved, again):
        ob.material_slots[0].link = "OBJECT"
        ob.material_slots[0].material = displacing("DISPLACEMENT") if ob is moved else moved.material_slots[0].material
    scene = export()
    mesh = dict(zip(scene.names["instances"], scene.instance_mesh.tolist(), strict=True))
    assert mesh["b"] == mesh["c"] != mesh["a"] and len(scene.mesh_normals) == 2
    heights = [scene.vertices[scene.mesh_vertices[mesh[name]]:scene.mesh_vertices[mesh[name] + 1], 2] for name in "ab"]
    near(heights, [[0, 0, 0, 0], [-0.75, 0.25, 0.25, -0.75]])


def test_what_needs_rays_is_named():
    add("square", square(materials=(glowing("ao", "ShaderNodeAmbientOcclusion", "Color"),)))
    assert "nothing is occluded" in notes_of(export(), "ao")[0]


run_all(sys.modules[__name__])
