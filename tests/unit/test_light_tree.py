"""The light tree: how often its walks end at each light against what light_chance says, and what clusters bound."""

import ctypes

import numpy as np
import pytest
from scipy import stats

from isophote.light_tree import make_light_tree
from isophote.records import numbers
from tests.kernel_lib import compiled
from tests.scenes import POINT, RECTANGLE, SPOT, SUN, Builder, ball, diffuse, emission, look_at, place, quad, ready

N = numbers()
SAMPLES = 1 << 17
SIGNIFICANCE = 1e-5

PROBE = """
#include "light.h"
extern "C" {
void probe_walk(const World *world, const Light *lights, const LightCluster *tree, const float *p, unsigned normal,
                int n, const float *u, unsigned *light, float *chance, float *rest) {
  Scene s;
  s.world = world; s.lights = lights; s.light_tree = tree;
  Receiver at = make_receiver(make_real3(p[0], p[1], p[2]), normal);
  for (int i = 0; i < n; i++) {
    LightWalk w = start_walk(u[i]);
    for (uint d = 0; d < world->light_depth; d++) w = step_walk(s, w, at);
    light[i] = w.at & ~CLUSTER_LIGHT;
    chance[i] = w.chance;
    rest[i] = w.u;
  }
}
void probe_chance(const World *world, const Light *lights, const LightCluster *tree, const float *p, unsigned normal,
                  float *chance) {
  Scene s;
  s.world = world; s.lights = lights; s.light_tree = tree;
  for (uint i = 0; i < world->light_count; i++)
    chance[i] = light_chance(s, lights[i], make_receiver(make_real3(p[0], p[1], p[2]), normal));
}
void probe_normal(int n, const float *v, unsigned *packed, float *back) {
  for (int i = 0; i < n; i++) {
    packed[i] = pack_normal(make_real3(v[3 * i], v[3 * i + 1], v[3 * i + 2]));
    Receiver r = make_receiver(zero3(), packed[i]);
    back[3 * i] = r.normal.x; back[3 * i + 1] = r.normal.y; back[3 * i + 2] = r.normal.z;
  }
}
void probe_find(const World *world, const Light *lights, int n, const unsigned *ids, unsigned *found) {
  Scene s;
  s.world = world; s.lights = lights;
  for (int i = 0; i < n; i++) found[i] = find_triangle_light(s, ids[2 * i], ids[2 * i + 1]);
}
}
"""


@pytest.fixture(scope="module")
def call():
    loaded = compiled(PROBE)
    return lambda name, *arguments: getattr(loaded, name)(*[
        a.ctypes.data_as(ctypes.c_void_p) if isinstance(a, np.ndarray) else a for a in arguments])


def scene_of(count: int) -> dict:
    """Buffers of a scene with some `count` lights of all kinds."""
    rng = np.random.default_rng(count)
    b = Builder()
    b.add(quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), diffuse(0.5))
    for k in range(count):
        where = rng.uniform((-5, -5, 0.5), (5, 5, 4))
        matrix = look_at(where, rng.uniform(-3, 3, 3))
        kind = (POINT, SPOT, RECTANGLE, SUN)[k % 4]
        b.lamp(kind, rng.uniform(0.1, 20, 3), matrix, size=(0.1 * (k % 3), 0.2) if kind != RECTANGLE else (0.4, 0.2))
    if count > 3:
        b.add(ball((1, -2, 2), 0.5, 4), emission(rng.uniform(0, 4, 3)))
        mesh, glow = b.mesh(quad((0, 0, 0), (0.2, 0, 0), (0, 0.2, 0))), b.material(emission(3.0))
        for k in range(count // 2):
            b.instance(mesh, glow, matrix=place(rng.uniform((-5, -5, 0.5), (5, 5, 4)), angle=k))
    return ready(b.make()).buffers


PLACES = {"floor": ((0.3, 0.2, 0.0), (0, 0, 1)), "ceiling": ((1.0, 1.0, 5.0), (0.1, 0, -1)),
          "among them": ((1.0, -2.0, 2.6), (1, 0, 0)), "all sides": ((-1.0, 2.0, 1.0), None)}


def test_clusters_know_what_part_of_them_lights_whom():
    lights = scene_of(37)["lights"].copy()
    lit = np.random.default_rng(2).random((len(lights), 5)) < (1.0, 0.5, 0.3, 0.1, 0.0)
    tree, _, shares = make_light_tree(lights, lit)
    brings = shares * tree["intensity"][:, None]
    for row, child in enumerate(tree["child"].tolist()):
        light = child & ~N["CLUSTER_LIGHT"]
        whole = lit[light] * tree["intensity"][row] if light != child else brings[2 * child] + brings[2 * child + 1]
        np.testing.assert_allclose(brings[row], whole, rtol=1e-5)
    assert make_light_tree(lights)[2].shape == (len(tree), 0)


def packed(call, normal):
    if normal is None:
        return 0x3FFF
    n = np.array(normal, np.float32) / np.linalg.norm(normal).astype(np.float32)
    code, back = np.zeros(1, np.uint32), np.zeros(3, np.float32)
    call("probe_normal", 1, n, code, back)
    return int(code[0])


@pytest.mark.parametrize("where", PLACES)
@pytest.mark.parametrize("count", [2, 3, 8, 37, 200])
def test_walks_end_with_the_chance_that_is_said(call, count, where):
    buffers = scene_of(count)
    world, lights, tree = (buffers[name] for name in ("world", "lights", "light_tree"))
    p, normal = np.array(PLACES[where][0], np.float32), packed(call, PLACES[where][1])
    said = np.zeros(len(lights), np.float32)
    call("probe_chance", world, lights, tree, p, normal, said)
    assert said.astype(float).sum() == pytest.approx(1, abs=1e-5)
    u = np.random.default_rng(1).random(SAMPLES, np.float32)
    light, chance, rest = np.zeros(SAMPLES, np.uint32), np.zeros(SAMPLES, np.float32), np.zeros(SAMPLES, np.float32)
    call("probe_walk", world, lights, tree, p, normal, SAMPLES, u, light, chance, rest)
    assert (chance == said[light]).all()  # the same arithmetic, the same bits: MIS rests on it
    counts = np.bincount(light, minlength=len(lights))
    often = said * SAMPLES > 8
    expected = said[often] * float(SAMPLES)
    assert stats.chi2.sf(((counts[often] - expected) ** 2 / expected).sum(), often.sum()) > SIGNIFICANCE
    assert rest.max() < 1 and stats.kstest(rest, "uniform").pvalue > SIGNIFICANCE


def test_tree_holds_every_light_once(call):
    buffers = scene_of(37)
    tree, lights = buffers["light_tree"], buffers["lights"]
    leaves = tree["child"][tree["child"] & N["CLUSTER_LIGHT"] != 0] & ~np.uint32(N["CLUSTER_LIGHT"])
    assert sorted(leaves.tolist()) == list(range(len(lights))) and len(tree) == 2 * (len(lights) - 1)
    assert buffers["world"]["light_depth"][0] <= int(np.ceil(np.log2(len(lights)))) + 2
    for number, trail in enumerate(lights["trail"].tolist()):
        at = 0
        while not at & N["CLUSTER_LIGHT"]:
            at, trail = int(tree["child"][2 * at + (trail & 1)]), trail >> 1
        assert at & ~N["CLUSTER_LIGHT"] == number
    assert make_light_tree(lights[:1])[1] == make_light_tree(lights[:0])[1] == 0


def test_clusters_hold_their_lights():
    buffers = scene_of(37)
    tree, lights = buffers["light_tree"], buffers["lights"]

    def lights_below(child):
        if child & N["CLUSTER_LIGHT"]:
            return [child & ~N["CLUSTER_LIGHT"]]
        return lights_below(int(tree["child"][2 * child])) + lights_below(int(tree["child"][2 * child + 1]))

    for cluster in tree:
        if cluster["flags"] & N["CLUSTER_DISTANT"]:
            continue
        for light in lights[lights_below(int(cluster["child"]))]:
            assert np.linalg.norm(light["position"] - cluster["center"]) <= cluster["radius"] * (1 + 1e-5) + 1e-5
            if light["kind"] in (N["LIGHT_RECTANGLE"], N["LIGHT_TRIANGLE"]):
                cosine = float(light["normal"] @ cluster["axis"])
                cosine = abs(cosine) if cluster["flags"] & N["CLUSTER_TWO_SIDED"] else cosine
                assert cosine >= cluster["cos_axes"] - 1e-5


def test_emissive_triangles_are_found(call):
    buffers = scene_of(8)
    world, lights = buffers["world"], buffers["lights"]
    first = int(world["lamp_count"][0])
    ids = np.stack([lights["instance"], lights["primitive"]], axis=1)[first:]
    ids = np.ascontiguousarray(np.concatenate([ids, [[0, 0], [99, 0], [ids[0, 0], 99999]]]), np.uint32)
    found = np.zeros(len(ids), np.uint32)
    call("probe_find", world, lights, len(ids), ids, found)
    assert found.tolist() == [*range(first, len(lights)), *[len(lights)] * 3]


def test_normals_fit_in_14_bits(call):
    v = np.random.default_rng(2).normal(size=(20000, 3))
    v = np.concatenate([v, np.eye(3), -np.eye(3)])
    v = (v / np.linalg.norm(v, axis=1)[:, None]).astype(np.float32)
    code, back = np.zeros(len(v), np.uint32), np.zeros_like(v)
    call("probe_normal", len(v), v, code, back)
    assert code.max() < N.get("RECEIVER_ALL", 0x3FFF)
    assert np.degrees(np.arccos(np.clip((v * back).sum(1), -1, 1))).max() < 1.9
