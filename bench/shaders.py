"""Each shader's ball against Cycles: channel means over the ball, as a statistical statement.

    python -m bench.shaders [WORD] [--samples 64] [--replicates 8] [--maker make_subsurface]

A script of blend_scenes/nodes/, make_shaders if not another is named, makes the scene; WORD keeps shaders whose names
hold it. Prints a row of JSON for
each: ratios of the channel means ours / Cycles' with half their 95 % intervals, and the notes of its export.
"""

from __future__ import annotations

import argparse
import json
import math
import tempfile
from pathlib import Path

import numpy as np

from bench.common import ROOT, print_row
from bench.cycles_compare import render_both, same_bits
from bench.cycles_process import run_script
from bench.replicates import mean_ratios

COLUMNS, RADIUS = 8, 0.43  # of the grid; a little less than the balls'
MAKER = ROOT / "blend_scenes" / "nodes" / "make_shaders.py"


def make_grid(path: Path, maker: Path, word: str) -> list[str]:
    """Names of the balls of the scene, which is saved at `path`. Raises CyclesError."""
    said = run_script(maker, path, word, makes=path)
    names = next(line for line in said.splitlines() if line.startswith("SHADERS "))
    return json.loads(names.removeprefix("SHADERS "))


def ball(images: np.ndarray, index: int, rows: int) -> np.ndarray:
    """Pixels of a ball, (K, n, 1, 3); the grid fills the picture, rows from the bottom."""
    side = images.shape[2] / COLUMNS
    y, x = np.indices(images.shape[1:3]) + 0.5
    inside = np.hypot(x / side - index % COLUMNS - 0.5, y / side - index // COLUMNS - 0.5) < RADIUS
    assert images.shape[1] == round(rows * side)
    return images[:, inside][:, :, None]


def compare_shaders(word: str, samples: int, replicates: int, maker: Path = MAKER) -> tuple[list[dict], dict]:
    """A row for each of the maker's shaders whose name holds `word`, and what cycles_compare.same_bits says."""
    with tempfile.TemporaryDirectory() as folder:
        blend = Path(folder) / "grid.blend"
        names = make_grid(blend, maker, word)
        both = render_both(blend, 0, samples, replicates)
    grid, rows = math.ceil(len(names) / COLUMNS), []
    for k, name in enumerate(names):
        means = mean_ratios(*(ball(both[engine], k, grid) for engine in ("isophote", "cycles")))
        rows.append({"shader": name, "ratios": [round(mean["ratio"], 5) for mean in means],
                     "half_intervals": [round(mean["half_interval"], 5) for mean in means],
                     "verdict": "/".join(sorted({mean["verdict"] for mean in means})),
                     "notes": [note["what"] for note in both["scene"].notes if note["name"] == name]})
    return rows, same_bits(both["scene"], both["settings"])


def main() -> int:
    parser = argparse.ArgumentParser(prog="bench.shaders", description="Compare shaders with Cycles.")
    parser.add_argument("word", nargs="?", default="")
    parser.add_argument("--samples", type=int, default=64, help="of each replicate")
    parser.add_argument("--replicates", type=int, default=8)
    parser.add_argument("--maker", default=MAKER.stem, help="script of blend_scenes/nodes")
    options = parser.parse_args()
    maker = MAKER.with_name(f"{options.maker}.py")
    rows, bits = compare_shaders(options.word, options.samples, options.replicates, maker)
    for row in [*rows, {"opencl": bits}]:
        print_row(row)
    return 1 if any("beyond" in row["verdict"] for row in rows) else 0


if __name__ == "__main__":
    raise SystemExit(main())
