"""Hits do not depend on the tree: no tree, the BVH2 of the kernels and the wide tree of the CPU give the same bits.

Rays are random ones, and those that meet what is hard: vertices, edges, coincident triangles, planes that contain
them, instances.
"""

from functools import cache

import numpy as np
import pytest

from isophote import _native, geometry, trees
from isophote.records import numbers
from tests.scenes import Builder, ball, box, diffuse, place, quad, ready

RAYS = 6000
VARIANTS = [name for name, _, _, supported in _native.variants if supported]
STRICT = [name for name in VARIANTS if name.startswith("strict")]
FAR = 3e38


def soup(rng, count, size):
    """Random triangles in a box of 4 m, on a grid that makes vertices and edges coincide."""
    corners = np.round(rng.uniform(-2, 2, (count, 1, 3)) * 8) / 8 + np.round(rng.normal(0, size, (count, 3, 3)) * 8) / 8
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    corners = corners[area > 1e-3]
    return corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)


def scene_of(kind):
    rng = np.random.default_rng(3)
    b = Builder()
    material = b.material(diffuse(0.5))
    if kind == "soup":
        b.instance(b.mesh(soup(rng, 700, 0.4)), material)
    elif kind == "closed":
        vertices, triangles = ball(radius=1.5, rings=14)
        b.instance(b.mesh((vertices @ np.linalg.qr(rng.normal(size=(3, 3)))[0], triangles)), material)
        b.instance(b.mesh(box(half=1.9)), material)
    elif kind == "slanted":  # long and thin: in several leaves each
        start, along, across = rng.uniform(-2, 2, (900, 3)), rng.normal(size=(900, 3)), rng.normal(size=(900, 3))
        corners = np.stack([start, start + 2 * along, start + 0.03 * across], axis=1)
        b.instance(b.mesh((corners.reshape(-1, 3), np.arange(2700).reshape(-1, 3))), material)
        b.instance(b.mesh(box(half=1.9)), material)
    elif kind == "coincident":  # each triangle eight times, in one mesh and in several
        shape = soup(rng, 40, 0.8)
        for _ in range(4):
            b.instance(b.mesh((shape[0], np.concatenate([shape[1], shape[1][:, [1, 2, 0]]]))), material)
        for _ in range(5):
            b.instance(b.mesh(quad((0, 0, 0), (1.5, 0, 0), (0, 1.5, 0))), material)
            b.sphere((0.5, 0.5, 0.5), 0.7, material)
    else:
        meshes = [b.mesh(soup(rng, 60, 0.3)), b.mesh(ball(rings=6)), b.mesh(box())]
        for k in range(40):
            scale = rng.uniform(0.1, 0.8, 3) * rng.choice([-1, 1], 3)
            matrix = place(rng.uniform(-2, 2, 3), scale, rng.uniform(0, 6)) if k % 5 else place((0.25, 0, 0), scale[0])
            b.instance(meshes[k % 3], material, matrix=matrix)
        for _ in range(10):
            b.sphere(rng.uniform(-2, 2, 3), rng.uniform(0.05, 0.5), material)
    return b.make()


def rays_at(targets, origins):
    directions = targets - origins
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return np.concatenate([origins, directions, np.zeros((len(origins), 1)), np.full((len(origins), 1), FAR)], axis=1)


def rays_for(scene):
    """float32 (n, 8): origin, direction, t_min, t_max."""
    rng = np.random.default_rng(4)
    first, all_corners = scene.mesh_triangles, scene.vertices[scene.triangles].astype(float)
    corners = np.concatenate([all_corners[first[mesh]:first[mesh + 1]] @ matrix[:, :3].T + matrix[:, 3]
                              for mesh, matrix in zip(scene.instance_mesh, scene.instance_to_world, strict=True)])
    picked = corners[rng.integers(len(corners), size=RAYS)]
    outside = rng.normal(size=(RAYS, 3)) * 3
    onto_edges = picked[:, 0] + rng.integers(0, 5, (RAYS, 1)) / 4 * (picked[:, 1] - picked[:, 0])
    inside = np.einsum("nk,nkj->nj", rng.dirichlet((1, 1, 1), RAYS), picked)
    along = np.repeat(np.eye(3)[rng.integers(3, size=RAYS)] * rng.choice([-1, 1], (RAYS, 1)), 1, axis=0)
    rays = [
        rays_at(rng.uniform(-2, 2, (RAYS, 3)), outside),
        rays_at(picked[:, 0], outside),  # through vertices
        rays_at(onto_edges, outside),
        rays_at(inside + along, inside),  # from surfaces, along the axes: in the planes of axis-aligned triangles
        rays_at(picked[:, 1], picked[:, 0]),  # along edges
        rays_at(inside + rng.normal(size=(RAYS, 3)), inside),
    ]
    rays[0][::3, 6:] = np.sort(rng.uniform(0, 4, (RAYS // 3, 2)), axis=1)  # limited rays
    return np.concatenate(rays).astype(np.float32)


@cache
def traced(kind):
    """(rays, the buffers' bytes, the wide tree, t u v bits and ids of the closest hits in the BVH2)."""
    scene = scene_of(kind)
    data, wide = bytes_and_tree(ready(scene))
    rays = rays_for(scene)
    return rays, data, wide, hits(data, None, rays)


def bytes_and_tree(prepared):
    return [geometry.plain(buffer) for buffer in prepared.traced().values()], prepared.geometry.wide_tree


def hits(data, tree, rays, any_hit=False, threads=2, variant=STRICT[0], packets=False):
    """uint32 (n, 5): bits of t, u, v, instance and primitive."""
    tuv, ids = _native.trace(variant, data, tree, rays, any_hit, threads, packets)
    return np.concatenate([tuv.view(np.uint32), ids], axis=1)


@pytest.fixture(params=["soup", "closed", "slanted", "coincident", "instances"])
def kind(request):
    return request.param


def test_rays_hit_and_miss(kind):
    """Otherwise the other tests would compare nothing."""
    rays, _, _, closest = traced(kind)
    misses = closest[:, 3] == numbers()["NONE"]
    assert 0.02 < misses.mean() < 0.9
    assert len(np.unique(closest[~misses][:, 4])) > 20


@pytest.mark.parametrize("variant", STRICT)
def test_wide_tree(kind, variant):
    rays, data, wide, closest = traced(kind)
    np.testing.assert_array_equal(hits(data, wide, rays, variant=variant), closest)
    np.testing.assert_array_equal(hits(data, None, rays, variant=variant, threads=1), closest)


def bundles(rays):
    """Sixteen rays in the place of each: the same one, in part turned a little, so that packets stay together."""
    rng = np.random.default_rng(5)
    sixteen = np.repeat(rays, 16, axis=0)
    turned = sixteen[:, 3:6] + rng.normal(size=(len(sixteen), 3)) * rng.choice([0, 1e-6, 1e-2], (len(sixteen), 1))
    sixteen[:, 3:6] = turned / np.linalg.norm(turned, axis=1, keepdims=True)
    return sixteen


@pytest.mark.parametrize("variant", STRICT)
def test_packets(kind, variant):
    """Of rays that go much the same way, of rays that do not, and of a number that sixteen does not divide."""
    rays, data, wide, closest = traced(kind)
    np.testing.assert_array_equal(hits(data, wide, rays[:5003], variant=variant, packets=True), closest[:5003])
    together = bundles(rays[::23])
    np.testing.assert_array_equal(hits(data, wide, together, variant=variant, packets=True),
                                  hits(data, None, together, variant=variant))


@pytest.mark.parametrize("exponent", [-40, 0, 40])
def test_hard_directions_and_scales(exponent):
    """Components of a direction that are zero, of either sign, or hardly more; origins in planes of boxes and far off;
    scenes of a picometre and of light minutes."""
    rng = np.random.default_rng(6)
    k = np.float32(2.0 ** exponent)
    b = Builder()
    material = b.material(diffuse(0.5))
    vertices, triangles = soup(rng, 300, 0.4)
    b.instance(b.mesh((vertices * k, triangles)), material)
    b.instance(b.mesh(box(half=1.9 * k)), material)
    data, wide = bytes_and_tree(ready(b.make()))
    direction = np.eye(3)[rng.integers(3, size=RAYS)] * rng.choice([-1, 1], (RAYS, 1))
    direction += rng.choice([0.0, -0.0, 1e-38, -1e-38, 1e-30, 1e-20, -1e-8, 0.3], (RAYS, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    origin = np.round(rng.uniform(-2, 2, (RAYS, 3)) * 8) / 8 - direction * rng.choice([0, 10, 1e6], (RAYS, 1))
    limits = np.zeros((RAYS, 1)), np.full((RAYS, 1), FAR)
    rays = bundles(np.concatenate([origin * k, direction, *limits], axis=1).astype(np.float32)[::4])
    closest = hits(data, None, rays)
    assert (closest[:, 3] != numbers()["NONE"]).mean() > 0.3
    for variant in STRICT:
        for packets in (False, True):
            np.testing.assert_array_equal(hits(data, wide, rays, variant=variant, packets=packets), closest)


@pytest.mark.parametrize("tree", ["BVH2", "wide"])
def test_occlusion_is_whether_there_is_a_hit(kind, tree):
    rays, data, wide, closest = traced(kind)
    occluded = hits(data, wide if tree == "wide" else None, rays, any_hit=True)[:, 3] != numbers()["NONE"]
    np.testing.assert_array_equal(occluded, closest[:, 3] != numbers()["NONE"])


@pytest.mark.parametrize("max_leaf", [1, 1 << 20])
def test_no_tree_and_a_deep_one(kind, max_leaf, monkeypatch):
    """Leaves of one item; and one leaf for each kind that holds all: brute force."""
    rays, _, _, closest = traced(kind)
    monkeypatch.setattr(trees, "MAX_LEAF", max_leaf)
    data, wide = bytes_and_tree(ready(scene_of(kind)))
    some = np.random.default_rng(8).permutation(len(rays))[:8000 if max_leaf > 1 else None]
    np.testing.assert_array_equal(hits(data, None, rays[some]), closest[some])
    np.testing.assert_array_equal(hits(data, wide, rays[some]), closest[some])


def test_brute_force_over_all_triangles(kind):
    """Trees of single triangles, one ray loop each, merged by the order of (t, instance, primitive)."""
    scene = scene_of(kind)
    if kind == "instances":
        pytest.skip("object space is the kernels' matter: covered by the trees of one leaf")
    rays = traced(kind)[0][::8]
    buffers = ready(scene).traced()
    best = np.full(len(rays), np.inf, np.float32), np.full((len(rays), 2), numbers()["NONE"], np.uint64)
    for first in range(len(buffers["triangles"])):
        one = dict(buffers, triangles=buffers["triangles"][first:first + 1].copy(), world=buffers["world"].copy())
        one["triangles"]["flags"] |= np.uint32(numbers()["LAST_IN_LEAF"])
        one["world"]["root"] = numbers()["REF_TRIANGLES"] << 30
        tuv, ids = _native.trace(STRICT[0], [geometry.plain(buffer) for buffer in one.values()], None, rays, False, 2)
        key = ids[:, 0].astype(np.uint64) << 32 | ids[:, 1]
        known = best[1][:, 0] << 32 | best[1][:, 1]
        closer = (ids[:, 0] != numbers()["NONE"]) & ((tuv[:, 0] < best[0]) | ((tuv[:, 0] == best[0]) & (key < known)))
        best[0][closer], best[1][closer] = tuv[closer, 0], ids[closer]
    closest = traced(kind)[3][::8]
    on_triangle = closest[:, 3] < numbers()["NONE"] - 1
    np.testing.assert_array_equal(closest[on_triangle, 0], best[0][on_triangle].view(np.uint32))
    np.testing.assert_array_equal(closest[on_triangle, 3:], best[1][on_triangle].astype(np.uint32))
    if not len(scene.sphere_radius):
        np.testing.assert_array_equal(np.isfinite(best[0]), on_triangle)


def test_hits_agree_with_float64():
    """Where a hit is well inside a triangle, t is that of the exact ray and plane."""
    rays, data, _, _ = traced("closed")
    tuv, ids = _native.trace(STRICT[0], data, None, rays, False, 2)
    scene = scene_of("closed")
    hit = (ids[:, 0] != numbers()["NONE"]) & (tuv[:, 1] > 0.01) & (tuv[:, 2] > 0.01) & (tuv[:, 1] + tuv[:, 2] < 0.99)
    # Vertices of a mesh follow each other in the scene; triangles index into all of them.
    a, b, c = np.moveaxis(scene.vertices[scene.triangles[ids[hit, 1]]].astype(float), 1, 0)
    origin, direction = rays[hit, :3].astype(float), rays[hit, 3:6].astype(float)
    normal = np.cross(b - a, c - a)
    facing = np.einsum("ij,ij->i", normal, direction)
    t = np.einsum("ij,ij->i", normal, a - origin) / facing
    steep = np.abs(facing) > 0.1 * np.linalg.norm(normal, axis=1)
    assert steep.sum() > 1000
    np.testing.assert_allclose(tuv[hit, 0][steep], t[steep], rtol=1e-5, atol=2e-6)


def test_no_ray_slips_through_a_closed_body():
    """From inside a ball every ray, also towards vertices and along edges, hits it: watertight."""
    vertices, triangles = ball(radius=1.5, rings=14)
    b = Builder()
    b.add((vertices, triangles), diffuse(0.5))
    data, wide = bytes_and_tree(ready(b.make()))
    rng = np.random.default_rng(9)
    origins = rng.normal(size=(60000, 3)) * 0.3
    corners = b.meshes[0][0][triangles[rng.integers(len(triangles), size=60000)]].astype(float)
    targets = corners[:, 0] + rng.integers(0, 9, (60000, 1)) / 8 * (corners[:, 1] - corners[:, 0])
    rays = rays_at(targets, origins).astype(np.float32)
    for tree, packets in ((None, False), (wide, False), (wide, True)):
        assert (hits(data, tree, rays, packets=packets)[:, 3] == 0).all()
    assert (hits(data, wide, bundles(rays[::16]), packets=True)[:, 3] == 0).all()


def test_just_in_front_of_a_long_wall():
    """Where t is too inexact to tell it from 0, the side of the plane still says that the wall is hit."""
    b = Builder()
    b.instance(b.mesh(box(half=(1, 1, 1000))), b.material(diffuse(0.5)))
    data, wide = bytes_and_tree(ready(b.make()))
    rng = np.random.default_rng(5)
    x, below, z = rng.uniform(-0.999, 0.999, RAYS), rng.uniform(1e-4, 4e-3, RAYS), rng.uniform(-9, 9, RAYS)
    origins = np.stack([x, 1 - below, z], axis=1)
    rays = rays_at(origins + rng.uniform((-0.6, 0.4, -0.9), (0.6, 0.8, 0.9), (RAYS, 3)), origins).astype(np.float32)
    found = hits(data, None, rays)
    assert (found[:, 3] != numbers()["NONE"]).all()
    assert (found[:, 0] == 0).any()  # else this shows nothing
    for packets in (False, True):
        assert (hits(data, wide, rays, packets=packets) == found).all()
        assert (hits(data, wide, rays, any_hit=True, packets=packets)[:, 3] != numbers()["NONE"]).all()
