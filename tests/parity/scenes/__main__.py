"""Writes the scenes as .npz files for bench/parity.py: `python -m tests.parity.scenes FOLDER`."""

import sys
from pathlib import Path

from isophote.scene import save_scene
from tests.parity.scenes import SCENES

folder = Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)
for name, make in SCENES.items():
    save_scene(make(), folder / f"{name}.npz")
