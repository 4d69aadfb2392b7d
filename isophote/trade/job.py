"""What a report is asked for, and how it says how far it is."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from isophote.scene import Scene
from isophote.settings import Settings
from isophote.trade.plan import MOST_ROUNDS


@dataclass(frozen=True)
class Job:
    """What a report is of. `base` are the user's settings, `devices` others to try; `seconds` is the time in all.

    `pictures`: png or jpg. `anew`: forget what lies in the folder. `most_rounds` ends a report before its time.
    """

    scene: Scene
    name: str
    full_size: tuple[int, int]
    base: Settings
    folder: Path
    seconds: float
    devices: tuple[str, ...] = ()
    pictures: str = "png"
    anew: bool = False
    most_rounds: int = MOST_ROUNDS


@dataclass(frozen=True)
class Status:
    """Where a report stands: what it does, the seconds spent and those it may spend."""

    doing: str
    spent: float
    seconds: float
