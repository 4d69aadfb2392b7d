# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes scenes that each show one texture and nothing else, for bench.cycles_speed.

    python blend_scenes/nodes/make_speed.py -- FOLDER
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from make_cells import voronoi
from make_noise import noise
from points import make_patches, point

SCENES = {"plain": point, "noise_detail_2": noise(Detail=2.0), "noise_detail_15": noise(Detail=15.0),
          "voronoi_f1": voronoi()}


if __name__ == "__main__":
    for name, build in SCENES.items():
        make_patches(name, [(name, build)], 1, 512)
