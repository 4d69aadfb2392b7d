"""Records of triangles against numpy in float64; what is kept from another frame against what is made anew."""

import numpy as np
import pytest
from noise_device import tiny_scene

from isophote import geometry, trees
from isophote.device import list_kind
from isophote.geometry import make_geometry
from isophote.prepare import prepare
from isophote.records import numbers
from isophote.validate import check
from tests.conftest import missing
from tests.scenes import SUN, Builder, ball, box, diffuse, look_at, place, program, quad, render

N = numbers()


def some_scene(turn=0.0, bump=0.0, count=3, rings=12):
    """Meshes with one user (one of them mirrored and smooth), instances of two others, spheres, a sun."""
    b = Builder((16, 12))
    b.world = 0.4
    b.look((0, -6, 3), (0, 0, 0.5), 0.5)
    grey = b.material(diffuse((0.7, 0.5, 0.3)))
    glass = b.material(program(("glass", 0.9, dict(roughness=0.2, ior=1.4, multiscatter=0))))
    b.instance(b.mesh(quad((0, 0, 0), (4, 0, 0), (0, 4, 0))), grey)
    vertices, triangles = ball(rings=rings)
    smooth = b.mesh((vertices * (1 + bump * vertices[:, 2:]), triangles), normals=vertices)
    b.instance(smooth, grey, matrix=place((1.5, 0.3, 1), (-0.8, 0.9, 0.7), turn))
    cube, stone = b.mesh(box(half=0.3)), b.mesh(ball(radius=0.3, rings=6), normals=ball(rings=6)[0])
    for k in range(count):
        b.instance(cube, grey, matrix=place((-2 + k, -1, 0.4), 1, turn + k))
        b.instance(stone, glass, matrix=place((-2 + k, 1, 0.4 + 0.1 * k), (1, 1.2, 1), turn))
    b.sphere((-1.5, turn, 1.2), 0.4, glass)
    b.lamp(SUN, 2.0, look_at((0, 0, 5), (1, 1, 0)), (0.1, 0))
    return b.make()


def expected_corners(scene, instance, primitive):
    matrix = scene.instance_to_world[instance]
    corners = scene.vertices[scene.triangles[primitive]].astype(float)
    return np.einsum("ij,ncj->nci", matrix[:, :3], corners) + matrix[:, 3]


def leaf_records(made):
    return made.leaf_records(made.joined())


def test_vertices_are_baked_in_double_and_rounded_once():
    """What tracing and what shading read of each triangle, against numpy."""
    scene = some_scene(0.3)
    made = make_geometry(scene)
    triangles, buffers = leaf_records(made), made.buffers
    in_world = triangles["instance"] != N["NONE"]
    assert in_world.sum() == 2 + 2 * 12 * 11 * 2 and len(triangles) == len(scene.triangles)
    for row in np.flatnonzero(in_world)[::7]:
        record = triangles[row]
        instance, primitive = int(record["instance"]), int(record["primitive"])
        mirrored = np.linalg.det(scene.instance_to_world[instance][:, :3]) < 0
        order = [0, 2, 1] if mirrored else [0, 1, 2]
        flags = buffers["instances"]["visibility"][instance]
        assert bool(flags & N["INSTANCE_MIRRORED"]) == mirrored
        wanted = expected_corners(scene, instance, [primitive])[0, order]
        seen = np.stack([record[name] for name in ("v0", "v1", "v2")])
        assert np.abs(seen - wanted).max() <= np.abs(wanted).max() * 2.0**-24
        used = buffers["indices"][primitive][order]
        assert np.array_equal(buffers["vertices"][used], seen)
        assert record["flags"] >> 16 & 31 == scene.instance_visibility[instance]
        mesh = scene.instance_mesh[instance]
        assert bool(flags & N["INSTANCE_SMOOTH"]) == (scene.mesh_normals[mesh] >= 0)
        if scene.mesh_normals[mesh] >= 0:
            at = (used + buffers["instances"]["first_normal"][instance]) % 2**32
            own = scene.normals[used - scene.mesh_vertices[mesh] + scene.mesh_normals[mesh]].astype(float)
            turned = own @ np.linalg.inv(scene.instance_to_world[instance][:, :3])
            unit = turned / np.linalg.norm(turned, axis=1, keepdims=True)
            np.testing.assert_allclose(buffers["normals"][at], unit, atol=1e-7)
    for row in np.flatnonzero(~in_world):  # as they are
        primitive = triangles["primitive"][row]
        corners = scene.vertices[scene.triangles[primitive]]
        assert np.array_equal(np.stack([triangles[name][row] for name in ("v0", "v1", "v2")]), corners)
        assert np.array_equal(buffers["vertices"][buffers["indices"][primitive]], corners)


def test_meshes_that_stay_where_they_are_take_no_memory():
    b = Builder()
    b.instance(b.mesh(ball(rings=6)), b.material(diffuse(0.5)))
    scene = b.make()
    made = make_geometry(scene)
    assert made.buffers["vertices"] is scene.vertices and made.buffers["indices"] is scene.triangles


def test_flat_and_smooth_meshes_in_any_order():
    """first_normal wraps around where a flat mesh has vertices before a smooth one."""
    b = Builder()
    grey = b.material(diffuse(0.5))
    for smooth in (False, True, False, True):
        vertices, triangles = ball(rings=4)
        b.instance(b.mesh((vertices, triangles), normals=vertices if smooth else None), grey)
    made = make_geometry(b.make())
    count = len(ball(rings=4)[0])
    instances = made.buffers["instances"]
    assert (instances["visibility"] & N["INSTANCE_SMOOTH"] != 0).tolist() == [False, True, False, True]
    assert instances["first_normal"][[1, 3]].tolist() == [2**32 - count, 2**32 - 2 * count]


def test_split_vertices():
    """A vertex for each normal that its corners have, in the order of the corners, for any number of threads."""
    rng = np.random.default_rng(12)
    for count, kinds in ((5, 1), (200, 3), (40000, 1), (40000, 4)):
        vertex = rng.integers(0, count, 3 * count).astype(np.uint32)
        table = rng.normal(size=(kinds, 3)).astype(np.float32)
        normals = table[np.where(rng.random(3 * count) < 0.9, 0, rng.integers(0, kinds, 3 * count))]
        corner, origin, made = geometry._native.split_vertices(vertex, normals, count, 1)
        assert made.shape == (count + len(origin), 3) and np.array_equal(made[corner], normals)
        whole = np.concatenate([np.arange(count), origin])
        assert np.array_equal(whole[corner], vertex)
        pairs = np.unique(np.concatenate([vertex[:, None], normals.view(np.uint32)], axis=1), axis=0)
        assert len(np.unique(corner)) == len(pairs)
        first = np.unique(corner, return_index=True)[1]
        added = corner[np.sort(first)]
        assert (np.diff(added[added >= count].astype(int)) == 1).all() and (origin < count).all()
        for threads in (2, 7):
            again = geometry._native.split_vertices(vertex, normals, count, threads)
            assert all(np.array_equal(a, b) for a, b in zip((corner, origin, made), again, strict=True))


def test_fingerprints_see_every_byte():
    data = np.random.default_rng(3).integers(0, 256, 3 << 20).astype(np.uint8)
    seen = {geometry._native.fingerprint(data, threads) for threads in (1, 2, 7)}
    assert len(seen) == 1
    for at in (0, 1, 15, 16, 1 << 20, (1 << 20) - 1, len(data) - 1):
        data[at] ^= 0x40
        seen.add(geometry._native.fingerprint(data, 2))
        data[at] ^= 0x40
    seen |= {geometry._native.fingerprint(np.zeros(n, np.uint8), 1) for n in range(40)}
    assert len(seen) == 1 + 7 + 40


def test_boxes_of_meshes():
    scene = some_scene()
    for mesh, (low, high) in enumerate(geometry.mesh_boxes(scene)):
        corners = scene.vertices[scene.triangles[scene.mesh_triangles[mesh]:scene.mesh_triangles[mesh + 1]]]
        assert np.array_equal(low, corners.min((0, 1))) and np.array_equal(high, corners.max((0, 1)))


def test_bad_triangles_are_those_of_numpy():
    rng = np.random.default_rng(2)
    vertices = rng.normal(size=(4000, 3)).astype(np.float32)
    vertices[:200] *= 1e-30
    vertices[200:400] *= 1e30
    vertices[400:440] = np.array([np.nan, np.inf, -np.inf, 3e38] * 10, np.float32)[:, None]
    triangles = rng.integers(0, 4000, (9000, 3)).astype(np.uint32)
    triangles[::9, 1] = triangles[::9, 0]
    scene = tiny_scene(vertices=vertices, triangles=triangles, triangle_slots=np.zeros(9000, int),
                       mesh_triangles=[0, 9000])
    with np.errstate(all="ignore"):
        corners = vertices[triangles]
        edges = (corners[:, 1:] - corners[:, :1]).astype(float)
        square = (np.cross(edges[:, 0], edges[:, 1]) ** 2).sum(1)
        reach = (edges**2).max((1, 2))  # kernels multiply such lengths in float32
        bad = ~((square > 0) & np.isfinite(square) & (reach <= np.finfo(np.float32).max))
    problems, cleaned, notes = check(scene)
    assert 1000 < bad.sum() < 4000 and np.array_equal(cleaned.triangles, triangles[~bad])
    assert notes[0]["what"].startswith(f"{bad.sum()} of 9000 triangles") and len(problems) == 1


# ------------------------------------------------------------------ what another frame has left


def everything(made):
    """All that is made of a scene, by name."""
    joined = made.joined()
    return made.buffers | {"nodes": joined.nodes, "triangles": made.leaf_records(joined), "joined": joined.instances}


def same_buffers(a, b, names=None):
    a, b = everything(a), everything(b)
    return all(a[name].tobytes() == b[name].tobytes() for name in names or a)


def test_what_has_not_changed_is_the_same_object():
    kept = make_geometry(some_scene())
    moved = some_scene()
    moved.arrays["camera_to_world"] = place((1, 2, 3))
    moved.arrays["world_radiance"] = np.ones(3)
    assert make_geometry(moved, kept) is kept
    assert prepare(moved, kept).buffers["camera"]["position"].tolist() == [[1, 2, 3]]


def test_every_input_counts():
    def with_slots():
        scene = some_scene()
        scene.arrays["triangle_slots"] = np.zeros(len(scene.triangles), np.uint16)
        scene.arrays["radii"] = np.zeros(1, np.float32)
        count = int(scene.mesh_vertices[1])
        scene.arrays["instance_keys"][0] = scene.arrays["mesh_keys"][0] = 2
        scene.arrays |= {"key_to_world": np.stack([scene.instance_to_world[0]] * 2),
                         "key_vertices": np.tile(scene.vertices[:count], (2, 1)),
                         "key_normals": np.zeros((2 * count, 3), np.float32)}
        return scene

    kept = make_geometry(with_slots())
    for name in geometry.INPUTS:
        scene = with_slots()
        array = scene.arrays[name].copy()
        array.reshape(-1).view(np.uint8)[0] ^= 1
        scene.arrays[name] = array
        assert kept.changes(scene) == {name}


@pytest.mark.parametrize("device", ["openmp", "opencl"])
def test_frames_of_what_moves_give_the_bits_of_one_alone(device, monkeypatch):
    """Trees whose boxes hold the way of another frame: instances and a mesh that deforms go elsewhere, or stay."""
    def scene(turn, moves=True):
        b = Builder((12, 10))
        b.world = 0.5
        b.look((0, -6, 1), (0, 0, 0), 0.4)
        b.add(quad((0, 0, -1), (4, 0, 0), (0, 4, 0)), diffuse(0.5))
        shape = ball(rings=6)
        swollen = [(shape[0] * (1 + turn * k), shape[0]) for k in (-0.2, 0.0, 0.3)] if moves else None
        keys = [place((k, 0, 0), (1, 0.5, 0.7), turn + k) for k in (-0.4, 0, 0.5)]
        b.instance(b.mesh(shape, normals=shape[0], shapes=swollen), b.material(diffuse(0.7)),
                   matrix=place((-1.2, 0, turn)))
        b.instance(b.mesh(box(half=0.5)), b.material(diffuse(0.4)), keys=keys if moves else None)
        return b.make()

    if device == "opencl" and not list_kind("opencl"):
        missing("no OpenCL device")
    kept = make_geometry(scene(0.2))
    assert kept.wide_tree
    for following in (scene(0.25), scene(-0.5), scene(0.2, moves=False), scene(0.2)):
        wanted = sums(render(following, 8, device=device))
        made = make_geometry(following, kept)
        monkeypatch.setattr("isophote.prepare.make_geometry", lambda scene, _=None, made=made: made)
        assert sums(render(following, 8, device=device)) == wanted
        monkeypatch.undo()
        kept = made


def test_trees_of_instances_stay_when_they_move():
    kept = make_geometry(some_scene())
    made = make_geometry(some_scene(0.1), kept)
    assert [tree.content.mesh for tree in made.bvh2()] == [2, 3, trees.WORLD]
    assert all(made.trees[k] is kept.trees[k] for k in range(2)) and made.trees[2] is not kept.trees[2]


def test_boxes_of_trees_that_are_used_again_are_those_of_new_ones():
    """Nothing has moved, but a slot's visibility: the nodes with new boxes are the nodes that the builder made."""
    scene, kept = some_scene(), make_geometry(some_scene())
    scene.arrays["instance_visibility"] = scene.instance_visibility ^ 1
    made = make_geometry(scene, kept)
    assert made is not kept and same_buffers(made, kept, ("nodes", "vertices", "normals"))
    assert not same_buffers(made, kept, ("triangles",)) and same_buffers(made, make_geometry(scene))


def sums(film):
    return np.stack([film.sum(plane) for plane in range(film.planes)]).tobytes()


CHANGES = {"moved": dict(turn=0.02), "far": dict(turn=2.0), "deformed": dict(bump=0.01), "more": dict(count=5),
           "finer": dict(rings=13), "less": dict(count=1)}


@pytest.mark.parametrize("left", ["bvh2", "wide", "both"])
@pytest.mark.parametrize("change", CHANGES)
def test_pictures_with_and_without_what_was_kept_have_the_same_bits(change, left, monkeypatch):
    first, second = some_scene(), some_scene(**CHANGES[change])
    kept = make_geometry(first)
    before = {name: array.tobytes() for name, array in everything(kept).items()}
    if left != "bvh2":
        assert kept.wide_tree
        kept.settle(keep_bvh2=left == "both")
    wanted = sums(render(second, 16))
    for limit in (trees.REFIT_COST, 0.0, 1e9):  # as it is, never, and with trees that have become bad ones
        monkeypatch.setattr(trees, "REFIT_COST", limit)
        made = make_geometry(second, kept)
        monkeypatch.setattr("isophote.prepare.make_geometry", lambda scene, _=None, made=made: made)
        assert sums(render(second, 16)) == wanted
        monkeypatch.undo()
    assert before == {name: array.tobytes() for name, array in everything(kept).items()}, "what is kept stays as it is"


@pytest.mark.parametrize("change", ["moved", "deformed"])
def test_the_cpus_tree_gets_new_boxes_without_a_bvh2(change):
    """Its hits are those of a new one; the parts of meshes that have not changed are copied."""
    kept = make_geometry(some_scene())
    assert kept.wide_tree
    kept.settle(keep_bvh2=False)
    scene = some_scene(**CHANGES[change])
    made, new = make_geometry(scene, kept), make_geometry(scene)
    assert made.wide_tree.bytes == kept.wide_tree.bytes and not made.trees
    prepared = prepare(scene)
    rng = np.random.default_rng(6)
    direction = rng.normal(size=(5000, 3))
    rays = np.concatenate([rng.uniform(-3, 3, (5000, 3)), direction / np.linalg.norm(direction, axis=1, keepdims=True),
                           np.zeros((5000, 1)), np.full((5000, 1), 1e30)], axis=1).astype(np.float32)
    data = [geometry.plain(array) for array in prepared.traced().values()]
    variant = geometry._native.variants[0][0]
    hits = [geometry._native.trace(variant, data, tree, rays, False, 2)
            for tree in (made.wide_tree, new.wide_tree, None)]
    assert (hits[0][1][:, 0] != N["NONE"]).mean() > 0.2
    for other in hits[1:]:
        assert all(np.array_equal(a, b) for a, b in zip(hits[0], other, strict=True))
    made.settle(keep_bvh2=False)
    assert set(made.bytes) == {"meshes", "bvh2", "wide_tree"} and made.bytes["bvh2"] == 0


def test_trees_that_have_become_bad_are_built_anew():
    """Objects that change places: the tree of the one order is a bad one of the other."""
    def scattered(order):
        b = Builder()
        material = b.material(diffuse(0.5))
        shape = ball(radius=0.3, rings=6)
        for k in order:
            b.instance(b.mesh(shape), material, matrix=place((k % 6, k // 6, 0)))
        return b.make()

    kept = make_geometry(scattered(range(36)))
    near = make_geometry(scattered(range(36)), kept)
    assert near is kept
    shuffled = scattered(np.random.default_rng(1).permutation(36).tolist())
    made = make_geometry(shuffled, kept)
    assert same_buffers(made, make_geometry(shuffled)), "as built from nothing"
    assert made.bvh2()[-1].built_cost == 0.0
    assert kept.wide_tree
    kept.settle(keep_bvh2=False)
    made = make_geometry(shuffled, kept)
    assert made.wide_tree.bytes == make_geometry(shuffled).wide_tree.bytes and made.trees, "built from nothing"


def test_other_normals_leave_the_cpus_tree_as_it_is():
    scene, kept = some_scene(), make_geometry(some_scene())
    tree = kept.wide_tree
    scene.arrays["normals"] = -scene.normals
    made = make_geometry(scene, kept)
    assert made is not kept and made.wide_tree is tree and not same_buffers(made, kept, ("normals",))
    assert make_geometry(some_scene(0.1), kept).wide_tree is not tree


def wires(turn=0.0):
    """Long thin slanted triangles, in several leaves each, half of them smooth."""
    rng = np.random.default_rng(4)
    start, along, across = (rng.normal(size=(1000, 3)) for _ in range(3))
    corners = np.stack([start, start + along, start + 0.003 * across], axis=1).reshape(-1, 3)
    b = Builder()
    grey = b.material(diffuse(0.5))
    normals = across / np.linalg.norm(across, axis=1, keepdims=True)
    b.instance(b.mesh((corners, np.arange(3000).reshape(-1, 3)), normals=np.repeat(normals, 3, axis=0)), grey)
    b.instance(b.mesh((corners[:, [1, 2, 0]], np.arange(3000).reshape(-1, 3))), grey, matrix=place((0, 0, turn)))
    return b.make()


def test_triangles_in_several_leaves():
    """A tree of pieces is built anew when things have moved."""
    scene = wires()
    made = make_geometry(scene)
    triangles = leaf_records(made)
    assert len(triangles) > 1.1 * len(scene.triangles)
    assert set(triangles["primitive"].tolist()) == set(range(len(scene.triangles)))
    corners = scene.vertices[scene.triangles[triangles["primitive"]]]
    assert np.array_equal(np.stack([triangles[name] for name in ("v0", "v1", "v2")], axis=1), corners)
    moved = make_geometry(wires(0.01), made)
    assert same_buffers(moved, make_geometry(wires(0.01)))


def test_trees_that_were_dropped_are_built_again():
    for scene in (some_scene(), wires()):
        made, dropped = make_geometry(scene), make_geometry(scene)
        wide = dropped.wide_tree
        dropped.settle(keep_bvh2=False)
        assert dropped.bytes["bvh2"] == 0 and dropped.bytes["wide_tree"] == sum(wide.bytes.values())
        assert make_geometry(scene, dropped) is dropped and not dropped.trees
        assert same_buffers(made, dropped)
    moved = make_geometry(wires(0.01), dropped)
    assert moved.wide_tree.bytes == make_geometry(wires(0.01)).wide_tree.bytes, "no pieces of other triangles"


def test_a_scene_with_other_slots_keeps_its_trees_without_asking_for_them():
    scene, kept = some_scene(), make_geometry(some_scene())
    wide = kept.wide_tree
    kept.settle(keep_bvh2=False)
    scene.arrays["triangle_slots"] = np.zeros(len(scene.triangles), np.uint16)
    made = make_geometry(scene, kept)
    assert made is not kept and not made.trees and made.wide_tree is wide
