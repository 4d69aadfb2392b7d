"""Pictures of the scenes of each family of nodes for docs/nodes.md: Cycles, Isophote and their difference.

    python -m bench.node_pictures [WORD] [--out docs/nodes]

blend_scenes/nodes/make_*.py make the scenes; WORD keeps those whose names hold it. Prints a row of JSON for each: the
picture, its samples, FLIP of Isophote against Cycles and of Cycles against itself, and the export's notes.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from bench.common import ROOT, print_row
from bench.comparison_report import write_picture
from bench.cycles_compare import render_both
from bench.cycles_process import run_script
from bench.replicates import flips

MAKERS = ROOT / "blend_scenes" / "nodes"
REPLICATES = 2
FEW, MANY = 8, 256  # samples of a replicate: of what shines through a filter 1/100 of a pixel wide, and of what is lit
# Name of a picture -> (script, its arguments, samples); "{}" is the folder into which scripts write NAME.blend.
SCENES = {
    **{name: ("make_conversions.py", ("--", "{}"), FEW) for name in ("numbers", "vectors", "colours", "spaces")},
    "noise": ("make_noise.py", ("--", "{}"), FEW),
    "cells": ("make_cells.py", ("--", "{}"), FEW),
    **{name: ("make_inputs.py", ("{}",), FEW) for name in ("inputs", "instances")},
    "paths": ("make_inputs.py", ("{}",), MANY),
    "normals": ("make_normals.py", ("{}",), MANY),
    "steps": ("make_normals.py", ("{}",), FEW),
    "displacement": ("make_displacement.py", ("--", "{}"), FEW),
    "displaced": ("make_displacement.py", ("--", "{}"), MANY),
    "terminator": ("make_terminator.py", ("--", "{}/terminator.blend"), MANY),
    "images": ("make_images.py", ("--", "{}/images.blend"), FEW),
    **{world: ("make_worlds.py", ("--", f"{{}}/{world}.blend", world), MANY)
       for world in ("sky", "sunny", "ball", "hidden", "light_path", "lamps", "screens")},
    "shaders": ("make_shaders.py", ("{}/shaders.blend",), MANY),
    "subsurface": ("make_subsurface.py", ("{}/subsurface.blend",), MANY),
    "volumes": ("make_volumes.py", ("{}/volumes.blend",), MANY),
    **{kind: ("make_volume_scenes.py", ("--", f"{{}}/{kind}.blend", kind), MANY)
       for kind in ("fog", "inside", "glow")},
    **{kind: ("make_strands.py", ("--", f"{{}}/{kind}.blend", kind), MANY) for kind in ("fur", "children", "curves")},
    "skies": ("make_skies.py", ("--", "{}"), FEW),
    **{f"under_{sky}": ("make_skies.py", ("--", "{}"), MANY) for sky in ("sun", "hosek_wilkie")},
    **{lamp: ("make_lamps.py", ("--", f"{{}}/{lamp}.blend", lamp), MANY)
       for lamp in ("spread", "picture", "graphs", "photometric")},
    **{camera: ("../make_cameras.py", ("--", f"{{}}/{camera}.blend", camera, "marks"), FEW)
       for camera in ("equirectangular", "equisolid")},
}


def made(folder: Path, name: str) -> Path:
    """The scene of a picture, made in `folder` unless it lies there. Raises CyclesError."""
    script, arguments, _ = SCENES[name]
    path = folder / f"{name}.blend"
    if not path.is_file():
        run_script(MAKERS / script, *(argument.format(folder) for argument in arguments), makes=path)
    return path


def main() -> int:
    parser = argparse.ArgumentParser(prog="bench.node_pictures", description="Pictures for docs/nodes.md.")
    parser.add_argument("word", nargs="?", default="")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "nodes")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        for name in (name for name in SCENES if options.word in name):
            samples = SCENES[name][2]
            both = render_both(made(Path(folder), name), 0, samples, REPLICATES)
            path = options.out / f"{name}.png"
            write_picture(path, both["cycles"].mean(axis=0), both["isophote"].mean(axis=0))
            print_row({"picture": path.name, "samples": REPLICATES * samples, **flips(both["isophote"], both["cycles"]),
                       "notes": both["scene"].notes})
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
