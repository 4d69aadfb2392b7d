"""What `isophote ledger` does: measure what the settings of a scene cost, on a small picture of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from isophote.bias import PAIRS, checked_ledger, small
from isophote.render_command import Job, open_scene, with_file_settings
from isophote.settings import Settings


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


def measure_job(wanted: Measurement, console: Console) -> dict:
    """The ledger and what it was measured with. Raises SceneError, DeviceError, BlenderError."""
    scene, _ = open_scene(wanted.scene, wanted.frame, wanted.size, wanted.blender, console)
    settings = with_file_settings(Job(wanted.scene, Path(), wanted.settings, wanted.given), scene).settings
    scene = scene if wanted.size else small(scene)
    with console.status("measuring ...") as status:
        entries = checked_ledger(scene, settings, wanted.pairs, lambda what: status.update(f"measuring: {what} ..."))
    width, height = (int(n) for n in scene.resolution)
    return {"width": width, "height": height, "samples": settings.samples, "pairs": wanted.pairs,
            "precision": settings.precision, "ledger": entries}
