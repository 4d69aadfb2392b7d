"""The ledger adds up: the picture and what a setting took are the picture without the setting."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from isophote.bias import measured_ledger
from isophote.cli import cli
from isophote.film import LIMITS, load_film, merge
from isophote.ledger import CLAMPS, described, entry, ledger_lines, ledger_of
from isophote.scene import save_scene
from isophote.settings import Settings
from isophote.statistics import LUMINANCE, weighted_sums
from tests.parity.scenes import SCENES
from tests.rare_scenes import caustic
from tests.scenes import RECTANGLE, Builder, box, diffuse, look_at, program, quad, render

DEVICES = {"openmp": dict(device="openmp"), "opencl": dict(device="opencl", wait_for_kernels=True),
           "reference": dict(precision="reference")}
CLAMPED = dict(clamp_direct=2.0, clamp_indirect=0.3)


def luminance(film):
    return np.stack(weighted_sums(film, LUMINANCE))


def entries_of(film, **settings):
    return {entry["switch"]: entry for entry in ledger_of(film, Settings(**settings), [])}


@pytest.mark.parametrize("name,device", [("lamps", "openmp"), ("closures", "openmp"), ("closures", "opencl"),
                                         ("lamps", "reference"), ("closures", "reference")])
def test_clamped_light_and_what_was_cut_off_are_the_unclamped_light(name, device):
    """Each pixel and replicate, to rounding: the same seed gives the same paths."""
    scene, settings = SCENES[name](), DEVICES[device] | dict(seed=3, max_bounces=6)
    free = luminance(render(scene, 32, **settings))
    clamped = render(scene, 32, **settings, **CLAMPED)
    cut = np.stack([clamped.cut(False, k) + clamped.cut(True, k) for k in (0, 1)])
    assert cut.sum() > 0.005 * free.sum(), "nothing to see"
    np.testing.assert_allclose(luminance(clamped) + cut, free, rtol=1e-5 if device != "reference" else 1e-6)
    made = entries_of(clamped, **CLAMPED)
    removed = sum(made[clamp]["removed"] for clamp in CLAMPS)
    assert luminance(clamped).sum() == pytest.approx((1 - removed) * free.sum(), rel=1e-6)
    shares = [made[clamp]["luminance"] for clamp in CLAMPS]
    assert (luminance(clamped).sum() / clamped.samples / clamped.sum(0).size + sum(shares)) == pytest.approx(
        free.sum() / clamped.samples / clamped.sum(0).size, rel=1e-6)


def test_devices_agree_on_what_was_cut_and_ended():
    scene, settings = SCENES["closures"](), dict(max_bounces=4, transparent_bounces=1, **CLAMPED)
    a, b = (render(scene, 16, **settings, **DEVICES[device]) for device in ("openmp", "opencl"))
    assert all((a.sum(plane) == b.sum(plane)).all() for plane in range(a.planes))
    assert (a.ended == b.ended).all() and a.ended[[0, -1]].min() > 0


def test_intervals_of_what_clamping_takes_hold():
    """40 seeds: 95 % intervals of small renders hold the share of all, in about 38."""
    films = [render(caustic(), 32, seed=seed, region=(16, 16, 48, 48), clamp_indirect=0.5) for seed in range(40)]
    made = [entries_of(film, clamp_indirect=0.5)["clamp_indirect"] for film in films]
    truth = np.mean([entry["removed"] for entry in made])
    held = sum(entry["interval"][0] <= truth <= entry["interval"][1] for entry in made)
    assert truth > 0.01 and held >= 33


def room():
    """Grey walls with a lamp: paths of every length."""
    b = Builder((16, 16))
    b.look((0, -0.9, 0), (0, 1, -0.3), 0.8)
    vertices, triangles = box()
    b.add((vertices, triangles[:, ::-1]), diffuse(0.8))
    metal = program(("glossy", 0.8, dict(roughness=0.3, multiscatter=0)))
    b.add(quad((0.3, 0.3, -0.6), (0.2, 0, 0), (0, 0, 0.3)), metal)
    b.lamp(RECTANGLE, 20.0, look_at((0, 0, 0.95), (0, 0, 0), up=(0, 1, 0)), (0.5, 0.5))
    return b.make()


def test_bounce_limits_are_measured_by_pairs():
    """What the pairs say was removed is the difference to a picture of other seeds without limits."""
    scene, limits = room(), dict(max_bounces=3, diffuse_bounces=2)
    settings = Settings(samples=64, threads=2, **limits)
    made = {entry["switch"]: entry for entry in measured_ledger(scene, settings, 6, [])}
    assert [made[name]["status"] for name in LIMITS] == ["measured"] * 2 + ["none"] * 4
    together = made["all_bounces"]
    low, high = together["interval"]
    assert low < together["removed"] < high < 1.05 * together["removed"]
    free, short = (np.mean([luminance(render(scene, 256, seed=seed, **given)).sum() for seed in (11, 12, 13)])
                   for given in ({}, limits))
    assert 1 - short / free == pytest.approx(together["removed"], rel=0.03)
    assert made["max_bounces"]["removed"] < made["diffuse_bounces"]["removed"] < together["removed"]


def test_limits_that_no_path_met_took_nothing():
    film = render(room(), 16, max_bounces=254, diffuse_bounces=254)
    made = entries_of(film)
    assert all(made[name]["status"] == "none" and made[name]["removed"] == 0.0 for name in LIMITS)
    assert ledger_lines(list(made.values())) == ["No setting took anything from the picture"]
    met = entries_of(render(room(), 16, max_bounces=1), max_bounces=1)["max_bounces"]
    assert met["status"] == "not measured" and met["removed"] is None and 0.5 < met["paths"] <= 1.0


def test_counts_of_limits_are_kept_and_merge(tmp_path):
    settings = Settings(samples=64)
    film = render(room(), 64, max_bounces=1)
    film.save(tmp_path / "film.npz", "scene", settings.fingerprint())
    again = load_film(tmp_path / "film.npz", "scene", settings.fingerprint())
    assert (again.ended == film.ended).all() and film.ended[0] > 0
    again.first, again.end = 64, 128
    assert (merge([again, film]).ended == 2 * film.ended).all()


def test_fast_precision_is_measured_by_pairs():
    settings = Settings(samples=64, threads=2, precision="fast", max_bounces=4)
    made = next(entry for entry in measured_ledger(room(), settings, 4, []) if entry["switch"] == "precision")
    assert made["status"] in ("measured", "none") and abs(made["removed"]) < 5e-4 and made["worst_tile"] < 0.02
    film = render(room(), 4, precision="fast")
    assert entries_of(film, precision="fast")["precision"]["status"] == "not measured"


def test_notes_of_the_scene_are_entries():
    film = render(room(), 2)
    notes = [{"kind": "light", "name": "Lamp", "what": "textures are not supported"},
             {"kind": "device", "name": "GPU", "what": "is slow"}]
    left_out = [entry for entry in ledger_of(film, Settings(), notes) if entry["switch"] == "left_out"]
    assert [entry["setting"] for entry in left_out] == ["light 'Lamp': textures are not supported"]
    assert left_out[0]["removed"] is None


def test_the_command_measures_it(tmp_path):
    def run(*arguments):
        return CliRunner().invoke(cli, [str(argument) for argument in arguments])

    save_scene(room(), tmp_path / "room.npz")
    options = ("ledger", tmp_path / "room.npz", "--samples", 8, "--pairs", 3, "--diffuse-bounces", 1, "--threads", 1)
    result = json.loads(run(*options, "--json").stdout)
    assert (result["width"], result["samples"], result["pairs"]) == (16, 8, 3)
    found = next(one for one in result["ledger"] if one["switch"] == "diffuse_bounces")
    assert found["setting"] == 1 and found["status"] == "measured" and 0.2 < found["removed"] < 0.9
    told = run(*options).stdout
    assert "measured   3 pairs of 16 x 16 pixels" in told and "The limit of 1 diffuse bounces ended" in told
    assert run("ledger", tmp_path / "room.npz", "--pairs", 2).exit_code == 2


def test_sentences():
    def said(switch, setting, status, **more):
        return described(entry(switch, setting, status, **more))

    assert said("diffuse_bounces", 4, "measured", removed=0.032, interval=[0.031, 0.033], paths=0.09) == (
        "The limit of 4 diffuse bounces ended 9 % of the paths and took 3.2 % of the light (95 %: 3.1 % to 3.3 %)")
    assert said("clamp_direct", 10.0, "rendered", removed=0.01) == "Clamping direct light at 10 took 1 % of the light"
    assert said("precision", "fast", "not measured", how="do X") == (
        "Fast precision: the light that is missing was not measured (do X)")
    assert said("invalid_samples", "count as 0", "not measured", samples=3, pixels=2, how="look") == (
        "Invalid samples (3 in 2 pixels, they count as 0); the light that is missing was not measured (look)")
    assert said("left_out", "light 'Lamp': a texture", "not measured") == "Left out: light 'Lamp': a texture"
