"""What adaptive sampling costs or saves in the time that a user waits, and where that time goes.

    python -m bench.adaptive_time FILE.npz|NAME ... [--device opencl] [--size 512] [--target 3] [--rounds 3]

NAME is a scene of tests/rare_scenes.py. Rounds render each scene to the wanted error, uniform and adaptive in turn,
with one device whose kernels are ready; no round begins after --seconds for a scene. bench/adaptive.py measures what
pictures are worth; here nothing is compared with a reference, so it is quick on a GPU. Needs no Blender.

`seconds` are medians of the wall's, `faster` the median of the rounds' ratios of them, `fewer` that of samples.
`drawing`, `deciding` (claims, limits, lists of pixels) and `adding` (sums) are shares of the seconds, of uniform and of
adaptive renders; what is missing to 1 is progress and other bookkeeping. Prints a row of JSON for each scene.
"""

from __future__ import annotations

import argparse
import time
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from bench.adaptive import MOST, scene_named
from bench.common import print_row
from isophote.device import Device, open_device
from isophote.film import COMBINED_PLANES, Film
from isophote.scene import Scene
from isophote.session import Session
from isophote.settings import Settings

PARTS = ("drawing", "deciding", "adding")


@dataclass
class Clock:
    """Seconds of each of PARTS."""

    spent: dict[str, float] = field(default_factory=lambda: dict.fromkeys(PARTS, 0.0))

    @contextmanager
    def timing(self, part: str):
        before = time.perf_counter()
        yield
        self.spent[part] += time.perf_counter() - before


class TimedFilm(Film):
    clock: Clock

    def add_blocks(self, *given) -> None:
        with self.clock.timing("adding"):
            super().add_blocks(*given)

    def close_block(self) -> None:
        with self.clock.timing("adding"):
            super().close_block()


class TimedDevice:
    """A device whose renders are timed."""

    def __init__(self, device: Device, clock: Clock):
        self.device, self.clock, self.items = device, clock, 0

    def __getattr__(self, name: str):
        return getattr(self.device, name)

    def render(self, *given) -> int:
        self.items += 1
        with self.clock.timing("drawing"):
            return self.device.render(*given)


class TimedSession(Session):
    clock: Clock

    def claim(self, fresh: bool = False):
        with self.clock.timing("deciding"):
            return super().claim(fresh)

    def next_item(self):
        with self.clock.timing("deciding"):
            return super().next_item()


def timed(scene: Scene, settings: Settings, device: Device) -> dict:
    """A render on a device that stays open."""
    clock = Clock()
    film = TimedFilm((0, 0, *(int(n) for n in scene.resolution)), COMBINED_PLANES)
    drawing = TimedDevice(device, clock)
    session = TimedSession(scene, settings, drawing, film)
    film.clock = session.clock = clock
    before = time.perf_counter()
    last = session.run()
    seconds = time.perf_counter() - before
    return {"seconds": seconds, "samples": film.paths / film.pixels, "items": drawing.items,
            "decisions": len(session._looks), "why_stopped": last.why_stopped} | {
            part: spent / seconds for part, spent in clock.spent.items()}


def scene_row(rounds: list[dict[bool, dict]]) -> dict:
    """Of each round's renders, uniform (False) and adaptive (True)."""
    def median(name: str, adaptive: bool) -> float:
        return float(np.median([both[adaptive][name] for both in rounds]))

    def ratio(name: str) -> float:
        return round(float(np.median([both[False][name] / both[True][name] for both in rounds])), 3)

    pairs = {name: [round(median(name, adaptive), 3) for adaptive in (False, True)]
             for name in ("seconds", "samples", "items", "decisions", *PARTS)}
    return {"rounds": len(rounds), "faster": ratio("seconds"), "fewer": ratio("samples"), **pairs,
            "stopped": sorted({one["why_stopped"] for both in rounds for one in both.values()})}


def main() -> None:
    parser = argparse.ArgumentParser(prog="bench.adaptive_time", description=__doc__.split("\n")[0])
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--device", default="opencl")
    parser.add_argument("--size", type=int, default=512, help="longer side in pixels")
    parser.add_argument("--target", type=float, default=3.0, help="per cent")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=40.0, help="for a scene; one round is always done")
    options = parser.parse_args()
    settings = Settings(samples=MOST, error_target=options.target / 100.0, device=options.device,
                        wait_for_kernels=True, passes=("combined",))
    for name in options.scenes:
        scene, device = scene_named(name, options.size, 1.0), open_device(options.device, settings)
        timed(scene, replace(settings, samples=1, error_target=0.0), device)  # compiles
        began, rounds = time.perf_counter(), []
        while len(rounds) < options.rounds and (not rounds or time.perf_counter() - began < options.seconds):
            order = (False, True) if len(rounds) % 2 else (True, False)
            rounds.append({adaptive: timed(scene, replace(settings, adaptive=adaptive), device) for adaptive in order})
        print_row({"scene": Path(name).stem, "device": device.name, "size": options.size, "target": options.target,
                   **scene_row(rounds)})
        device.close()


if __name__ == "__main__":
    main()
