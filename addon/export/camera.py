# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera: a rigid frame, a window and clip distances.

The window follows Blender's view plane (BKE_camera_params_compute_viewplane): the sensor fits the
longer side in AUTO, the shift is counted in the fitted side, and pixels may be oblong.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isophote.records import numbers
from isophote.scene import SceneError

from .. import compat
from .origin import make_origin

KINDS = {"PERSP": "PERSPECTIVE", "ORTHO": "ORTHOGRAPHIC"}  # CAMERA_ numbers of kernels/scene_records.h
PANORAMAS = {
    "EQUIRECTANGULAR": "EQUIRECTANGULAR", "CENTRAL_CYLINDRICAL": "CYLINDER", "EQUIANGULAR_CUBEMAP_FACE": "CUBE_FACE",
    "MIRRORBALL": "MIRROR_BALL", "FISHEYE_EQUIDISTANT": "EQUIDISTANT", "FISHEYE_EQUISOLID": "EQUISOLID",
    "FISHEYE_LENS_POLYNOMIAL": "POLYNOMIAL"}
# Axes of the record in those of Blender's camera: forward, left, down, and of a mirror ball right, back, down. So its
# space is that of Cycles' panoramas (kernels/camera_space.h).
PANORAMA_AXES = ((2, 0, 1), (-1.0, -1.0, -1.0))
BALL_AXES = ((0, 2, 1), (1.0, 1.0, -1.0))


def export_camera(scene, camera, resolution, notes, view: View | None = None,
                  origin: np.ndarray | None = None) -> dict[str, np.ndarray]:
    """The scene's arrays of the camera, and its origin in Blender's world, f8 [3].

    `scene` and `camera` are evaluated; `resolution` is (width, height) in pixels. Of several views each has its own
    `view`, and the `origin` of the first. Raises SceneError where there is no camera.
    """
    if camera is None or camera.type != "CAMERA":
        raise SceneError(f"no camera in scene '{scene.name}'")
    data = camera.data
    kind, panorama = kind_of(data, camera.name, notes)
    view = view or View(np.array(camera.matrix_world, dtype=np.float64), data.shift_x)
    matrix, shift = view.matrix, (view.shift_x, data.shift_y)
    axes = make_rigid(matrix, camera.name, notes)
    window, shape = make_window(data, scene.render, resolution, shift), np.zeros(8)
    if panorama is not None:
        window, shape = make_panorama(kind, data, panorama, scene.render, resolution, shift)
    elif view.stereo[0]:
        what = "spherical stereo is supported for panoramas alone: rendered from one place for both eyes"
        notes.add("camera", camera.name, what)
    if origin is None:
        origin = make_origin(matrix[:3, 3], window[1] - window[0] if data.type == "ORTHO" else data.clip_start)
    return {
        "origin": origin,
        "resolution": np.array(resolution, dtype=np.int32),
        "camera_kind": np.int32(numbers()[f"CAMERA_{kind}"]),
        "camera_to_world": np.concatenate([axes_of(kind, axes), (matrix[:3, 3] - origin)[:, None]], axis=1),
        "camera_window": window,
        "camera_clip": np.array([data.clip_start, data.clip_end], dtype=np.float64),
        "camera_lens": make_lens(data, matrix, axes),
        "camera_panorama": shape,
        "camera_stereo": np.array(view.stereo if panorama is not None else (0.0,) * 4),
    }


@dataclass(frozen=True)
class View:
    """The camera as one of a render's views has it: its matrix, f8 [4, 4], the window's shift, and what spherical
    stereo adds (a scene's camera_stereo)."""

    matrix: np.ndarray
    shift_x: float
    stereo: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)


def camera_of(engine, depsgraph):
    """The evaluated camera of the engine's active view: views may have cameras of their own."""
    camera = engine.camera_override or depsgraph.scene_eval.camera
    return camera.evaluated_get(depsgraph)


def view_of(engine, camera, name: str) -> View:
    """The view that the engine has made the active one; `camera` is evaluated."""
    spherical = engine.use_spherical_stereo(camera)
    matrix = np.array(engine.camera_model_matrix(camera, use_spherical_stereo=spherical), dtype=np.float64)
    shift = engine.camera_shift_x(camera, use_spherical_stereo=spherical)
    stereo, side = camera.data.stereo, {"left": -0.5, "right": 0.5}.get(name, 0.0)
    if not spherical or not side:
        return View(matrix, shift)
    convergence = 0.0 if stereo.convergence_mode == "PARALLEL" else stereo.convergence_distance
    merge = (stereo.pole_merge_angle_from, stereo.pole_merge_angle_to) if stereo.use_pole_merge else (0.0, 0.0)
    return View(matrix, shift, (side * stereo.interocular_distance, convergence, *merge))


def kind_of(data, name: str, notes) -> tuple[str, object]:
    """(CAMERA_ kind, what holds the camera's panorama or None)."""
    panorama = compat.panorama_of(data) if data.type == "PANO" else None
    if panorama is not None and panorama.panorama_type in PANORAMAS:
        return PANORAMAS[panorama.panorama_type], panorama
    if data.type not in KINDS:
        what = (panorama.panorama_type if panorama is not None else data.type).lower().replace("_", " ")
        notes.add("camera", name, f"{what} cameras are not supported: rendered as perspective")
    return KINDS.get(data.type, "PERSPECTIVE"), None


def axes_of(kind: str, axes: np.ndarray) -> np.ndarray:
    """Blender's axes of a camera, f8 [3, 3], as kernels have them."""
    if kind not in PANORAMAS.values():
        return axes
    columns, signs = BALL_AXES if kind == "MIRROR_BALL" else PANORAMA_AXES
    return axes[:, columns] * signs


def make_panorama(kind: str, data, panorama, render, resolution, shift) -> tuple[np.ndarray, np.ndarray]:
    """(left, right, bottom, top in what kernels/panorama.h counts, f8 [4]; the scene's camera_panorama, f8 [8]).

    As in Cycles (intern/cycles/blender/camera.cpp) the sensor fits as it does for other cameras, and a shift counts in
    whole frames.
    """
    reach, polynomial = 0.0, np.zeros(5)
    if kind == "EQUIRECTANGULAR":
        low = np.array([panorama.longitude_min, panorama.latitude_min])
        high = np.array([panorama.longitude_max, panorama.latitude_max])
    elif kind == "CYLINDER":
        scale = np.array([1.0, 1.0 / panorama.central_cylindrical_radius])
        low = scale * (panorama.central_cylindrical_range_u_min, panorama.central_cylindrical_range_v_min)
        high = scale * (panorama.central_cylindrical_range_u_max, panorama.central_cylindrical_range_v_max)
    else:
        if kind == "CUBE_FACE":
            high = np.full(2, np.pi / 4.0)
        elif kind == "MIRROR_BALL":
            high, reach = np.full(2, 2.0), 2.0
        elif kind == "EQUIDISTANT":
            high, reach = np.full(2, panorama.fisheye_fov / 2.0), panorama.fisheye_fov / 2.0
        elif kind == "EQUISOLID":
            high = sensor_of(data, render, resolution) / (2.0 * panorama.fisheye_lens)
            reach = 2.0 * np.sin(panorama.fisheye_fov / 4.0)
        else:
            high, reach = sensor_of(data, render, resolution) / 2.0, panorama.fisheye_fov / 2.0
            polynomial = np.array([getattr(panorama, f"fisheye_polynomial_k{k}") for k in range(5)])
        low = -high
    shift = (high - low) * shift
    (left, bottom), (right, top) = low + shift, high + shift
    return np.array([left, right, bottom, top]), np.array([reach, *polynomial, *shift])


def sensor_of(data, render, resolution) -> np.ndarray:
    """Width and height of what a frame uses of the sensor, mm, f8 [2]."""
    left, right, bottom, top = make_window(data, render, resolution, (0.0, 0.0)) * data.lens
    return np.array([right - left, top - bottom])


def make_rigid(matrix: np.ndarray, name: str, notes) -> np.ndarray:
    """Unit, orthogonal axes of a camera's matrix, f8 [3, 3]: scale does not count, mirroring does.

    Raises SceneError where an axis has no length.
    """
    axes = matrix[:3, :3]
    lengths = np.linalg.norm(axes, axis=0)
    if not np.all(np.isfinite(matrix)) or np.any(lengths == 0.0):
        raise SceneError(f"camera '{name}' has a matrix with zero scale or values that are not finite")
    axes = axes / lengths
    x, y, z = axes.T

    # Plain sums, not BLAS: the same bits from every version of numpy.
    def dot(a, b):
        return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]

    if max(abs(dot(x, y)), abs(dot(y, z)), abs(dot(z, x))) > 1e-4:
        notes.add("camera", name, "its matrix is sheared: the shear is left out")
    x = x - z * dot(z, x)
    x = x / np.sqrt(dot(x, x))
    up = np.cross(z, x)
    return np.stack([x, up if dot(up, y) >= 0.0 else -up, z], axis=1)


def make_lens(data, matrix: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Radius, distance in focus, blades, rotation, ratio, f8 [5]; zeros where everything is in focus.

    The f-number is the focal length over the lens' diameter; of an orthographic camera, as in Cycles, 1 m over it.
    """
    dof = data.dof
    if not dof.use_dof:
        return np.zeros(5)
    focus = dof.focus_distance
    if dof.focus_object is not None:
        place = focus_place(dof)
        focus = abs(float((axes[:, 2] * (place - matrix[:3, 3])).sum()))
    length = 1.0 if data.type == "ORTHO" else 1e-3 * data.lens
    radius = length / (2.0 * max(dof.aperture_fstop, 1e-5))
    return np.array([radius, max(focus, 1e-5), dof.aperture_blades if dof.aperture_blades > 2 else 0,
                     dof.aperture_rotation, max(dof.aperture_ratio, 1e-5)])


def focus_place(dof) -> np.ndarray:
    """Where the object lies, or its bone, that a camera has in focus, world, f8 [3]."""
    ob = dof.focus_object
    matrix = np.array(ob.matrix_world, dtype=np.float64)
    bone = ob.pose.bones.get(dof.focus_subtarget) if ob.pose and dof.focus_subtarget else None
    if bone is None:
        return matrix[:3, 3]
    return (matrix[:3, :3] * np.array(bone.matrix.translation)).sum(axis=1) + matrix[:3, 3]


def make_window(data, render, resolution, shift) -> np.ndarray:
    """left, right, bottom, top at distance 1 (else) or in metres (orthographic), f8 [4]."""
    width, height = resolution
    stretch = render.pixel_aspect_y / render.pixel_aspect_x  # height of a pixel, its width being 1
    tall = height * stretch
    fit = data.sensor_fit
    if fit == "AUTO":
        fit = "HORIZONTAL" if width >= tall else "VERTICAL"
    side = width if fit == "HORIZONTAL" else tall
    if data.type == "ORTHO":
        extent = data.ortho_scale
    else:
        # AUTO measures the sensor's width, whichever side it fits.
        sensor = data.sensor_height if data.sensor_fit == "VERTICAL" else data.sensor_width
        extent = sensor / data.lens
    unit = extent / side
    x, y = shift[0] * side, shift[1] * side
    return np.array([x - 0.5 * width, x + 0.5 * width, y - 0.5 * tall, y + 0.5 * tall], dtype=np.float64) * unit


def resolution_of(render) -> tuple[int, int]:
    """Width and height of the full frame in pixels, as Blender rounds them."""
    part = render.resolution_percentage / 100.0
    return max(1, int(render.resolution_x * part)), max(1, int(render.resolution_y * part))
