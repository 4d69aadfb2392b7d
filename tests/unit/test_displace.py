"""Displacement of vertices by what programs compute, compared with formulas."""

import numpy as np
import pytest

from isophote.displace import displaced
from isophote.material_program import make_displacement
from isophote.values import ARITHMETIC, call1
from tests.scenes import Builder, ball, box, diffuse, place, quad

X = ARITHMETIC.call("object_point")[0]
ALONG = ARITHMETIC.call("shading_normal")


def scene_of(shape, matrices, normals=None, materials=1):
    b = Builder()
    numbers = [b.material(diffuse(0.5)) for _ in range(materials)]
    triangles = len(shape[1])
    mesh = b.mesh(shape, slots=np.arange(triangles) * materials // triangles, normals=normals)
    for matrix in matrices:
        b.instance(mesh, *numbers, matrix=matrix)
    return b.make()


def turned(degrees, scale=(1.0, 1.0, 1.0)):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.concatenate([np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) * scale, [[3.0], [-2.0], [1.0]]], axis=1)


@pytest.mark.parametrize("scale", [(1.0, 1.0, 1.0), (2.0, 0.5, 3.0), (-1.0, 2.0, 1.0)])
def test_vectors_are_those_of_the_world(scale):
    vertices, triangles = box()
    scene = scene_of((vertices, triangles), [turned(30, scale)])
    moved = displaced(scene, {0: make_displacement((0.25, -1.0, 0.5), True)}, {0: vertices.astype(np.float32)})
    to_world = turned(30, scale)[:, :3]
    off = (moved.vertices.astype(float) - scene.vertices) @ to_world.T
    assert np.allclose(off, [0.25, -1.0, 0.5], atol=2e-6)
    assert not moved.notes and moved.content_hash != scene.content_hash


@pytest.mark.parametrize("smooth", [True, False])
@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_balls_swell_along_their_normals(smooth, mirror):
    vertices, triangles = ball(rings=12)
    normals = vertices / np.linalg.norm(vertices, axis=1, keepdims=True)
    scene = scene_of((vertices, triangles), [turned(70, (mirror, 1.0, 1.0))], normals if smooth else None)
    by = [0.5 * (n + 0.0) for n in ALONG]
    moved = displaced(scene, {0: make_displacement(by, True)}, {0: normals.astype(np.float32)})
    assert np.allclose(moved.vertices, 1.5 * vertices, atol=2e-6)
    if smooth:  # the normals are those of the triangles around
        assert np.allclose(moved.normals, normals, atol=0.06) and not np.array_equal(moved.normals, scene.normals)
    else:
        assert not len(moved.normals)


def test_normals_follow_slopes_or_stay():
    vertices, triangles = quad((0, 0, 0), (1, 0, 0), (0, 1, 0))
    up = np.tile([0.0, 0.0, 1.0], (4, 1))
    scene = scene_of((vertices, triangles), [place()], up)
    by = 0.0, 0.0, X * 0.75
    turns, stays = (displaced(scene, {0: make_displacement(by, turns)}, {}) for turns in (True, False))
    assert np.allclose(turns.vertices[:, 2], 0.75 * vertices[:, 0]) and np.array_equal(turns.vertices, stays.vertices)
    assert np.allclose(turns.normals, [-0.6, 0.0, 0.8], atol=1e-6) and np.array_equal(stays.normals, up)


def test_only_the_triangles_of_a_material_move_and_shared_vertices_once():
    vertices, triangles = quad((0, 0, 0), (1, 0, 0), (0, 1, 0))
    scene = scene_of((vertices, triangles), [place()], np.tile([0.0, 0.0, 1.0], (4, 1)), materials=2)
    moved = displaced(scene, {1: make_displacement((0.0, 0.0, 1.0), True)}, {})
    there = np.isin(np.arange(4), triangles[1])
    assert moved.vertices[:, 2].tolist() == there.astype(float).tolist() and there.sum() == 3


def test_instances_are_moved_as_the_first_of_them():
    shape = quad((0, 0, 0), (1, 0, 0), (0, 1, 0))
    world_x = ARITHMETIC.call("position")[0]
    scene = scene_of(shape, [place((5, 0, 0)), place((9, 0, 0))], np.tile([0.0, 0.0, 1.0], (4, 1)))
    moved = displaced(scene, {0: make_displacement((0.0, 0.0, world_x), True)}, {})
    assert np.allclose(moved.vertices[:, 2], shape[0][:, 0] + 5.0, atol=1e-5)
    assert moved.vertices.tobytes() == displaced(scene, {0: make_displacement((0.0, 0.0, world_x), True)},
                                                 {}).vertices.tobytes()


def test_what_is_no_number_moves_nothing_and_is_named():
    scene = scene_of(quad((0, 0, 0), (1, 0, 0), (0, 1, 0)), [place()], np.tile([0.0, 0.0, 1.0], (4, 1)))
    endless = call1("multiply", call1("add", X, 2.0), 3e38) * 3e38  # x + 2 is above 0
    moved = displaced(scene, {0: make_displacement((0.0, 1.0, endless), True)}, {})
    assert np.array_equal(moved.vertices, scene.vertices)
    assert moved.notes == [{"kind": "mesh", "name": "meshes[0]",
                            "what": "the displacement of 4 vertices is no number: left where they are"}]


def test_triangles_without_an_area_do_not_count():
    vertices, triangles = quad((0, 0, 0), (1, 0, 0), (0, 1, 0))
    flat = np.concatenate([[[0, 0, 1]], triangles])  # comes first
    scene = scene_of((vertices, flat), [place()], np.tile([0.0, 0.0, 1.0], (4, 1)))
    moved = displaced(scene, {0: make_displacement((0.0, 0.0, X), True)}, {})
    assert np.allclose(moved.vertices[:, 2], vertices[:, 0]) and np.isfinite(moved.normals).all()
