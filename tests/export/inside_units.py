"""docs/units.md against Cycles: what each lamp does to a diffuse floor, to 1 %.

Cycles renders one pixel of a white floor; the records of isophote.lights, made from the exported
scene, are integrated in numpy.
"""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import bpy
import numpy as np
from common import add, export, material, near, node, run_all, square

ALBEDO = 0.5
POINTS = 400  # a side of the grid over a lamp


def cycles_pixel():
    """RGB of the middle of Cycles' picture."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = 5
    cycles = scene.cycles
    cycles.samples, cycles.max_bounces = 4096, 0
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    with tempfile.TemporaryDirectory() as folder:
        settings = scene.render.image_settings
        if hasattr(settings, "media_type"):
            settings.media_type = "IMAGE"
        settings.file_format, settings.color_depth = "OPEN_EXR", "32"
        scene.render.filepath = str(Path(folder) / "pixel.exr")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        pixels = np.array(image.pixels[:]).reshape(5, 5, -1)
    return pixels[2, 2, :3]


def floor_radiance(scene):
    """The same from the records of the exported scene: albedo / pi times irradiance at the world's origin."""
    from isophote.lights import light_records

    light = light_records(scene)[0]
    place = light["position"].astype(float) + scene.origin
    radiance, distance2 = light["radiance"].astype(float), float((place ** 2).sum())
    cosine = place[2] / np.sqrt(distance2)
    if light["kind"] == 2:
        cosine = -light["normal"][2]
        size = np.pi * np.sin(light["size_u"]) ** 2
        irradiance = radiance * cosine * (size if size > 0 else 1.0)
    elif light["kind"] <= 1:
        size = light["size_u"]
        solid = np.pi * size ** 2 / (distance2 + soft() * size ** 2) if size > 0 else 1.0 / distance2
        irradiance = radiance * cosine * solid
        if light["kind"] == 1:
            axis = -(place / np.sqrt(distance2)) @ light["normal"]
            x = np.clip((axis - light["cone"]) * light["cone_scale"], 0, 1)
            irradiance = irradiance * x * x * (3 - 2 * x)
    else:
        grid = (np.arange(POINTS) + 0.5) / POINTS * 2 - 1
        a, b = (g.ravel() for g in np.meshgrid(grid, grid))
        inside = (a * a + b * b <= 1) | (light["kind"] == 3)
        points = place + np.outer(a * light["size_u"], light["u"]) + np.outer(b * light["size_v"], light["v"])
        d2 = (points ** 2).sum(axis=1)
        shines = np.maximum(-(points @ light["normal"]), 0) * np.maximum(points[:, 2], 0) / d2 ** 2
        irradiance = radiance * light["area"] * shines[inside].mean()
    return irradiance * ALBEDO / np.pi


def soft():
    """1 where Cycles draws points as disks: always before 4.2, where the tests switch it off."""
    return 0.0 if "use_soft_falloff" in bpy.types.PointLight.bl_rna.properties else 1.0


def check(kind, location, rotation=(0, 0, 0), scale=(1, 1, 1), **settings):
    white = material("white", lambda tree, output: node(
        tree, "ShaderNodeBsdfDiffuse", output.inputs["Surface"], Color=(ALBEDO,) * 3))
    floor = add("floor", square(materials=(white,)))
    floor.scale = (0.01, 0.01, 1)
    camera = bpy.context.scene.camera
    camera.location, camera.rotation_euler, camera.data.angle = (0, 0, 5), (0, 0, 0), 1e-3
    lamp = bpy.data.lights.new(kind, kind)
    lamp.energy, lamp.color = 50.0, (1.0, 0.5, 0.25)
    for name, value in settings.items():
        if hasattr(lamp, name):
            setattr(lamp, name, value)
    add("lamp", lamp, location, rotation, scale)
    wanted = cycles_pixel()
    near(floor_radiance(export()) / wanted, np.ones(3), 0.01)


def test_point():
    check("POINT", (1, 0.5, 1.5), shadow_soft_size=0.0)


def test_sphere():
    check("POINT", (0.3, 0.2, 1.0), shadow_soft_size=0.15, use_soft_falloff=False)


def test_spot_on_the_falloff():
    if bpy.app.version < (4, 0, 0):
        return  # spots were darker by the cosine there (docs/units.md)
    check("SPOT", (0, 0, 2), (0.4, 0, 0), spot_size=1.2, spot_blend=0.7, shadow_soft_size=0.0)


def test_sun():
    check("SUN", (0, 0, 2), (0.5, 0.2, 0), angle=0.2)


def test_sharp_sun():
    check("SUN", (0, 0, 2), (0.5, 0.2, 0), angle=0.0)


def test_rectangle():
    check("AREA", (0.4, 0.2, 1.0), (0.2, -0.3, 0.5), (1.5, 0.5, 2.0), shape="RECTANGLE", size=0.8, size_y=0.6)


def test_ellipse():
    check("AREA", (0.4, 0.2, 1.0), (0.2, -0.3, 0.5), shape="ELLIPSE", size=0.8, size_y=0.4)


def test_not_normalized():
    for kind, settings in (("POINT", {"shadow_soft_size": 0.2, "use_soft_falloff": False}), ("SUN", {"angle": 0.3}),
                           ("AREA", {"shape": "DISK", "size": 0.5})):
        for ob in list(bpy.data.objects):
            if ob.type != "CAMERA":
                bpy.data.objects.remove(ob)
        check(kind, (0.2, 0, 1.2), normalize=False, **settings)


run_all(sys.modules[__name__])
