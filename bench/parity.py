"""The same bits everywhere: renders scenes on every device, number of threads and split of the samples, and counts
the floats that differ.

    python -m bench.parity scenes/*.npz --devices openmp,opencl:0 --size 64x64 --samples 64 --splits 1,3,16

prints one JSON row for each scene and variant, then a verdict; the exit status is 1 if a float differs.
tests/parity compares with the functions of this file.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from bench.common import print_row
from isophote.device import DeviceError, open_device
from isophote.film import Film, load_film, merge
from isophote.passes import PASSES, film_planes, make_passes
from isophote.prepare import Prepared, prepare
from isophote.scene import Scene, load_scene, resized
from isophote.schedule import BLOCK, WorkItem, split
from isophote.settings import Settings
from isophote.validate import clean

EVERY_PASS = tuple(PASSES)


# ------------------------------------------------------------------ rendering in parts


def expose(device, film: Film, end: int, settings: Settings, step: int = BLOCK) -> Film:
    """Render a film on to sample `end`, in items of at most `step` samples."""
    while film.end < end:
        count = min(step, BLOCK - film.end % BLOCK, end - film.end)
        added = device.render(WorkItem(film.region, film.end, count), settings, film.open, lambda: False)
        if added != count:
            raise DeviceError(f"{device.name} gave {added} of {count} samples")
        film.add_samples(count, device.ended)
    return film


def full_frame(scene: Scene) -> tuple[int, int, int, int]:
    return 0, 0, int(scene.resolution[0]), int(scene.resolution[1])


def render_in_parts(device, region, settings: Settings, parts: int = 1, step: int = BLOCK) -> Film:
    """settings.samples in `parts` films, merged; the parts are rendered last to first, as other machines might."""
    films = [expose(device, Film(region, film_planes(settings), first), end, settings, step)
             for first, end in reversed(split(settings.samples, parts))]
    return merge(films)


def render_with_break(device, scene: Scene, settings: Settings, cut: int) -> Film:
    """As render_in_parts, but saved after `cut` samples and resumed from the file."""
    film = expose(device, Film(full_frame(scene), film_planes(settings)), cut, settings)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.npz"
        film.save(path, scene.content_hash, settings.fingerprint())
        film = load_film(path, scene.content_hash, settings.fingerprint())
    return expose(device, film, settings.samples, settings)


def opened(spec: str, settings: Settings, prepared: Prepared):
    """A device that holds the scene. Raises DeviceError."""
    device = open_device(spec, settings)
    device.upload(prepared)
    return device


# ------------------------------------------------------------------ comparing


def differing_floats(a: np.ndarray, b: np.ndarray) -> int:
    """Values whose bits differ; every NaN equals itself only bit for bit, and 0.0 differs from -0.0."""
    if a.shape != b.shape or a.dtype != b.dtype:
        raise ValueError(f"{a.dtype} {a.shape} against {b.dtype} {b.shape}")
    word = {4: np.uint32, 8: np.uint64}[a.dtype.itemsize]
    return int(np.count_nonzero(np.ascontiguousarray(a).view(word) != np.ascontiguousarray(b).view(word)))


def differences(film: Film, other: Film, passes: tuple[str, ...] = EVERY_PASS) -> dict[str, int]:
    """Differing floats of each pass, and of the film's sums as "sums"."""
    mine, others = (make_passes(f, passes) for f in (film, other))
    counts = {name: differing_floats(mine[name], others[name]) for name in mine}
    counts["sums"] = sum(differing_floats(film.sum(plane), other.sum(plane)) for plane in range(film.planes.sums))
    mattes = zip(film.all_mattes().of.values(), other.all_mattes().of.values(), strict=True)
    counts["mattes"] = sum(not (np.array_equal(a.keys, b.keys) and np.array_equal(a.units, b.units)) for a, b in mattes)
    return counts


# ------------------------------------------------------------------ the program


def variants(devices: list[str], threads: list[int], splits: list[int]) -> Iterable[dict]:
    """What is compared with the first: on the CPU every number of threads and every split, elsewhere every split;
    and on each device a render that was interrupted and resumed."""
    for device in devices:
        for count in threads if device == "openmp" else [0]:
            for parts in splits if device != "openmp" or count == threads[0] else [1]:
                yield {"device": device, "threads": count, "split": parts, "resumed": False}
        yield {"device": device, "threads": threads[-1] if device == "openmp" else 0, "split": 1, "resumed": True}


def render_variant(scene: Scene, prepared: Prepared, settings: Settings, variant: dict) -> tuple[Film, dict]:
    """The film, and what the row says about the device."""
    settings = replace(settings, device=variant["device"], threads=variant["threads"])
    started = time.perf_counter()
    device = opened(variant["device"], settings, prepared)
    try:
        if variant["resumed"]:
            film = render_with_break(device, scene, settings, settings.samples * 2 // 3)
        else:
            film = render_in_parts(device, full_frame(scene), settings, variant["split"])
        return film, {"name": device.name, "driver": device.driver, "strict": device.strict,
                      "seconds": round(time.perf_counter() - started, 3)}
    finally:
        device.close()


def compare_scene(path: Path, arguments, settings: Settings) -> int:
    """Print the rows of one scene; returns how many floats differ."""
    scene = load_scene(path)
    if arguments.size:
        scene = resized(scene, arguments.size)
    prepared = prepare(clean(scene)[0])
    first, total = None, 0
    for variant in variants(arguments.devices, arguments.threads, arguments.splits):
        film, device = render_variant(scene, prepared, settings, variant)
        first = first or film
        counts = differences(first, film)
        total += sum(counts.values())
        print_row({"scene": path.stem, **variant, **device, "samples": film.samples, "floats": film.open.size,
                   "differing": counts, "equal": not any(counts.values())})
    return total


def parsed(argv=None):
    def listed(kind):
        return lambda text: [kind(part) for part in text.split(",")]

    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("scenes", nargs="+", type=Path, help=".npz scenes")
    parser.add_argument("--devices", type=listed(str), default=["openmp", "opencl"])
    parser.add_argument("--size", type=lambda text: tuple(map(int, text.split("x"))), help="WxH; else the scene")
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--splits", type=listed(int), default=[1, 3, 16], help="cut at borders of blocks")
    parser.add_argument("--threads", type=listed(int), default=[1, 2, 7])
    parser.add_argument("--seed", type=int, default=0)
    return parser.parse_args(argv)


def main(argv=None) -> int:
    arguments = parsed(argv)
    settings = Settings(samples=arguments.samples, seed=arguments.seed, passes=EVERY_PASS)
    total = sum(compare_scene(path, arguments, settings) for path in arguments.scenes)
    print_row({"verdict": "the same bits" if total == 0 else "bits differ", "differing": total,
               "scenes": len(arguments.scenes)})
    return 1 if total else 0


if __name__ == "__main__":
    sys.exit(main())
