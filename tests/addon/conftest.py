# SPDX-License-Identifier: Apache-2.0
"""Real Blenders for the tests of the add-on: the program, and each Python that has a bpy wheel.

ISOPHOTE_BLENDER names the program (default: `blender` on PATH), ISOPHOTE_BPY_PYTHONS the Pythons
(tools/blender_run.py).
"""

import json
import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import blender_run
import pytest

from tests.conftest import missing

ROOT = blender_run.ROOT
SCENARIOS = Path(__file__).parent / "scenarios"
MARK = "SCENARIO "
HOSTS = ("program", "bpy45", "bpy50")


def host_path(host: str) -> str | None:
    """The program or Python of a host, None where it is missing."""
    if host == "program":
        return os.environ.get("ISOPHOTE_BLENDER") or shutil.which("blender")
    candidates = blender_run.bpy_pythons()
    index = HOSTS.index(host) - 1
    return candidates[index] if index < len(candidates) and Path(candidates[index]).exists() else None


@dataclass
class Host:
    """A Blender that runs scenarios; `folder` is the test's own."""

    path: str
    scripts: Path
    folder: Path

    def command(self, *options: str) -> list[str]:
        """With the add-on of this tree, and Blender's factory settings."""
        return [*blender_run.program(self.path), "-b", "--factory-startup", "--addons", blender_run.ADDON, *options]

    def run(self, *options: str, timeout: float = 120) -> subprocess.CompletedProcess:
        """stdout and stderr are in one text."""
        return subprocess.run(self.command(*options), env=blender_run.environment(self.scripts), text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
                              timeout=timeout, cwd=self.folder)

    def scenario(self, name: str, *arguments: str, timeout: float = 120) -> tuple[dict, str]:
        """What a scenario found (it prints one line of JSON), and the log."""
        done = self.run("--python", str(SCENARIOS / f"{name}.py"), "--", str(self.folder), *arguments,
                        timeout=timeout)
        lines = [line[len(MARK):] for line in done.stdout.splitlines() if line.startswith(MARK)]
        assert lines, f"scenario {name} did not come to its end:\n{done.stdout}"
        return json.loads(lines[-1]), done.stdout


@pytest.fixture(scope="session")
def scripts(tmp_path_factory) -> Path:
    return blender_run.scripts_folder(tmp_path_factory.mktemp("user") / "scripts")


@pytest.fixture(params=HOSTS)
def host(request, scripts, tmp_path) -> Host:
    path = host_path(request.param)
    if path is None:
        missing(f"no Blender for '{request.param}'")
    return Host(path, scripts, tmp_path)


@pytest.fixture
def program(scripts, tmp_path) -> Host:
    """The Blender program, with windows."""
    path = host_path("program")
    if path is None:
        missing("no Blender program")
    return Host(path, scripts, tmp_path)
