"""Many adaptive renders out of a few: blocks of samples are rendered once and put together again in other orders.

    python -m bench.adaptive_replay FILE.npz|NAME ... [--target 10] [--size 72] [--seeds 3] [--blocks 40] [--orders 8]

Each seed's blocks of 64 samples, begun at `orders` places, are as many renders to the wanted error, uniform (decided at
every block) and adaptive, by isophote.adaptive and isophote.confidence as in a session. `samples`, `reached` (measured
error of 95 % of the pixels over the wanted one, against the other seeds) and `decisions` are medians, `fewer` is the
median of the ratio of samples with its extremes, `bias` the mean difference to the mean of all blocks with half its
95 % interval, in per cent of it; `held` the share of sure tiles whose 95 % interval holds the other seeds' value, for
uniform and adaptive. Orders of one seed share samples, so intervals are those of somewhat fewer renders. Prints a row
of JSON for each scene.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from bench.adaptive import half_interval, scene_named
from bench.common import print_row
from bench.coverage import held
from bench.parity import expose
from bench.replicates import mean_and_variance, uploaded
from isophote.adaptive import next_counts
from isophote.confidence import FLOOR, SHARE, error_of_most, relative_errors, tiles_of
from isophote.film import COMBINED_PLANES, Film
from isophote.schedule import BLOCK
from isophote.settings import Settings
from isophote.statistics import LUMINANCE, Luminance, sums_over_tiles, variance_of_mean, weighted_sums


def blocks_of(scene, settings: Settings, count: int, seed: int) -> np.ndarray:
    """Sums of luminance of both replicates in blocks of samples, float64 (count, 2, h, w)."""
    region = (0, 0, *(int(n) for n in scene.resolution))
    with uploaded(scene, settings) as device:
        films = (expose(device, Film(region, COMBINED_PLANES, block * BLOCK), (block + 1) * BLOCK,
                        Settings(seed=seed, samples=BLOCK)) for block in range(count))
        return np.stack([weighted_sums(film, LUMINANCE) for film in films])


def seen_with(sums: np.ndarray, counts: np.ndarray) -> Luminance:
    """The picture of `counts` (h, w) samples; `sums` are those before each block's border."""
    rows, columns = np.indices(counts.shape)
    halves = np.moveaxis(sums[counts // BLOCK, :, rows, columns], -1, 0)
    return Luminance(halves.sum(axis=0) / counts, variance_of_mean(halves, (counts // 2, counts // 2)), (0, 0))


def render(sums: np.ndarray, target: float, adaptive: bool) -> tuple[Luminance, np.ndarray, int] | None:
    """The picture that reaches the wanted error, its samples, and after how many decisions; None where none does."""
    counts, most, decisions = np.full(sums.shape[2:], BLOCK, np.int64), BLOCK * (len(sums) - 1), 0
    while True:
        seen = seen_with(sums, counts)
        if error_of_most(relative_errors(seen, tiles_of(seen))).value <= target:
            return seen, counts, decisions
        if counts.min() >= most:
            return None
        counts = next_counts(seen, counts, target, most) if adaptive else counts + BLOCK
        decisions += 1


def scene_row(blocks: np.ndarray, target: float, orders: int) -> dict:
    """`blocks` are those of blocks_of by seed."""
    seeds, count = blocks.shape[:2]
    pixels, mean = sums_over_tiles(np.ones(blocks.shape[3:])), blocks.sum(axis=(0, 1, 2)) / (seeds * count * BLOCK)
    floor = np.maximum(mean, FLOOR * mean.mean())
    looks: list = [[], []]
    for seed in range(seeds):
        others = np.delete(blocks, seed, axis=0).sum(axis=2).reshape(-1, *mean.shape) / BLOCK
        reference, of_tiles = others.mean(axis=0), mean_and_variance([sums_over_tiles(o) / pixels for o in others])
        for order in range(orders):
            own = np.roll(blocks[seed], order * count // orders, axis=0)
            sums = np.concatenate([np.zeros_like(own[:1]), np.cumsum(own, axis=0)])
            made = [render(sums, target, adaptive) for adaptive in (False, True)]
            for into, (seen, counts, decisions) in zip(looks, made if all(made) else (), strict=all(made)):
                off = np.abs(seen.mean - reference) / floor / np.sqrt(1.0 + counts / (BLOCK * len(others)))
                tiles = tiles_of(seen)
                holds, _, noisy = held(tiles.mean, *tiles.interval(), *of_tiles)
                into.append((counts.mean(), float(np.quantile(off, SHARE)) / target, decisions, counts.max(),
                             seen.mean.mean() - mean.mean(), holds[noisy & ~tiles.unsure]))
    if not looks[0]:
        return {"reached": None}
    uniform, adaptive = (list(zip(*look, strict=True)) for look in looks)
    fewer = np.array(uniform[0]) / np.array(adaptive[0])
    return {"renders": len(fewer), "samples": [float(np.median(kind[0])) for kind in (uniform, adaptive)],
            "most": int(max(adaptive[3])), "decisions": float(np.median(adaptive[2])),
            "fewer": [float(x) for x in (np.median(fewer), fewer.min(), fewer.max())],
            "reached": [float(np.median(kind[1])) for kind in (uniform, adaptive)],
            "reached_adaptive": [min(adaptive[1]), max(adaptive[1])],
            "bias": [100.0 * x / mean.mean() for x in half_interval(np.array(adaptive[4]))],
            "held": [float(np.concatenate(kind[5]).mean()) for kind in (uniform, adaptive)]}


def main() -> None:
    parser = argparse.ArgumentParser(prog="bench.adaptive_replay", description=__doc__.split("\n")[0])
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--target", type=float, default=10.0, help="per cent")
    parser.add_argument("--size", type=int, default=72, help="longer side in pixels")
    parser.add_argument("--away", type=float, default=1.0, help="how many times as much the camera sees")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--blocks", type=int, default=40)
    parser.add_argument("--orders", type=int, default=8)
    parser.add_argument("--device", default="openmp")
    options = parser.parse_args()
    settings = Settings(device=options.device, wait_for_kernels=True)
    for name in options.scenes:
        scene = scene_named(name, options.size, options.away)
        blocks = np.stack([blocks_of(scene, settings, options.blocks, 1 + seed) for seed in range(options.seeds)])
        print_row({"scene": Path(name).stem, "target": options.target / 100.0,
                   **scene_row(blocks, options.target / 100.0, options.orders)})


if __name__ == "__main__":
    main()
