import time

import numpy as np
import pytest
from noise_device import tiny_scene

from isophote.strands import marked_radii
from isophote.validate import clean, validate
from tests.scenes import Builder, program, quad


def errors(scene):
    return [str(problem) for problem in validate(scene) if problem.severity == "error"]


def test_a_good_scene_has_no_problems():
    scene = tiny_scene()
    assert validate(scene) == []
    assert clean(scene) == (scene, [])


@pytest.mark.parametrize(("changes", "message"), [
    (dict(camera_to_world=np.zeros((3, 4))), "camera: the scene has no camera"),
    (dict(camera_to_world=np.full((3, 4), np.nan)), "camera: camera_to_world is not finite"),
    (dict(camera_to_world=2 * np.eye(3, 4)), "camera: camera_to_world is not rigid"),
    (dict(camera_window=[1, 1, -1, 1]), "camera: its window is empty"),
    (dict(camera_clip=[np.inf, 1]), "camera: camera_clip is not finite"),
    (dict(camera_kind=70), "camera: kind 70 is not known"),
    (dict(camera_kind=6), "camera: its fisheye lens sees nothing"),
    (dict(camera_kind=8, camera_panorama=[1, 0, 0, 1, 0, 0, 0, 0]), "camera: its polynomial has no linear term"),
    (dict(camera_kind=2, camera_window=[1, 1, -1, 1]), "camera: its window is empty"),
    (dict(resolution=[0, 10]), "resolution: 0 x 10 pixels"),
    (dict(triangles=[[0, 1, 3]]), "Mesh: triangles points to vertex 3 of 3"),
    (dict(triangle_slots=[0, 1]), "meshes: 2 slots for 1 triangles"),
    (dict(mesh_vertices=[0, 2]), "meshes: mesh_vertices does not ascend from 0 to 3"),
    (dict(vertices=np.zeros((4, 3)), triangles=[[0, 1, 3]], mesh_vertices=[0, 3, 4], mesh_triangles=[0, 1, 1],
          mesh_normals=[-1, -1]), "Mesh: its triangles have vertices of other meshes"),
    (dict(triangle_slots=[2]), "Triangle: its material slots reach 3 of 1"),
    (dict(instance_slots=[1]), "Triangle: its material slots reach 2 of 1"),
    (dict(instance_mesh=[5]), "Triangle: instance_mesh points to mesh 5 of 1"),
    (dict(slot_materials=[4]), "slots[0]: slot_materials points to material 4 of 1"),
    (dict(mesh_triangles=[1, 1]), "meshes: mesh_triangles does not ascend from 0 to 1"),
    (dict(mesh_normals=[0]), "Mesh: its normals lie outside the array"),
    (dict(material_first=[0, 2]), "materials: material_first does not ascend from 0 to 1"),
    (dict(instruction_op=[77]), "Grey: operation 77 is not known"),
    (dict(instruction_weight=[[np.nan, 0, 0]]), "Grey: a constant is not finite"),
    (dict(light_kind=[5]), "Lamp: light kind 5 is not known"),
    (dict(world_radiance=[0, np.inf, 0]), "world: its radiance is not finite"),
])
def test_errors_name_the_thing(changes, message):
    assert errors(tiny_scene(**changes)) == [message]


def test_the_owner_of_an_instruction_is_found():
    scene = tiny_scene(material_first=[0, 1, 1, 3], instruction_op=[1, 1, 99], instruction_weight=np.ones((3, 3)),
                       instruction_params=np.zeros((3, 11)))
    scene.names["materials"] = ["Grey", "Empty", "Wrong"]
    assert errors(scene) == ["Wrong: operation 99 is not known"]


def test_an_empty_scene_renders_the_world_and_says_so():
    scene = tiny_scene(instance_mesh=[], instance_to_world=np.zeros((0, 3, 4)), instance_slots=[],
                       instance_visibility=[], world_radiance=[1, 1, 1])
    (problem,) = validate(scene)
    assert problem.severity == "warning" and "only the world is rendered" in problem.what
    scene.arrays["world_radiance"] = np.zeros(3)
    assert "the world is black" in validate(scene)[0].what


@pytest.mark.parametrize("closure, black", [(("diffuse", (1, 1, 1)), True), (("emission", (1, 1, 1)), False)])
def test_a_scene_without_light_says_so(closure, black):
    builder = Builder()
    builder.instance(builder.mesh(quad((0, 0, 0), (1, 0, 0), (0, 1, 0))), builder.material(program(closure)))
    whats = [problem.what for problem in validate(builder.make())]
    assert whats == (["nothing gives light: no lamp, no world, no material that emits"] if black else [])


def two_meshes(smooth=(True, True)):
    """Meshes A and B of three triangles each over six vertices each."""
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [2, 0, 0], [np.nan, 0, 0]])
    triangles = [[0, 1, 2], [0, 0, 1], [1, 3, 2], [7, 10, 9], [6, 7, 11], [6, 7, 8]]
    starts, count = [], 0
    for is_smooth in smooth:
        starts.append(count if is_smooth else -1)
        count += 6 * is_smooth
    scene = tiny_scene(vertices=np.concatenate([vertices, vertices]), triangles=triangles, triangle_slots=np.arange(6),
                       mesh_vertices=[0, 6, 12], mesh_triangles=[0, 3, 6],
                       mesh_normals=starts, normals=np.tile([0.0, 0.0, 1.0], (count, 1)),
                       instance_mesh=[0, 1], instance_slots=[0, 0], instance_to_world=[np.eye(3, 4)] * 2,
                       instance_visibility=[31, 31], slot_materials=[0] * 6)
    scene.names.update(meshes=["A", "B"], instances=["a", "b"])
    return scene


@pytest.mark.parametrize(("smooth", "starts"), [
    ((True, True), [0, 6]), ((False, True), [-1, 0]), ((True, False), [0, -1]), ((False, False), [-1, -1]),
])
def test_bad_triangles_are_dropped_and_counted(smooth, starts):
    scene, notes = clean(two_meshes(smooth))
    assert scene.mesh_triangles.tolist() == [0, 2, 4]
    assert scene.triangle_slots.tolist() == [0, 2, 3, 5]
    assert scene.mesh_normals.tolist() == starts and scene.mesh_vertices.tolist() == [0, 6, 12]
    assert [(note["name"], note["what"].split(" triangles")[0]) for note in notes] == [("A", "1 of 3"), ("B", "1 of 3")]
    assert validate(scene) == []
    assert all(scene.arrays[name].dtype == array.dtype for name, array in tiny_scene().arrays.items())


def test_non_finite_normals_drop_their_triangle():
    broken = two_meshes()
    broken.arrays["normals"][10, 0] = np.inf  # the first triangle of B
    scene, _ = clean(broken)
    assert scene.triangle_slots.tolist() == [0, 2, 5]


def test_bad_instances_go_and_mirrored_ones_stay():
    mirrored, line, far = np.eye(3, 4), np.eye(3, 4), np.eye(3, 4)
    mirrored[0, 0] = -1
    line[1, 1] = line[2, 2] = 0
    far[0, 3] = 1e300  # not finite in float32
    matrices = [np.eye(3, 4), mirrored, line, np.full((3, 4), np.nan), far, far]
    scene = tiny_scene(instance_mesh=[0] * 6, instance_slots=[0] * 6, instance_visibility=range(6),
                       instance_to_world=matrices)
    scene.names["instances"] = list("abcdee")
    cleaned, notes = clean(scene)
    assert cleaned.instance_visibility.tolist() == [0, 1]
    assert cleaned.names["instances"] == ["a", "b"]
    assert [(note["name"], note["what"][-16:]) for note in notes[:2]] == [("c", "es it to nothing")] + [
        ("d", "es it to nothing")]
    assert notes[2]["name"] == "e" and notes[2]["what"].endswith("(2 of that name)")


def test_instances_squashed_flat_become_meshes_of_their_own():
    flat = np.array([[2.0, 0, 1, 5], [0, 0, 0, 7], [0, 0, 1, 9]])  # sheared, with one zero scale, along y
    scene = two_meshes()
    scene.arrays["vertices"][[*range(5), *range(6, 11)], 2] = [0, 3, 1, 2, 4] * 2
    scene.arrays["instance_to_world"] = np.array([np.eye(3, 4), flat])
    scene.names["instances"] = ["a", "Sheet"]
    cleaned, _ = clean(scene)
    assert validate(cleaned) == []
    assert cleaned.names["meshes"] == ["A", "B", "Sheet"] and cleaned.instance_mesh.tolist() == [0, 2]
    assert np.array_equal(cleaned.instance_to_world, [np.eye(3, 4)] * 2)
    assert cleaned.mesh_normals.tolist() == [0, 6, -1] and cleaned.mesh_vertices.tolist() == [0, 6, 12, 18]
    assert cleaned.mesh_triangles.tolist() == [0, 2, 4, 6]
    assert cleaned.triangle_slots.tolist() == [0, 2, 3, 5, 3, 5]
    before = scene.vertices[scene.triangles[[3, 5]]] @ flat[:, :3].T + flat[:, 3]
    assert np.array_equal(cleaned.vertices[cleaned.triangles[4:]], before)


def test_instances_of_meshes_without_triangles_go_silently():
    scene = tiny_scene(mesh_vertices=[0, 3, 3], mesh_triangles=[0, 1, 1], mesh_normals=[-1, -1],
                       instance_mesh=[1, 0], instance_slots=[0, 0], instance_to_world=[np.eye(3, 4)] * 2,
                       instance_visibility=[1, 2])
    cleaned, notes = clean(scene)
    assert cleaned.instance_visibility.tolist() == [2] and notes == []


def test_bad_spheres_and_lights_are_dropped():
    scene = tiny_scene(sphere_center=np.zeros((4, 3)), sphere_radius=[1, 0, -1, np.nan], sphere_material=[0] * 4,
                       sphere_visibility=range(4), light_strength=[[np.nan, 0, 0]])
    scene.names["spheres"] = ["one", "zero", "minus", "nan"]
    cleaned, notes = clean(scene)
    assert cleaned.sphere_radius.tolist() == [1.0]
    assert len(cleaned.light_kind) == 0
    assert [note["name"] for note in notes] == ["zero", "minus", "nan", "Lamp"]
    assert cleaned.content_hash != scene.content_hash


def hairy(**changes):
    """A scene of two strands of three points, with some arrays changed."""
    b = Builder()
    b.instance(b.strands(np.arange(18.0).reshape(2, 3, 3), 0.1), b.material(program(("diffuse", 0.5))))
    scene = b.make()
    scene.arrays |= {name: np.asarray(value, scene.arrays[name].dtype) for name, value in changes.items()}
    return scene


@pytest.mark.parametrize(("changes", "message"), [
    (dict(mesh_radii=[2]), "its radii lie outside the array"),
    (dict(mesh_radii=[-3]), "its radii lie outside the array"),
    (dict(mesh_normals=[0], normals=np.zeros((6, 3))), "strands with normals"),
    (dict(triangles=[[0, 1, 0], [1, 2, 1], [3, 4, 3], [4, 3, 4]]), "is no segment"),
    (dict(triangles=[[0, 1, 2], [1, 2, 1], [3, 4, 3], [4, 5, 4]]), "is no segment"),
    (dict(material_volume=[1]), "no inside for a volume")])
def test_errors_of_strands(changes, message):
    found = errors(hairy(**changes))
    assert len(found) == 1 and message in found[0], found


WAX = dict(anisotropy=0.0, ior=1.4, roughness=0.7, diffuse=0.0, radius_r=0.2, radius_g=0.1, radius_b=0.05, albedo_r=0.9,
           albedo_g=0.6, albedo_b=0.4)


def test_strands_with_subsurface_scattering_are_refused():
    b = Builder()
    b.instance(b.strands(np.arange(9.0).reshape(1, 3, 3), 0.1), b.material(program(("subsurface", 0.5, WAX))))
    with pytest.raises(AssertionError, match="no inside for"):
        b.make()


@pytest.mark.parametrize(("changes", "kept"), [
    (dict(radii=[0.1, -0.1, 0.1, 0.1, 0.1, 0.1]), 2), (dict(radii=[0, 0, 0.1, 0.1, np.nan, 0.1]), 1),
    (dict(radii=[0.0, 0.1, 0.0, 0.1, 0.0, 0.1]), 4)])
def test_bad_segments_are_dropped_and_ends_marked_anew(changes, kept):
    """Where one is missing the strand ends; a radius of 0, or of -0, has the sign of an end as well."""
    scene, notes = clean(hairy(**changes))
    assert len(scene.triangles) == kept and bool(notes) == (kept < 4)
    marked = marked_radii(scene)
    begins, ends = set(scene.triangles[:, 0].tolist()), set(scene.triangles[:, 1].tolist())
    assert np.flatnonzero(~np.signbit(marked)).tolist() == sorted(begins & ends)


def test_a_radius_of_minus_0_is_no_end():
    assert np.signbit(marked_radii(hairy(radii=[-0.0, -0.0, -0.0, 0.1, 0.1, 0.1]))).tolist() == [
        True, False, True, True, False, True]


@pytest.mark.timed
def test_a_million_triangles_take_less_than_a_fifth_of_a_second():
    count = 1_000_000
    scene = tiny_scene(vertices=np.random.default_rng(1).random((count // 2, 3)), triangle_slots=np.ones(count),
                       slot_materials=[0, 0],
                       triangles=np.random.default_rng(2).permuted(np.arange(3 * count) % (count // 2)).reshape(-1, 3),
                       mesh_triangles=[0, count])
    best = min(timed(scene) for _ in range(3))
    assert best < 0.2, f"{best:.3f} s"


def timed(scene):
    """Seconds of CPU time: other load does not count."""
    started = time.process_time()
    validate(scene)
    return time.process_time() - started
