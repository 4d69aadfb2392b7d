"""What fast precision does to the picture: pairs of renders, fast and strict, with the same seeds.

    python -m bench.fast_bias FILE.npz ... [--rare] [--size 64] [--samples 256] [--pairs 16] [--device openmp]

An equivalence test (isophote/bias.py): fast counts as equivalent where the 95 % interval of the relative difference
of the pictures' means lies within 0.05 %, and that of each tile of 8 x 8 pixels within 0.5 %. Paths that turn
otherwise at an edge make the difference noisy, so both need enough samples to be shown: `image` is "within",
"beyond" (the interval lies outside) or "undecided".

`bias` is the difference of the means (fast less strict) in per cent, `low` and `high` the ends of its interval;
`tiles` the share of tiles whose interval lies within 0.5 %, `worst_tile` the largest end of one, in per cent,
`tiles_beyond` the share of tiles whose interval lies outside; `rel_mse` how far the two pictures of a pair are apart,
`noise` how far a strict picture is from the truth, from its replicates. Prints a row of JSON a scene.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from bench.common import print_row
from bench.coverage import scene_of
from isophote.bias import IMAGE_BOUND, TILE_BOUND, effect_of, half_interval, luminance_of_film, renderer, worst_tile
from isophote.confidence import FLOOR
from isophote.scene import Scene
from isophote.settings import Settings
from isophote.statistics import LUMINANCE, sums_over_tiles, variance_of_mean, weighted_sums


def relative_square(difference: np.ndarray, reference: np.ndarray) -> float:
    """Mean of (difference / reference)^2; pixels darker than FLOOR of the picture are measured by that."""
    return float(((difference / np.maximum(reference, FLOOR * reference.mean())) ** 2).mean())


def verdict(low: float, high: float, bound: float) -> str:
    if -bound <= low and high <= bound:
        return "within"
    return "beyond" if low > bound or high < -bound else "undecided"


def bias_row(scene: Scene, settings: Settings, pairs: int) -> dict:
    """The row of one scene."""
    with renderer(scene, settings) as renders:
        films = [(renders.film(seed, precision="fast"), renders.film(seed, precision="strict"))
                 for seed in range(1, pairs + 1)]
    found = [tuple(luminance_of_film(film) for film in pair) for pair in films]
    effect = effect_of(found)
    fast, strict = (np.stack([pair[k] for pair in found]) for k in (0, 1))
    reference = strict.mean(axis=0)
    noise = np.mean([variance_of_mean(weighted_sums(film, LUMINANCE), film.replicate_samples) for _, film in films], 0)
    worst, share = worst_tile(found)
    of_tiles = [np.stack([sums_over_tiles(image) for image in images]) for images in (fast, strict)]
    off, half = (of_tiles[0] - of_tiles[1]).mean(axis=0), half_interval(of_tiles[0] - of_tiles[1])
    floor = np.maximum(of_tiles[1].mean(axis=0), FLOOR * of_tiles[1].mean())
    return {"pairs": pairs, "samples": settings.samples, "bias": -100.0 * effect.removed,
            "low": -100.0 * effect.high, "high": -100.0 * effect.low,
            "image": verdict(-effect.high, -effect.low, IMAGE_BOUND), "tiles": share, "worst_tile": 100.0 * worst,
            "tiles_beyond": float((np.abs(off) - half > TILE_BOUND * floor).mean()),
            "rel_mse": float(np.mean([relative_square(a - b, reference) for a, b in found])),
            "noise": float((noise / np.maximum(reference, FLOOR * reference.mean()) ** 2).mean())}


def main() -> None:
    parser = argparse.ArgumentParser(prog="bench.fast_bias", description=__doc__.split("\n")[0])
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--rare", action="store_true", help="also the scenes of tests/rare_scenes.py")
    parser.add_argument("--size", type=int, default=64, help="longer side in pixels")
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--pairs", type=int, default=16)
    parser.add_argument("--device", default="openmp")
    options = parser.parse_args()
    scenes = {path.stem: lambda path=path: scene_of(path, options.size) for path in options.files}
    if options.rare:
        from tests.rare_scenes import SCENES

        scenes |= SCENES
    settings = Settings(samples=options.samples, device=options.device, wait_for_kernels=True)
    for name, make in scenes.items():
        print_row({"scene": name, "device": options.device, **bias_row(make(), settings, options.pairs)})


if __name__ == "__main__":
    main()
