"""From a scene to the buffers that kernels read: trees, lights to sample, tables, and what the scene uses."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np

from isophote.geometry import Geometry, make_geometry
from isophote.light_tree import make_light_tree, shining
from isophote.lights import light_records, triangle_lights
from isophote.materials import OPERATIONS, is_delta
from isophote.records import make_records, numbers, scene_buffers
from isophote.scene import Scene

TRANSMITTING = ("refraction", "glass", "principled_glass", "film_glass", "translucent")
TABLELESS = ("diffuse", "transparent", "rough_diffuse", "translucent", "diffuse_toon", "glossy_toon", "velvet",
             "beckmann", "ashikhmin_shirley", "layer_absorption", "layer_reset")
FILTER_STEPS = 1024
NAME_OF_OPERATION = {number: name for name, (number, _) in OPERATIONS.items()}


@dataclass
class Prepared:
    """What a device takes. `buffers` holds an array for each entry of kernels/scene_buffers.h, but not for `nodes` and
    `triangles`: these are for those who trace the BVH2 and are made by `traced`.

    `features` is a mask of FEATURE_ bits, `operations` one of the instructions' operations (bit 1 << op): what kernels
    must know. `resolution` is the full frame (width, height) in pixels.
    """

    buffers: dict[str, np.ndarray]
    geometry: Geometry
    features: int
    operations: int
    resolution: tuple[int, int]
    build_seconds: float
    notes: list[dict] = field(default_factory=list)

    def traced(self, held: Geometry | None = None) -> dict[str, np.ndarray]:
        """All buffers by name, with a new copy of what only tracing the BVH2 reads: but not that, nor `instances`, of
        the geometry that the caller holds already."""
        made = dict(self.buffers)
        if "nodes" not in made:
            joined = self.geometry.joined()
            world = made["world"].copy()
            world["root"] = joined.root
            made |= {"nodes": joined.nodes, "triangles": None, "instances": joined.instances, "world": world}
            if held is self.geometry:
                del made["nodes"], made["triangles"], made["instances"]
            else:
                made["triangles"] = self.geometry.leaf_records(joined)
        return {name: made[name] for name in scene_buffers() if name in made}

    def traced_sizes(self) -> dict[str, int]:
        """Bytes of `traced`, by buffer, without making it."""
        sizes = {name: array.nbytes for name, array in self.buffers.items()}
        return sizes if "nodes" in sizes else sizes | self.geometry.traced_sizes()


def prepare(scene: Scene, kept: Geometry | None = None) -> Prepared:
    """Build everything that kernels need from a scene that validate.clean has passed.

    `kept` is the geometry of another scene, often of the frame before: what is the same is used again.
    """
    started = time.perf_counter()
    geometry = make_geometry(scene, kept)
    buffers = dict(geometry.buffers)
    materials, instructions = make_materials(scene)
    lamps = shining(light_records(scene))
    lights = np.concatenate([lamps, shining(triangle_lights(scene, materials))])
    light_tree, light_depth = make_light_tree(lights)
    features = find_features(scene, buffers, materials, lights, len(lamps))
    buffers |= {
        "camera": make_camera(scene), "materials": materials, "instructions": instructions,
        "slot_materials": scene.slot_materials, "lights": lights, "light_tree": light_tree,
        "filter_table": blackman_harris_table(), "albedo_tables": albedo_tables(instructions),
        "world": make_records("World", 1, radiance=scene.world_radiance, origin=scene.origin, root=0,
                              light_count=len(lights), lamp_count=len(lamps), light_depth=light_depth,
                              features=features)}
    buffers = {name: np.ascontiguousarray(buffers[name], dtype.base) for name, dtype in scene_buffers().items()
               if name in buffers}
    operations = sum(1 << int(op) for op in np.unique(instructions["op"]))
    return Prepared(buffers, geometry, features, operations, tuple(int(r) for r in scene.resolution),
                    time.perf_counter() - started)


def make_camera(scene: Scene) -> np.ndarray:
    """The camera's record."""
    matrix = scene.camera_to_world
    left, right, bottom, top = scene.camera_window
    return make_records(
        "Camera", 1, x=matrix[:, 0], y=matrix[:, 1], z=matrix[:, 2], position=matrix[:, 3], left=left, right=right,
        bottom=bottom, top=top, clip_start=scene.camera_clip[0], clip_end=scene.camera_clip[1],
        kind=scene.camera_kind, width=scene.resolution[0], height=scene.resolution[1])


def make_materials(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Material records and the instructions that remain once emission is folded into them."""
    n = numbers()
    operation = np.array([NAME_OF_OPERATION[op] for op in scene.instruction_op.tolist()], dtype=object)
    made, kept, placed = make_records("Material", len(scene.material_first) - 1), [], 0
    for number, material in enumerate(made):
        program = np.arange(scene.material_first[number], scene.material_first[number + 1])
        emission = program[operation[program] == "emission"]
        transparent = program[operation[program] == "transparent"]
        rest = program[operation[program] != "emission"]
        closures = [i for i in rest if not operation[i].startswith("layer_")]
        smooth = all(is_delta(int(scene.instruction_op[i]), scene.instruction_params[i]) for i in closures)
        material["emission"] = scene.instruction_weight[emission].sum(0)
        material["transparency"] = scene.instruction_weight[transparent].sum(0)
        material["first"], material["count"] = placed, len(rest)
        material["flags"] = (bool(material["emission"].any()) * n["MATERIAL_EMITS"]
                             | bool(material["transparency"].any()) * n["MATERIAL_TRANSPARENT"]
                             | smooth * n["MATERIAL_DELTA_ONLY"]
                             | any(operation[i] in TRANSMITTING for i in rest) * n["MATERIAL_TRANSMITS"])
        kept.append(rest)
        placed += len(rest)
    order = np.concatenate(kept) if kept else np.zeros(0, int)
    instructions = make_records("Instruction", len(order), op=scene.instruction_op[order],
                                weight=scene.instruction_weight[order], params=scene.instruction_params[order])
    return made, instructions


@cache
def blackman_harris_table() -> np.ndarray:
    """Inverse CDF of the Blackman-Harris window (Harris 1978, table I, four terms) for filter_width 1, float32.

    The window is two filter widths wide, as in Cycles (src/scene/film.cpp, filter_table): most of its
    weight then lies within one.
    """
    x = np.linspace(-1.0, 1.0, 1 << 16 | 1)
    phase = np.pi * (x + 1.0)
    window = 0.35875 - 0.48829 * np.cos(phase) + 0.14128 * np.cos(2 * phase) - 0.01168 * np.cos(3 * phase)
    cdf = np.concatenate([[0.0], np.cumsum(0.5 * (window[1:] + window[:-1]))])
    return np.interp(np.linspace(0, 1, FILTER_STEPS + 1), cdf / cdf[-1], x).astype(np.float32)


def albedo_tables(instructions: np.ndarray) -> np.ndarray:
    """The tables of kernels/bsdf/ where a closure needs them, else nothing."""
    needless = [OPERATIONS[name][0] for name in TABLELESS]
    if np.isin(instructions["op"], needless).all():
        return np.zeros(0, np.float32)
    return loaded_albedo_tables()


@cache
def loaded_albedo_tables() -> np.ndarray:
    """One after the other, as albedo.h and sheen.h count."""
    folder = Path(__file__).parent / "data"
    return np.concatenate([np.load(folder / f"{name}_tables.npy").ravel() for name in ("albedo", "sheen")])


def find_features(scene: Scene, buffers: dict, materials: np.ndarray, lights: np.ndarray, lamps: int) -> int:
    """Mask of FEATURE_ bits: what kernels for this scene must know."""
    n = numbers()
    visibility = [scene.instance_visibility, scene.sphere_visibility]
    uses = {
        "FEATURE_INSTANCES": (buffers["instances"]["root"] != n["NONE"]).any(),
        "FEATURE_SPHERES": len(buffers["spheres"]) > 0,
        "FEATURE_TRANSPARENT": (materials["flags"] & n["MATERIAL_TRANSPARENT"]).any(),
        "FEATURE_VISIBILITY": any((v & n["RAY_ALL"] != n["RAY_ALL"]).any() for v in visibility),
        "FEATURE_LIGHTS": len(lights) > 0,
        "FEATURE_LAMPS": len(lights[:lamps]) > 0,
        "FEATURE_VISIBLE_LIGHTS": (lights[:lamps]["size_u"] > 0).any(),
        "FEATURE_SMOOTH": (buffers["instances"]["visibility"] & n["INSTANCE_SMOOTH"]).any(),
        "FEATURE_SLOTS": len(buffers["slots"]) > 0,
        "FEATURE_EMISSION": materials["emission"].any(),
    }
    return sum(n[name] for name, used in uses.items() if used)
