"""The camera's window and axes, against Blender's own projection."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import bpy
import numpy as np
from bpy_extras.object_utils import world_to_camera_view
from common import export, near, notes_of, run_all
from mathutils import Vector

from addon.compat import panorama_of

SIZES = ((640, 480), (300, 700))


def projected(scene, points):
    """Points of the world as fractions of the picture, from its lower left corner."""
    local = (points - scene.origin - scene.camera_to_world[:, 3]) @ scene.camera_to_world[:, :3]
    if scene.camera_kind == 0:
        local = local / -local[:, 2:]
    left, right, bottom, top = scene.camera_window
    return np.stack([(local[:, 0] - left) / (right - left), (local[:, 1] - bottom) / (top - bottom)], axis=1)


def check(**aspect):
    scene, camera = bpy.context.scene, bpy.context.scene.camera
    camera.location, camera.rotation_euler = (3.0, -4.0, 2.0), (1.1, 0.2, 0.6)
    render = scene.render
    for name, value in aspect.items():
        setattr(render, name, value)
    points = np.random.default_rng(0).uniform(-1, 1, (20, 3))
    for render.resolution_x, render.resolution_y in SIZES:
        for camera.data.sensor_fit in ("AUTO", "HORIZONTAL", "VERTICAL"):
            made = export()
            wanted = [world_to_camera_view(scene, camera, Vector(p))[:2] for p in points]
            near(projected(made, points), wanted, 2e-5)
            assert made.resolution.tolist() == [render.resolution_x, render.resolution_y]
            near(made.camera_clip, (camera.data.clip_start, camera.data.clip_end))
            near(made.camera_to_world[:, :3].T @ made.camera_to_world[:, :3], np.eye(3), 1e-12)


def test_perspective():
    check()


def test_perspective_shifted():
    data = bpy.context.scene.camera.data
    data.lens, data.shift_x, data.shift_y, data.sensor_width, data.sensor_height = 70, 0.2, -0.3, 30, 20
    check()


def test_orthographic():
    data = bpy.context.scene.camera.data
    data.type, data.ortho_scale, data.shift_x = "ORTHO", 4.5, 0.1
    check()


def test_pixel_aspect():
    check(pixel_aspect_x=1.0, pixel_aspect_y=1.7)


def test_scale_of_the_camera_does_not_count():
    bpy.context.scene.camera.scale = (2, 2, 2)
    near(np.linalg.norm(export().camera_to_world[:, :3], axis=0), (1, 1, 1))


def test_resolution_percentage():
    render = bpy.context.scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = 641, 480, 33
    assert export().resolution.tolist() == [int(641 * 0.33), int(480 * 0.33)]


def test_origin_stays_while_the_camera_moves_in_its_cell():
    """Cells of 64 m for things from 0.1 m on; the camera's place is exact in float32, wherever it is."""
    camera = bpy.context.scene.camera
    for place, origin in (((31.9, -31.9, 0.3), (0, 0, 0)), ((32.5, 100.0, -97.0), (64, 128, -128)),
                          ((1e6 + 0.0625, -299990.0, 0), (1e6, -299968, 0))):
        camera.location = place
        made = export()
        near(made.origin, origin)
        local = made.camera_to_world[:, 3]
        assert np.array_equal(local.astype(np.float32), local)
        assert np.array_equal((made.origin + local).astype(np.float32), np.array(place, np.float32))
    camera.location = (5.0, 0.0, 0.0)
    camera.data.clip_start = 0.01
    near(export().origin, (8, 0, 0))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 1.0
    near(export().origin, (0, 0, 0))


def test_what_is_left_out_is_named():
    data = bpy.context.scene.camera.data
    if "CUSTOM" in data.bl_rna.properties["type"].enum_items:
        data.type = "CUSTOM"
        assert "custom cameras are not supported" in " ".join(notes_of(export(), "camera"))


def test_panoramas():
    """Windows, reaches and polynomials in what kernels/panorama.h counts; axes forward, left and down."""
    camera = bpy.context.scene.camera
    camera.rotation_euler = (1.1, 0.2, 0.6)
    blender = np.array(camera.evaluated_get(bpy.context.evaluated_depsgraph_get()).matrix_world)[:3, :3]
    data = camera.data
    data.type, data.sensor_width = "PANO", 30.0
    panorama = panorama_of(data)
    panorama.latitude_min, panorama.longitude_max, panorama.fisheye_fov, panorama.fisheye_lens = -0.5, 2.0, 2.0, 10.0
    wanted = {
        "EQUIRECTANGULAR": (2, (-np.pi, 2.0, -0.5, np.pi / 2), 0.0),
        "MIRRORBALL": (5, (-2, 2, -2, 2), 2.0),
        "FISHEYE_EQUIDISTANT": (6, (-1, 1, -1, 1), 1.0),
        "FISHEYE_EQUISOLID": (7, (-1.5, 1.5, -1.125, 1.125), 2 * np.sin(0.5)),
        "FISHEYE_LENS_POLYNOMIAL": (8, (-15, 15, -11.25, 11.25), 1.0),
    }
    kinds = panorama.bl_rna.properties["panorama_type"].enum_items
    if "CENTRAL_CYLINDRICAL" in kinds:
        panorama.central_cylindrical_radius = 2.0
        wanted["CENTRAL_CYLINDRICAL"] = 3, (-np.pi, np.pi, -0.5, 0.5), 0.0
    if "EQUIANGULAR_CUBEMAP_FACE" in kinds:
        wanted["EQUIANGULAR_CUBEMAP_FACE"] = 4, np.array((-1, 1, -1, 1)) * np.pi / 4, 0.0
    for name, (kind, window, reach) in wanted.items():
        panorama.panorama_type = name
        made = export()
        assert made.camera_kind == kind and not notes_of(made, "camera")
        near(made.camera_window, window, 1e-6)
        near(made.camera_panorama[0], reach, 1e-6)
        right, up, back = blender.T
        axes = (right, back, -up) if name == "MIRRORBALL" else (-back, -right, -up)
        near(made.camera_to_world[:, :3], np.stack(axes, axis=1), 1e-6)
        data.shift_x, data.shift_y = 0.25, -0.5
        left, right, bottom, top = window
        shift = 0.25 * (right - left), -0.5 * (top - bottom)
        near(export().camera_window, np.add(window, np.repeat(shift, 2)), 1e-6)
        near(export().camera_panorama[6:], shift, 1e-6)
        data.shift_x = data.shift_y = 0.0
        polynomial = [getattr(panorama, f"fisheye_polynomial_k{k}") for k in range(5)]
        near(made.camera_panorama[1:6], polynomial if name == "FISHEYE_LENS_POLYNOMIAL" else np.zeros(5))


def test_lens():
    camera = bpy.context.scene.camera
    data, dof = camera.data, camera.data.dof
    near(export().camera_lens, np.zeros(5))
    dof.use_dof, data.lens, dof.aperture_fstop, dof.focus_distance = True, 50.0, 2.8, 3.0
    dof.aperture_blades, dof.aperture_rotation, dof.aperture_ratio = 5, 0.5, 2.0
    near(export().camera_lens, (0.05 / 5.6, 3.0, 5, 0.5, 2.0))
    camera.location, camera.rotation_euler, camera.scale = (0, 0, 5), (0, 0, 0), (2, 2, 2)
    target = bpy.data.objects.new("target", None)
    bpy.context.scene.collection.objects.link(target)
    target.location, dof.focus_object, dof.aperture_blades = (7, 0, 1), target, 2
    near(export().camera_lens, (0.05 / 5.6, 4.0, 0, 0.5, 2.0))
    data.type = "ORTHO"
    near(export().camera_lens[0], 1 / 5.6)


run_all(sys.modules[__name__])
