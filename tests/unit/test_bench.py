"""What benches share, and the page that is made of their rows."""

import json

import pytest
from click.testing import CliRunner

from bench import __main__ as program
from bench import adaptive_time, report
from bench.catalogue import BENCHES, FOLDER, SCENES, Bench
from bench.common import in_turn, machine, medians, versions
from bench.compile import kernel_names, only_kernel
from bench.scaling import cores_first, doublings, middle
from isophote.opencl import kernel_source

ROWS = [{"scene": "box", "device": "openmp", "speed": 1.234, "deep": {"er": 2}, "ok": True},
        {"scene": "box", "device": "opencl", "speed": 1234.5, "deep": {}, "ok": False},
        {"scene": "room", "device": "openmp", "speed": 12.0, "list": [1, 2]}]


def result(rows=ROWS, **changes) -> dict:
    return {"bench": "parity", "command": "python -m bench.parity", "date": "2026-01-02", "commit": "abc",
            "machine": {"name": "here", "processor": "CPU", "threads": 2, "opencl": ["card"]},
            "versions": {"numpy": "1.26"}, "rows": rows, **changes}


def test_works_are_done_in_turn():
    order = []
    found = in_turn({name: lambda name=name: order.append(name) or len(order) for name in "ab"}, 3)
    assert order == list("ababab") and found == {"a": [1, 3, 5], "b": [2, 4, 6]}
    assert medians(found) == {"a": 3, "b": 4}


def test_the_machine_and_versions_are_said():
    assert {"processor", "threads", "memory_gib", "opencl"} <= set(machine())
    assert "numpy" in versions() and "native module" in versions()


def test_adaptive_and_uniform_renders_are_compared_round_by_round():
    one = dict(samples=128, items=9, decisions=3, drawing=0.8, deciding=0.1, adding=0.05, why_stopped="error")
    rounds = [{False: one | {"seconds": seconds}, True: one | {"seconds": 2.0, "samples": 64, "why_stopped": "samples"}}
              for seconds in (2.0, 3.0, 40.0)]
    row = adaptive_time.scene_row(rounds)
    assert row["faster"] == 1.5 and row["fewer"] == 2.0 and row["seconds"] == [3.0, 2.0]
    assert row["stopped"] == ["error", "samples"]


def test_threads_take_a_processor_of_each_core_before_the_second_of_any():
    assert cores_first([0, 1, 2, 3], lambda cpu: f"{cpu // 2}") == [0, 2, 1, 3]
    assert cores_first([1, 4, 5], lambda cpu: "") == [1, 4, 5]
    assert doublings(1) == [1] and doublings(16) == [1, 2, 4, 8, 16] and doublings(6) == [1, 2, 4, 6]
    assert middle((720, 720), 320) == (200, 200, 520, 520) and middle((100, 50), 64) == (18, 0, 82, 50)


@pytest.mark.parametrize(("value", "text"), [
    (None, "–"), (True, "yes"), (1.2, "1.20"), (335.0, "335"), (0.01234, "0.0123"), (12345.6, "12,346"),
    (2015244, "2,015,244"), ([1, 2.5], "1, 2.50"), ({"16": 2.5}, "16: 2.50"), ("a|b", "a\\|b")])
def test_cells(value, text):
    assert report.shown(value) == text


def test_tables_of_columns_of_everything_plain_and_pivoted():
    chosen = Bench("x", "", columns={"scene": "scene", "deeper": "deep.er", "nowhere": "no.where"})
    assert report.rows_table(chosen, ROWS).splitlines() == [
        "| scene | deeper |", "| --- | --- |", "| box | 2 |", "| box | – |", "| room | – |"]
    assert report.rows_table(Bench("x", ""), ROWS).splitlines()[0] == "| scene | device | speed | ok |"
    pivoted = report.rows_table(Bench("x", "", pivot=("scene", "on {device}", "speed")), ROWS)
    assert pivoted.splitlines()[2:] == ["| box | 1.23 | 1,234 |", "| room | 12.0 | – |"]


def test_results_are_kept_by_bench_and_machine_and_replaced(tmp_path):
    path = report.save_result(tmp_path, result())
    assert path.name == "parity.here.json" and json.loads(path.read_text()) == result()
    report.save_result(tmp_path, result(date="2026-01-01", machine=result()["machine"] | {"name": "there"}))
    report.save_result(tmp_path, result(rows=ROWS[:1]))
    found = report.load_results(tmp_path, "parity")
    assert [r["machine"]["name"] for r in found] == ["there", "here"] and found[1]["rows"] == ROWS[:1]


def test_the_page_holds_rows_where_the_template_wants_them_and_keeps_its_text(tmp_path):
    report.save_result(tmp_path, result(by_hand=True))
    made = report.page("Before.\n\n<!-- rows: parity -->\n\nAfter `<!-- rows: not alone -->`.\n"
                       "<!-- rows: rays -->\n", tmp_path)
    assert made.startswith("Before.\n\nEntered by hand from the output of that day. 2026-01-02; CPU; 2 threads; card; "
                           "commit abc. `python -m bench.parity`; numpy 1.26.\n\n| scene |")
    assert "After `<!-- rows: not alone -->`." in made and "No rows yet: `python -m bench rays`" in made
    with pytest.raises(KeyError, match="nothing"):
        report.page("<!-- rows: nothing -->", tmp_path)


def test_measurements_md_is_what_the_rows_say():
    """Text of that page is changed in its template; then `python -m bench --report-only`."""
    assert report.PAGE.read_text() == report.page(report.TEMPLATE.read_text(), report.RESULTS)


def test_every_bench_has_a_place_on_the_page():
    assert set(report.PLACE.findall(report.TEMPLATE.read_text())) == {b.name for b in BENCHES.values() if not b.then}


def test_rows_are_kept_and_reported_and_failures_named(tmp_path, monkeypatch):
    for name in ("good", "bad"):
        monkeypatch.setitem(BENCHES, name, Bench(name, ""))
    monkeypatch.setattr(Bench, "exists", True)
    monkeypatch.setattr(program, "run_bench", lambda bench, *_: (
        ["-m", f"bench.{bench.name}"], *(([{"speed": 2}], 0) if bench.name == "good" else ([{"speed": 1}], 3))))
    written = []
    monkeypatch.setattr(program, "write_page", written.append)
    done = CliRunner().invoke(program.main, ["good", "bad", "--results", str(tmp_path), "--machine", "m"])
    assert done.exit_code == 1 and "no rows of bad" in done.output
    kept, = report.load_results(tmp_path, "good")
    assert kept["rows"] == [{"speed": 2}] and kept["machine"]["name"] == "m" and kept["date"] and written == [tmp_path]
    assert kept["command"] == "python -m bench.good" and not report.load_results(tmp_path, "bad")
    assert CliRunner().invoke(program.main, ["nothing"]).exit_code == 2


def test_the_list_names_what_is_missing(tmp_path):
    done = CliRunner().invoke(program.main, ["--list", "--scenes", str(tmp_path)])
    assert done.exit_code == 0 and len(done.output.splitlines()) == len(BENCHES)


def test_scenes_are_put_into_the_command(tmp_path, monkeypatch):
    monkeypatch.setattr(program, "exported_scenes", lambda folder: [folder / "a.npz", folder / "b.npz"])
    seen = []

    class Process:
        stdout, returncode = ["not a row\n", '{"a": 1}\n'], 0

        def __init__(self, command, **_):
            seen.append(command[1:])

        def __enter__(self):
            return self

        def __exit__(self, *_):
            pass

    monkeypatch.setattr(program.subprocess, "Popen", Process)
    bench = Bench("x", "", (SCENES, "--fast", "--made", FOLDER))
    command, rows, status = program.run_bench(bench, False, tmp_path)
    assert rows == [{"a": 1}] and status == 0 and seen == [command]
    assert program.readable_command(command, tmp_path) == "python -m bench.x a.npz b.npz --fast --made FOLDER"


def test_a_source_with_one_kernel_has_that_kernel_and_the_functions():
    source = kernel_source()
    names = kernel_names(source)
    assert {"generate", "extend", "shade", "connect", "accumulate"} <= set(names)
    for name in ("", *names):
        part = only_kernel(source, name)
        assert kernel_names(part) == ([name] if name else [])
        assert part.count("{") == part.count("}") and "make_real3" in part
