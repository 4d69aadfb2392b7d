"""What float32 costs: strict pictures against the same ones in float64 (precision "reference"), sample by sample.

    python -m bench.rounding [FILE.npz ...] [--rare] [--size 32] [--samples 1024]

Both draw the same random numbers, so most samples differ by rounding only. In some a rounding decides otherwise
(another side of an edge, another closure, a lamp just missed): from there on the path is another one, as good as the
first, and the difference is as large as noise is. Such a sample is `turned`: its luminances differ by more than TURN
of the larger one. The picture's difference is the sum of both parts, which are looked at apart:

`rounding`: relMSE of the mean over samples of the differences of those that did not turn; `turns`: the same of those
that did; `noise`: that of the picture itself, from its replicates; `ratio` noise / rounding, `ratio_all` noise /
both together. `turned`: share of the samples. A turn is harmless where it favours no side: `bias` is the mean
difference that turns make, in per cent of the picture, `bias_95` half its 95 % interval (from the spread between
pixels), and `bias_all` that of all samples. Of luminance; relative to the pixel, at least to a tenth of the picture's
mean. Prints a row of JSON a scene.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from bench.common import print_row
from bench.coverage import scene_of
from bench.fast_bias import relative_square
from isophote.bias import renderer
from isophote.confidence import FLOOR
from isophote.film import COMBINED_PLANES
from isophote.scene import Scene
from isophote.schedule import WorkItem
from isophote.settings import Settings
from isophote.statistics import LUMINANCE, Z95

TURN = 1e-2  # relative


def sample_of(device, settings: Settings, region, sample: int) -> np.ndarray:
    """The luminance of one sample of each pixel, float64 (h, w)."""
    x0, y0, x1, y1 = region
    sums = np.zeros((COMBINED_PLANES, y1 - y0, x1 - x0), np.float32)
    device.render(WorkItem(region, sample, 1), settings, sums, lambda: False)
    first = 4 * (sample & 1)
    return np.tensordot(LUMINANCE, sums[first:first + 3].astype(np.float64), 1)


def rounding_row(scene: Scene, samples: int) -> dict:
    """The row of one scene."""
    settings = [Settings(samples=samples, precision=precision, passes=("combined",))
                for precision in ("strict", "reference")]
    with renderer(scene, settings[0]) as renders:
        devices = [renders.device(each) for each in settings]
        shape = renders.region[3] - renders.region[1], renders.region[2] - renders.region[0]
        same, turned, counts, halves = np.zeros(shape), np.zeros(shape), 0, np.zeros((2, *shape))
        for sample in range(samples):
            mine, exact = (sample_of(device, each, renders.region, sample)
                           for device, each in zip(devices, settings, strict=True))
            turns = np.abs(mine - exact) > TURN * np.maximum(mine, exact)
            same += np.where(turns, 0.0, mine - exact)
            turned += np.where(turns, mine - exact, 0.0)
            counts += int(turns.sum())
            halves[sample & 1] += exact
    same, turned, reference = same / samples, turned / samples, halves.sum(axis=0) / samples
    variance = (halves[0] - halves[1]) ** 2 / samples ** 2  # of replicates of equal size: statistics.py
    noise = float((variance / np.maximum(reference, FLOOR * reference.mean()) ** 2).mean())
    parts = [relative_square(part, reference) for part in (same, turned, same + turned)]
    return {"samples": samples, "turned": counts / (samples * same.size), "noise": noise, "rounding": parts[0],
            "turns": parts[1], "ratio": noise / parts[0] if parts[0] else None,
            "ratio_all": noise / parts[2] if parts[2] else None,
            "bias": 100.0 * float(turned.mean() / reference.mean()),
            "bias_95": 100.0 * Z95 * float(turned.std() / np.sqrt(turned.size) / reference.mean()),
            "bias_all": 100.0 * float((same + turned).mean() / reference.mean())}


def main() -> None:
    parser = argparse.ArgumentParser(prog="bench.rounding", description=__doc__.split("\n")[0])
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--rare", action="store_true", help="also the scenes of tests/rare_scenes.py")
    parser.add_argument("--size", type=int, default=32, help="longer side in pixels")
    parser.add_argument("--samples", type=int, default=1024, help="an even number")
    options = parser.parse_args()
    scenes = {path.stem: lambda path=path: scene_of(path, options.size) for path in options.files}
    if options.rare:
        from tests.rare_scenes import SCENES

        scenes |= SCENES
    for name, make in scenes.items():
        print_row({"scene": name, **rounding_row(make(), options.samples)})


if __name__ == "__main__":
    main()
