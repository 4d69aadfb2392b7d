"""The process that exports, against programs that fail in the ways in which Blender does."""

import json
import os
import stat
import sys

import pytest

from isophote.blender_process import BlenderError, check_blend, export_blend, find_blender

WRITE = "import sys; out = [a for a in sys.argv if a.endswith('.npz')][0]; open(out, 'w').write('scene');"


@pytest.fixture
def blend(tmp_path):
    path = tmp_path / "a.blend"
    path.write_bytes(b"BLENDER-v304 and more")
    return path


@pytest.fixture
def exporter(tmp_path, monkeypatch):
    """A function that makes `body` the program's behaviour and exports a.blend with it."""
    addon = tmp_path / "addon"
    addon.mkdir()
    (addon / "run_export.py").write_text("")
    monkeypatch.setenv("ISOPHOTE_ADDON", str(addon))

    def export(blend, body, **options):
        program = tmp_path / "blender"
        program.write_text(f"#!{sys.executable}\n{body}\n")
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
        return export_blend(blend, tmp_path / "out.npz", blender=str(program), **options)

    return export


def test_a_good_export_gives_the_report_and_the_file(blend, exporter, tmp_path):
    lines = []
    report = exporter(blend, WRITE + "print('Blender 9'); print('ISOPHOTE-EXPORT', '{\"triangles\": 12}')",
                      on_line=lines.append)
    assert report == {"triangles": 12} and lines[0] == "Blender 9"
    assert (tmp_path / "out.npz").read_text() == "scene"


def test_options_are_passed_on(blend, exporter):
    body = WRITE + "import json; print('ISOPHOTE-EXPORT', json.dumps({'argv': sys.argv[1:]}))"
    argv = exporter(blend, body, frame=3, size=(64, 48))["argv"]
    assert argv[:2] == ["-b", str(blend)]
    assert argv[argv.index("--python") + 1].endswith("run_export.py")
    own = argv[argv.index("--") + 1:]
    assert own[0].endswith(".npz") and own[1:] == ["--frame", "3", "--size", "64x48"]


@pytest.mark.parametrize(("body", "message"), [
    ("print('Traceback: boom')", "without a report"),
    ("print('ISOPHOTE-EXPORT {}')", "wrote no scene"),
    (WRITE + "print('ISOPHOTE-EXPORT', '{\"error\": \"no camera\"}')", "no camera"),
    (WRITE + "print('ISOPHOTE-EXPORT {}'); sys.exit(1)", "ended with status 1"),
    (WRITE + "print('ISOPHOTE-EXPORT {}', flush=True); import os; os.kill(os.getpid(), 9)", "by signal 9"),
    (WRITE + "print('ISOPHOTE-EXPORT {oops')", "report cannot be read"),
    (WRITE + "print('ISOPHOTE-EXPORT', '{\"file\": \"/other.blend\"}')", "exported /other.blend instead"),
])
def test_failures_are_seen_though_blender_hides_them(blend, exporter, tmp_path, body, message):
    with pytest.raises(BlenderError, match=f"a.blend: export failed: .*{message}") as caught:
        exporter(blend, "print('last words', flush=True);" + body)
    assert "| last words" in str(caught.value)
    log = str(caught.value).rsplit("log: ", 1)[1]
    with open(log) as file:
        assert "last words" in file.read()
    os.unlink(log)
    assert not (tmp_path / "out.npz").exists()


def test_files_that_are_no_blend_are_refused_before_blender_starts(tmp_path):
    path = tmp_path / "a.blend"
    path.write_bytes(b"PK\x03\x04")
    with pytest.raises(BlenderError, match="a.blend: not a .blend file"):
        check_blend(path)
    with pytest.raises(BlenderError, match="none.blend: No such file"):
        check_blend(tmp_path / "none.blend")


def test_blender_is_found_in_order(tmp_path, monkeypatch):
    for name in ("blender", "other"):
        (tmp_path / name).write_text("#!/bin/sh\n")
        (tmp_path / name).chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("ISOPHOTE_BLENDER", raising=False)
    assert find_blender().program == str(tmp_path / "blender")
    monkeypatch.setenv("ISOPHOTE_BLENDER", str(tmp_path / "other"))
    assert find_blender().program == str(tmp_path / "other")
    found = find_blender(sys.executable)
    assert found.is_wheel
    assert found.command("run.py", "a.blend", ["out"]) == [sys.executable, "run.py", "a.blend", "out"]
    with pytest.raises(BlenderError, match="--blender: no program nonesuch"):
        find_blender("nonesuch")


def test_no_blender_at_all_says_what_to_do(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("ISOPHOTE_BLENDER", raising=False)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(BlenderError, match="pip install bpy"):
        find_blender()


def test_a_missing_exporter_is_named(blend, tmp_path, monkeypatch):
    monkeypatch.setenv("ISOPHOTE_ADDON", str(tmp_path / "none"))
    with pytest.raises(BlenderError, match="run_export.py: no such file; ISOPHOTE_ADDON"):
        export_blend(blend, tmp_path / "out.npz", blender=sys.executable)


def test_reports_are_json(blend, exporter):
    report = {"triangles": 1, "name": "Würfel"}
    assert exporter(blend, WRITE + f"print('ISOPHOTE-EXPORT', {json.dumps(json.dumps(report))})") == report
