"""Writes the comparison with Cycles as a page: a table of all scenes compared so far, and pictures side by side."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from isophote.images import decode_srgb, encode_srgb, write_image
from isophote.statistics import pool

GAP = 4  # pixels between pictures
AMPLIFIED = 10
BLOCK = 4
HEAD = """# Isophote against Cycles

Made by `python -m bench.cycles_compare --report docs/comparison`; the figures behind it are in `rows.json`.

Each scene is rendered by both engines from the same .blend file with the same bounce limits and pixel
filter, without clamping, filtered glossy, denoising or adaptive sampling: {replicates} times each, with
another seed each time. The scatter of these replicates is the only source of error estimates, for
both engines alike.

What is tested:

- **Means.** The ratio Isophote / Cycles of the whole picture's mean, by channel, with its 95 % interval
  (Welch), and whether that interval lies within 1 ± 0.5 %, beyond it, or across its end (undecided).
- **Tiles.** Means over 8 x 8 pixels, each channel by itself: z = difference / standard error, the error
  from the tile's own replicates, t turned into z. A tile is rejected when its z has, among this many
  tiles, a probability below 1 % (Sidak). "sees" is the smallest error of a single tile that this
  finds, for the tile of median noise.
- **Pixels.** The same for each pixel, with an error bar that is at least the mean of its 8 x 8 neighbours.
- Both pass while at most 0.25 % of the values are rejected and the means of the whole picture agree
  (at 1 %); `isophote.compare.z_test` is the test. Fireflies are not removed anywhere.
- **FLIP** of half of the replicates of each engine, and, as the measure of what noise alone does, of
  Cycles against its own other half.
- **Noise** is the variance of Isophote's pixels over that of Cycles' at equal samples, of the mean and of
  the median pixel: below 1 would be better than Cycles.
- **OpenCL** counts the floats that differ between OpenMP and the OpenCL device, on a small version.

Two things had to be known to compare fairly. Cycles sends its first sample through the pixel's centre
instead of drawing it from the pixel filter, which makes edges differ by something of order 1 / samples;
it is asked for the samples n to 2n of its sequence. And a Blackman-Harris filter of width 1.5 px reaches
1.5 px to *each* side.
"""
COLUMNS = ("scene", "size", "samples", "mean Isophote / Cycles - 1 in %: R, G, B (95 %)", "within 0.5 %",
           "tiles rejected", "tile test sees", "pixels rejected", "FLIP (Cycles itself)", "noise mean, median",
           "OpenCL: floats that differ", "verdict")
SAID = {"within": "yes", "beyond": "no", "undecided": "undecided"}


def write_report(folder: Path, row: dict, pictures: dict) -> None:
    """Add one scene to the page: its row replaces an older one of the same scene."""
    folder.mkdir(parents=True, exist_ok=True)
    store = folder / "rows.json"
    rows = {old["scene"]: old for old in (json.loads(store.read_text()) if store.exists() else [])}
    rows[row["scene"]] = row
    store.write_text(json.dumps(list(rows.values()), indent=1) + "\n")
    write_picture(folder / f"{row['scene']}.png", pictures["cycles"], pictures["isophote"])
    (folder / "README.md").write_text(page(list(rows.values())))


def write_picture(path: Path, cycles: np.ndarray, isophote: np.ndarray) -> None:
    """Cycles | Isophote | grey + AMPLIFIED x difference; linear RGB (h, w, 3) in, all encoded as sRGB (Standard).

    The difference is of means over BLOCK x BLOCK pixels: of single ones it would be nothing but noise.
    """
    encoded = [np.clip(encode_srgb(picture), 0.0, 1.0) for picture in (cycles, isophote)]
    off = encoded[1] - encoded[0]
    blocks = np.stack([pool(off[..., c], tile=BLOCK) for c in range(3)], axis=-1)
    difference = np.clip(0.5 + AMPLIFIED * blocks, 0.0, 1.0)
    gap = np.ones((cycles.shape[0], GAP, 3))
    side_by_side = decode_srgb(np.concatenate([encoded[0], gap, encoded[1], gap, difference], axis=1))
    opaque = np.concatenate([side_by_side, np.ones((*side_by_side.shape[:2], 1))], axis=2)
    write_image(path, {"Combined": opaque.astype(np.float32)})


def page(rows: list[dict]) -> str:
    lines = [HEAD.format(replicates=" or ".join(sorted({str(row["replicates"]) for row in rows})))]
    lines += [f"| {' | '.join(COLUMNS)} |", "|" + " --- |" * len(COLUMNS)]
    lines += [f"| {' | '.join(cells(row))} |" for row in rows]
    lines += ["", f"Blender {rows[0]['cycles']['version']}; {rows[0]['processor']}.", "", "## Pictures", "",
              f"Cycles, Isophote, and grey + {AMPLIFIED} times their difference (of the encoded values, means over "
              f"{BLOCK} x {BLOCK} pixels).", ""]
    for row in rows:
        lines += [f"### {row['scene']}", "", f"![Cycles, Isophote, difference: {row['scene']}]({row['scene']}.png)", ""]
        lines += [f"- {note['name']}: {note['what']}" for note in row["notes"]]
        changed = [f"{name} was {old}" for name, old in row["cycles"]["changed"].items() if name != "use_sample_subset"]
        lines += [f"- Changed in Cycles' settings: {', '.join(changed)}."] if changed else []
        lines += [""] if row["notes"] or changed else []
    return "\n".join(lines).rstrip() + "\n"


def cells(row: dict) -> list[str]:
    pixels, tiles, opencl = row["pixels"], row["tiles"], row["opencl"]
    return [
        row["scene"],
        "x".join(map(str, row["size"])),
        f"{row['replicates']} x {row['samples']}",
        ", ".join(f"{100 * (mean['ratio'] - 1):+.3f} ± {100 * mean['half_interval']:.3f}" for mean in row["means"]),
        "/".join(sorted({SAID[mean["verdict"]] for mean in row["means"]})),
        f"{tiles['rejected']} of {tiles['tested']}",
        f"{100 * tiles['sees']:.1f} %",
        f"{pixels['rejected']} of {pixels['tested']}",
        f"{row['flip']:.3f} ({row['flip_itself']:.3f})",
        f"{row['noise']['mean']:.2f}, {row['noise']['median']:.2f}",
        opencl.get("why_not") or f"{opencl['differing']} of {opencl['compared']}",
        "**agrees**" if row["agrees"] else "**differs**",
    ]
