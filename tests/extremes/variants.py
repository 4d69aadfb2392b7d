"""A scene in other sizes, places and spaces, and its film on every device."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from bench.parity import differing_floats, expose, full_frame
from bench.specialise import WANTING
from isophote.device import list_kind, open_device
from isophote.film import Film
from isophote.materials import OF_VOLUMES, OPERATIONS
from isophote.passes import film_planes
from isophote.records import make_records, numbers
from isophote.scene import Scene
from isophote.settings import Settings
from tests.conftest import missing
from tests.scenes import SUN, mean_and_error, pixels, place, ready

POCL = "Portable Computing Language"
BOUNCES = dict.fromkeys(("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces",
                         "transparent_bounces"), 64)
TURN = place((0.3, -0.2, 0.1), (0.7, 1.3, 0.9), 0.4)  # a space of its own for what is instanced


# ------------------------------------------------------------------ scenes


def changed(scene: Scene, **arrays) -> Scene:
    """The scene with other arrays; types stay."""
    return replace(scene, arrays=scene.arrays | {name: np.ascontiguousarray(value, scene.arrays[name].dtype)
                                                 for name, value in arrays.items()})


def scaled(scene: Scene, factor: float) -> Scene:
    """All lengths times a factor. Lamps' watts grow with its square, so that radiances stay."""
    def far(matrices):
        return np.concatenate([matrices[..., :3], matrices[..., 3:] * factor], axis=-1)

    sun = (scene.light_kind == SUN)[:, None]
    return changed(
        scene, camera_to_world=far(scene.camera_to_world), camera_clip=scene.camera_clip * factor,
        camera_lens=scene.camera_lens * (factor, factor, 1, 1, 1),
        camera_window=scene.camera_window * (factor if scene.camera_kind == 1 else 1), vertices=scene.vertices,
        instance_to_world=scene.instance_to_world * factor, key_to_world=scene.key_to_world * factor,
        camera_poses=scene.camera_poses * ([factor] * 3 + [1] * 4), sphere_center=scene.sphere_center * factor,
        sphere_radius=scene.sphere_radius * factor, light_to_world=far(scene.light_to_world),
        light_size=scene.light_size * np.where(sun, 1, factor),
        light_strength=scene.light_strength * np.where(sun, 1, factor ** 2))


def scaled_vertices(scene: Scene, factor: float) -> Scene:
    """As `scaled`, but what grows are the meshes and not their instances' matrices."""
    grown, matrices, keys = scaled(scene, factor), scene.instance_to_world.copy(), scene.key_to_world.copy()
    matrices[:, :, 3] *= factor
    keys[:, :, 3] *= factor
    return changed(grown, instance_to_world=matrices, key_to_world=keys, vertices=scene.vertices * np.float32(factor),
                   key_vertices=scene.key_vertices * np.float32(factor))


def moved(scene: Scene, offset) -> Scene:
    """Everything, the camera too, `offset` metres away."""
    def far(matrices):
        return np.concatenate([matrices[..., :3], matrices[..., 3:] + np.reshape(offset, (3, 1))], axis=-1)

    return changed(scene, camera_to_world=far(scene.camera_to_world), instance_to_world=far(scene.instance_to_world),
                   sphere_center=scene.sphere_center + offset, light_to_world=far(scene.light_to_world))


def instanced(scene: Scene, matrix: np.ndarray = TURN) -> Scene:
    """The same scene in world space, but for rounding, with every mesh traced through an instance.

    Meshes lie in another space, from which `matrix` leads back, and have a second user that no ray sees.
    """
    a, linear = dict(scene.arrays), matrix[:, :3]
    a["vertices"] = ((scene.vertices - matrix[:, 3]) @ np.linalg.inv(linear).T).astype(np.float32)
    normals = scene.normals @ linear
    a["normals"] = (normals / np.linalg.norm(normals, axis=-1, keepdims=True)).astype(np.float32)
    if np.linalg.det(linear) < 0:  # outside stays outside
        a["triangles"] = a["triangles"][:, [0, 2, 1]]
    into = scene.instance_to_world
    into = np.concatenate([into[:, :, :3] @ linear, into[:, :, :3] @ matrix[:, 3:] + into[:, :, 3:]], axis=2)
    meshes, slots = len(scene.mesh_normals), int(scene.triangle_slots.max(initial=0)) + 1
    black = len(scene.material_first) - 1
    a |= {
        "instance_mesh": np.append(scene.instance_mesh, np.arange(meshes)),
        "instance_to_world": np.concatenate([into, np.broadcast_to(place(), (meshes, 3, 4))]),
        "instance_visibility": np.append(scene.instance_visibility, np.zeros(meshes)),
        "instance_terminator": np.append(scene.instance_terminator, np.zeros(meshes)),
        "instance_slots": np.append(scene.instance_slots, np.full(meshes, len(scene.slot_materials))),
        "instance_keys": np.append(scene.instance_keys, np.zeros(meshes)),
        "slot_materials": np.append(scene.slot_materials, np.full(slots, black)),
        "material_first": np.append(scene.material_first, len(scene.instruction_op) + 1),
        "instruction_op": np.append(scene.instruction_op, OPERATIONS["diffuse"][0]),
        "instruction_weight": np.concatenate([scene.instruction_weight, np.zeros((1, 3))]),
        "instruction_params": np.concatenate([scene.instruction_params, 0 * scene.instruction_params[:1]]),
        "instruction_flags": np.append(scene.instruction_flags, 0),
        "material_volume": np.append(scene.material_volume, 0),
        "material_steps": np.append(scene.material_steps, len(scene.step_op)),
        "material_shadow_steps": np.append(scene.material_shadow_steps, 0),
    }
    return changed(scene, **a)


def spaces(scene: Scene) -> dict[str, Scene]:
    """The scene with transforms applied, instanced, and instanced in a mirrored space (det < 0)."""
    return {"applied": scene, "instanced": instanced(scene), "mirrored": instanced(scene, TURN * [[-1], [1], [1]])}


# ------------------------------------------------------------------ films


@cache
def opencl_device(lights: bool):
    """PoCL with a program for any scene that has lights, or for any that has none."""
    for info in list_kind("opencl"):
        if POCL in info.driver and info.usable:
            return open_device(info.id, Settings(device=info.id))
    return missing(f"no OpenCL platform {POCL!r}")


def for_any_scene(prepared):
    """Compiled for all features and operations, of which the scene uses some: one program serves all tests."""
    n = numbers()
    lights = n["FEATURE_LIGHTS"] | n["FEATURE_LAMPS"] | n["FEATURE_VISIBLE_LIGHTS"]
    every = sum(value for name, value in n.items() if name.startswith("FEATURE_")) & ~lights
    every |= lights if prepared.features & lights else 0
    # These say that there are arrays of slots and poses, and values that are computed of surfaces, the world, lights.
    there = ("SLOTS", "VALUES", "BUMP", "LENS", *WANTING)
    every &= ~sum(n[f"FEATURE_{name}"] for name in there) | prepared.features
    closures = [number for name, (number, _) in OPERATIONS.items() if name not in ("emission", *OF_VOLUMES)]
    unused = make_records("Instruction", len(closures), op=closures)
    tables = prepared.buffers["albedo_tables"]
    buffers = prepared.buffers | {"instructions": np.concatenate([prepared.buffers["instructions"], unused]),
                                  "albedo_tables": tables}
    return replace(prepared, features=every, buffers=buffers)


def opencl_film(prepared, region, samples: int, settings: Settings, first: int = 0) -> Film:
    device = opencl_device(bool(prepared.features & numbers()["FEATURE_LIGHTS"]))
    device.take_up(replace(settings, device=device.settings.device))
    device.upload(for_any_scene(prepared))
    return expose(device, Film(region, film_planes(settings), first), first + samples, settings)


def openmp_film(prepared, region, samples: int, settings: Settings, first: int = 0) -> Film:
    device = open_device("openmp", settings)
    try:
        device.upload(prepared)
        return expose(device, Film(region, film_planes(settings), first), first + samples, settings)
    finally:
        device.close()


def settings_for(samples: int, **changes) -> Settings:
    """Every bounce limit is 64 unless it is given."""
    return Settings(**BOUNCES | dict(samples=samples, passes=("combined",)) | changes)


def film(scene: Scene, samples: int = 64, **changes) -> Film:
    """The strict film. It has the same bits on OpenMP and on OpenCL, or the test fails here."""
    settings, prepared = settings_for(samples, **changes), ready(scene)
    region = settings.region or full_frame(scene)
    mine = openmp_film(prepared, region, samples, settings)
    other = opencl_film(prepared, region, samples, settings)
    differing = sum(differing_floats(mine.sum(plane), other.sum(plane)) for plane in range(mine.planes.sums))
    assert not differing, f"{differing} floats differ between OpenMP and OpenCL"
    return mine


def reference(scene: Scene, samples: int = 64, **changes) -> Film:
    """The float64 film: the same random numbers, the same paths."""
    settings = settings_for(samples, precision="reference", **changes)
    return openmp_film(ready(scene), settings.region or full_frame(scene), samples, settings)


def rgb(made: Film) -> np.ndarray:
    """Means (h, w, 3), float64."""
    return pixels(made)[..., :3]


def differing(a: Film, b: Film) -> int:
    """Sums that differ in a bit."""
    return sum(differing_floats(a.sum(plane), b.sum(plane)) for plane in range(a.planes.sums))


def rounding(made: Film, exact: Film) -> float:
    """Relative difference of the median pixel of two films that share their random numbers.

    A path that touches an edge takes another turn for the smallest difference, so a few pixels say nothing; but
    the pictures' means must agree within three standard errors, or the test fails here.
    """
    (mean, error), (other, _) = mean_and_error(exact), mean_and_error(made)
    assert (np.abs(mean - other) <= 3 * error).all(), f"means differ by {np.abs(mean - other) / error} standard errors"
    return float(np.median(np.abs(rgb(made) - rgb(exact)) / rgb(exact).mean()))
