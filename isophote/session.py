"""A render from scene to film: prepare once, then step by step until the samples, the time or the user say stop."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from isophote.adaptive import PILOT, next_limits
from isophote.confidence import Claim, claim_of, samples_for
from isophote.cryptomatte import metadata, names_of
from isophote.device import Device, DeviceError, SceneTooLarge, open_device
from isophote.film import Film, FilmError
from isophote.handover import with_cpu_meanwhile
from isophote.ledger import ledger_of
from isophote.mattes import UNITS
from isophote.memory import check_host_memory
from isophote.passes import check_passes, film_planes
from isophote.planes import RECORDS
from isophote.records import feature_names
from isophote.scene import Scene, SceneError
from isophote.schedule import (
    BLOCK,
    ITEM_SECONDS,
    Region,
    WorkItem,
    choose_blocks,
    choose_step,
    is_decision,
    next_decision,
    next_samples,
)
from isophote.settings import Settings
from isophote.statistics import Luminance, luminance_of
from isophote.validate import check

if TYPE_CHECKING:
    from isophote.geometry import Geometry

ERROR_SHARE = 0.05  # of the render's time that may go into estimating its error


@dataclass(frozen=True)
class Progress:
    """Where a render stands.

    `error` is the picture's relative error (statistics.image_error), `error_95` the one within which 95 % of its
    pixels are (confidence.py), None while unknown; `error_target` is what is wanted of that, 0 for nothing.
    `why_stopped` is "" while it goes on, then "samples", "time", "error" (the wanted one is reached) or
    "cancelled". `seconds` counts from the first step, set-up left out; `remaining` is an estimate, None
    before the first sample; `samples_per_second` counts camera paths: samples times pixels. Where pixels have different
    numbers of samples, `samples_done` is the mean and `most_samples` the largest.
    """

    samples_done: int
    samples_total: int
    seconds: float
    remaining: float | None
    error: float | None
    error_95: float | None
    error_target: float
    samples_per_second: float
    why_stopped: str
    most_samples: int


class Session:
    """One render. `film` holds whatever was rendered, also after an error or a cancel.

    A `film` given is rendered on from where it ends: settings.samples count from its first sample.
    A `device` given is used and not opened; the session closes it either way, unless it is told to leave it.
    `kept` is the geometry of another session (its `prepared.geometry`): what the scenes have in common is used
    again, without changing a bit. Of the scene nothing is held but what is rendered.
    Raises SceneError for a scene that cannot be rendered, SceneTooLarge for one that does not fit, DeviceError
    for a device that cannot be opened, FilmError for a film of another region or kind, ValueError for settings
    that do not fit.
    """

    def __init__(self, scene: Scene, settings: Settings, device: Device | None = None, film: Film | None = None,
                 kept: Geometry | None = None):
        started = time.perf_counter()
        self.settings, self.device = settings, device
        self._cancel = threading.Event()
        self._started: float | None = None
        self._seconds = 0.0
        self._paths_by_device: dict[str, int] = {}  # of this session, without those of a film that it was given
        self._lately = (0.0, 0.0)  # seconds and paths of the last items
        self._room = np.zeros(0, np.float32)  # for the sums of blocks: new memory costs more than they do
        self._leaves = False
        self._claim, self._claim_due, self._claim_at = Claim(None, None, None), 0.0, -1
        self._seen: Luminance | None = None  # what the last claim saw, until the next item
        self._looks: list[tuple[int, float]] = []  # samples and error_95 where the render might have stopped
        self.why_stopped = ""
        self._scene: Scene | None = scene  # until it is hashed
        self._hashing: Future | None = None
        problems, cleaned, dropped = check(scene)
        errors = [str(problem) for problem in problems if problem.severity == "error"]
        if errors:
            raise SceneError("; ".join(errors))
        self.region = checked_region(scene, settings)
        check_passes(settings.passes)
        if settings.named not in ((), scene.named):
            raise ValueError(f"passes {', '.join(settings.named)} of a scene that has "
                             f"{', '.join(scene.named) or 'none'}")
        planes = film_planes(settings)
        self.film = film or Film(self.region, planes)
        if self.film.region != self.region or self.film.planes != planes:
            raise FilmError(f"the film is of region {self.film.region} with {self.film.planes}; "
                            f"the render needs {self.region} with {planes}")
        warnings = [{"kind": "scene", "name": problem.thing, "what": problem.what}
                    for problem in problems if problem.severity == "warning"]
        self._notes: list[dict] = list(scene.notes) + dropped + warnings
        if "uv" in settings.passes and not len(scene.uv_attribute):
            self._notes.append({"kind": "pass", "name": "UV", "what": "black: the view layer has its switch off"})
        self._matte_names = {kind: names_of(scene, kind) for kind in planes.mattes}
        if planes.mattes and not scene.material_matte.any():
            self._notes.append({"kind": "pass", "name": "Cryptomatte", "what": "empty: the view layer has its switches "
                                                                               "off"})
        check_host_memory(len(cleaned.triangles), self.film.open.size)
        if self.device is None:
            self.device = open_device(settings.device, settings)
        self.device = with_cpu_meanwhile(self.device, settings)
        from isophote.prepare import prepare  # needs the native module, which a scene with errors should not

        self.prepared = prepare(cleaned, kept)
        self._notes += self.prepared.notes
        self.build_seconds = self.prepared.build_seconds
        try:
            self.device.upload(self.prepared)
        except SceneTooLarge:
            self.device.close()
            raise
        except DeviceError as error:
            self.fall_back(error)
        self.prepared.geometry.settle(keep_bvh2=self.device.kind != "openmp")
        self.setup_seconds = time.perf_counter() - started - self.build_seconds - self.device.compile_seconds

    @property
    def notes(self) -> list[dict]:
        """What the picture lacks or the user should know, of the scene and of the devices."""
        return [*self._notes, *self.device.notes, *lost_mattes(self.film)]

    def cancel(self) -> None:
        """Stop soon, from any thread; the whole samples that are done stay in the film."""
        self._cancel.set()

    def cancelled(self) -> bool:
        """What devices ask: the user's cancel, or the end of the time once there is a sample to show."""
        limit = self.settings.time_limit
        late = limit > 0.0 and self.film.samples > 0 and self.elapsed() >= limit
        return late or self._cancel.is_set()

    def elapsed(self) -> float:
        return 0.0 if self._started is None else time.perf_counter() - self._started

    def step(self) -> Progress:
        """Render the next item into the film. Raises DeviceError where the CPU fails too; the film stays good."""
        if self._started is None:
            self._started = time.perf_counter()
        if not self.why_stopped:
            self.why_stopped = self.reason_to_stop()
        if not self.why_stopped:
            self.render_item()
            self.why_stopped = self.reason_to_stop()
            self._seconds = self.elapsed()
        return self.progress()

    def run(self, callback: Callable[[Progress], None] | None = None) -> Progress:
        """Step to the end, calling back after each step."""
        while True:
            progress = self.step()
            if callback:
                callback(progress)
            if progress.why_stopped:
                return progress

    @property
    def scene_hash(self) -> str:
        """The scene's content hash."""
        self.hash_scene()
        return self._hashing.result()

    def hash_scene(self) -> None:
        """Hash the scene and let go of it, in a thread of its own: nobody waits for that."""
        if self._hashing is None:
            pool, scene = ThreadPoolExecutor(1, "isophote-hash"), self._scene
            self._hashing, self._scene = pool.submit(lambda: scene.content_hash), None
            pool.shutdown(wait=False)

    @property
    def end(self) -> int:
        return int(np.max(self.film.first)) + self.settings.samples

    @property
    def own_samples(self) -> float:
        """Samples a pixel that this session rendered."""
        return sum(self._paths_by_device.values()) / self.film.pixels

    def reason_to_stop(self) -> str:
        if self.error_reached():
            return "error"
        if self.is_complete():
            return "samples"
        if self._cancel.is_set():
            return "cancelled"
        return "time" if self.cancelled() else ""

    def is_complete(self) -> bool:
        """Whether every pixel has all samples, of which there are whole blocks where pixels have different numbers."""
        if self.film.ends is None:
            return self.film.end >= self.end
        return bool((self.film.ends >= self.end // BLOCK * BLOCK).all())

    def error_reached(self) -> bool:
        """Whether the film has the wanted error; decided at fixed numbers of samples (schedule.next_decision), with
        adaptive sampling whenever what was decided last is done."""
        film, target, samples = self.film, self.settings.error_target, self.film.samples
        if not (target > 0.0 and (film.settled if film.ends is not None else is_decision(samples))):
            return False
        most = self.claim(fresh=True).most
        if most and (not self._looks or self._looks[-1][0] < samples):
            self._looks.append((samples, most.value))
        return most is not None and most.value <= target

    def goes_adaptive(self) -> bool:
        """Whether it is time for a film whose pixels have the same samples to leave that."""
        settings, film = self.settings, self.film
        return (settings.adaptive and settings.error_target > 0.0 and settings.samples >= PILOT + BLOCK
                and film.samples >= PILOT and film.open_samples == 0)

    def next_item(self) -> WorkItem:
        film, most = self.film, self.end // BLOCK * BLOCK
        if film.ends is not None and film.settled or film.ends is None and self.goes_adaptive():
            adaptive = self.settings.adaptive and self.settings.error_target > 0.0
            seen = self._seen if self._claim_at == film.paths else None
            film.allow(next_limits(film, self.settings.error_target, most, seen) if adaptive else
                       np.full(film.shape, most))
        self._seen = None
        left = self.settings.time_limit - self.elapsed() if self.settings.time_limit > 0.0 else ITEM_SECONDS
        seconds = min(ITEM_SECONDS, max(0.0, left))
        if film.ends is not None:
            return film.next_blocks(choose_blocks(BLOCK * self.path_seconds, seconds))
        step, end = choose_step(film.pixels * self.path_seconds, seconds), self.end
        if self.settings.error_target > 0.0:
            end = min(end, film.first + next_decision(film.samples))
        return WorkItem(self.region, film.end, next_samples(film.first, film.end, end, step))

    def render_item(self) -> None:
        film, item = self.film, self.next_item()
        blocks = item.pixels is not None
        sums = self.sums_of_blocks(len(item.pixels)) if blocks else film.open
        before = time.perf_counter()
        try:
            added = self.device.render(item, self.settings, sums, self.cancelled)
            if not 0 <= added <= item.samples or not (added or self.cancelled()):
                raise DeviceError(f"{self.device.name} gave {added} of {item.samples} samples without being cancelled")
        except DeviceError as error:
            self.fall_back(error)
            return
        if blocks and added < BLOCK:
            added = 0  # a block is there whole or not at all
        if added:
            self.note_speed(time.perf_counter() - before, added * sums[0].size)
        if not blocks:
            film.add_samples(added, self.device.ended if added else 0)
        elif added:
            film.add_blocks(sums, self.device.ended)
        self.hash_scene()

    def sums_of_blocks(self, count: int) -> np.ndarray:
        """Zeros for an item of so many blocks, float32 (planes, 1, count), in memory that is used again."""
        size = int(self.film.planes) * count
        if size > len(self._room):
            self._room = np.empty(size, np.float32)
        self._room[:size] = 0.0
        return self._room[:size].reshape(-1, 1, count)

    def note_speed(self, seconds: float, paths: int) -> None:
        """Note an item. It counts twice as much as the one before, and small ones count little."""
        self._lately = self._lately[0] / 2.0 + seconds, self._lately[1] / 2.0 + paths
        drawn = self._paths_by_device
        drawn[self.device.name] = drawn.get(self.device.name, 0) + paths

    @property
    def path_seconds(self) -> float:
        """Time that the device takes for a path; 0 while nobody knows."""
        return self._lately[0] / self._lately[1] if self._lately[1] else 0.0

    def fall_back(self, error: DeviceError) -> None:
        """Go on on the CPU with the same film, and say so. Raises the error where it is the CPU that failed."""
        failed = self.device
        if failed.kind == "openmp":
            raise error
        what = f"failed after {self.film.samples} samples, the render went on on the CPU: {error}"
        self._notes += [*failed.notes, {"kind": "device", "name": failed.name, "what": what}]
        try:
            failed.close()
        except DeviceError as closing:
            self._notes.append({"kind": "device", "name": failed.name, "what": f"could not be closed: {closing}"})
        self.settings = replace(self.settings, device="openmp")
        self.device = open_device("openmp", self.settings)
        self.device.upload(self.prepared)
        self._lately = (0.0, 0.0)

    def claim(self, fresh: bool = False) -> Claim:
        """What is known of the error; estimated anew where `fresh`, else when that costs little of the time."""
        now = time.perf_counter()
        if self._claim_at != self.film.paths and (fresh or now >= self._claim_due):
            self._seen, self._claim_at = luminance_of(self.film), self.film.paths
            self._claim = claim_of(self.film, self._seen)
            cost = time.perf_counter() - now
            self._claim_due = now + cost / ERROR_SHARE
        return self._claim

    def progress(self) -> Progress:
        claim = self.claim(fresh=bool(self.why_stopped))
        return Progress(self.film.samples, self.settings.samples, self._seconds, self.remaining(),
                        claim.mean.value if claim.mean else None, claim.most.value if claim.most else None,
                        self.settings.error_target, self.samples_per_second(), self.why_stopped,
                        self.film.most_samples)

    def remaining(self) -> float | None:
        """Seconds to the end of the samples, of the time or to the wanted error, whichever comes first; or None."""
        if self.why_stopped:
            return 0.0
        left = [self.settings.time_limit - self.elapsed()] if self.settings.time_limit > 0.0 else []
        if self._paths_by_device:
            samples = self.settings.samples
            if self.settings.error_target > 0.0:
                samples = min(samples, samples_for(self.settings.error_target, self._looks) or samples)
            left.append((samples - self.film.samples) * self._seconds / self.own_samples)
        return max(0.0, min(left)) if left else None

    def samples_per_second(self) -> float:
        return sum(self._paths_by_device.values()) / self._seconds if self._seconds > 0.0 else 0.0

    def result(self) -> dict:
        """What `isophote render --json` prints. `strict` is True or the reason why the bits are not strict's."""
        claim = self.claim(fresh=True)
        precision = self.settings.precision
        height, width = self.film.shape
        return {
            "device": self.device.name,
            "driver": self.device.driver,
            "width": width,
            "height": height,
            "samples": self.film.samples,
            "most_samples": self.film.most_samples,
            "samples_by_device": {name: paths // self.film.pixels for name, paths in self._paths_by_device.items()},
            "setup_seconds": self.setup_seconds,
            "build_seconds": self.build_seconds,
            "compile_seconds": self.device.compile_seconds,
            "kernels_from": self.device.kernels_from,
            "features": feature_names(self.prepared.features),
            "memory": dict(self.device.memory),
            "render_seconds": self._seconds,
            "samples_per_second": self.samples_per_second(),
            "error": claim.mean.value if claim.mean else None,
            "error_interval": [claim.mean.low, claim.mean.high] if claim.mean else None,
            "error_95": claim.most.value if claim.most else None,
            "error_95_interval": [claim.most.low, claim.most.high] if claim.most else None,
            "error_target": self.settings.error_target,
            "unsure": claim.unsure,
            "why_stopped": self.why_stopped,
            "precision": precision,
            "strict": self.device.strict if precision == "strict" else f"precision is {precision}",
            "seed": self.settings.seed,
            "scene_hash": self.scene_hash,
            "ledger": ledger_of(self.film, self.settings, self.notes) if self.film.samples else [],
            "notes": self.notes,
        }

    def matte_metadata(self, layer: str) -> dict[str, str]:
        """What a file's header says of the mattes, of a layer of this name."""
        return {field: text for kind, names in self._matte_names.items()
                for field, text in metadata(layer, kind, names).items()}

    def leave(self) -> Device | None:
        """The device with the scene on it, for another session; None where there is nothing worth keeping."""
        left, self._leaves = self.device.leave(), True
        return left

    def close(self) -> None:
        """Close the device, unless it was left. The film stays."""
        if not self._leaves:
            self.device.close()

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_) -> None:
        self.close()


def lost_mattes(film: Film) -> list[dict]:
    """A note where mattes lack ids."""
    lost = film.all_mattes().lost / (UNITS * film.paths) if film.planes.mattes and film.paths else 0.0
    what = (f"ids of {100.0 * lost:.2g} % of the picture are missing: more than {film.planes.matte_rows} met in "
            f"{BLOCK} samples of a pixel, or more than {RECORDS} along a ray")
    return [{"kind": "pass", "name": "Cryptomatte", "what": what}] if lost else []


def checked_region(scene: Scene, settings: Settings) -> Region:
    """The region to render, the full frame by default. Raises ValueError where it is not inside the frame."""
    width, height = (int(n) for n in scene.resolution)
    x0, y0, x1, y1 = settings.region or (0, 0, width, height)
    if not (0 <= x0 < x1 <= width and 0 <= y0 < y1 <= height):
        raise ValueError(f"region {settings.region} does not lie in the frame of {width}x{height} pixels")
    return x0, y0, x1, y1
