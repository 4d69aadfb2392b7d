import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from noise_device import AOV_PLANES, NoiseDevice, tiny_scene

from isophote.device import DeviceError
from isophote.film import COMBINED_PLANES, Film, FilmError, load_film, merge
from isophote.passes import USUAL, make_passes
from isophote.scene import SceneError
from isophote.schedule import is_decision
from isophote.session import Session
from isophote.settings import Settings

pytestmark = pytest.mark.usefixtures("engine")
ALL = USUAL


def settings(samples=100, **options):
    return Settings(samples=samples, passes=ALL, **options)


def bits(film):
    return {name: array.tobytes() for name, array in make_passes(film, ALL).items()}


def rendered(samples=100, **options):
    session = Session(tiny_scene(), settings(samples, **options), NoiseDevice())
    session.run()
    return session


def test_a_render_runs_to_its_samples_and_reports():
    seen = []
    session = Session(tiny_scene(), settings(), NoiseDevice())
    last = session.run(seen.append)
    assert last.why_stopped == "samples" and last.samples_done == last.samples_total == 100
    assert [p.samples_done for p in seen][:3] == [1, 2, 4]
    assert seen[0].error is None and last.error > 0 and last.remaining == 0.0
    result = session.result()
    assert {"device", "samples", "setup_seconds", "build_seconds", "compile_seconds", "render_seconds",
            "samples_per_second", "error", "why_stopped", "notes", "precision", "strict", "scene_hash"} <= set(result)
    assert result["samples"] == 100 and result["strict"] is True and result["build_seconds"] == 0.25
    assert result["samples_per_second"] == pytest.approx(100 * 120 / result["render_seconds"])
    session.close()
    assert session.device.closed


def test_the_picture_converges_to_the_known_answer_within_its_error():
    made = make_passes(rendered(2000).film, ALL)
    truth = np.broadcast_to(np.arange(1, 13)[None, :, None], (10, 12, 3))
    z = (made["Combined"][..., :3] - truth) / made["Error"]
    assert (np.abs(z) < 6).all() and 0.88 < (np.abs(z) < 1.96).mean() < 0.99


def test_steps_do_not_change_the_bits(monkeypatch):
    whole = bits(rendered(150).film)
    monkeypatch.setattr("isophote.session.choose_step", lambda *seconds: 1)
    assert bits(rendered(150).film) == whole


def test_a_render_resumed_from_a_checkpoint_has_the_same_bits(tmp_path):
    part = rendered(77)
    part.film.save(tmp_path / "film.npz", part.scene_hash, part.settings.fingerprint())
    film = load_film(tmp_path / "film.npz", tiny_scene().content_hash, settings(150).fingerprint())
    session = Session(tiny_scene(), settings(150), NoiseDevice(), film)
    assert session.run().samples_done == 150
    assert bits(session.film) == bits(rendered(150).film)


def test_parts_by_workers_merge_to_the_same_bits():
    films = []
    for first, count in ((64, 64), (0, 64), (128, 22)):
        session = Session(tiny_scene(), settings(count), NoiseDevice(), Film((0, 0, 12, 10), AOV_PLANES, first))
        session.run()
        films.append(session.film)
    assert bits(merge(films)) == bits(rendered(150).film)


def test_a_finished_film_is_not_rendered_again():
    session = Session(tiny_scene(), settings(50), NoiseDevice(), rendered(50).film)
    assert session.step().why_stopped == "samples" and session.device.items == []


def test_a_region_is_a_crop():
    region = (3, 2, 9, 8)
    crop = make_passes(rendered(40, region=region).film, ["combined"])["Combined"]
    whole = make_passes(rendered(40).film, ["combined"])["Combined"]
    assert (crop == whole[2:8, 3:9]).all()


@pytest.mark.timed
def test_time_stops_a_render_and_keeps_whole_samples():
    session = Session(tiny_scene(), settings(100_000, time_limit=0.3), NoiseDevice(delay=0.02))
    started = time.perf_counter()
    last = session.run()
    assert last.why_stopped == "time" and time.perf_counter() - started < 1.0
    assert 2 <= last.samples_done < 20
    assert bits(session.film) == bits(rendered(last.samples_done).film)


def test_time_too_short_for_a_sample_still_gives_one():
    session = Session(tiny_scene(), settings(100, time_limit=1e-9), NoiseDevice(delay=0.01))
    assert session.run().samples_done >= 1


@pytest.mark.timed
def test_cancelling_from_a_thread_is_quick_and_keeps_the_samples():
    session = Session(tiny_scene(), settings(100_000), NoiseDevice(delay=0.05))
    threading.Timer(0.3, session.cancel).start()
    started = time.perf_counter()
    last = session.run()
    assert last.why_stopped == "cancelled" and time.perf_counter() - started < 0.3 + 0.5
    assert last.samples_done >= 2
    assert bits(session.film) == bits(rendered(last.samples_done).film)


def test_a_device_that_fails_halfway_is_replaced_by_the_cpu():
    failing = NoiseDevice(kind="opencl", fail_after=37)
    session = Session(tiny_scene(), settings(), failing)
    assert session.run().samples_done == 100
    assert failing.closed and session.device.kind == "openmp" and session.device.uploads == 1
    assert bits(session.film) == bits(rendered(100).film)
    (note,) = [note for note in session.result()["notes"] if note["kind"] == "device"]
    assert note["name"] == "noise opencl" and "went on on the CPU: the driver reset" in note["what"]


def test_a_device_that_cannot_take_the_scene_is_replaced():
    session = Session(tiny_scene(), settings(4), NoiseDevice(kind="opencl", fail_after=-1))
    assert session.run().samples_done == 4 and "out of device memory" in session.notes[0]["what"]


def test_a_cpu_that_fails_raises_and_the_film_stays():
    session = Session(tiny_scene(), settings(), NoiseDevice(fail_after=37))
    with pytest.raises(DeviceError, match="the driver reset"):
        session.run()
    assert bits(session.film) == bits(rendered(session.film.samples).film)


def test_a_device_that_gives_up_silently_is_caught():
    device = NoiseDevice()
    device.render = lambda *_: 0
    with pytest.raises(DeviceError, match="gave 0 of 1 samples"):
        Session(tiny_scene(), settings(), device).run()


def test_scenes_with_errors_are_refused_and_name_the_thing():
    with pytest.raises(SceneError, match="camera: the scene has no camera"):
        Session(tiny_scene(camera_to_world=np.zeros((3, 4))), settings())


def test_what_was_dropped_is_in_the_notes():
    session = Session(tiny_scene(light_strength=[[np.nan, 1, 1]]), settings(1), NoiseDevice())
    assert session.notes == [{"kind": "geometry", "name": "Lamp", "what": "its place, strength or size is not finite"}]


def test_what_does_not_fit_is_refused():
    with pytest.raises(ValueError, match="region .* does not lie in the frame of 12x10"):
        Session(tiny_scene(), settings(region=(0, 0, 13, 10)))
    with pytest.raises(FilmError, match="the render needs"):
        Session(tiny_scene(), settings(), NoiseDevice(), Film((0, 0, 12, 10), COMBINED_PLANES))
    with pytest.raises(ValueError, match="no pass 'haze'"):
        Session(tiny_scene(), replace(settings(), passes=("haze",)))


def test_strict_says_why_not():
    session = Session(tiny_scene(), settings(1, precision="fast"), NoiseDevice())
    assert session.result()["strict"] == "precision is fast"
    device = NoiseDevice()
    device.strict = "the driver does not round division correctly"
    assert Session(tiny_scene(), settings(1), device).result()["strict"] == device.strict


def test_a_render_stops_when_its_error_is_reached_and_says_so():
    session = Session(tiny_scene(), settings(100_000, error_target=0.2), NoiseDevice())
    seen = []
    last = session.run(seen.append)
    assert last.why_stopped == "error" and last.error_95 <= 0.2 and last.remaining == 0.0
    assert is_decision(last.samples_done) and 24 <= last.samples_done <= 112  # 1.96 * 0.745 / sqrt(53) = 0.2
    assert all(p.error_95 > 0.2 for p in seen if is_decision(p.samples_done) and not p.why_stopped)
    result = session.result()
    assert result["error_95"] == last.error_95 and result["error_target"] == 0.2 and result["why_stopped"] == "error"
    assert result["error_95_interval"][0] <= result["error_95"] <= result["error_95_interval"][1]
    assert 0.0 <= result["unsure"] <= 1.0


@pytest.mark.parametrize("step", [1, 4, 64])
def test_where_a_render_stops_for_its_error_does_not_depend_on_its_items(monkeypatch, step):
    whole = rendered(100_000, error_target=0.25).film
    monkeypatch.setattr("isophote.session.choose_step", lambda *seconds: step)
    other = rendered(100_000, error_target=0.25).film
    assert other.samples == whole.samples and bits(other) == bits(whole)
    part = rendered(37).film  # as if interrupted and resumed
    resumed = Session(tiny_scene(), settings(100_000, error_target=0.25), NoiseDevice(), part)
    assert resumed.run().samples_done == whole.samples and bits(part) == bits(whole)


def test_samples_stop_a_render_before_its_error_does():
    session = Session(tiny_scene(), settings(50, error_target=1e-4), NoiseDevice())
    assert session.run().why_stopped == "samples" and session.film.samples == 50


def test_the_time_to_the_wanted_error_is_foretold():
    seen = []
    session = Session(tiny_scene(), settings(1 << 20, error_target=0.1), NoiseDevice(delay=0.0005))
    session.run(seen.append)
    total = seen[-1].seconds
    foretold = [(p.seconds, p.remaining) for p in seen if 100 < p.samples_done < 300]
    assert foretold and all(0.4 * total < seconds + left < 2.5 * total for seconds, left in foretold)
