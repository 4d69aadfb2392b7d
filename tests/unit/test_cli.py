import json
import signal

import numpy as np
import pytest
from click.testing import CliRunner
from noise_device import NoiseDevice, tiny_scene

from isophote.cli import cli
from isophote.images import read_image
from isophote.kernel_cache import KernelCache
from isophote.scene import save_scene

pytest.importorskip("OpenImageIO")
pytestmark = pytest.mark.usefixtures("engine")


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "scene.npz"
    save_scene(tiny_scene(), path)
    return path


def run(*arguments):
    return CliRunner().invoke(cli, [str(argument) for argument in arguments])


def test_render_writes_an_exr_with_every_pass_and_prints_one_object(scene, tmp_path):
    outcome = run("render", scene, "-o", tmp_path / "a.exr", "--samples", 20, "--json")
    assert outcome.exit_code == 0, outcome.output
    result = json.loads(outcome.stdout)
    assert result["samples"] == 20 and result["partial"] is False and result["error"] > 0
    image = read_image(tmp_path / "a.exr")
    assert set(image.planes) == {"Combined", "Depth", "Normal", "Albedo", "Position", "Sample Count",
                                 "Invalid", "Error"}
    assert image.planes["Combined"].shape == (10, 12, 4) and not image.partial
    assert image.metadata["isophote:error"] == pytest.approx(result["error"], rel=1e-6)
    assert image.metadata["isophote:scene"] == tiny_scene().content_hash


def test_render_writes_a_png(scene, tmp_path):
    outcome = run("render", scene, "-o", tmp_path / "a.png", "--samples", 2, "--size", "24x20")
    assert outcome.exit_code == 0, outcome.output
    assert "error" in outcome.stdout and "2/2 samples" in outcome.stderr
    assert read_image(tmp_path / "a.png").planes["Combined"].shape == (20, 24, 4)


def test_the_files_settings_stand_where_no_option_is_given(tmp_path):
    scene = tiny_scene()
    scene.settings = {"samples": 6, "seed": 5, "time_limit": 100.0}
    save_scene(scene, tmp_path / "scene.npz")

    def result(*options):
        return json.loads(run("render", tmp_path / "scene.npz", "-o", tmp_path / "a.png", "--json", *options).stdout)

    assert [result()[name] for name in ("samples", "seed")] == [6, 5]
    assert [result("--samples", 3, "--seed", 0)[name] for name in ("samples", "seed")] == [3, 0]
    scene.settings = {"samples": 0}
    save_scene(scene, tmp_path / "scene.npz")
    outcome = run("render", tmp_path / "scene.npz", "-o", tmp_path / "a.png")
    assert outcome.exit_code == 1 and "scene.npz: its settings cannot be used: samples is 0" in outcome.stderr


def test_one_sample_has_a_null_error(scene, tmp_path):
    outcome = run("render", scene, "-o", tmp_path / "a.exr", "--samples", 1, "--json")
    assert json.loads(outcome.stdout)["error"] is None
    assert np.isnan(read_image(tmp_path / "a.exr").planes["Error"]).all()


def test_time_alone_has_no_limit_of_samples(scene, tmp_path):
    outcome = run("render", scene, "-o", tmp_path / "a.exr", "--time", 0.5, "--json")
    result = json.loads(outcome.stdout)
    assert result["why_stopped"] == "time" and result["samples"] > 128 and result["partial"] is False


def test_a_wanted_error_stops_the_render_and_is_said(scene, tmp_path):
    outcome = run("render", scene, "-o", tmp_path / "a.exr", "--error", "20%")
    assert outcome.exit_code == 0, outcome.output
    assert "(wanted: 20 %)" in outcome.stdout and "stopped    the wanted error is reached" in outcome.stdout
    assert "% (wanted 20 %)" in outcome.stderr
    metadata = read_image(tmp_path / "a.exr").metadata
    assert metadata["isophote:why_stopped"] == "error" and metadata["isophote:error_target"] == pytest.approx(0.2)
    assert 0.0 < metadata["isophote:error_95"] <= 0.2
    result = json.loads(run("render", scene, "-o", tmp_path / "b.exr", "--error", "20", "--json").stdout)
    assert result["why_stopped"] == "error" and 16 <= result["samples"] < 200 and result["error_target"] == 0.2
    outcome = run("render", scene, "-o", tmp_path / "c.exr", "--error", "0.1%", "--samples", 9, "--json")
    limited = json.loads(outcome.stdout)
    assert limited["why_stopped"] == "samples" and limited["samples"] == 9


@pytest.mark.parametrize("text", ["0", "-1%", "x", "nan"])
def test_errors_that_are_none_are_refused(scene, tmp_path, text):
    outcome = run("render", scene, "-o", tmp_path / "a.exr", "--error", text)
    assert outcome.exit_code == 2 and "write it as 1%" in outcome.stderr


def interrupting(engine, at, count=1):
    def interrupt(sample):
        if sample == at:
            for _ in range(count):
                signal.raise_signal(signal.SIGINT)

    engine.OpenMPDevice = lambda settings: NoiseDevice(on_sample=interrupt)


def test_ctrl_c_writes_what_is_rendered_marked_as_partial(scene, tmp_path, engine):
    interrupting(engine, at=37)
    outcome = run("render", scene, "-o", tmp_path / "a.exr", "--samples", 100, "--json")
    assert outcome.exit_code == 130
    result = json.loads(outcome.stdout)
    assert result["partial"] is True and result["samples"] == 37
    image = read_image(tmp_path / "a.exr")
    assert image.partial and (image.planes["Sample Count"] == 37).all()
    assert "marked as partial" in outcome.stderr


@pytest.mark.parametrize(("at", "count"), [(0, 1), (20, 2)])
def test_ctrl_c_before_the_first_sample_or_twice_writes_nothing(scene, tmp_path, engine, at, count):
    interrupting(engine, at, count)
    outcome = run("render", scene, "-o", tmp_path / "a.exr", "--samples", 100, "--json")
    assert outcome.exit_code == 130 and not (tmp_path / "a.exr").exists()
    assert "interrupted before anything was written" in json.loads(outcome.stdout)["failed"]


def test_a_cpu_that_fails_leaves_a_partial_picture_and_status_1(scene, tmp_path, engine):
    engine.OpenMPDevice = lambda settings: NoiseDevice(fail_after=37)
    outcome = run("render", scene, "-o", tmp_path / "a.exr", "--samples", 100, "--json")
    assert outcome.exit_code == 1
    assert "the driver reset" in json.loads(outcome.stdout)["failed"] and "marked as partial" in outcome.stderr
    assert read_image(tmp_path / "a.exr").partial


def test_out_of_memory_is_said(scene, tmp_path, monkeypatch):
    def no_memory(*_):
        raise MemoryError("Unable to allocate 3.00 TiB")

    monkeypatch.setattr("isophote.session.Film", no_memory)
    outcome = run("render", scene, "-o", tmp_path / "a.exr")
    assert outcome.exit_code == 1 and "out of memory: Unable to allocate 3.00 TiB" in outcome.stderr


def test_a_picture_that_cannot_be_written_after_all_is_kept_elsewhere(scene, tmp_path, monkeypatch, engine):
    folder = tmp_path / "gone"
    folder.mkdir()
    engine.OpenMPDevice = lambda settings: NoiseDevice(on_sample=lambda sample: sample == 3 and folder.rmdir())
    outcome = run("render", scene, "-o", folder / "a.exr", "--samples", 4)
    assert outcome.exit_code == 1
    kept = outcome.stderr.replace("\n", "").split("was written to ")[1].split(" instead")[0]
    assert read_image(kept).planes["Combined"].shape == (10, 12, 4)


def rendered_nothing(settings):
    raise AssertionError("the device was opened")


@pytest.mark.parametrize(("output", "message"), [("none/a.exr", "there is no folder"), ("a.jpg", "pictures end in")])
def test_unwritable_outputs_are_found_before_rendering(scene, tmp_path, engine, output, message):
    engine.OpenMPDevice = rendered_nothing
    outcome = run("render", scene, "-o", tmp_path / output)
    assert outcome.exit_code == 1 and message in outcome.stderr


@pytest.mark.parametrize("arguments", [("--samples", "0"), ("--time", "-1"), ("--size", "12"), ("--precision", "best"),
                                       ("--passes", "haze"), ("--frame", "3"), ("--seed", "-1")])
def test_wrong_usage_has_status_2(scene, tmp_path, arguments):
    assert run("render", scene, "-o", tmp_path / "a.exr", *arguments).exit_code == 2
    assert not (tmp_path / "a.exr").exists()


@pytest.mark.parametrize(("name", "content", "message"), [
    ("none.npz", None, "none.npz: no such file"),
    ("bad.npz", b"not a zip", "bad.npz: not a readable scene file"),
    ("bad.blend", b"not a blend", "bad.blend: not a .blend file"),
    ("none.blend", None, "none.blend: No such file"),
    ("a.obj", b"v 0 0 0", "a.obj: neither a .blend nor a .npz file"),
])
def test_damaged_inputs_are_named(tmp_path, name, content, message):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    outcome = run("render", tmp_path / name, "-o", tmp_path / "a.exr", "--json")
    assert outcome.exit_code == 1 and message in json.loads(outcome.stdout)["failed"] and message in outcome.stderr
    assert not (tmp_path / "a.exr").exists()


def test_unknown_devices_are_named_with_those_that_exist(scene, tmp_path):
    outcome = run("render", scene, "-o", tmp_path / "a.exr", "--device", "cuda")
    assert outcome.exit_code == 1 and "no device 'cuda': there are openmp" in outcome.stderr


def test_a_scene_without_camera_is_refused(tmp_path):
    save_scene(tiny_scene(camera_to_world=np.zeros((3, 4))), tmp_path / "a.npz")
    outcome = run("render", tmp_path / "a.npz", "-o", tmp_path / "a.exr")
    assert outcome.exit_code == 1 and "camera: the scene has no camera" in outcome.stderr


def test_info(scene):
    result = json.loads(run("info", scene, "--json").stdout)
    assert (result["triangles"], result["materials"], result["lights"], result["problems"]) == (1, 1, 1, [])
    assert "triangles  1" in run("info", scene).stdout


def test_devices():
    result = json.loads(run("devices", "--json").stdout)
    assert result["devices"][0]["id"] == "openmp" and result["devices"][0]["usable"] is True
    assert "noise openmp" in run("devices").stdout


def test_devices_says_where_kernels_are_kept(tmp_path, monkeypatch):
    assert json.loads(run("devices", "--json").stdout)["kernel_cache"]["folder"] is None
    assert "kernels    not kept" in run("devices").stdout
    monkeypatch.setenv("ISOPHOTE_KERNEL_CACHE", str(tmp_path))
    KernelCache(tmp_path).store("a", bytes(2_000_000))
    assert f"kernels    kept in {tmp_path}: 1 entries, 2.0 MB of at most 134.2 MB" in run("devices").stdout


def test_explain_says_what_was_compiled_and_held(scene, tmp_path, monkeypatch):
    monkeypatch.setattr(NoiseDevice, "kernels_from", "cache")
    monkeypatch.setattr(NoiseDevice, "memory", {"scene": 2048, "paths": 3 << 20})
    told = run("render", scene, "-o", tmp_path / "a.png", "--samples", 1, "--explain").stdout
    assert "used       nothing" in told and "left out   instances, spheres" in told
    assert "kernels    from the cache in 0.00 s" in told and "memory     scene 2.0 KiB, paths 3.0 MiB" in told
    result = json.loads(run("render", scene, "-o", tmp_path / "a.png", "--samples", 1, "--json").stdout)
    assert result["memory"]["scene"] == 2048 and result["samples_by_device"] == {"noise openmp": 1}


def test_the_ledger_is_told_and_kept_with_the_picture(scene, tmp_path):
    told = run("render", scene, "-o", tmp_path / "a.exr", "--samples", 2, "--clamp-indirect", 3)
    assert "ledger     No setting took anything from the picture" in told.stdout
    assert read_image(tmp_path / "a.exr").metadata["isophote:ledger"] == "No setting took anything from the picture"
    told = run("render", scene, "-o", tmp_path / "a.exr", "--samples", 2, "--clamp-indirect", 3, "--explain")
    assert "ledger     Clamping indirect light at 3 took nothing" in told.stdout
    told = run("render", scene, "-o", tmp_path / "a.exr", "--samples", 2, "--clamp-direct", 1, "--json")
    first = json.loads(told.stdout)["ledger"][0]
    assert (first["switch"], first["setting"], first["status"], first["removed"]) == ("clamp_direct", 1.0, "none", 0.0)


def test_compare(scene, tmp_path):
    for name, seed in (("a.exr", 0), ("b.exr", 0), ("c.exr", 1)):
        run("render", scene, "-o", tmp_path / name, "--samples", 8, "--seed", seed)
    same = json.loads(run("compare", tmp_path / "a.exr", tmp_path / "b.exr", "--json").stdout)
    other = json.loads(run("compare", tmp_path / "a.exr", tmp_path / "c.exr", "--json").stdout)
    assert same["differing_floats"] == 0 and same["psnr"] is None and same["rmse"] == 0.0
    assert other["differing_floats"] > 0 and other["rmse"] > 0.1
    assert "rmse" in run("compare", tmp_path / "a.exr", tmp_path / "b.exr").stdout


def test_export_goes_through_blender(tmp_path, monkeypatch):
    def export_blend(path, out, frame, size, blender):
        save_scene(tiny_scene(), out)
        return {"triangles": 1, "instances": frame, "notes": 0}

    monkeypatch.setattr("isophote.render_command.export_blend", export_blend)
    outcome = run("export", "a.blend", "-o", tmp_path / "a.npz", "--frame", 5, "--json")
    assert json.loads(outcome.stdout)["instances"] == 5 and (tmp_path / "a.npz").exists()
    outcome = run("render", "a.blend", "-o", tmp_path / "a.exr", "--samples", 2, "--json")
    assert json.loads(outcome.stdout)["samples"] == 2
    assert run("export", "a.blend", "-o", tmp_path / "a.exr").exit_code == 2
