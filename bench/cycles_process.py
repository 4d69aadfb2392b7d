"""Cycles for benches and tests: where a bpy wheel is, a process that renders with it, and the same settings for us."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

import numpy as np

from isophote.blender_process import export_blend
from isophote.scene import Scene, load_scene
from isophote.settings import Settings

WORKER = Path(__file__).with_name("cycles_worker.py")
MARK = "ISOPHOTE-CYCLES "


class CyclesError(RuntimeError):
    """Cycles did not start or did not render; the message holds its last lines."""


@cache
def find_python() -> str | None:
    """The first Python of ISOPHOTE_BPY_PYTHONS (separated by colons) with a bpy module, else this one if it has it."""
    named = [path for path in os.environ.get("ISOPHOTE_BPY_PYTHONS", "").split(":") if path]
    ask = "import importlib.util, sys; sys.exit(importlib.util.find_spec('bpy') is None)"
    for python in [*named, sys.executable]:
        if Path(python).exists() and subprocess.run([python, "-c", ask], capture_output=True).returncode == 0:
            return python
    return None


def run_script(script: Path, *arguments, makes: Path) -> str:
    """Standard output of a script for the bpy module that makes a file. Raises CyclesError with what it said."""
    done = subprocess.run([find_python(), str(script), *map(str, arguments)], capture_output=True, text=True,
                          stdin=subprocess.DEVNULL)
    if not makes.is_file():  # the exit status of the bpy module says little
        raise CyclesError(f"{script.name} made no {makes.name}:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


class Cycles:
    """Cycles with one .blend file loaded, as a process. `info` is what cycles_worker.set_up says.

    `longest`: the longer side of the picture in pixels, 0 for the file's own size. Raises CyclesError.
    """

    def __init__(self, blend: Path, longest: int = 0, threads: int = 0):
        python = find_python()
        if python is None:
            raise CyclesError("no Python with a bpy module: set ISOPHOTE_BPY_PYTHONS or pip install bpy")
        arguments = [str(Path(blend).resolve()), str(longest), str(threads or os.cpu_count() or 1)]
        self.process = subprocess.Popen([python, "-P", str(WORKER), *arguments], stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.folder = tempfile.TemporaryDirectory(prefix="isophote_cycles_")
        self.info = self.read()

    def read(self) -> dict:
        """The next answer; `said` is what stood before it. Raises CyclesError where the process ends first."""
        self.said: list[str] = []
        for line in self.process.stdout:
            if line.startswith(MARK):
                return json.loads(line[len(MARK):])
            self.said.append(line)
        raise CyclesError("Cycles ended without an answer:\n" + "".join(self.said[-15:]))

    def ask(self, **request) -> dict:
        self.process.stdin.write(json.dumps(request) + "\n")
        self.process.stdin.flush()
        return self.read()

    def seconds(self, samples: int, seed: int) -> float:
        """Wall time of one render, with everything that Blender does around it."""
        return self.ask(samples=samples, seed=seed, out=None)["seconds"]

    def render(self, samples: int, seed: int, over=None) -> np.ndarray:
        """Linear RGB, float32 (h, w, 3), rows from the bottom; over a colour of the background where one is given."""
        out = Path(self.folder.name) / "picture.npy"
        self.ask(samples=samples, seed=seed, out=str(out))
        return laid_over(np.load(out), over)

    def close(self) -> None:
        self.process.stdin.close()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.process.stdout.close()
        self.folder.cleanup()

    def __enter__(self) -> Cycles:
        return self

    def __exit__(self, *_) -> None:
        self.close()


def laid_over(rgba: np.ndarray, background) -> np.ndarray:
    """RGB of pictures (..., 4) whose alpha is premultiplied, over a colour, or as it is where that is None."""
    light = rgba[..., :3]
    if background is None:
        return light
    return light + (1.0 - rgba[..., 3:]) * np.asarray(background, rgba.dtype)


def same_settings(info: dict, **others) -> Settings:
    """Isophote's settings that mean what Cycles was told (`info` of a Cycles)."""
    bounces = dict(info["bounces"])
    return Settings(transparent_bounces=bounces.pop("transparent_max_bounces"), **bounces,
                    filter_width=info["filter_width"], film_transparent=info["film_transparent"],
                    passes=("combined",), **others)


def exported(blend: Path, size: tuple[int, int]) -> Scene:
    """The .blend as a Scene, exported by the Blender that holds the Cycles compared with."""
    with tempfile.TemporaryDirectory(prefix="isophote_export_") as folder:
        path = Path(folder) / "scene.npz"
        export_blend(blend, path, size=size, blender=find_python())
        return load_scene(path)
