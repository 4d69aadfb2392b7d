# SPDX-License-Identifier: Apache-2.0
"""Builds dist/: the extension for Blender 4.2 and newer, and the add-on for 3.4 to 4.1.

The native module is built for each Python found here that some Blender has; what the package needs
beside numpy is bundled as wheels (4.2 installs them) or unpacked (3.4 gets them in `vendor`).
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tomllib
import zipfile
from importlib.util import find_spec
from pathlib import Path

from blender_run import ADDON, MODULES, ROOT

BUILD = ROOT / "build" / "extension"
WHEELS = BUILD / "wheels"
DIST = ROOT / "dist"
BLENDER_PYTHONS = ("3.11", "3.13")  # of Blender 4.1 to 5.0 (and Debian's 3.4), and of 5.1 and newer
MANYLINUX = ("manylinux_2_28_x86_64", "manylinux_2_17_x86_64", "manylinux2014_x86_64")
NOT_PACKED = shutil.ignore_patterns("__pycache__", "*.pyc", "scripts")


def main() -> int:
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    check_versions(version)
    shutil.rmtree(BUILD, ignore_errors=True)
    WHEELS.mkdir(parents=True)
    DIST.mkdir(exist_ok=True)
    built = [python for python in BLENDER_PYTHONS if build_wheel(python)]
    if not built:
        print(f"No Python of {', '.join(BLENDER_PYTHONS)} could build the native module", file=sys.stderr)
        return 1
    for python in built:
        download_wheels(python)
    for zip_path in (pack_extension(version), pack_legacy(version)):
        print(f"{zip_path.relative_to(ROOT)}  {zip_path.stat().st_size / 1e6:.1f} MB, Python {' and '.join(built)}")
    return 0


def check_versions(version: str) -> None:
    """The version stands in three files; they must agree. Exits naming the one that does not."""
    manifest = tomllib.loads((ROOT / "addon" / "blender_manifest.toml").read_text())["version"]
    numbers = ", ".join(version.split("."))
    if manifest != version:
        sys.exit(f"addon/blender_manifest.toml has version {manifest}, pyproject.toml {version}")
    if f"VERSION = ({numbers})" not in (ROOT / "addon" / "__init__.py").read_text():
        sys.exit(f"addon/__init__.py has another VERSION than pyproject.toml's {version}")


def find_python(version: str) -> str | None:
    """A Python of that version with pip and headers, or None."""
    probe = ("import os, pip, sys, sysconfig; "
             "sys.exit(not os.path.exists(os.path.join(sysconfig.get_path('include'), 'Python.h'))"
             f" or sys.version_info[:2] != ({version.replace('.', ', ')}))")
    pyenv = Path(os.environ.get("PYENV_ROOT") or Path.home() / ".pyenv") / "versions"
    for name in (sys.executable, f"python{version}", *sorted(pyenv.glob(f"{version}.*/bin/python"))):
        path = shutil.which(name)
        if path and subprocess.run([path, "-c", probe], capture_output=True).returncode == 0:
            return path
    return None


def build_wheel(version: str) -> bool:
    """The package's wheel for a version of Python; False where there is no such Python here."""
    python = find_python(version)
    if python is None:
        print(f"No Python {version} with pip and headers here: the zip will not hold a module for it")
        return False
    compiler = subprocess.run([ROOT / "tools" / "compiler.sh"], check=True, stdout=subprocess.PIPE, text=True)
    subprocess.run([python, "-m", "pip", "wheel", "-q", "--no-deps", "-w", str(WHEELS), str(ROOT)],
                   check=True, env={**os.environ, "CXX": compiler.stdout.strip()})
    return True


def download_wheels(version: str) -> None:
    """What the package needs beside numpy, in the versions of requirements.lock."""
    pins = [line.split(";")[0].strip() for line in (ROOT / "requirements.lock").read_text().splitlines()]
    wanted = [pin for pin in pins if pin.split("==")[0] in MODULES]
    platforms = [option for tag in MANYLINUX for option in ("--platform", tag)]
    subprocess.run([sys.executable, "-m", "pip", "download", "-q", "--no-deps", "--only-binary", ":all:", *platforms,
                    "--python-version", version, "-d", str(WHEELS), *wanted], check=True)


def pack_extension(version: str) -> Path:
    """The zip for Blender 4.2 and newer."""
    staged = BUILD / "extension"
    shutil.copytree(ROOT / "addon", staged, ignore=NOT_PACKED)
    shutil.copytree(WHEELS, staged / "wheels")
    with (staged / "blender_manifest.toml").open("a") as manifest:
        manifest.write("\nwheels = [\n")
        manifest.writelines(f'  "./wheels/{wheel.name}",\n' for wheel in sorted(WHEELS.glob("*.whl")))
        manifest.write("]\n")
    target = DIST / f"isophote-{version}-linux-x64.zip"
    pack(staged, target, "")
    validate(target)
    return target


def pack_legacy(version: str) -> Path:
    """The zip for Blender 3.4 to 4.1."""
    staged = BUILD / "legacy"
    shutil.copytree(ROOT / "addon", staged, ignore=NOT_PACKED)
    (staged / "blender_manifest.toml").unlink()
    for wheel in sorted(WHEELS.glob("*.whl")):
        with zipfile.ZipFile(wheel) as content:
            content.extractall(staged / "vendor")
    target = DIST / f"isophote-{version}-linux-x64-blender-3.4.zip"
    pack(staged, target, ADDON)
    return target


def pack(folder: Path, target: Path, prefix: str) -> None:
    """Zip a folder's files in their order, below `prefix`."""
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as content:
        for path in sorted(folder.rglob("*")):
            if path.is_file():
                content.write(path, Path(prefix) / path.relative_to(folder))


def validate(extension: Path) -> None:
    """Let Blender's own tool judge the extension, where the bpy wheel is here. Exits with its message."""
    spec = find_spec("bpy")
    tools = sorted(Path(spec.origin).parent.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py")) if spec else []
    if not tools:
        print("No bpy wheel here: the extension was not validated")
        return
    done = subprocess.run([sys.executable, tools[0], "validate", str(extension)], text=True, capture_output=True)
    if done.returncode != 0:
        sys.exit(f"{extension}: {done.stdout}{done.stderr}")


if __name__ == "__main__":
    sys.exit(main())
