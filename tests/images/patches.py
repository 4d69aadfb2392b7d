"""Pictures of patches (blend_scenes/nodes/patches.py) by both engines, patch by patch."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np

from bench.common import ROOT
from bench.cycles_compare import render_both
from bench.cycles_process import CyclesError, find_python

SAMPLES, REPLICATES = 8, 2  # the filter is 1/100 of a pixel wide: next to no noise


def make_blends(script: str, folder: Path) -> None:
    """Runs a script of blend_scenes/nodes. Raises CyclesError where it does not say that it saved a file."""
    done = subprocess.run([find_python(), str(ROOT / "blend_scenes" / "nodes" / script), "--", str(folder)],
                          capture_output=True, text=True)
    if not list(folder.glob("*.blend")):  # the exit status of the bpy module says little
        raise CyclesError(f"{script} made no scenes:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")


def patches_of(pictures: np.ndarray, pixels: int) -> np.ndarray:
    """(replicates, patches, pixels, 3) of pictures (replicates, h, w, 3)."""
    count, height, width, _ = pictures.shape
    rows, columns = height // pixels, width // pixels
    patches = pictures.reshape(count, rows, pixels, columns, pixels, 3).swapaxes(2, 3)
    return patches.reshape(count, rows * columns, -1, 3)


def differences(blend: Path, columns: int, pixels: int) -> tuple[dict[str, np.ndarray], list]:
    """({name of a patch: largest difference of a colour's parts at each of its pixels}, the export's notes)."""
    both = render_both(blend, 0, SAMPLES, REPLICATES)
    scene, found = both["scene"], {}
    off = np.abs(both["isophote"].mean(axis=0) - both["cycles"].mean(axis=0)).max(axis=-1)
    for number in range(len(scene.instance_mesh)):
        row, column = divmod(number, columns)
        place = np.s_[row * pixels:(row + 1) * pixels, column * pixels:(column + 1) * pixels]
        found[scene.name_of("instances", number)] = off[place]
    return found, scene.notes
