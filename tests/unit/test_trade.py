"""The trade report: grid, plan, runs that are interrupted and continued, the page, the command's errors."""

import csv
import io
import json
import re
from dataclasses import asdict, dataclass, replace

import numpy as np
import pytest
from click.testing import CliRunner
from noise_device import NoiseDevice, tiny_scene

from isophote.cli import cli
from isophote.images import read_image
from isophote.scene import save_scene
from isophote.settings import Settings
from isophote.trade import grid, plan, words
from isophote.trade.grid import BASE, TRUTH, make_grid, plain_settings, truth_of
from isophote.trade.intervals import Interval
from isophote.trade.job import Job
from isophote.trade.pictures import difference, exposure_of, write_picture
from isophote.trade.plan import Cost, choose_samples, drop_slow, reduced, snapshots
from isophote.trade.report import make_report
from isophote.trade.runs import Cancelled, TradeError

TIMES = re.compile("seconds|time|effort|pareto")


class Device(NoiseDevice):
    """Noise whose mean follows the settings: a clamp and few bounces take light away."""

    stop_after = None  # runs' first samples seen, over all devices
    begun = 0

    def leave(self):
        self.close()

    def render(self, item, settings, sums, cancelled):
        if item.first_sample == 0:
            type(self).begun += 1
        before = sums.copy()
        added = super().render(item, settings, sums, cancelled)
        light = (0.95 if settings.clamp_indirect == 1.0 else 1.0) * (0.8 if settings.max_bounces == 1 else 1.0)
        sums[:] = before + (sums - before) * np.float32(light)
        return added


@pytest.fixture
def numpy_engine(engine, monkeypatch):
    engine.OpenMPDevice = Device
    Device.begun = 0
    return engine


def job(folder, **changes):
    scene = tiny_scene()
    made = Job(scene, "tiny", (24, 20), Settings(), folder, seconds=600.0, most_rounds=3)
    return replace(made, **changes)


@pytest.fixture
def short(monkeypatch):
    """Few samples, and a plan that does not hang on how quick the machine is at the moment."""
    monkeypatch.setattr(plan, "MOST_SAMPLES", 16)
    monkeypatch.setattr("isophote.trade.pilots.FLOAT64_WORTH", 1e9)
    monkeypatch.setattr("isophote.trade.report.REFERENCE_SHARE", 0.0)  # two pieces, as at least


# ------------------------------------------------------------------ grid and plan


def test_choices_differ_from_the_users_settings_in_one_thing():
    base = plain_settings(Settings(error_target=0.1, samples=99, time_limit=3.0))
    assert base.samples == 1 and not base.error_target and not base.time_limit
    choices = make_grid(base, ["opencl:1"])
    assert choices[0].key == BASE and choices[0].settings == base
    assert len({choice.settings for choice in choices}) == len({choice.key for choice in choices}) == len(choices)
    for choice in choices[1:]:
        changed = {name for name, value in asdict(choice.settings).items() if value != asdict(base)[name]}
        assert len(changed) == 1 or choice.key in ("quick", "bounces=32"), choice
    assert {choice.axis for choice in choices} == {"Your settings", "Bounces", "Clamping", "Filter", "Precision",
                                                   "Device", "All savings"}
    assert all(choice.settings.max_bounces < 2 for choice in make_grid(replace(base, max_bounces=1))
               if choice.axis == "Bounces" and choice.key != "bounces=32")
    clamped = make_grid(replace(base, clamp_indirect=10.0))
    assert "clamp=off" in {choice.key for choice in clamped} and "clamp_indirect=10" not in {c.key for c in clamped}
    truth = truth_of(replace(base, clamp_direct=1.0), "strict")
    assert truth.clamp_direct == 0.0 and truth.glossy_bounces == grid.NO_LIMIT


@dataclass(frozen=True)
class Later(Settings):
    """Settings with more axes than there are now."""

    adaptive: bool = True
    texture_scale: float = 0.5


def test_axes_appear_with_their_settings(monkeypatch):
    monkeypatch.setattr(grid, "FIELDS", {*grid.FIELDS, "adaptive", "texture_scale"})
    found = {choice.key: choice.settings for choice in make_grid(Later())}
    assert found["texture_scale=0.25"].texture_scale == 0.25 and "texture_scale=0.5" not in found
    assert truth_of(Later(), "strict").adaptive is False


def test_the_budget_is_divided():
    costs = [Cost(0.01, 0.02)] * 10
    samples = choose_samples(costs, 60.0)
    used = plan.WANTED_ROUNDS * sum(cost.run(samples) for cost in costs)
    assert used <= 60.0 * (1.0 - plan.REFERENCE_SHARE) < 2.1 * used and samples & (samples - 1) == 0
    with pytest.raises(TradeError, match="the time is too short: [0-9]+ s more"):
        choose_samples(costs, 1.0)
    assert snapshots(64) == [1, 4, 16, 64] and snapshots(4) == [1, 4] and snapshots(512) == [8, 32, 128, 512]


def test_what_is_too_slow_is_named():
    choices = make_grid(Settings())[:3]
    kept, notes = drop_slow(choices, [Cost(1.0, 0.0), Cost(20.0, 0.0), Cost(2.0, 0.0)])
    assert [choice.key for choice in kept] == [BASE, choices[2].key]
    assert notes == [{"name": choices[1].label, "what": "20 times as slow as your settings: left out"}]


def test_reduced_sizes():
    assert reduced((1920, 1080)) == (256, 144) and reduced((100, 50)) == (100, 50) and reduced((1, 4000)) == (1, 256)


# ------------------------------------------------------------------ reports


def test_a_report_says_what_is_so(numpy_engine, tmp_path, short):
    result = make_report(job(tmp_path / "r"))
    rows = {(row["choice"], row["samples"]): row for row in result["rows"]}
    clamped, bounced = rows["clamp_indirect=1", 16.0], rows["max_bounces=1", 16.0]
    for row, change in ((clamped, -0.05), (bounced, -0.2)):
        assert row["light"] == pytest.approx(change, rel=0.03) and row["light_found"]
        assert row["noise_ratio"] == pytest.approx(1.0 + change, abs=1e-3)
    assert rows["clamp_indirect=10", 16.0]["same_bits"] and not rows[BASE, 16.0]["bias_found"]
    left_out = {note["name"]: note["what"] for note in result["notes"]}
    assert "changed not one of 480 paths" in left_out["4 bounces"]
    assert rows[BASE, 4.0]["noise"] == pytest.approx(2 * rows[BASE, 16.0]["noise"], rel=0.3)
    assert not result["partial"] and result["rounds"] == 3


def test_adaptive_sampling_is_tried_where_it_is_a_setting(numpy_engine, tmp_path, monkeypatch, short):
    monkeypatch.setattr("isophote.trade.pilots.FIELDS", {*grid.FIELDS, "adaptive"})
    monkeypatch.setattr(grid, "FIELDS", {*grid.FIELDS, "adaptive"})
    few = make_report(job(tmp_path / "few", base=Later(), most_rounds=2))
    assert {"name": "Adaptive sampling", "what": "begins at 128 samples, and the time allows runs of 16: left out"} in (
        few["notes"])
    monkeypatch.setattr("isophote.trade.pilots.FEWEST_ADAPTIVE", 16)
    result = make_report(job(tmp_path / "enough", base=Later(), most_rounds=2))
    row = next(row for row in result["rows"] if row["choice"] == "adaptive")
    settings = next(choice["settings"] for choice in result["choices"] if choice["choice"] == "adaptive")
    assert settings["adaptive"] and 0.0 < settings["error_target"] < 1.0 and 16 <= row["samples"] <= 16 * 16


def test_the_page_holds_everything_and_loads_nothing(numpy_engine, tmp_path, short):
    result = make_report(job(tmp_path / "r"))
    page = (tmp_path / "r" / "index.html").read_text()
    assert "<script" not in page and not re.search(r"(src|href)=[\"']https?:", page)
    assert page.count("<tr><th>") >= len(result["rows"])
    for choice in result["choices"]:
        assert choice["label"] in page
    for path in re.findall(r'(?:src|href)="([^"]+)"', page):
        assert (tmp_path / "r" / path).is_file(), path
    table = list(csv.DictReader(io.StringIO((tmp_path / "r" / "rows.csv").read_text())))
    assert [(row["choice"], float(row["samples"])) for row in table] == [
        (row["choice"], row["samples"]) for row in result["rows"]]
    assert json.loads((tmp_path / "r" / "rows.json").read_text())["rows"] == result["rows"]
    picture = read_image(tmp_path / "r" / "pictures" / "base.picture.png").planes["Combined"]
    assert picture.shape == (10, 12, 4)


def test_interrupted_and_continued_gives_the_same_rows(numpy_engine, tmp_path, short):
    def with_runs(count):
        return lambda: len(list((tmp_path / "parts" / "runs").glob("*.npz"))) >= count

    whole = make_report(job(tmp_path / "whole"))
    with pytest.raises(TradeError, match="pilots"):
        make_report(job(tmp_path / "parts"), cancelled=with_runs(0))
    with pytest.raises(TradeError, match="too little was rendered .* the same command goes on"):
        make_report(job(tmp_path / "parts"), cancelled=with_runs(8))
    partial = make_report(job(tmp_path / "parts"), cancelled=with_runs(30))
    assert partial["partial"] and "stopped before its end" in (tmp_path / "parts" / "index.html").read_text()
    continued = make_report(job(tmp_path / "parts"))
    begun = Device.begun
    again = make_report(job(tmp_path / "parts"))
    assert Device.begun == begun, "nothing was left to render"
    for result in (continued, again):
        assert not result["partial"] and len(result["rows"]) == len(whole["rows"])
        for a, b in zip(result["rows"], whole["rows"], strict=True):
            assert {name: a[name] for name in a if not TIMES.search(name)} == {
                name: b[name] for name in b if not TIMES.search(name)}
    runs = [np.load(tmp_path / folder / "runs" / "quick.2.npz")["pictures"] for folder in ("whole", "parts")]
    assert np.array_equal(*runs)


def test_a_changed_scene_or_setting_is_named(numpy_engine, tmp_path, short):
    make_report(job(tmp_path))
    with pytest.raises(TradeError, match="glossy_bounces was 4, now 3 .*--anew"):
        make_report(job(tmp_path, base=Settings(glossy_bounces=3)))
    with pytest.raises(TradeError, match="the size was 12x10, now 10x10"):
        make_report(job(tmp_path, scene=tiny_scene(10, 10)))
    with pytest.raises(TradeError, match="the scene was another"):
        make_report(job(tmp_path, scene=tiny_scene(light_strength=[[1, 1, 1]])))
    assert make_report(job(tmp_path, base=Settings(glossy_bounces=3), anew=True))["rounds"] == 3


def test_a_damaged_run_is_rendered_again(numpy_engine, tmp_path, short):
    make_report(job(tmp_path))
    damaged = tmp_path / "runs" / "base.2.npz"
    damaged.write_bytes(damaged.read_bytes()[:1000])
    assert make_report(job(tmp_path))["rounds"] == 3 and np.load(damaged)["pictures"].shape[0] == 3
    (tmp_path / "runs" / "plan.json").write_text("{}")
    with pytest.raises(TradeError, match="plan.json: no plan of a trade report"):
        make_report(job(tmp_path))


def test_the_time_is_kept(numpy_engine, tmp_path, monkeypatch):
    monkeypatch.setattr("isophote.trade.pilots.PILOTS", 1)
    result = make_report(job(tmp_path, seconds=4.0, most_rounds=1000))
    assert result["spent"] <= 4.0 and result["rounds"] >= 3


def test_cancelling_reaches_into_a_run(numpy_engine):
    from isophote.trade.runs import Renderer

    with pytest.raises(Cancelled):
        Renderer(tiny_scene(), lambda: True).render(Settings(), 1, [4])


def test_pictures(tmp_path):
    pixels = np.random.default_rng(1).integers(0, 256, (5, 7, 3), np.uint8)
    write_picture(tmp_path / "a.png", pixels)
    from isophote.images import to_srgb8

    assert np.array_equal(to_srgb8(read_image(tmp_path / "a.png").planes["Combined"])[..., :3], pixels)
    write_picture(tmp_path / "a.jpg", pixels)
    assert (tmp_path / "a.jpg").read_bytes()[:2] == b"\xff\xd8"
    exposures = [exposure_of(np.full((2, 2, 3), x)) for x in (0.0, 0.2, 1.0, 10.0)]
    assert exposures == [1.0, 1.0, 1.0, pytest.approx(0.05)]
    grey = difference(np.zeros((2, 2, 3)), np.ones((2, 2, 3)), 0.1)
    darker, brighter = (difference(np.full((2, 2, 3), x), np.ones((2, 2, 3)), 0.1) for x in (-0.2, 0.2))
    assert np.ptp(grey[0, 0]) < 5 and darker[0, 0, 2] > darker[0, 0, 0] and brighter[0, 0, 0] > brighter[0, 0, 2]


def test_words():
    assert [words.percent(x) for x in (0.123, 0.0311, 0.05, 0.00042, 0.0, 1e-9)] == [
        "12 %", "3.1 %", "5 %", "0.042 %", "0 %", "less than 0.00001 %"]
    assert words.time_words(Interval(0.63, 0.6, 0.66), True) == "saves 37 % of the time"
    assert words.time_words(Interval(0.99, 0.9, 1.1), False) == "takes as long"
    assert words.time_words(Interval(0.8, 0.5, 1.28), False) == "takes about as long (between 50 % less and 28 % more)"
    assert words.time_words(Interval(0.8, 0.7, 0.95), False) == "probably saves time (between 30 % less and 5 % less)"
    assert words.light_words(Interval(-0.031, -0.033, -0.029), True) == "removes 3.1 % of the light"
    assert words.light_words(Interval(-0.001, -0.003, 0.001), False) == (
        "keeps the light as far as one can tell (a change is smaller than 0.3 %)")
    assert words.noise_words(0.6, True) == "makes the picture 40 % less noisy"


# ------------------------------------------------------------------ the command


def run(*arguments):
    return CliRunner().invoke(cli, ["trade", *map(str, arguments)])


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "tiny.npz"
    made = tiny_scene()
    made.settings = {"max_bounces": 3}
    save_scene(made, path)
    return path


def test_the_command_makes_a_report(numpy_engine, scene, tmp_path, monkeypatch):
    monkeypatch.setattr("isophote.trade.pilots.PILOTS", 1)
    outcome = run(scene, "-o", tmp_path / "report", "--time", "4s", "--size", "8x6", "--pictures", "jpg", "--json")
    assert outcome.exit_code == 0, outcome.output
    result = json.loads(outcome.stdout)
    assert result["name"] == "tiny" and result["size"] == [8, 6] and result["full_size"] == [12, 10]
    assert (tmp_path / "report" / "pictures" / "base.picture.jpg").is_file()
    assert {c["settings"]["max_bounces"] for c in result["choices"] if c["choice"] == BASE} == {3}
    assert any(choice["choice"] == TRUTH for choice in result["choices"])
    outcome = run(scene, "-o", tmp_path / "report", "--time", "4s", "--size", "6x6")
    assert outcome.exit_code == 1 and "the size was 8x6, now 6x6" in outcome.stderr


@pytest.mark.parametrize(("arguments", "status", "said"), [
    (["--time", "soon"], 2, "'soon' is no time; write it as 90s, 10m or 1h"),
    (["--time", "0"], 2, "'0' is no time above 0"),
    (["--time", "0.01"], 1, "the time is too short"),
    (["--device", "abacus"], 1, "no device 'abacus'"),
    (["--size", "3by4"], 2, "'3by4' is no size"),
])
def test_errors_name_the_thing(numpy_engine, scene, tmp_path, arguments, status, said):
    outcome = run(scene, "-o", tmp_path / "report", *arguments)
    assert outcome.exit_code == status and said in outcome.stderr, outcome.output


def test_places_that_cannot_be_are_named(numpy_engine, scene, tmp_path):
    outcome = run(scene, "-o", scene)
    assert outcome.exit_code == 2 and "tiny.npz: is no folder" in outcome.stderr
    outcome = run(tmp_path / "none.npz", "-o", tmp_path / "report")
    assert outcome.exit_code == 1 and "none.npz: no such file" in outcome.stderr
    outcome = run(scene, "-o", scene / "below")
    assert outcome.exit_code == 1 and "cannot be used as the report's folder" in outcome.stderr
