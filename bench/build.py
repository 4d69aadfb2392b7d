"""Trees: triangles a second and core, quality and memory, beside Embree's builders.

    python -m bench.build [SCENE.npz ...] [--counts 300000,1000000,2000000] [--threads 1,2] [--rounds 5] [--no-embree]

Scenes are rooms of blobs made here, of `counts` triangles, and exported ones, all moved to world space. A round
builds everything once, so that builders take turns; medians count. Prints a row of JSON for each scene, builder
and number of threads. Ours: seconds of `boxes` (of the triangles), `split` (binning and moving them) and `join`
(laying subtrees out), of which `tree` is the whole; of `records` (triangles in the order of the leaves, for OpenCL)
and of `collapse` (to eight wide); the rate counts tree and collapse. `sah` is the expected cost of a random line
with 1 a node and 1 a triangle; `bytes` are a triangle's. Embree (Debian's libembree-dev, with g++) commits a scene
of one mesh, which is all of that. One thread's rate is that of a core.
"""

from __future__ import annotations

import argparse
import ctypes
import json
import os
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

from isophote import _native
from isophote.geometry import MESH_USE, plain
from isophote.records import numbers, records
from isophote.scene import load_scene
from isophote.trees import BOX_MARGIN, ITEM_COST, MAX_LEAF
from isophote.validate import clean

QUALITIES = {"medium": 1, "high": 2}
BLOBS = 12


def blob_room(count: int) -> tuple[np.ndarray, np.ndarray]:
    """A closed room of `count` triangles, about: 12 bumpy balls. Vertices float32 (n, 3), triangles uint32 (n, 3)."""
    rng = np.random.default_rng(1)
    rows = max(3, round((count / BLOBS / 4) ** 0.5))
    theta, phi = np.meshgrid(np.linspace(0, np.pi, rows + 1), np.linspace(0, 2 * np.pi, 2 * rows + 1), indexing="ij")
    around = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1).reshape(-1, 3)
    corner = np.arange(rows)[:, None] * (2 * rows + 1) + np.arange(2 * rows)
    a, b, c, d = corner, corner + 1, corner + 2 * rows + 1, corner + 2 * rows + 2
    grid = np.stack([np.stack([a, c, d], -1), np.stack([a, d, b], -1)], 2).reshape(-1, 3)
    box = np.array([[x, y, z] for x in (-4, 4) for y in (-4, 4) for z in (-4, 4)], float)
    sides = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    vertices, triangles = [box], [sides[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)]
    for _ in range(BLOBS):
        waves, shift = rng.normal(0, 6, (5, 3)), rng.uniform(0, 7, 5)
        radius = 0.9 + 0.05 * np.sin(around @ waves.T + shift).sum(1, keepdims=True)
        triangles.append(grid + sum(map(len, vertices)))
        vertices.append(rng.uniform(-2.8, 2.8, 3) + radius * around)
    return np.concatenate(vertices).astype(np.float32), np.concatenate(triangles).astype(np.uint32)


def exported(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """All instances of an exported scene in world space, as blob_room."""
    scene, _ = clean(load_scene(path))
    vertices, triangles, placed = [], [], 0
    for mesh, matrix in zip(scene.instance_mesh, scene.instance_to_world, strict=True):
        own = scene.triangles[scene.mesh_triangles[mesh]:scene.mesh_triangles[mesh + 1]]
        used, local = np.unique(own, return_inverse=True)
        vertices.append(scene.vertices[used] @ matrix[:, :3].T + matrix[:, 3])
        triangles.append(local.reshape(-1, 3) + placed)
        placed += len(used)
    return np.concatenate(vertices).astype(np.float32), np.concatenate(triangles).astype(np.uint32)


def timed(function, *arguments):
    started = time.perf_counter()
    made = function(*arguments)
    return made, time.perf_counter() - started


def one_mesh(vertices: np.ndarray, triangles: np.ndarray):
    """A mesh in world space, for the builders."""
    use = np.zeros(1, MESH_USE)
    use["visibility"] = numbers()["RAY_ALL"]
    return _native.Meshes(vertices, triangles, np.array([0, len(triangles)], np.uint32), use.view(np.uint8))


def place(meshes, order: np.ndarray, last: np.ndarray, threads: int) -> np.ndarray:
    """Triangle records in the order of the leaves."""
    made = np.empty(len(order), records()["Triangle"])
    _native.make_triangles(meshes, order, last, threads, plain(made))
    return made


def surface_cost(nodes: np.ndarray, last: np.ndarray) -> float:
    """Expected cost of a random line that meets the root's box: 1 a node, 1 a triangle."""
    n = numbers()
    size = [2 * nodes[f"half_{axis}"].astype(float) for axis in "xyz"]
    area = size[0] * size[1] + size[1] * size[2] + size[2] * size[0]
    inner = nodes["child"] >> 30 == n["REF_NODE"]
    ends = np.flatnonzero(last)
    first = nodes["child"][~inner] & np.uint32(0x3FFFFFFF)
    count = ends[np.searchsorted(ends, first)] - first + 1
    center, half = ([nodes[0][f"{name}_{axis}"] for axis in "xyz"] for name in ("center", "half"))
    whole = [max(c + h) - min(c - h) for c, h in zip(center, half, strict=True)]
    root = whole[0] * whole[1] + whole[1] * whole[2] + whole[2] * whole[0]
    return float(1 + (area[inner].sum() + (area[~inner] * count).sum()) / root)


def build_ours(vertices: np.ndarray, triangles: np.ndarray, threads: int) -> dict:
    none, no_items, all_ = np.zeros((0, 3), np.float32), np.zeros(0, np.uint32), np.zeros(1, np.uint32)
    meshes = one_mesh(vertices, triangles)
    (nodes, order, last, root, depth), tree = timed(
        _native.make_tree, meshes, all_, none, none, no_items, BOX_MARGIN, ITEM_COST, MAX_LEAF, threads)
    _, placing = timed(place, meshes, order, last, threads)
    wide, collapse = timed(
        _native.make_wide_tree, meshes, [(nodes, order, last, root)], no_items, threads)
    stages = _native.time_tree(meshes, all_, BOX_MARGIN, ITEM_COST, MAX_LEAF, threads)
    seconds = dict(zip(("boxes", "split", "join"), stages, strict=True))
    return {"seconds": {**seconds, "tree": tree, "records": placing, "collapse": collapse}, "total": tree + collapse,
            "made": (nodes.view(records()["Bvh2Node"]), last, depth, wide)}


def describe(nodes: np.ndarray, last: np.ndarray, depth: int, wide) -> dict:
    count = len(last)
    return {"sah": round(surface_cost(nodes, last), 3), "depth": depth,
            "bytes": {"nodes": round(nodes.nbytes / count, 1), "triangles": records()["Triangle"].itemsize,
                      **{name: round(size / count, 1) for name, size in wide.bytes.items()}}}


def compile_embree(folder: str):
    """The C function of embree_build.cpp. Raises CalledProcessError where g++ or Embree is missing."""
    source, made = Path(__file__).parent / "embree_build.cpp", Path(folder) / "embree_build.so"
    subprocess.run(["g++", "-O2", "-shared", "-fPIC", "-o", made, source, "-lembree3"], check=True)
    build = ctypes.CDLL(str(made)).build
    build.restype = ctypes.c_double
    return build


def build_embree(build, quality: str, vertices: np.ndarray, triangles: np.ndarray, threads: int) -> dict:
    held = ctypes.c_long()
    pointers = [array.ctypes.data_as(ctypes.c_void_p) for array in (vertices, triangles)]
    seconds = build(pointers[0], ctypes.c_size_t(len(vertices)), pointers[1], ctypes.c_size_t(len(triangles)),
                    QUALITIES[quality], threads, ctypes.byref(held))
    if seconds < 0:
        raise RuntimeError("Embree could not build the scene")
    return {"total": seconds, "bytes": {"all": round(held.value / len(triangles), 1)}}


def measure(name: str, vertices: np.ndarray, triangles: np.ndarray, threads: list[int], rounds: int, embree) -> None:
    builders = {"isophote": lambda count: build_ours(vertices, triangles, count)}
    for quality in QUALITIES if embree else ():
        builders[f"embree {quality}"] = lambda count, q=quality: build_embree(embree, q, vertices, triangles, count)
    results = {(builder, count): [] for count in threads for builder in builders}
    kept = {}
    for _ in range(rounds):
        for (builder, count), rows in results.items():
            row = builders[builder](count)
            kept[builder] = row.pop("made", None)
            rows.append(row)
    for (builder, count), rows in results.items():
        total = statistics.median(row["total"] for row in rows)
        row = {"scene": name, "triangles": len(triangles), "builder": builder, "threads": count,
               "seconds": round(total, 4), "mtriangles_per_second": round(len(triangles) / total / 1e6, 3)}
        if kept[builder]:
            row["stages"] = {stage: round(statistics.median(r["seconds"][stage] for r in rows), 4)
                             for stage in rows[0]["seconds"]}
            row |= describe(*kept[builder])
        else:
            row["bytes"] = rows[0]["bytes"]
        print(json.dumps(row), flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", type=Path)
    parser.add_argument("--counts", default="300000,1000000,2000000")
    parser.add_argument("--threads", default=f"1,{os.cpu_count()}")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--no-embree", action="store_true")
    options = parser.parse_args()
    threads = sorted({int(count) for count in options.threads.split(",")})
    with tempfile.TemporaryDirectory() as folder:
        embree = None if options.no_embree else compile_embree(folder)
        for count in filter(None, options.counts.split(",")):
            measure(f"room of {count}", *blob_room(int(count)), threads, options.rounds, embree)
        for path in options.scenes:
            measure(path.stem, *exported(path), threads, options.rounds, embree)


if __name__ == "__main__":
    main()
