"""The scenes that benches use: the project's own, and those of ../shared/scenes where that folder exists."""

from __future__ import annotations

import subprocess
from pathlib import Path

from bench.common import ROOT
from bench.cycles_process import CyclesError, find_python
from isophote.blender_process import export_blend

OWN = ("cornell_box", "sphere_box", "torus_box", "monkey_box", "instances", "garlands")
MADE = ("cornell", "monkeys", "glassbox")
SHARED = ROOT.parent / "shared" / "scenes"


def own_scenes(names=OWN) -> list[Path]:
    return [ROOT / "blend_scenes" / f"{name}.blend" for name in names]


def ignis_box() -> list[Path]:
    """The box of the Ignis project (MIT), or nothing."""
    path = SHARED / "ignis" / "evaluation" / "blender" / "box.blend"
    return [path] if path.is_file() else []


def made_scenes(folder: Path, names=MADE) -> list[Path]:
    """The scenes of make_bench_scenes.py, made in `folder` unless they lie there; nothing without that script."""
    script = SHARED / "make_bench_scenes.py"
    paths = [Path(folder) / f"{name}.blend" for name in names]
    if not all(path.is_file() for path in paths):
        if not script.is_file() or find_python() is None:
            return []
        done = subprocess.run([find_python(), str(script), str(folder)], capture_output=True, text=True)
        if not all(path.is_file() for path in paths):  # the exit status of the bpy module says little
            raise CyclesError(f"{script.name} made no scenes:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return paths


def exported_scenes(folder: Path, names=MADE) -> list[Path]:
    """Scenes as .npz files, exported into `folder` unless they lie there; those that can be had.

    `names` are of MADE or of OWN. Raises CyclesError, BlenderError.
    """
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"{name}.npz" for name in names]
    for path in paths:
        if not path.is_file() and find_python() is not None:
            for blend in own_scenes([path.stem]) if path.stem in OWN else made_scenes(folder, [path.stem]):
                export_blend(blend, path, blender=find_python())
    return [path for path in paths if path.is_file()]
