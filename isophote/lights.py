"""Lamps of a scene as Light records: Blender's strengths become radiances (docs/units.md)."""

from __future__ import annotations

import numpy as np

from isophote.records import make_records, numbers
from isophote.scene import Scene

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
SHARPEST = 1e-6  # width of a spot's edge in cosine, where Blender's blend is 0


def light_records(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """(Light records of the scene's lamps, their powers in W for light selection, f8 [L]).

    Probabilities stay 0: they are filled in once emissive triangles are known. A lamp without
    light or area has power 0, so that it is never picked.
    """
    n = numbers()
    kind, size, strength = scene.light_kind, scene.light_size, scene.light_strength
    is_ball = (kind == n["LIGHT_POINT"]) | (kind == n["LIGHT_SPOT"])
    is_sun = kind == n["LIGHT_SUN"]
    is_area = ~(is_ball | is_sun)
    area = lamp_areas(scene)
    half = np.where(is_sun | is_area, size[:, 0] / 2, size[:, 0])
    cos_cone, blend = np.cos(scene.light_spot[:, 0] / 2), scene.light_spot[:, 1]
    axes = scene.light_to_world
    records = make_records(
        "Light", len(kind), kind=kind, flags=scene.light_flags, visibility=scene.light_visibility,
        instance=n["NONE"], primitive=n["NONE"], radiance=strength * radiance_factors(scene)[:, None],
        position=axes[:, :, 3], u=axes[:, :, 0], v=axes[:, :, 1], normal=-axes[:, :, 2], size_u=half,
        # Of a sun, 1 - cos of the half angle, without the cancellation.
        size_v=np.where(is_sun, 2 * np.sin(half / 2) ** 2, np.where(is_area, size[:, 1] / 2, half)),
        area=area, spot_cos=cos_cone, spot_smooth=1 / np.maximum((1 - cos_cone) * blend, SHARPEST))
    return records, lamp_powers(scene, area, cos_cone, blend)


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


def lamp_powers(scene: Scene, area: np.ndarray, cos_cone: np.ndarray, blend: np.ndarray) -> np.ndarray:
    """Luminous part of what each lamp sends into the scene, W, f8 [L].

    A spot sends what its cone lets through: the smooth step over the blended part of the cone
    passes half. A sun lights the disk that the scene's bounding sphere fills.
    """
    n = numbers()
    kind = scene.light_kind
    power = np.abs(scene.light_strength) @ LUMINANCE
    power = np.where(kind == n["LIGHT_SPOT"], power * (1 - cos_cone) / 2 * (1 - np.clip(blend, 0, 1) / 2), power)
    is_sun = kind == n["LIGHT_SUN"]
    if is_sun.any():
        power = np.where(is_sun, power * np.pi * scene_radius(scene) ** 2, power)
    return np.where((kind >= n["LIGHT_RECTANGLE"]) & (area <= 0), 0.0, power)


def scene_radius(scene: Scene) -> float:
    """Radius in metres of a sphere around everything that can be lit; 1 for an empty scene."""
    lows, highs = [], []
    first = scene.mesh_triangles.astype(np.int64)
    filled = np.flatnonzero(np.diff(first) > 0)
    if len(filled) and len(scene.instance_mesh):
        corners = scene.vertices[scene.triangles]
        low = np.zeros((len(first) - 1, 3))
        high = low.copy()
        low[filled] = np.minimum.reduceat(corners.min(axis=1), first[filled])
        high[filled] = np.maximum.reduceat(corners.max(axis=1), first[filled])
        matrix = scene.instance_to_world
        middle = (low + high)[scene.instance_mesh] / 2
        reach = (high - low)[scene.instance_mesh] / 2
        center = np.einsum("nij,nj->ni", matrix[:, :, :3], middle) + matrix[:, :, 3]
        extent = np.einsum("nij,nj->ni", np.abs(matrix[:, :, :3]), reach)
        lows.append((center - extent).min(axis=0))
        highs.append((center + extent).max(axis=0))
    if len(scene.sphere_radius):
        lows.append((scene.sphere_center - scene.sphere_radius[:, None]).min(axis=0))
        highs.append((scene.sphere_center + scene.sphere_radius[:, None]).max(axis=0))
    if not lows:
        return 1.0
    radius = float(np.linalg.norm(np.max(highs, axis=0) - np.min(lows, axis=0)) / 2)
    return radius if np.isfinite(radius) and radius > 0.0 else 1.0
