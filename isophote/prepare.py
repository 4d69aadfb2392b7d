"""From a scene to the buffers that kernels read: trees, lights to sample, tables, and what the scene uses."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np

from isophote.geometry import Geometry, make_geometry
from isophote.light_linking import link_features, link_records, lit_sets, lit_shares
from isophote.light_tree import make_light_tree, shining
from isophote.lights import estimated, has_program, light_records, triangle_lights, world_light
from isophote.majorants import find_majorants
from isophote.materials import OPERATIONS, closure_mask, is_delta
from isophote.motion import deforming, moving
from isophote.planes import named_width
from isophote.records import make_records, numbers, scene_buffers
from isophote.scene import Scene
from isophote.strands import stranded
from isophote.values import operation_of, operations
from isophote.volumes import Filled, filled_objects, has_volumes, is_camera_enclosed
from isophote.world_map import make_world_map

TRANSMITTING = ("refraction", "glass", "principled_glass", "film_glass", "beckmann_glass", "translucent")
TABLELESS = ("diffuse", "transparent", "rough_diffuse", "translucent", "diffuse_toon", "glossy_toon", "velvet",
             "beckmann", "beckmann_glass", "ashikhmin_shirley", "layer_absorption", "layer_reset",
             "holdout", "subsurface", "scattering")
FILTER_STEPS = 1024
VALUE_FAMILIES = 8  # kernels/values/values.h
NAME_OF_OPERATION = {number: name for name, (number, _) in OPERATIONS.items()}


@dataclass
class Prepared:
    """What a device takes. `buffers` holds an array for each entry of kernels/scene_buffers.h, but not for `nodes` and
    `triangles`: these are for those who trace the BVH2 and are made by `traced`.

    `features` is a mask of FEATURE_ bits, `operations` one of the instructions' operations (bit 1 << op), `values` has
    such a mask for each family of operations on values, `registers` is how many of these there are: what kernels must
    know. `resolution` is the full frame (width, height) in pixels.
    """

    buffers: dict[str, np.ndarray]
    geometry: Geometry
    features: int
    operations: int
    values: list[int]
    registers: int
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
    buffers = program_buffers(scene, geometry.buffers)
    buffers |= as_kernels_have_them(make_lights(scene, buffers))
    features = int(buffers["world"]["features"][0])
    closures = closure_mask(np.unique(buffers["instructions"]["op"]).tolist())
    return Prepared(buffers, geometry, features, closures, values_used(scene), registers_used(scene),
                    tuple(int(r) for r in scene.resolution), time.perf_counter() - started)


def program_buffers(scene: Scene, geometry: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """All that programs of materials read: the buffers of a geometry, and what there is but lights."""
    materials, instructions = make_materials(scene)
    filled = filled_objects(scene)
    buffers = geometry | {
        "camera": make_camera(scene), "materials": materials, "instructions": instructions,
        "steps": make_steps(scene), **lookup_buffers(scene), "slot_materials": scene.slot_materials,
        "filter_table": filter_tables(scene), "albedo_tables": albedo_tables(instructions),
        "light_groups": light_groups(scene), "aovs": make_aovs(scene), "terminators": terminators(scene),
        "pass_indices": np.concatenate([pass_indices(scene), matte_ids(scene)])}
    buffers["world"] = make_world(scene, buffers, filled)
    buffers["world"]["features"] = find_features(scene, buffers, materials)
    buffers = as_kernels_have_them(buffers)
    if len(scene.step_op) and not len(scene.instance_mesh):
        buffers |= stand_ins(scene, buffers)
    if has_volumes(scene) and len(scene.step_op):
        buffers["materials"]["majorant"] = find_majorants(scene, buffers, filled)
    return buffers


def stand_ins(scene: Scene, buffers: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Zeros for a scene of spheres: what steps read of a mesh, to drop it again where they meet something else."""
    counts = {"instances": 1, "indices": 3, "vertices": 1, "normals": 1, "instance_meshes": 1, "attribute_values": 1,
              "mesh_attributes": scene.mesh_attributes.shape[1], "instance_values": scene.instance_values.shape[1]}
    return {name: np.zeros((count, 3) if name in ("vertices", "normals") else count, buffers[name].dtype)
            for name, count in counts.items()}


def as_kernels_have_them(buffers: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """In the order of kernels/scene_buffers.h, in its types."""
    return {name: np.ascontiguousarray(buffers[name], dtype.base) for name, dtype in scene_buffers().items()
            if name in buffers}


def make_world(scene: Scene, buffers: dict[str, np.ndarray], filled: list[Filled]) -> np.ndarray:
    """The world's record, without lights; `buffers` hold light_groups, `filled` are volumes.filled_objects."""
    none = numbers()["NONE"]
    indices, ids = pass_indices(scene), matte_ids(scene)
    material = scene.world_material[0] if len(scene.world_material) else none
    spheres = len(scene.instance_index) if len(indices) else none
    things = len(scene.instance_matte) + len(scene.sphere_matte)
    start, depth, falloff = scene.mist
    known = numbers()["VECTORS_CAMERA"] | numbers()["VECTORS_MOTION"] * (len(buffers["motions"]) > 0)
    vectors = known if scene.vectors and len(scene.camera_poses) == 3 else 0
    return make_records("World", 1, radiance=scene.world_radiance, origin=scene.origin, root=0, material=material,
                        light_group=scene.world_group,
                        sphere_groups=len(scene.instance_group) if len(buffers["light_groups"]) else none,
                        volume=scene.world_volume - 1 if scene.world_volume else none,
                        camera_enclosed=is_camera_enclosed(scene, filled), vectors=vectors,
                        aovs=scene.aov_values.shape[1], mist_start=start, mist_falloff=falloff,
                        mist_scale=1.0 / depth if depth > 0.0 else 0.0,
                        uv=scene.uv_attribute[0] if len(scene.uv_attribute) else none, sphere_indices=spheres,
                        material_indices=none if spheres == none else spheres + len(scene.sphere_index),
                        mattes=len(indices) if len(ids) else none, sphere_mattes=len(scene.instance_matte),
                        material_mattes=len(indices) + 2 * things, occlusion_distance=scene.occlusion_distance,
                        hidden=scene.world_hidden, attributes=scene.mesh_attributes.shape[1],
                        instance_columns=scene.instance_values.shape[1],
                        registers=registers_used(scene))


def pass_indices(scene: Scene) -> np.ndarray:
    """Of instances, spheres and materials; empty where all are 0."""
    joined = np.concatenate([scene.instance_index, scene.sphere_index, scene.material_index])
    return joined if joined.any() else joined[:0]


def matte_ids(scene: Scene) -> np.ndarray:
    """Of instances and spheres, object and asset in turn, then of materials, float32; empty where there are none."""
    joined = np.concatenate([scene.instance_matte.ravel(), scene.sphere_matte.ravel(), scene.material_matte])
    return joined.view(np.float32) if joined.any() else np.zeros(0, np.float32)


def light_groups(scene: Scene) -> np.ndarray:
    """Of instances and spheres; empty where none has one."""
    joined = np.concatenate([scene.instance_group, scene.sphere_group])
    return joined if joined.any() else joined[:0]


def terminators(scene: Scene) -> np.ndarray:
    """Of instances of smooth meshes; empty where all are 0."""
    smooth = scene.mesh_normals[scene.instance_mesh] >= 0
    made = np.where(smooth, scene.instance_terminator, np.float32(0.0))
    return made if made.any() else made[:0]


def make_aovs(scene: Scene) -> np.ndarray:
    """AovOutput records, by material and output."""
    widths = [named_width(name) for name in scene.aovs]
    planes = np.cumsum([0, *widths])[:-1]
    materials = len(scene.aov_values)
    return make_records("AovOutput", scene.aov_flags.size, plane=np.tile(planes, materials),
                        color=np.tile([width > 1 for width in widths], materials), flags=scene.aov_flags.ravel(),
                        value=scene.aov_values.reshape(-1, 3))


def make_lights(scene: Scene, buffers: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """What it takes to draw lights: their records, lamps before triangles, their tree, the world's map and record.

    `buffers` hold what programs of materials read.
    """
    lamps, cells = light_records(scene), np.zeros(0, np.float32)
    kept = shining(lamps)
    lamps = lamps[kept]
    visible = numbers()["RAY_ALL"] & ~scene.world_hidden.item()
    world_map = make_world_map(scene, buffers) if visible & numbers()["RAY_INDIRECT"] else None
    world = buffers["world"].copy()
    if world_map:
        lamps = np.concatenate([lamps, world_light(world_map.mean, scene.world_group.item(), visible)])
        world["map_width"], world["map_height"] = world_map.width, world_map.height
        cells = world_map.cumulated
    if world_map and world_map.sun_width:
        world["sun"], world["sun_width"] = scene.world_sun[0, :3], world_map.sun_width
        world["sun_chance"] = world_map.sun_chance
        world["features"] |= numbers()["FEATURE_WORLD_SUN"]
    triangles = triangle_lights(scene, buffers["materials"], buffers)
    lights = np.concatenate([lamps, triangles[shining(triangles)]])
    guessed = estimated(lights, len(lamps), buffers, scene.camera_to_world[:, 3])
    light_tree, world["light_depth"], shares = make_light_tree(guessed, lit_sets(scene, lights, kept))
    lights["trail"] = guessed["trail"]
    world["light_count"], world["lamp_count"] = len(lights), len(lamps)
    world["features"] |= light_features(lights, len(lamps)) | link_features(scene)
    world["receiver_sets"], world["sphere_links"] = shares.shape[1], len(scene.instance_sets)
    world["lamp_links"] = len(scene.instance_sets) + len(scene.sphere_sets)
    return {"lights": lights, "light_tree": light_tree, "world_map": cells, "world": world,
            "links": link_records(scene, kept), "lit_shares": lit_shares(shares)}


def make_camera(scene: Scene) -> np.ndarray:
    """The camera's record, then those of its poses."""
    matrix = scene.camera_to_world
    left, right, bottom, top = scene.camera_window
    polynomial = scene.camera_kind == numbers()["CAMERA_POLYNOMIAL"]
    middle = abs(scene.camera_panorama[2]) if polynomial else 1.0  # angle by distance there
    poses = make_records("Camera", len(scene.camera_poses), position=scene.camera_poses[:, :3],
                         turn=scene.camera_poses[:, 3:])
    camera = make_records(
        "Camera", 1, x=matrix[:, 0], y=matrix[:, 1], z=matrix[:, 2], position=matrix[:, 3], left=left, right=right,
        bottom=bottom, top=top,
        pixel=0.5 * (abs(right - left) / scene.resolution[0] + abs(top - bottom) / scene.resolution[1]) * middle,
        clip_start=scene.camera_clip[0], clip_end=scene.camera_clip[1],
        lens=scene.camera_lens[0], focus=scene.camera_lens[1], blades=scene.camera_lens[2],
        blade_rotation=scene.camera_lens[3], lens_ratio=scene.camera_lens[4], kind=scene.camera_kind,
        width=scene.resolution[0], height=scene.resolution[1], reach=scene.camera_panorama[0],
        polynomial=scene.camera_panorama[1:6], shift_x=scene.camera_panorama[6], shift_y=scene.camera_panorama[7],
        eye=scene.camera_stereo[0], convergence=scene.camera_stereo[1], merge_from=scene.camera_stereo[2],
        merge_to=scene.camera_stereo[3], poses=0 if scene.vectors else len(poses))
    return np.concatenate([camera, poses])


def make_materials(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Material records and the instructions that remain once emission is folded into them.

    Of a material whose emission or transparency varies validate has found one instruction for it.
    """
    n = numbers()
    varies = scene.instruction_flags & n["INSTRUCTION_VARIES"] != 0
    bumps = scene.instruction_flags & n["INSTRUCTION_BUMPS"] != 0
    operation = np.array([NAME_OF_OPERATION[op] for op in scene.instruction_op.tolist()], dtype=object)
    made, kept, placed = make_records("Material", len(scene.material_first) - 1), [], 0
    walks = "subsurface" in operation
    for number, material in enumerate(made):
        program = np.arange(scene.material_first[number], scene.material_first[number + 1])
        emission = program[operation[program] == "emission"]
        transparent = program[np.isin(operation[program], ("transparent", "extinction"))]
        rest = program[~np.isin(operation[program], ("emission", "extinction"))]
        closures = [i for i in rest if not operation[i].startswith("layer_")]
        smooth = all(is_delta(int(scene.instruction_op[i]), scene.instruction_params[i], varies[i]) for i in closures)
        material["emission"] = scene.instruction_weight[emission].sum(0)
        material["transparency"] = scene.instruction_weight[transparent].sum(0)
        material["first"], material["count"] = placed, len(rest)
        material["first_step"] = scene.material_steps[number]
        material["steps"] = scene.material_steps[number + 1] - scene.material_steps[number]
        material["shadow_steps"] = scene.material_shadow_steps[number]
        material["volume"] = scene.material_volume[number] - 1 if scene.material_volume[number] else n["NONE"]
        glows, passes = varies[emission].any(), varies[transparent].any()
        material["flags"] = (bool(glows or material["emission"].any()) * n["MATERIAL_EMITS"]
                             | bool(passes or material["transparency"].any()) * n["MATERIAL_TRANSPARENT"]
                             | glows * n["MATERIAL_EMISSION_VARIES"] | passes * n["MATERIAL_TRANSPARENCY_VARIES"]
                             | bumps[rest].any() * n["MATERIAL_BUMPS"]
                             | any(operation[i] == "holdout" for i in rest) * n["MATERIAL_HOLDS_OUT"]
                             | smooth * n["MATERIAL_DELTA_ONLY"]
                             | (scene.material_volume[number] > 0 and not len(program)) * n["MATERIAL_BOUNDARY"]
                             | any(operation[i] in TRANSMITTING for i in rest) * n["MATERIAL_TRANSMITS"])
        below = rest[operation[rest] == "subsurface"]
        material["flags"] |= bool(len(below)) * n["MATERIAL_SUBSURFACE"]
        kept += [make_instructions(scene, rest), *([way_out(scene, below)] if walks else [])]
        placed += len(rest) + walks
    return made, np.concatenate(kept) if kept else make_instructions(scene, np.zeros(0, int))


def make_instructions(scene: Scene, rows: np.ndarray) -> np.ndarray:
    """Instruction records of rows of the scene's."""
    return make_records("Instruction", len(rows), op=scene.instruction_op[rows], flags=scene.instruction_flags[rows],
                        weight=scene.instruction_weight[rows], params=scene.instruction_params[rows])


def way_out(scene: Scene, below: np.ndarray) -> np.ndarray:
    """The closure, white and diffuse, by which light comes out of a material with these rows of subsurface scattering:
    with the normal of the first of them that has its own."""
    n = numbers()
    own = below[scene.instruction_flags[below] & n["INSTRUCTION_BUMPS"] != 0][:1]
    record = make_instructions(scene, own) if len(own) else make_records("Instruction", 1, weight=1.0)
    if len(own):  # weights are registers
        record["weight"] = record["params"][:, -1:]
    record["op"] = OPERATIONS["diffuse"][0]
    return record


def make_steps(scene: Scene) -> np.ndarray:
    """ValueStep records."""
    return make_records("ValueStep", len(scene.step_op), op=scene.step_op, to=scene.step_to, repeat=scene.step_repeat,
                        data=scene.step_data, number=scene.step_number, **{"from": scene.step_from})


def values_used(scene: Scene) -> list[int]:
    """A mask of the operations on values that the scene's steps need, for each family of 32."""
    masks = [0] * VALUE_FAMILIES
    for op in np.unique(scene.step_op).tolist():
        masks[op // 32] |= 1 << op % 32
    return masks


def registers_used(scene: Scene) -> int:
    """The largest number of registers that a material's steps need."""
    outputs = np.array([operations()[operation_of(op)].outputs for op in scene.step_op.tolist()], np.int64)
    return int((scene.step_to + outputs).max(initial=0))


def lookup_buffers(scene: Scene) -> dict[str, np.ndarray]:
    """What steps read beside their registers. Attributes are placed so that the numbers of the scene's vertices,
    triangles and corners lead to their values."""
    n, a = numbers(), scene.mesh_attributes.astype(np.int64)
    start = np.zeros((len(a), 5), np.int64)  # the mesh's first element, by domain
    start[:, n["DOMAIN_VERTEX"]] = scene.mesh_vertices[:-1]
    start[:, n["DOMAIN_TRIANGLE"]] = scene.mesh_triangles[:-1]
    start[:, n["DOMAIN_CORNER"]] = 3 * scene.mesh_triangles[:-1].astype(np.int64)
    first = a[:, :, 0] - a[:, :, 2] * np.take_along_axis(start, a[:, :, 1], axis=1)
    i = scene.images.astype(np.int64)
    texels = np.zeros(-(-len(scene.image_texels) // 4) * 4, np.uint8)
    texels[:len(scene.image_texels)] = scene.image_texels
    return {
        "value_tables": scene.value_tables,
        "mesh_attributes": make_records("MeshAttribute", first.size, first=(first % 2**32).ravel(),
                                        domain=a[:, :, 1].ravel(), components=a[:, :, 2].ravel()),
        "attribute_values": scene.attribute_values if len(scene.attribute_values) else np.zeros(a.size, np.float32),
        "instance_meshes": scene.instance_mesh if a.size else np.zeros(0, np.uint32),
        "instance_values": scene.instance_values,
        "images": make_records("Image", len(i), first=i[:, 0], width=i[:, 1], height=i[:, 2], channels=i[:, 3],
                               texel=i[:, 4], flags=i[:, 5]),
        "texels": texels.view(np.uint32),
    }


@cache
def blackman_harris_table() -> np.ndarray:
    """Inverse CDF of the Blackman-Harris window (Harris 1978, table I, four terms) for filter_width 1, float32.

    The window is two filter widths wide, as in Cycles (src/scene/film.cpp, filter_table): most of its
    weight then lies within one.
    """
    x = np.linspace(-1.0, 1.0, 1 << 16 | 1)
    phase = np.pi * (x + 1.0)
    window = 0.35875 - 0.48829 * np.cos(phase) + 0.14128 * np.cos(2 * phase) - 0.01168 * np.cos(3 * phase)
    return inverse_cdf(x, window)


def inverse_cdf(x: np.ndarray, density: np.ndarray) -> np.ndarray:
    """At FILTER_STEPS + 1 even chances, of a density that is linear between the x, float32."""
    cdf = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
    return np.interp(np.linspace(0, 1, FILTER_STEPS + 1), cdf / cdf[-1], x).astype(np.float32)


def filter_tables(scene: Scene) -> np.ndarray:
    """Those that camera rays are drawn by: of the pixel filter, and where something moves of the shutter."""
    if not (len(scene.camera_poses) or len(scene.key_to_world) or len(scene.key_vertices)) or scene.vectors:
        return blackman_harris_table()
    return np.concatenate([blackman_harris_table(), shutter_table(scene.shutter_curve)])


def shutter_table(curve: np.ndarray) -> np.ndarray:
    """Inverse CDF of a curve that is linear between its values, float32; of an even one where it is empty."""
    if not len(curve) or not curve.sum() > 0.0:
        curve = np.ones(2)
    time = np.linspace(0.0, 1.0, 1 << 14 | 1)
    return inverse_cdf(time, np.interp(time, np.linspace(0.0, 1.0, len(curve)), curve))


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


def find_features(scene: Scene, buffers: dict, materials: np.ndarray) -> int:
    """Mask of FEATURE_ bits: what kernels for this scene must know, but for its lights."""
    n = numbers()
    visibility = [scene.instance_visibility, scene.sphere_visibility]
    uses = {
        "FEATURE_INSTANCES": (buffers["instances"]["root"] != n["NONE"]).any(),
        "FEATURE_SPHERES": len(buffers["spheres"]) > 0,
        "FEATURE_TRANSPARENT": (materials["flags"] & n["MATERIAL_TRANSPARENT"]).any() or has_volumes(scene),
        "FEATURE_VISIBILITY": scene.catches or any((v & n["RAY_ALL"] != n["RAY_ALL"]).any() for v in visibility),
        "FEATURE_CATCHERS": scene.catches,
        "FEATURE_SMOOTH": (buffers["instances"]["visibility"] & n["INSTANCE_SMOOTH"]).any(),
        "FEATURE_SLOTS": len(buffers["slots"]) > 0,
        "FEATURE_EMISSION": materials["emission"].any(),
        "FEATURE_LENS": scene.camera_lens[0] > 0,
        "FEATURE_PANORAMA": scene.camera_kind >= n["CAMERA_EQUIRECTANGULAR"],
        "FEATURE_CAMERA_MOTION": len(scene.camera_poses) > 0 and not scene.vectors,
        "FEATURE_VALUES": len(scene.step_op) > 0 or len(scene.uv_attribute) > 0,
        "FEATURE_BUMP": (materials["flags"] & n["MATERIAL_BUMPS"]).any(),
        "FEATURE_WORLD": len(scene.world_material) > 0,
        "FEATURE_VOLUME": has_volumes(scene),
        "FEATURE_TERMINATOR": len(buffers["terminators"]) > 0,
        "FEATURE_SUBSURFACE": (materials["flags"] & n["MATERIAL_SUBSURFACE"]).any(),
        "FEATURE_STRANDS": stranded(scene).any(),
        "FEATURE_MOTION": moving(scene).any() or deforming(scene).any(),
        "FEATURE_DEFORMATION": deforming(scene).any(),
    }
    return sum(n[name] for name, used in uses.items() if used)


def has_shapes(lamps: np.ndarray) -> bool:
    """Whether an area lamp has a spread, or a spot is stretched."""
    n = numbers()
    is_area = (lamps["kind"] == n["LIGHT_RECTANGLE"]) | (lamps["kind"] == n["LIGHT_ELLIPSE"])
    return bool((is_area & (lamps["cone_scale"] > 0) | (lamps["flags"] & n["LIGHT_STRETCHED"] != 0)).any())


def has_limits(lights: np.ndarray) -> bool:
    """Whether some rays that a surface sends on, or paths of many bounces, do not see a light."""
    n = numbers()
    bounces = lights["flags"] >> n["LIGHT_BOUNCES_SHIFT"] & 255  # LIGHT_BOUNCES; above it lies the light group
    indirect = n["RAY_INDIRECT"]
    return bool(((lights["visibility"] & indirect != indirect) | (bounces != 0)).any())


def light_features(lights: np.ndarray, lamps: int) -> int:
    """Those of its lights, of which the first `lamps` are no triangles."""
    n = numbers()
    uses = {
        "FEATURE_LIGHTS": len(lights) > 0,
        "FEATURE_LAMPS": lamps > 0,
        "FEATURE_VISIBLE_LIGHTS": (lights[:lamps]["size_u"] > 0).any(),
        "FEATURE_LAMP_SHAPES": has_shapes(lights[:lamps]),
        "FEATURE_LIGHT_LIMITS": has_limits(lights),
        "FEATURE_LAMP_PROGRAMS": has_program(lights[:lamps]).any(),
        "FEATURE_WORLD_LIGHT": (lights["kind"] == n["LIGHT_WORLD"]).any(),
        "FEATURE_SHINES": (lights["flags"] & n["LIGHT_COMPUTED"]).any(),
    }
    return sum(n[name] for name, used in uses.items() if used)
