"""Lamps of a scene as Light records: Blender's strengths become radiances (docs/units.md)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from isophote.emission import lamp_luminance, mean_radiance
from isophote.records import make_records, numbers
from isophote.scene import Scene, slots_of

SHARPEST = 1e-6  # width of a spot's edge in cosine, where Blender's blend is 0
NARROWEST = 1e-3  # radians of a spread: a parallel beam, too, has some width
EVEN = 1e-4  # in parts, by which axes differ before a spot is stretched; radians that a spread lacks of all
SMALL = 0.05  # half a spread below which its tangent less itself is a series


def light_records(scene: Scene) -> np.ndarray:
    """Light records of the scene's lamps. Their trails stay 0, for light_tree.make_light_tree."""
    n = numbers()
    scene = sharpened(scene)
    kind, size, strength = scene.light_kind, scene.light_size, scene.light_strength
    is_ball = (kind == n["LIGHT_POINT"]) | (kind == n["LIGHT_SPOT"])
    is_sun = kind == n["LIGHT_SUN"]
    is_area = ~(is_ball | is_sun)
    area = lamp_areas(scene)
    half = np.where(is_sun | is_area, size[:, 0] / 2, size[:, 0])
    cos_cone, blend = np.cos(scene.light_spot[:, 0] / 2), scene.light_spot[:, 1]
    blend_scale = 1 / np.maximum((1 - cos_cone) * blend, SHARPEST)
    tangent, spread_scale = spreads(scene)
    axes, lengths = unit_axes(scene)
    material = scene.light_material.astype(np.int64)
    uneven = (lengths > 0).all(axis=1) & (np.ptp(lengths, axis=1) > EVEN * lengths.max(axis=1))
    stretched = (kind == n["LIGHT_SPOT"]) & uneven
    stretch = np.where(stretched[:, None], lengths[:, 2:] / np.where(uneven[:, None], lengths[:, :2], 1.0), 1.0)
    return make_records(
        "Light", len(kind), kind=kind, visibility=scene.light_visibility,
        flags=scene.light_flags & ~np.uint32(n["LIGHT_COMPUTED"] | n["LIGHT_STRETCHED"])  # which are ours
        | stretched * n["LIGHT_STRETCHED"] | (material > 0) * n["LIGHT_COMPUTED"],
        instance=n["NONE"], primitive=np.where(material > 0, material - 1, n["NONE"]),
        radiance=strength * radiance_factors(scene)[:, None],
        position=scene.light_to_world[:, :, 3], u=axes[:, :, 0] * stretch[:, :1], v=axes[:, :, 1] * stretch[:, 1:],
        normal=-axes[:, :, 2], size_u=half,
        # Of a sun, 1 - cos of the half angle, without the cancellation.
        size_v=np.where(is_sun, 2 * np.sin(half / 2) ** 2, np.where(is_area, size[:, 1] / 2, half)),
        area=area, cone=np.where(is_area, tangent, cos_cone), cone_scale=np.where(is_area, spread_scale, blend_scale))


def unit_axes(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Axes of the lamps as columns, f8 [L, 3, 3], and their lengths, f8 [L, 3]."""
    axes = scene.light_to_world[:, :, :3]
    lengths = np.linalg.norm(axes, axis=1)
    return axes / np.where(lengths > 0, lengths, 1.0)[:, None], lengths


def spreads(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Of area lamps: the tangent of half the spread, and what makes their power what it would be without one; 0 where
    they have none. As in Cycles, scene/light.cpp; the small ones by the series."""
    half = np.clip(scene.light_spread, NARROWEST, np.pi) / 2
    narrow = (scene.light_spread > 0) & (half < np.pi / 2 - EVEN)
    tangent = np.tan(np.where(narrow, half, 0.0))
    rest = np.where(half < SMALL, half ** 3 / 3 * (1 + 0.4 * half ** 2), tangent - half)
    return tangent, np.where(narrow, 1 / np.where(narrow, rest, 1.0), 0.0)


def sharpened(scene: Scene) -> Scene:
    """The scene with lamps so small that float32 does not hold their radiance, or their size's square, of size 0."""
    with np.errstate(over="ignore"):
        finite = np.isfinite((scene.light_strength * radiance_factors(scene)[:, None]).astype(np.float32)).all(axis=1)
    lost = ~finite | (scene.light_size[:, 0].astype(np.float32) ** 2 < np.finfo(np.float32).tiny)
    if not (lost & (scene.light_size[:, 0] > 0)).any():
        return scene
    return replace(scene, arrays=scene.arrays | {"light_size": np.where(lost[:, None], 0.0, scene.light_size)})


def lamp_areas(scene: Scene) -> np.ndarray:
    """m^2, f8 [L]: of the sphere's surface, the rectangle or the ellipse; 0 for suns."""
    n = numbers()
    kind, size = scene.light_kind, scene.light_size
    area = np.where(kind == n["LIGHT_ELLIPSE"], np.pi / 4, 1.0) * size[:, 0] * size[:, 1]
    area = np.where(kind <= n["LIGHT_SPOT"], 4 * np.pi * size[:, 0] ** 2, area)
    return np.where(kind == n["LIGHT_SUN"], 0.0, area)


def radiance_factors(scene: Scene) -> np.ndarray:
    """What a lamp's strength is multiplied with, f8 [L], to give what Light.radiance holds.

    Radiance (1/(m^2 sr)) of a diffuse emitter: power / (pi area). A point without a radius:
    1 / (4 pi), its intensity. A sun: irradiance over the projected solid angle of its disk,
    pi sin^2(half angle); 1, the irradiance itself, where its angle is 0. As in Cycles,
    scene/light.cpp, LightManager::device_update_lights.
    """
    n = numbers()
    kind, size = scene.light_kind, scene.light_size
    area = lamp_areas(scene)
    diffuse = np.where(area > 0, 1 / (np.pi * np.where(area > 0, area, 1)), 0.0)
    point = np.where(size[:, 0] > 0, diffuse, 1 / (4 * np.pi))
    disk = np.pi * np.sin(size[:, 0] / 2) ** 2
    sun = np.where(size[:, 0] > 0, 1 / np.where(disk > 0, disk, 1), 1.0)
    return np.where(kind == n["LIGHT_SUN"], sun, np.where(kind <= n["LIGHT_SPOT"], point, diffuse))


def has_program(lamps: np.ndarray) -> np.ndarray:
    """Mask of records of lamps whose radiance is multiplied with what a material emits."""
    n = numbers()
    return (lamps["flags"] & n["LIGHT_COMPUTED"] != 0) & (lamps["kind"] < n["LIGHT_TRIANGLE"])


def estimated(lights: np.ndarray, lamps: int, buffers: dict[str, np.ndarray], viewer: np.ndarray) -> np.ndarray:
    """The records as the light tree is to have them: the radiance of lamps with programs, of the first ones, times what
    these emit. The same array where there are none.

    Programs are asked from where `viewer` (f8 [3]) is far from the lamp, for some depend on that.
    """
    own = np.flatnonzero(has_program(lights[:lamps]))
    if not len(own):
        return lights
    made = lights.copy()
    made["radiance"][own] *= lamp_luminance(buffers | {"lights": lights}, own, lights[own], viewer)[:, None]
    return made


def emitting_triangles(scene: Scene, emits: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Instance, primitive and entry of slot_materials of all triangles whose material emits, int64, in the order of
    (instance, primitive)."""
    emitting = emits[scene.slot_materials]
    found = [np.zeros((3, 0), np.int64)]
    slots = [slots_of(scene, mesh) for mesh in range(len(scene.mesh_normals))] if emitting.any() else []
    slot_counts = [int(each.max(initial=-1)) + 1 for each in slots]
    for instance, mesh in enumerate(scene.instance_mesh if slots else []):
        base = int(scene.instance_slots[instance])
        if emitting[base:base + slot_counts[mesh]].any():
            triangles = np.flatnonzero(emitting[base + slots[mesh]])
            found.append(np.stack([np.full(len(triangles), instance), int(scene.mesh_triangles[mesh]) + triangles,
                                   base + slots[mesh][triangles]]))
    return tuple(np.concatenate(found, axis=1))


def triangle_lights(scene: Scene, materials: np.ndarray, buffers: dict[str, np.ndarray]) -> np.ndarray:
    """Light records of all emissive triangles, each instance's its own, in the order of (instance, primitive).

    Where a material's emission varies, radiance is a mean; `buffers` are what it takes to compute it.
    """
    n = numbers()
    instance, primitive, slot = emitting_triangles(scene, materials["flags"] & n["MATERIAL_EMITS"] != 0)
    corners = scene.vertices[scene.triangles[primitive]].astype(np.float64)  # [N, 3, 3]
    matrix = scene.instance_to_world[instance].astype(np.float64)
    corners = sum(corners[:, :, axis, None] * matrix[:, None, :, axis] for axis in range(3)) + matrix[:, None, :, 3]
    edges = corners[:, 1:] - corners[:, :1]
    normal = np.cross(edges[:, 0], edges[:, 1])
    doubled = np.linalg.norm(normal, axis=1)
    kept = doubled > 0
    normal /= np.where(kept, doubled, 1)[:, None]
    own = materials[scene.slot_materials[slot]]
    varies = kept & (own["flags"] & n["MATERIAL_EMISSION_VARIES"] != 0)
    radiance = own["emission"].astype(np.float64)
    if varies.any():
        radiance[varies] = mean_radiance(buffers, instance[varies], primitive[varies], normal[varies])
    return make_records(
        "Light", len(primitive), kind=n["LIGHT_TRIANGLE"], instance=instance, primitive=primitive,
        visibility=scene.instance_visibility[instance], radiance=radiance,
        flags=varies * n["LIGHT_COMPUTED"] | scene.instance_group[instance].astype(np.int64) << n["LIGHT_GROUP_SHIFT"],
        position=corners[:, 0], u=edges[:, 0], v=edges[:, 1], normal=normal, area=doubled / 2)[kept]


def world_light(mean: np.ndarray, group: int, visibility: int) -> np.ndarray:
    """The Light record of a world with a mean radiance, f8 [3], its light group and the kinds of rays that see it."""
    n = numbers()
    return make_records(
        "Light", 1, kind=n["LIGHT_WORLD"], flags=n["LIGHT_COMPUTED"] | group << n["LIGHT_GROUP_SHIFT"],
        visibility=visibility, instance=n["NONE"], primitive=n["NONE"], radiance=mean, normal=[[0.0, 0.0, 1.0]])
