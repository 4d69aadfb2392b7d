"""Runs: renders of one choice with one seed, each kept in a file, so that a report can be interrupted and continued.

One run gives pictures at several numbers of samples, because the first k samples of a longer render are the render
of k samples. Its seconds are those of rendering, counted from the first sample; set-up stands apart.

A file is named by choice and seed and holds a key: a hash of scene, size, settings and counts. A file whose key
is another's is not used.
"""

from __future__ import annotations

import hashlib
import json
import time
import zipfile
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from isophote.device import DeviceError
from isophote.files import replacing
from isophote.passes import PASSES
from isophote.scene import Scene
from isophote.session import Session
from isophote.settings import Settings
from isophote.trade.grid import Choice

FORMAT = 1
KEPT = ("device", "driver", "strict", "error_95", "unsure", "features", "notes", "ledger")  # of Session.result()


class TradeError(RuntimeError):
    """A report that cannot be made or continued; the message names the thing."""


class Cancelled(Exception):
    """The user stopped the report; what was done is kept."""


@dataclass(frozen=True)
class Run:
    """`pictures`: linear RGB, float32 (S, h, w, 3), rows from the bottom, at `counts` (S) samples a pixel (their
    mean over the picture) after `seconds` (S) of rendering. `setup` and `wall`: seconds before, and in all.
    `info`: what the session said of it (KEPT)."""

    pictures: np.ndarray
    counts: np.ndarray
    seconds: np.ndarray
    setup: float
    wall: float
    info: dict = field(default_factory=dict)


class Renderer:
    """Renders runs of one scene. Geometry and OpenCL devices are kept from run to run, one for each kind of device."""

    def __init__(self, scene: Scene, cancelled: Callable[[], bool] = lambda: False):
        self.scene, self.cancelled = scene, cancelled
        self.scene_hash = scene.content_hash
        self.left: dict[tuple, tuple] = {}

    def render(self, settings: Settings, seed: int, counts: list[int]) -> Run:
        """One run. Raises Cancelled, DeviceError where the device fails (nothing falls back), SceneError."""
        started = time.perf_counter()
        kind = settings.device, settings.precision, settings.threads
        device, geometry = self.left.pop(kind, (None, None))
        settings = replace(settings, seed=seed, samples=counts[0])
        if device is not None:
            device.take_up(settings)  # always true: the kind holds all that it asks for
        with Session(self.scene, settings, device, kept=geometry) as session:
            setup = time.perf_counter() - started
            pictures, drawn, seconds = [], [], []
            for count in counts:
                seconds.append(render_to(session, count, self.cancelled) + (seconds[-1] if seconds else 0.0))
                pictures.append(PASSES["combined"].make(session.film)[..., :3])
                drawn.append(float(PASSES["sample_count"].make(session.film).mean(dtype=np.float64)))
            check_device(session, settings)
            result = session.result()
            self.left[kind] = session.leave(), session.prepared.geometry
        return Run(np.stack(pictures), np.array(drawn), np.array(seconds), setup, time.perf_counter() - started,
                   {name: result[name] for name in KEPT if name in result})

    def close(self) -> None:
        for device, _ in self.left.values():
            if device is not None:
                device.close()
        self.left = {}


def render_to(session: Session, samples: int, cancelled: Callable[[], bool]) -> float:
    """Let a session go on to a number of samples; the seconds that it took. Raises Cancelled."""
    session.settings, session.why_stopped = replace(session.settings, samples=samples), ""
    started = time.perf_counter()
    while not session.why_stopped:
        if cancelled():
            session.cancel()
            raise Cancelled
        session.step()
    return time.perf_counter() - started


def check_device(session: Session, settings: Settings) -> None:
    """A session goes on on the CPU where a device fails: here that would be timed as the device's. Raises."""
    if session.settings.device != settings.device:
        failed = [note for note in session.notes if note.get("kind") == "device"]
        raise DeviceError(f"{failed[-1]['name']}: {failed[-1]['what']}" if failed else f"{settings.device} failed")


def run_key(scene_hash: str, settings: Settings, seed: int, counts: list[int]) -> str:
    """What a run's bits and time depend on."""
    chosen = {name: value for name, value in asdict(settings).items() if name not in ("samples", "seed")}
    text = json.dumps([FORMAT, scene_hash, chosen, seed, list(counts)], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


@dataclass(frozen=True)
class Store:
    """The folder of a report's runs."""

    folder: Path
    scene_hash: str

    def path(self, choice: Choice, seed: int) -> Path:
        return self.folder / f"{choice.key.replace(':', '_')}.{seed}.npz"

    def save(self, choice: Choice, seed: int, counts: list[int], run: Run) -> None:
        head = {"key": run_key(self.scene_hash, choice.settings, seed, counts), "setup": run.setup, "wall": run.wall,
                "info": run.info}
        try:
            with replacing(self.path(choice, seed)) as temporary, open(temporary, "wb") as file:
                np.savez(file, head=np.array(json.dumps(head, default=str)), pictures=run.pictures, counts=run.counts,
                         seconds=run.seconds)
        except OSError as error:
            raise TradeError(f"{self.path(choice, seed)}: cannot be written: {error.strerror}") from error

    def load(self, choice: Choice, seed: int, counts: list[int]) -> Run | None:
        """The run, None where there is none that fits. A damaged file counts as none: it is rendered anew."""
        try:
            with np.load(self.path(choice, seed), allow_pickle=False) as data:
                head = json.loads(str(data["head"]))
                if head["key"] != run_key(self.scene_hash, choice.settings, seed, counts):
                    return None
                return Run(data["pictures"], data["counts"], data["seconds"], head["setup"], head["wall"], head["info"])
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
            return None
