"""Seconds from the start of export to the first pass of pixels, in real Blenders, for first and following frames.

    python -m bench.export [--blenders PROGRAM,PYTHON] [--scenes monkeys,flat,smooth,shared,cube]
                           [--changes camera,object,deform] [--rounds 3] [--frames 4] [--triangles 2000000]
                           [--size 720x720] [--threads 2] [--persistent] [--engines ISOPHOTE,CYCLES]

Each row of JSON is the median of one Blender, scene and kind of change between frames: "first" of first
frames, "next" of those that follow. `blender` is what Blender does before it asks the engine (its
dependency graph), and no part of `total`; the other stages add up to it (bench/export_worker.py names
the functions). `meshes` is Blender's part of it: until it has handed out every object's mesh. Of the picture's time
one sample a pixel counts. `whole` is the time from the end of one frame to the end of the next, all that Cycles tells.
flat, smooth and shared are one mesh of that many triangles (shared: with two users), cube is Blender's own scene;
monkeys comes from ../shared/scenes.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from itertools import product
from pathlib import Path

from bench.cycles_process import find_python
from bench.scenes import made_scenes

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tools"))
import blender_run  # noqa: E402

MARK = "ISOPHOTE-EXPORT-BENCH "
WORKER = Path(__file__).with_name("export_worker.py")


def frames_of(blender: str, blend: Path | None, job: dict) -> list[dict]:
    """What the worker measured, a row a frame. Raises RuntimeError with the end of Blender's log."""
    command = [*blender_run.program(blender), "-b", "--factory-startup", *([str(blend)] if blend else []), "--addons",
               blender_run.ADDON, "--python", str(WORKER), "--", json.dumps(job)]
    done = subprocess.run(command, env=blender_run.environment(), text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)
    rows = [json.loads(line[len(MARK):]) for line in done.stdout.splitlines() if line.startswith(MARK)]
    if len(rows) != job["rounds"] * job["frames"]:
        raise RuntimeError(f"{blender}: {len(rows)} frames\n{done.stdout[-3000:]}")
    return rows


def medians(rows: list[dict]) -> dict:
    return {name: round(statistics.median(row[name] for row in rows), 4) for name in rows[0]
            if name != "frame"}


def main() -> None:
    parser = argparse.ArgumentParser(prog="bench.export", description=__doc__.split("\n")[0])
    parser.add_argument("--blenders", default=",".join(filter(None, [shutil.which("blender"), find_python()])))
    parser.add_argument("--scenes", default="monkeys,flat,smooth,shared")
    parser.add_argument("--changes", default="camera,object,deform")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--frames", type=int, default=4)
    parser.add_argument("--triangles", type=int, default=2_000_000)
    parser.add_argument("--size", default="720x720")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--persistent", action="store_true", help="with Blender's Persistent Data")
    parser.add_argument("--engines", default="ISOPHOTE")
    parser.add_argument("--folder", type=Path, help="where monkeys.blend lies or is made")
    options = parser.parse_args()
    job = {name: getattr(options, name) for name in ("rounds", "frames", "triangles", "threads", "persistent")}
    job["size"] = [int(n) for n in options.size.split("x")]
    with tempfile.TemporaryDirectory(prefix="isophote_bench_") as folder:
        for scene in options.scenes.split(","):
            blend = made_scenes(options.folder or Path(folder), (scene,))[0] if scene == "monkeys" else None
            for blender in options.blenders.split(","):
                for change, engine in product(options.changes.split(","), options.engines.split(",")):
                    rows = frames_of(blender, blend, job | {"scene": "file" if blend else scene, "change": change,
                                                            "engine": engine})
                    made = {"blender_program": blender, "engine": engine, "scene": scene, "change": change, **job}
                    for which, chosen in (("first", [row for row in rows if row["frame"] == 1]),
                                          ("next", [row for row in rows if row["frame"] > 1])):
                        if chosen:
                            print(json.dumps({**made, "frames_are": which, **medians(chosen)}), flush=True)


if __name__ == "__main__":
    main()
