"""What `isophote ledger` does: measure what the settings of a scene cost, on a small picture of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from rich.console import Console

from isophote.bias import measured_ledger
from isophote.render_command import Job, open_scene, with_file_settings
from isophote.scene import Scene, SceneError, resized
from isophote.settings import Settings
from isophote.validate import check

SIDE = 192  # pixels of the longer side, unless a size is asked for: the share of light needs no resolution
SAMPLES, PAIRS = 64, 8


@dataclass(frozen=True)
class Measurement:
    """One call of `isophote ledger`; size None stands for SIDE. `given` as in Job."""

    scene: Path
    settings: Settings
    given: frozenset[str]
    pairs: int = PAIRS
    frame: int | None = None
    size: tuple[int, int] | None = None
    blender: str | None = None


def small(scene: Scene) -> Scene:
    """The scene with a longer side of at most SIDE pixels."""
    width, height = (int(n) for n in scene.resolution)
    scale = min(1.0, SIDE / max(width, height))
    return resized(scene, (max(1, round(width * scale)), max(1, round(height * scale))))


def measure_job(wanted: Measurement, console: Console) -> dict:
    """The ledger and what it was measured with. Raises SceneError, DeviceError, BlenderError."""
    scene, _ = open_scene(wanted.scene, wanted.frame, wanted.size, wanted.blender, console)
    settings = with_file_settings(Job(wanted.scene, Path(), wanted.settings, wanted.given), scene).settings
    problems, _, dropped = check(scene)
    if errors := [str(problem) for problem in problems if problem.severity == "error"]:
        raise SceneError("; ".join(errors))
    scene = scene if wanted.size else small(scene)
    with console.status("measuring ...") as status:
        entries = measured_ledger(scene, replace(settings, region=None), wanted.pairs, [*scene.notes, *dropped],
                                  lambda what: status.update(f"measuring: {what} ..."))
    width, height = (int(n) for n in scene.resolution)
    return {"width": width, "height": height, "samples": settings.samples, "pairs": wanted.pairs,
            "precision": settings.precision, "ledger": entries}
