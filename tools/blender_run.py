# SPDX-License-Identifier: Apache-2.0
"""Finds Blender, or Python with the bpy wheel, and starts it with the add-on of this tree."""

from __future__ import annotations

import os
import shutil
import sys
from importlib.util import find_spec
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
ADDON = "isophote_addon"  # not `isophote`: that is the package
# What the package imports inside Blender beside numpy, which Blender brings.
MODULES = ("pyopencl", "pytools", "siphash24", "platformdirs", "typing_extensions")


def scripts_folder(folder: Path = ROOT / "build" / "blender_scripts") -> Path:
    """A folder for BLENDER_USER_SCRIPTS in which add-on, package and modules are links to this tree and .venv."""
    wanted = {folder / "addons" / ADDON: ROOT / "addon", folder / "addons" / "modules" / "isophote": ROOT / "isophote"}
    modules = folder / "addons" / "modules"
    for name in MODULES:
        spec = find_spec(name)
        if spec is not None and spec.origin:
            origin = Path(spec.origin)
            place = origin.parent if origin.name == "__init__.py" else origin
            # pyopencl and pytools ask for their own versions: the metadata comes along.
            for target in (place, *place.parent.glob(f"{name}-*.dist-info")):
                wanted[modules / target.name] = target
    for link, target in wanted.items():
        link.parent.mkdir(parents=True, exist_ok=True)
        if link.is_symlink() and link.readlink() == target:
            continue
        new = link.with_name(f".{link.name}.{os.getpid()}")
        new.symlink_to(target)
        new.replace(link)  # at once: tests that run side by side make the same links
    return folder


def environment(scripts: Path | None = None, **more: str) -> dict[str, str]:
    """The environment in which Blender finds the add-on, and none of the user's own settings."""
    scripts = scripts or scripts_folder()
    config = scripts.parent / "blender_config"
    config.mkdir(parents=True, exist_ok=True)
    return {**os.environ, "BLENDER_USER_SCRIPTS": str(scripts), "BLENDER_USER_CONFIG": str(config), **more}


def find_program() -> list[str] | None:
    """The start of a command: Blender (ISOPHOTE_BLENDER, or on PATH), else this Python with the bpy wheel."""
    named = os.environ.get("ISOPHOTE_BLENDER") or shutil.which("blender")
    if named:
        return program(named)
    return program(sys.executable) if find_spec("bpy") else None


def program(path: str) -> list[str]:
    """The start of a command for Blender, or for a Python that has the bpy wheel and so needs the runner."""
    if Path(path).name.startswith("python"):
        return [path, str(ROOT / "addon" / "scripts" / "blender_bpy.py")]
    return [path]


def bpy_pythons() -> list[str]:
    """Pythons with a bpy wheel: ISOPHOTE_BPY_PYTHONS, separated by colons, else those that the Makefile creates.

    They need not exist, so that the order tells which Blender is meant: 4.5, then 5.0.
    """
    named = os.environ.get("ISOPHOTE_BPY_PYTHONS")
    return named.split(":") if named else [str(ROOT / venv / "bin" / "python") for venv in (".venv", ".venv-bpy50")]
