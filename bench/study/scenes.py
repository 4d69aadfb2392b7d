"""What the study renders: scenes that are already exported, and rooms with any number of triangles."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from isophote import trees
from isophote.material_program import join_materials, make_material
from isophote.materials import make_instruction
from isophote.prepare import Prepared, prepare
from isophote.scene import Scene, load_scene, make_scene, resized
from isophote.validate import clean

ROOM = "room"  # room:N is a room with about N triangles


@contextmanager
def leaf_limit(triangles: int):
    """Trees that are built within have at most so many items in a leaf."""
    usual, trees.MAX_LEAF = trees.MAX_LEAF, triangles
    try:
        yield
    finally:
        trees.MAX_LEAF = usual


def ready_with_leaves(scene: Scene, triangles: int) -> Prepared:
    """A prepared scene, with all buffers, whose leaves hold at most so many triangles."""
    with leaf_limit(triangles):
        prepared = prepare(clean(scene)[0])
        return replace(prepared, buffers=prepared.traced())


@lru_cache(maxsize=4)
def scene_named(folder: Path, name: str) -> Scene:
    """A room, or the scene of FOLDER/NAME.npz. Raises SceneError or OSError."""
    kind, _, count = name.partition(":")
    return make_room(int(count)) if kind == ROOM else load_scene(folder / f"{name}.npz")


@lru_cache(maxsize=3)
def prepared_scene(folder: Path, name: str, size: int, single_leaves: bool) -> Prepared:
    """The scene `size` pixels wide, in its own aspect; with leaves of one triangle where asked for."""
    scene = scene_named(folder, name)
    width, height = (int(n) for n in scene.resolution)
    scene = resized(scene, (size, max(1, round(size * height / width))))
    return ready_with_leaves(scene, 1 if single_leaves else trees.MAX_LEAF)


# ------------------------------------------------------------------ rooms


def quad(center, u, v) -> np.ndarray:
    """Corners (2, 3, 3) of the two triangles of the parallelogram center +- u +- v."""
    c, u, v = (np.asarray(a, float) for a in (center, u, v))
    a, b, c, d = c - u - v, c + u - v, c + u + v, c - u + v
    return np.array([[a, b, c], [a, c, d]])


def torus(center, major: float, minor: float, around: int) -> np.ndarray:
    """Corners (2 around^2, 3, 3) of a torus that is tilted towards the viewer."""
    angle = np.linspace(0, 2 * np.pi, around + 1)
    u, v = np.meshgrid(angle, angle, indexing="ij")
    grid = np.stack([(major + minor * np.cos(v)) * np.cos(u), minor * np.sin(v),
                     (major + minor * np.cos(v)) * np.sin(u)], axis=-1)
    tilt = np.array([[1, 0, 0], [0, np.cos(0.7), -np.sin(0.7)], [0, np.sin(0.7), np.cos(0.7)]])
    p = grid @ tilt.T + np.asarray(center, float)
    a, b, c, d = p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]
    return np.concatenate([np.stack([a, b, c], 2).reshape(-1, 3, 3), np.stack([a, c, d], 2).reshape(-1, 3, 3)])


def make_room(triangles: int, size: int = 64) -> Scene:
    """A closed diffuse room of 14 triangles, a lamp among them, with a torus of the others (2 n^2 of them) in it."""
    walls = [quad((0, -1, -2), (1, 0, 0), (0, 0, 2.5)), quad((0, 1, -2), (1, 0, 0), (0, 0, 2.5)),
             quad((0, 0, -4.5), (1, 0, 0), (0, 1, 0)), quad((0, 0, 0.5), (1, 0, 0), (0, 1, 0)),
             quad((-1, 0, -2), (0, 1, 0), (0, 0, 2.5)), quad((1, 0, -2), (0, 1, 0), (0, 0, 2.5)),
             quad((0, 0.999, -2.8), (0.35, 0, 0), (0, 0, 0.35))]
    around = max(3, round(((triangles - 14) / 2) ** 0.5))
    parts = [np.concatenate(walls), torus((0, -0.25, -2.8), 0.55, 0.25, around)]
    slots = np.concatenate([np.repeat([0, 0, 0, 0, 1, 2, 3], 2), np.full(len(parts[1]), 4)])
    corners = np.concatenate(parts)
    colours = [(0.8, 0.8, 0.8), (0.7, 0.1, 0.1), (0.1, 0.6, 0.1), (12, 11, 9), (0.6, 0.6, 0.8)]
    steps = [make_instruction("emission" if k == 3 else "diffuse", colour) for k, colour in enumerate(colours)]
    return make_scene(
        resolution=(size, size), camera_kind=0, camera_to_world=np.eye(3, 4), camera_window=(-0.5, 0.5, -0.5, 0.5),
        camera_clip=(1e-3, 1e4), vertices=corners.reshape(-1, 3), triangles=np.arange(3 * len(corners)).reshape(-1, 3),
        triangle_slots=slots, mesh_vertices=(0, 3 * len(corners)), mesh_triangles=(0, len(corners)),
        mesh_normals=(-1,), instance_mesh=(0,), instance_to_world=np.eye(3, 4)[None], instance_slots=(0,),
        instance_visibility=(31,),
        slot_materials=np.arange(len(colours)), **join_materials([make_material([step]) for step in steps]))
