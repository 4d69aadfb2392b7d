"""Cryptomatte: how much of a pixel is covered by what, by known answers, in any order and on any device."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from isophote.cli import cli
from isophote.cryptomatte import ids_of, murmur3
from isophote.film import BLOCK, Film, load_film, merge
from isophote.images import read_image
from isophote.mattes import UNITS, Coverage
from isophote.passes import film_planes, make_passes
from isophote.planes import RECORDS, SPARE_ROWS
from isophote.scene import Scene, save_scene
from isophote.schedule import WorkItem
from isophote.session import Session
from isophote.settings import Settings
from tests.scenes import Builder, diffuse, program, quad, render

KINDS = ("crypto_object", "crypto_material", "crypto_asset")
HALF = program(("transparent", 0.5), ("diffuse", 0.25))


def named(scene: Scene, objects, assets, materials) -> Scene:
    """The scene with names, of spheres behind those of instances."""
    count = len(scene.instance_mesh)
    ids = np.stack([ids_of(objects), ids_of(assets)], axis=1)
    scene.arrays |= {"instance_matte": ids[:count], "sphere_matte": ids[count:], "material_matte": ids_of(materials)}
    scene.names |= {"instances": list(objects[:count]), "spheres": list(objects[count:]), "assets": sorted(set(assets)),
                    "materials": list(materials)}
    return scene


def coverages(film: Film, name: str) -> dict[int, np.ndarray]:
    """id's bits -> (h, w), from the pass's channels."""
    made = make_passes(film, [name])
    pairs = np.concatenate([values.reshape(*film.shape, 2, 2) for values in made.values()], axis=2)
    assert (np.diff(pairs[..., 1], axis=2) <= 0).all(), "those that cover most come first"
    bits = np.ascontiguousarray(pairs[..., 0]).view(np.uint32)
    return {int(each): np.where(bits == each, pairs[..., 1], 0).sum(-1) for each in np.unique(bits[bits != 0])}


def assert_same_mattes(film: Film, other: Film) -> None:
    mine, others = film.all_mattes().of, other.all_mattes().of
    assert mine and set(mine) == set(others)
    for kind in mine:
        assert np.array_equal(mine[kind].keys, others[kind].keys)
        assert np.array_equal(mine[kind].units, others[kind].units)


def panes(count: int, size=(6, 5)) -> Builder:
    """Panes of glass without refraction, one behind the other, before half a wall and half nothing."""
    b = Builder(size)
    b.look((0, 0, 0), (0, 0, -1), 1.0, orthographic=True, up=(0, 1, 0))
    for number in range(count):
        b.add(quad((0, 0, -1 - 0.01 * number), (9, 0, 0), (0, 9, 0)), HALF)
    b.add(quad((-5, 0, -5), (5, 0, 0), (0, 9, 0)), diffuse(0.5))
    return b


def test_what_is_seen_through_a_pane_has_the_rest():
    scene = named(panes(1).make(), ["Pane", "Wall"], ["House", "House"], ["Glass", "Stone"])
    film = render(scene, 1024, passes=KINDS, filter_width=0.0)
    seen = coverages(film, "crypto_object")
    pane, wall = (seen[int(each)] for each in ids_of(["Pane", "Wall"]))
    assert (pane == 0.5).all() and set(seen) == set(ids_of(["Pane", "Wall"]).tolist())
    np.testing.assert_allclose(wall[:, :3], 0.5, atol=0.06)
    assert not wall[:, 3:].any() and wall[:, :3].mean() == pytest.approx(0.5, abs=0.015)
    of_materials = coverages(film, "crypto_material")
    for mine, other in zip((pane, wall), ids_of(["Glass", "Stone"]), strict=True):
        assert (of_materials[int(other)] == mine).all()
    (house,) = coverages(film, "crypto_asset").values()
    np.testing.assert_allclose(house, pane + wall, rtol=1e-6)


def balls_on_a_floor() -> Scene:
    """Two spheres of one name."""
    b = Builder((16, 12))
    b.look((0, 0, 6), (0, 0, 0), 0.5, up=(0, 1, 0))
    b.add(quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), diffuse(0.5))
    for x in (-1, 1):
        b.sphere((x, 0, 1), 0.9, b.material(diffuse(0.5)))
    b.world = (1, 1, 1)
    return named(b.make(), ["Floor", "Ball", "Ball"], ["Floor", "Ball", "Ball"], ["Stone", "Left", "Right"])


def test_edges_are_covered_in_part():
    """What covers a pixel adds up to 1, and things of one name are one."""
    film = render(balls_on_a_floor(), 96, passes=KINDS)
    objects = coverages(film, "crypto_object")
    assert len(objects) == 2 and (sum(objects.values()) == 1).all()
    materials = coverages(film, "crypto_material")
    ball = objects[int(ids_of(["Ball"])[0])]
    assert ((0 < ball) & (ball < 1)).sum() > 20
    np.testing.assert_allclose(sum(materials[int(each)] for each in ids_of(["Left", "Right"])), ball, rtol=1e-6)


def test_what_is_held_out_covers_nothing():
    b = panes(0)
    b.add(quad((0, 5, -1), (9, 0, 0), (0, 5, 0)), program(("holdout", 1.0)))
    film = render(named(b.make(), ["Wall", "Hole"], ["A", "A"], ["Stone", "Hole"]), 64, passes=KINDS, filter_width=0.0)
    assert set(coverages(film, "crypto_object")) == {int(ids_of(["Wall"])[0])}


def test_pixels_with_different_numbers_of_samples():
    settings = Settings(samples=1024, error_target=0.02, passes=("combined", *KINDS))
    with Session(balls_on_a_floor(), settings) as session:
        session.run()
    film = session.film
    assert film.ends is not None and len(np.unique(film.counts)) > 1
    for coverage in film.all_mattes().of.values():
        sums = np.zeros(film.pixels, np.int64)
        np.add.at(sums, (coverage.keys >> np.uint64(32)).astype(np.int64), coverage.units)
        assert (sums == UNITS * film.counts.ravel()).all()
    assert (np.abs(sum(coverages(film, "crypto_object").values()) - 1) < 1e-6).all()


def test_files_without_blender_are_those_that_compositors_want(tmp_path):
    scene = named(panes(1).make(), ["Pane", "Wall"], ["House", "House"], ["Glass", 'A "stone"'])
    scene.settings = {"samples": 8, "matte_levels": 3}
    save_scene(scene, tmp_path / "scene.npz")
    files = str(tmp_path / "scene.npz"), "-o", str(tmp_path / "a.exr")
    done = CliRunner().invoke(cli, ["render", *files, "--passes", "combined,crypto_object,crypto_material"])
    assert done.exit_code == 0, done.output
    image = read_image(tmp_path / "a.exr")
    numbers = ("Object00", "Object01", "Material00", "Material01")
    assert set(image.planes) == {"Combined", *(f"Crypto{number}" for number in numbers)}
    assert (image.planes["CryptoObject00"].view(np.uint32)[0, 0, [0, 2]] == ids_of(["Pane", "Wall"])).all()
    assert (image.planes["CryptoObject00"][0, 0, 1] == 0.5) and not image.planes["CryptoObject01"].any()
    for kind, names in (("Object", ["Pane", "Wall"]), ("Material", ["Glass", 'A "stone"'])):
        name = f"ViewLayer.Crypto{kind}"
        prefix = f"cryptomatte/{murmur3(name):08x}"[:-1] + "/"
        told = {key.removeprefix(prefix): text for key, text in image.metadata.items() if key.startswith(prefix)}
        manifest = json.loads(told.pop("manifest"))
        assert manifest == {each: f"{bits:08x}" for each, bits in zip(names, ids_of(names), strict=True)}
        assert told == {"name": name, "hash": "MurmurHash3_32", "conversion": "uint32_to_float32"}


@pytest.mark.parametrize("text,number", [("Cube", 0xA8FCE865), ("Inst", 0xD5E5909A), ("Top", 0x674F48D9),
                                         ('Böden "x"', 0x26B6AE59), ("default_volume", 0xB331280E)])
def test_hashes_are_those_of_cycles(text, number):
    assert murmur3(text) == number


def test_ids_are_numbers():
    ids = ids_of(f"Thing {number}" for number in range(3000))
    assert np.isfinite(ids.view(np.float32)).all() and (np.abs(ids.view(np.float32)) >= np.finfo(np.float32).tiny).all()


def strips(count: int) -> Scene:
    """A picture of two pixels that show so many objects, before another one."""
    b = Builder((2, 1))
    b.look((0, 0, 0), (0, 0, -1), 1.0, orthographic=True, up=(0, 1, 0))
    for number in range(count):
        b.add(quad((-1 + (2 * number + 1) / count, 0, -1), (1 / count, 0, 0), (0, 9, 0)), diffuse(0.5))
    b.add(quad((0, 0, -2), (9, 0, 0), (0, 9, 0)), diffuse(0.5))
    names = [f"Strip {number}" for number in range(count)] + ["Rest"]
    return named(b.make(), names, names, names)


@pytest.mark.parametrize("levels", [2, 6])
def test_more_ids_than_there_is_room_for_are_counted(levels):
    rows = levels + SPARE_ROWS
    film = render(strips(rows - 1), 256, passes=("crypto_object",), matte_levels=levels)
    assert film.all_mattes().lost == 0
    film = render(strips(4 * rows), 256, passes=("crypto_object",), matte_levels=levels)
    mattes = film.all_mattes()
    kept = mattes.of["object"].units.sum() - mattes.lost
    assert 0 < mattes.lost < film.pixels * 256 * UNITS and kept + mattes.lost == film.pixels * 256 * UNITS
    session = Session(strips(4 * rows), Settings(samples=64, passes=("crypto_object",), matte_levels=levels))
    with session:
        session.run()
        (note,) = [note for note in session.notes if note["name"] == "Cryptomatte"]
    assert f"more than {rows} met in 64 samples" in note["what"] and "% of the picture are missing" in note["what"]


def test_a_ray_shows_so_many_panes_and_the_rest_counts():
    count = RECORDS + 3
    names = [f"Pane {number}" for number in range(count)] + ["Wall"]
    veil = panes(count)
    veil.materials[:-1] = [program(("transparent", 0.9), ("diffuse", 0.05))] * count
    film = render(named(veil.make(), names, names, names), 256, passes=("crypto_object",), filter_width=0.0)
    mattes = film.all_mattes()
    behind = 0.9 ** RECORDS * (1 + 1 - 0.9 ** 3) / 2  # half of the picture is wall behind three more, half is none
    assert mattes.lost / (film.pixels * 256 * UNITS) == pytest.approx(behind, abs=0.02)


def test_films_merge_in_any_order_and_resume(tmp_path):
    settings = dict(passes=("combined", *KINDS), samples=3 * BLOCK + 7)
    scene = named(panes(3).make(), ["A", "B", "C", "Wall"], ["X", "X", "Y", "Y"], ["A", "B", "C", "D"])
    whole = render(scene, **settings)
    chosen = Settings(**settings, max_bounces=64, diffuse_bounces=64, glossy_bounces=64, transmission_bounces=64,
                      transparent_bounces=64)
    with Session(scene, chosen) as session:
        parts = []
        for first, end in ((2 * BLOCK, 3 * BLOCK + 7), (0, BLOCK), (BLOCK, 2 * BLOCK)):
            film = Film(whole.region, film_planes(chosen), first)
            while film.end < end:
                count = min(5, end - film.end, BLOCK - film.end % BLOCK)
                session.device.render(WorkItem(film.region, film.end, count), chosen, film.open, lambda: False)
                film.add_samples(count)
            film.save(tmp_path / "film.npz", "scene", {})
            parts.append(load_film(tmp_path / "film.npz", "scene", {}))
    for order in ((0, 1, 2), (2, 0, 1)):
        assert_same_mattes(whole, merge([parts[k] for k in order]))


def test_lists_of_keys_add_in_any_order():
    rng = np.random.default_rng(3)
    keys, units = rng.integers(0, 40, 300).astype(np.uint64) << np.uint64(32) | np.uint64(9), rng.integers(1, 99, 300)
    whole, parts = Coverage(), Coverage()
    whole.add(keys, units)
    for part in (slice(200, 300), slice(0, 120), slice(120, 200)):
        parts.add(keys[part], units[part])
    assert (whole.keys == parts.keys).all() and (whole.units == parts.units).all()
    assert (np.diff(whole.keys.astype(np.int64)) > 0).all() and whole.units.sum() == units.sum()
