"""Files that others made, for Blender's own engines, against Cycles: every file of ../shared/scenes.

    python -m bench.shared_scenes [WORD] [--size 96] [--samples 32] [--replicates 8] [--opencl] [--report FOLDER]

WORD keeps files whose paths hold it. Prints a row of JSON for each file, as bench.cycles_compare does, with the
exporter's notes; --report writes FOLDER/shared.md, and rows and pictures into FOLDER/shared. A file agrees where every
channel's mean is within 1 % or its 99.5 % interval holds 0, at most 0.25 % of the tiles are rejected, and FLIP against
Cycles is at most 0.03 above that of Cycles against itself. Exits with 1 where a file without notes does not.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path

from bench.common import ROOT, print_row
from bench.comparison_report import AMPLIFIED, BLOCK, write_picture
from bench.cycles_compare import render_both, same_bits
from bench.cycles_process import run_script
from bench.replicates import compare_replicates
from bench.scenes import SHARED
from isophote.scene import Scene
from isophote.validate import validate

MEANS, FLIP, TILES = 0.01, 0.03, 0.0025
SURE = 1.5  # half intervals of 95 % in one of 99.5 %: there are many channels
# Why a file differs, where no note says it.
OTHERWISE = {
    "armory/light_area.blend":
        "The walls are there twice, in one place and with opposite normals: in Cycles each shades the other, and they "
        "are black. In Isophote rays start off a surface by the rounding error of its points, and both are lit. With "
        "one of them moved by 1 % the pictures agree.",
}
IMPORTER = ROOT / "bench" / "import_collada.py"
SOURCES = {
    "armory": "[armory_examples](https://github.com/armory3d/armory_examples), zlib licence",
    "blenderseed": "[blenderseed](https://github.com/appleseedhq/blenderseed), MIT licence",
    "clevr": "[clevr-dataset-gen](https://github.com/facebookresearch/clevr-dataset-gen), BSD licence",
    "gltf": "[glTF-Blender-IO](https://github.com/KhronosGroup/glTF-Blender-IO), Apache licence 2.0",
    "ignis": "[Ignis](https://github.com/PearCoding/Ignis), MIT licence",
    "kirby": "[Scotty3Dataset](https://github.com/keenancrane/Scotty3Dataset), `dtorresr.dae` by Darwin Torres Romero, "
             "CC BY 4.0",
}
HEAD = """# Files by others, against Cycles

Made by `python -m bench.shared_scenes --opencl --report docs/comparison`, noisy files again with `--samples 512`; the
figures behind it are in `shared/rows.json`. What is rendered and tested is said in [the comparison](README.md). All
settings are the files' own but for the size and for those that make Cycles biased, which are off for both engines.

A file **agrees** where every channel's mean is within {means} % or its 99.5 % interval holds 0, at most {tiles} % of
its tiles are rejected, and FLIP against Cycles is at most {flip} above that of Cycles against its own other half. Where
one does not, notes say what Isophote left out or made otherwise: those that the log, the panel and `--json` have, or
lines of this page alone.
Seconds are those of all replicates from the file to the last picture, one run on a busy machine: they say what is
slow, not how fast.
"""
COLUMNS = ("file", "size", "samples", "mean Isophote / Cycles - 1 in %: R, G, B (95 %)", "tiles rejected",
           "FLIP (Cycles itself)", "noise mean, median", "OpenCL: floats that differ", "seconds (Cycles)", "verdict")


def shared_files(word: str) -> list[Path]:
    """.blend and COLLADA files whose paths hold `word`."""
    found = sorted(path for kind in ("blend", "dae") for path in SHARED.rglob(f"*.{kind}"))
    return [path for path in found if word in str(path.relative_to(SHARED))]


def as_blend(path: Path, folder: Path) -> Path:
    """The file itself, or what Blender imports from it, saved in `folder`. Raises CyclesError."""
    if path.suffix == ".blend":
        return path
    made = folder / f"{path.stem}.blend"
    run_script(IMPORTER, path, made, makes=made)
    return made


def notes_of(scene: Scene) -> list[dict]:
    """The exporter's notes, and what a render says of the arrays themselves."""
    return scene.notes + [{"kind": "scene", "name": each.thing, "what": each.what} for each in validate(scene)]


def agrees(found: dict) -> bool:
    means = all(abs(mean["ratio"] - 1.0) <= max(MEANS, SURE * mean["half_interval"]) for mean in found["means"])
    few = found["tiles"]["rejected"] <= TILES * found["tiles"]["tested"]
    return means and few and found["flip"] - found["flip_itself"] <= FLIP


def compare_file(path: Path, options: argparse.Namespace) -> tuple[dict, dict]:
    """The row of one file, and its two pictures."""
    with tempfile.TemporaryDirectory() as folder:
        both = render_both(as_blend(path, Path(folder)), options.size, options.samples, options.replicates)
    found = compare_replicates(both["isophote"], both["cycles"])
    row = {
        "file": str(path.relative_to(SHARED)),
        "size": both["info"]["size"],
        "samples": options.samples,
        "replicates": options.replicates,
        "cycles": both["info"],
        "notes": notes_of(both["scene"]),
        **found,
        "agrees": agrees(found),
        "seconds": {engine: round(seconds, 2) for engine, seconds in both["seconds"].items()},
    }
    if options.opencl:
        row["opencl"] = same_bits(both["scene"], both["settings"])
    return row, {engine: both[engine].mean(axis=0) for engine in ("cycles", "isophote")}


def write_report(folder: Path, row: dict, pictures: dict) -> None:
    """Add one file to the page: its row replaces an older one of the same file."""
    inner = folder / "shared"
    inner.mkdir(parents=True, exist_ok=True)
    store = inner / "rows.json"
    rows = {old["file"]: old for old in (json.loads(store.read_text()) if store.exists() else [])}
    rows[row["file"]] = row
    rows = [rows[name] for name in sorted(rows)]
    store.write_text(json.dumps(rows, indent=1) + "\n")
    write_picture(inner / f"{Path(row['file']).stem}.png", pictures["cycles"], pictures["isophote"])
    (folder / "shared.md").write_text(page(rows))


def page(rows: list[dict]) -> str:
    lines = [HEAD.format(means=round(100 * MEANS), tiles=100 * TILES, flip=FLIP), f"| {' | '.join(COLUMNS)} |",
             "|" + " --- |" * len(COLUMNS)]
    lines += [f"| {' | '.join(cells(row))} |" for row in rows]
    lines += ["", f"Blender {rows[0]['cycles']['version']}.", "", "## Pictures", "",
              f"Cycles, Isophote, and grey + {AMPLIFIED} times their difference (of the encoded values, means over "
              f"{BLOCK} x {BLOCK} pixels)."]
    for source in dict.fromkeys(Path(row["file"]).parts[0] for row in rows):
        lines += ["", f"### {SOURCES[source]}"]
        for row in (row for row in rows if Path(row["file"]).parts[0] == source):
            stem = Path(row["file"]).stem
            lines += ["", f"**{stem}**", "", f"![Cycles, Isophote, difference: {stem}](shared/{stem}.png)", ""]
            lines += [f"- {note['kind']} {note['name']}: {note['what']}" for note in row["notes"]]
            lines += [f"- {OTHERWISE[row['file']]}"] if row["file"] in OTHERWISE else []
    return "\n".join(lines).rstrip() + "\n"


def cells(row: dict) -> list[str]:
    tiles, opencl = row["tiles"], row.get("opencl", {"why_not": "not asked"})
    said = row["notes"] or row["file"] in OTHERWISE
    verdict = "**agrees**" if row["agrees"] else "for a reason, below" if said else "**differs**"
    return [
        Path(row["file"]).stem,
        "x".join(map(str, row["size"])),
        f"{row['replicates']} x {row['samples']}",
        ", ".join(f"{100 * (mean['ratio'] - 1):+.2f} ± {100 * mean['half_interval']:.2f}" for mean in row["means"]),
        f"{tiles['rejected']} of {tiles['tested']}",
        f"{row['flip']:.3f} ({row['flip_itself']:.3f})",
        f"{row['noise']['mean']:.2f}, {row['noise']['median']:.2f}",
        opencl.get("why_not") or f"{opencl['differing']} of {opencl['compared']}",
        f"{row['seconds']['isophote']:.1f} ({row['seconds']['cycles']:.1f})",
        verdict,
    ]


def main() -> int:
    parser = argparse.ArgumentParser(prog="bench.shared_scenes", description="Compare files by others with Cycles.")
    parser.add_argument("word", nargs="?", default="")
    parser.add_argument("--size", type=int, default=96, help="longer side in pixels, 0: the file's own size")
    parser.add_argument("--samples", type=int, default=32, help="of each replicate")
    parser.add_argument("--replicates", type=int, default=8)
    parser.add_argument("--opencl", action="store_true", help="compare the bits of OpenMP and OpenCL, too")
    parser.add_argument("--report", type=Path, help="folder for shared.md and the pictures")
    options = parser.parse_args()
    unexplained = 0
    for path in shared_files(options.word):
        row, pictures = compare_file(path, options)
        print_row(row)
        unexplained += not (row["agrees"] or row["notes"] or row["file"] in OTHERWISE)
        if options.report:
            write_report(options.report, row, pictures)
    return 1 if unexplained else 0


if __name__ == "__main__":
    raise SystemExit(main())
