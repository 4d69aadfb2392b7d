"""Rays a second by kind on one core: Isophote's CPU tracer against Embree, in turn in one process.

    python -m bench.rays [SCENE.npz ...] [--triangles 280000,1000000] [--rays 1048576] [--rounds 7]
                         [--embree LIBRARY,...] [--isa v4] [--all]

Without files: a closed room with nine bumpy blobs, of about that many triangles. Kinds of rays: primary (a
pixel each, in blocks of 4 x 4), shadow (from their hits to a lamp of 1 m under the ceiling), bounce1 and bounce2
(cosine-weighted, from hit to hit). Every kind is timed as single rays and as packets of 16; Embree's packets
have its coherent flag. Embree is opened from the libraries given, else those of Debian's libembree-dev and of
the embreex wheel that are found; fast mode, and with --all also robust and robust compact mode (as Cycles
sets it), and both at medium and at high build quality.

Rays and results are arrays; what is timed is one call that loops over all rays in native code. A round times each
tracer once; the ratio is the median over rounds of Embree's best time (single or packets) over ours. `differ` is
the share of rays whose distances differ by more than 1e-4 relative, or which only one of the two hits.
"""

from __future__ import annotations

import argparse
import ctypes
import importlib.util
import json
import os
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

from isophote import _native
from isophote.geometry import plain
from isophote.openmp import choose_variant, processor_name
from isophote.prepare import prepare
from isophote.scene import Scene, load_scene, make_scene
from isophote.validate import clean

FAR = 3e38
NONE = 0xFFFFFFFF
DEBIAN = Path("/usr/lib/x86_64-linux-gnu/libembree3.so.3")
KINDS = ("primary", "shadow", "bounce1", "bounce2")


# ------------------------------------------------------------------ scenes


def blob(rings: int, radius: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A displaced sphere of about 4 rings^2 triangles with bumps down to a few triangles in size."""
    rng = np.random.default_rng(seed)
    theta = np.linspace(0, np.pi, rings + 1)[:, None]
    phi = np.linspace(0, 2 * np.pi, 2 * rings, endpoint=False)[None]
    unit = np.stack(np.broadcast_arrays(np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)), -1)
    height = np.ones(unit.shape[:2])
    for octave in range(6):
        waves = rng.normal(size=(8, 3)) * 2.0**octave * 2
        height += 0.25 * 0.5**octave * np.sin(unit @ waves.T + rng.uniform(0, 6, 8)).mean(-1)
    vertices = (unit * height[..., None] * radius).reshape(-1, 3)
    at = np.arange(rings)[:, None] * 2 * rings
    k, following = np.arange(2 * rings)[None], (np.arange(2 * rings)[None] + 1) % (2 * rings)
    a, b, c, d = (x.ravel() for x in (at + k, at + 2 * rings + k, at + 2 * rings + following, at + following))
    upper, lower = np.stack([a, b, c], -1), np.stack([a, c, d], -1)
    # At the poles one triangle of each pair has no area.
    return vertices, np.concatenate([upper[:2 * rings * rings - 2 * rings], lower[2 * rings:]])


def room(triangles: int) -> Scene:
    """A closed room of 6 x 6 x 3 m with nine blobs; the camera looks from a corner."""
    rings = max(3, round((triangles / 9 / 4) ** 0.5))
    corners = np.array([[x, y, z] for x in (-3, 3) for y in (-3, 3) for z in (0, 3)], float)
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    parts = [(corners, np.array([t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))]))]
    rng = np.random.default_rng(7)
    for k in range(9):
        vertices, faces = blob(rings, rng.uniform(0.5, 0.8), k)
        parts.append((vertices + ((k % 3 - 1) * 1.9, (k // 3 - 1) * 1.9, rng.uniform(0.6, 1.4)), faces))
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    back = np.array([-2.8, -2.8, 2.5]) - np.array([0.5, 0.5, 0.7])
    z = back / np.linalg.norm(back)
    x = np.cross((0, 0, 1), z) / np.linalg.norm(np.cross((0, 0, 1), z))
    vertices = np.concatenate([vertices for vertices, _ in parts])
    faces = np.concatenate([f + start for (_, f), start in zip(parts, starts, strict=False)])
    return make_scene(
        resolution=(1024, 1024), camera_to_world=np.stack([x, np.cross(z, x), z, (-2.8, -2.8, 2.5)], 1),
        camera_window=(-0.7, 0.7, -0.7, 0.7), camera_clip=(0.01, 100.0), vertices=vertices, triangles=faces,
        mesh_vertices=(0, len(vertices)), mesh_triangles=(0, len(faces)), mesh_normals=(-1,), instance_mesh=(0,),
        instance_to_world=np.eye(4)[None, :3], instance_slots=(0,), instance_visibility=(31,), slot_materials=(0,),
        material_first=(0, 0))


# ------------------------------------------------------------------ tracers


class Isophote:
    """The native module's wide tree; rays float32 (n, 8): origin, direction, t_min, t_max."""

    def __init__(self, scene: Scene, isa: str):
        self.variant = choose_variant(_native.variants, "strict", isa)
        prepared = prepare(clean(scene)[0])
        self.buffers = prepared.traced()
        if (self.buffers["triangles"]["instance"] == NONE).any():
            raise SystemExit("bench.rays: a scene with instanced meshes; Embree would get object-space triangles")
        self.data = [plain(buffer) for buffer in self.buffers.values()]
        self.tree = prepared.geometry.wide_tree

    def corners(self) -> np.ndarray:
        """float32 (n, 3, 3), of all triangles in the scene's order"""
        return self.buffers["vertices"][self.buffers["indices"]]

    def trace(self, rays: np.ndarray, occlusion: bool, packets: bool = False):
        return _native.trace(self.variant, self.data, self.tree, rays, occlusion, 1, packets)

    def hits(self, rays: np.ndarray, occlusion: bool, packets: bool = False):
        """(t with infinity where nothing is hit, number of the triangle)"""
        tuv, ids = self.trace(rays, occlusion, packets)
        return np.where(ids[:, 0] == NONE, np.inf, tuv[:, 0]), ids[:, 1]


class Embree:
    """rtcIntersect1 / rtcOccluded1, or the packets of 16, over the same triangles."""

    def __init__(self, shim, library: Path, corners: np.ndarray, quality: str, robust: bool, compact: bool):
        self.shim, version = shim, ctypes.create_string_buffer(16)
        corners = np.ascontiguousarray(corners, np.float32)
        self.handle = ctypes.c_void_p(shim.embree_open(
            str(library).encode(), f"threads={os.cpu_count()}".encode(), pointer(corners), ctypes.c_long(len(corners)),
            {"medium": 1, "high": 2}[quality], int(robust), int(compact), version))
        if not self.handle:
            raise SystemExit(f"bench.rays: {library} is no Embree that could be opened")
        self.version = version.value.decode()
        self.mode = ("robust" if robust else "fast") + (", compact" if compact else "")
        self.name = f"Embree {self.version}, {self.mode}, {quality} quality"
        self.out = None

    def trace(self, rays: np.ndarray, occlusion: bool, packets: bool = False):
        if self.out is None or len(self.out[0]) != len(rays):
            self.out = np.zeros((len(rays), 3), np.float32), np.zeros(len(rays), np.uint32)
        self.shim.embree_trace(self.handle, pointer(rays), ctypes.c_long(len(rays)), int(occlusion), int(packets),
                               pointer(self.out[0]), pointer(self.out[1]))

    def hits(self, rays: np.ndarray, occlusion: bool, packets: bool = False):
        self.trace(rays, occlusion, packets)
        return np.where(self.out[1] == NONE, np.inf, 0.0 if occlusion else self.out[0][:, 0]), None

    def close(self):
        self.shim.embree_close(self.handle)


def pointer(array: np.ndarray):
    return array.ctypes.data_as(ctypes.c_void_p)


def make_shim(folder: str):
    """embree_rays.cpp as a library."""
    source, library = Path(__file__).with_name("embree_rays.cpp"), Path(folder) / "embree_rays.so"
    subprocess.run(["clang++-19", "-O3", "-march=native", "-std=c++20", "-shared", "-fPIC", str(source), "-o",
                    str(library), "-ldl"], check=True)
    shim = ctypes.CDLL(str(library))
    shim.embree_open.restype = ctypes.c_void_p
    return shim


def find_libraries() -> list[Path]:
    found = [DEBIAN] if DEBIAN.exists() else []
    wheel = importlib.util.find_spec("embreex")
    if wheel:
        found += sorted((Path(wheel.origin).parents[1] / "embreex.libs").glob("libembree4*.so*"))
    return found


# ------------------------------------------------------------------ rays


def make_rays(origin, direction, t_max=FAR) -> np.ndarray:
    n = len(direction)
    return np.concatenate([np.broadcast_to(origin, (n, 3)), direction, np.zeros((n, 1)),
                           np.broadcast_to(np.reshape(t_max, (-1, 1)), (n, 1))], 1).astype(np.float32)


def primary_rays(scene: Scene, count: int) -> np.ndarray:
    """A ray through the middle of each pixel of a square, pixels in blocks of 4 x 4."""
    side = int(count**0.5) // 4 * 4
    at = np.arange(side * side)
    block, within = at // 16, at % 16
    column, row = block % (side // 4) * 4 + within % 4, block // (side // 4) * 4 + within // 4
    left, right, bottom, top = scene.camera_window
    m = scene.camera_to_world
    toward = (m[:, 0] * (left + (right - left) * (column[:, None] + 0.5) / side)
              + m[:, 1] * (bottom + (top - bottom) * (row[:, None] + 0.5) / side) - m[:, 2])
    return make_rays(m[:, 3], toward / np.linalg.norm(toward, axis=1, keepdims=True))


def ray_kinds(tracer: Isophote, scene: Scene, count: int) -> dict[str, np.ndarray]:
    """Rays of each kind, found with our own tracer (whose hits the bench compares with Embree's)."""
    rng = np.random.default_rng(11)
    corners = tracer.corners().astype(np.float64)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    lo, hi = corners.min((0, 1)), corners.max((0, 1))
    rays = {"primary": primary_rays(scene, count)}
    for source, target in (("primary", "bounce1"), ("bounce1", "bounce2")):
        t, index = tracer.hits(rays[source], False)
        hit = np.isfinite(t)
        origin = (rays[source][hit, :3] + rays[source][hit, 3:6] * t[hit, None]).astype(np.float64)
        normal = normals[index[hit]]
        normal *= -np.sign(np.einsum("ij,ij->i", normal, rays[source][hit, 3:6]))[:, None]
        origin += normal * 1e-5 * np.abs(hi - lo).max()
        if source == "primary":
            lamp = (lo + hi) / 2 + np.append(rng.uniform(-0.5, 0.5, (len(origin), 2)), np.zeros((len(origin), 1)), 1)
            lamp[:, 2] = hi[2] - 0.02 * (hi - lo)[2]
            away = lamp - origin
            distance = np.linalg.norm(away, axis=1)
            rays["shadow"] = make_rays(origin, away / distance[:, None], distance)
        sphere = rng.normal(size=normal.shape)
        direction = normal + sphere / np.linalg.norm(sphere, axis=1, keepdims=True)
        rays[target] = make_rays(origin, direction / np.linalg.norm(direction, axis=1, keepdims=True))
    return rays


# ------------------------------------------------------------------ timing


def timed(call) -> float:
    """Processor time of this thread, s: what others do on a shared machine counts less than by the clock."""
    started = time.thread_time()
    call()
    return time.thread_time() - started


def compare(kind: str, rays: np.ndarray, ours: Isophote, theirs: list[Embree], rounds: int) -> list[dict]:
    """A row for each Embree, all measured in turn."""
    occlusion = kind == "shadow"
    runs = {(tracer, packets): [] for tracer in [ours, *theirs] for packets in (False, True)}
    for _ in range(rounds + 1):
        for (tracer, packets), seconds in runs.items():
            seconds.append(timed(lambda t=tracer, p=packets: t.trace(rays, occlusion, p)))
    mega = {run: len(rays) / statistics.median(seconds[1:]) / 1e6 for run, seconds in runs.items()}
    reference, _ = ours.hits(rays, occlusion)
    rows = []
    for embree in theirs:
        best = [min(a, b) / min(c, d) for a, b, c, d in zip(*(runs[run][1:] for run in (
            (embree, False), (embree, True), (ours, False), (ours, True))), strict=True)]
        single = [a / b for a, b in zip(runs[embree, False][1:], runs[ours, False][1:], strict=True)]
        t, _ = embree.hits(rays, occlusion)
        differ = np.isfinite(t) != np.isfinite(reference)
        if not occlusion:
            with np.errstate(invalid="ignore"):  # two misses: infinity minus infinity
                differ |= np.abs(t - reference) > 1e-4 * np.abs(reference)
        rows.append({
            "kind": kind, "rays": len(rays), "against": embree.name, "ratio": round(statistics.median(best), 3),
            "ratio_min": round(min(best), 3), "ratio_max": round(max(best), 3),
            "ratio_single": round(statistics.median(single), 3),
            "isophote_mrays": round(mega[ours, False], 2), "isophote_packet_mrays": round(mega[ours, True], 2),
            "embree_mrays": round(mega[embree, False], 2), "embree_packet_mrays": round(mega[embree, True], 2),
            "hit": round(float(np.isfinite(reference).mean()), 4), "differ": float(differ.mean())})
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(prog="bench.rays", description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", type=Path)
    parser.add_argument("--triangles", default="280000,1000000")
    parser.add_argument("--rays", type=int, default=1 << 20)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--embree", default="", help="paths of libraries, with commas")
    parser.add_argument("--isa", default="", help="instructions of ours: v2, v3, v4")
    parser.add_argument("--all", action="store_true", help="robust modes too, and both build qualities")
    options = parser.parse_args()
    libraries = [Path(p) for p in options.embree.split(",") if p] or find_libraries()
    if not libraries:
        raise SystemExit("bench.rays: no Embree found; install libembree-dev or the embreex wheel, or give --embree")
    modes = [("high", False, False)]
    if options.all:
        modes = [("medium", False, False), *modes, ("high", True, False), ("high", True, True)]
    scenes = [(path.stem, load_scene(path)) for path in options.scenes] or [
        (f"room {int(n) / 1e6:g} M", room(int(n))) for n in options.triangles.split(",")]
    with tempfile.TemporaryDirectory() as folder:
        shim = make_shim(folder)
        for name, scene in scenes:
            ours = Isophote(scene, options.isa)
            corners = ours.corners()
            theirs = [Embree(shim, library, corners, *mode) for library in libraries for mode in modes]
            for kind, rays in ray_kinds(ours, scene, options.rays).items():
                if kind not in options.kinds.split(","):
                    continue
                for row in compare(kind, rays, ours, theirs, options.rounds):
                    print(json.dumps({"scene": name, "triangles": len(corners), **row, "variant": ours.variant,
                                      "processor": processor_name()}), flush=True)
            for embree in theirs:
                embree.close()


if __name__ == "__main__":
    main()
