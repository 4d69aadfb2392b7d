"""Makes a scene of Image and Environment Textures: kinds of pictures, alpha, interpolation, extension and projection.

    python blend_scenes/nodes/make_images.py -- OUT.blend        (or blender -b --python ...)

Each patch shines with its picture and shows it from -0.6 to 1.6. Files of pictures are laid beside OUT.blend.
"""

import math
import sys
from pathlib import Path

import bpy
import numpy as np

PIXELS = 16  # of a patch's side
NEW = bpy.app.version >= (4, 0, 0)  # names of colour spaces
LINEAR, OTHER = ("Linear Rec.709", "Linear CIE-XYZ D65") if NEW else ("Linear", "XYZ")


def pixels_of(width, height, channels=4, seed=0, high=1.0):
    """Random texels, rows from the bottom up."""
    return (np.random.default_rng(seed).random((height, width, channels)) * high).astype(np.float32)


def image(name, texels, space="sRGB", is_float=False, alpha="STRAIGHT"):
    height, width = texels.shape[:2]
    made = bpy.data.images.new(name, width, height, alpha=True, float_buffer=is_float)
    made.colorspace_settings.name = space
    made.alpha_mode = alpha
    full = np.ones((height, width, 4), np.float32)
    full[:, :, :texels.shape[2]] = texels
    made.pixels.foreach_set(full.ravel())
    made.pack()
    return made


def saved(folder, name, texels, file_format, depth, space="sRGB", alpha="STRAIGHT"):
    """An image read from a file that Blender has written."""
    settings = bpy.context.scene.render.image_settings
    settings.file_format, settings.color_depth = file_format, depth
    settings.color_mode = "RGBA" if texels.shape[2] == 4 else "RGB"
    path = str(folder / name)
    image(name, texels, "Non-Color", True).save_render(path)
    made = bpy.data.images.load(path)
    made.colorspace_settings.name = space
    made.alpha_mode = alpha
    return made


class Picture:
    """Patches side by side, seen straight on without perspective."""

    def __init__(self, columns, rows):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.scene, self.columns, self.count = bpy.context.scene, columns, 0
        self.scene.render.engine = "CYCLES"
        self.scene.render.resolution_x, self.scene.render.resolution_y = PIXELS * columns, PIXELS * rows
        self.scene.render.resolution_percentage = 100
        self.scene.view_settings.view_transform = "Raw"
        cycles = self.scene.cycles
        cycles.use_denoising = cycles.use_adaptive_sampling = False
        cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
        cycles.pixel_filter_type, cycles.filter_width = "BLACKMAN_HARRIS", 0.01
        camera = bpy.data.cameras.new("camera")
        camera.type, camera.ortho_scale = "ORTHO", max(columns, rows)
        self.scene.camera = bpy.data.objects.new("camera", camera)
        self.scene.camera.location = (columns / 2, -rows / 2, 5.0)
        self.scene.collection.objects.link(self.scene.camera)

    def add(self, name, picture, shows="Color", coordinates="UV", kind="ShaderNodeTexImage", low=-0.6, high=1.6,
            rounded=False, vector=None, **modes):
        mesh = ball(name) if rounded else square(name, low, high)
        material = bpy.data.materials.new(name)
        material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        output, emission = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new("ShaderNodeEmission")
        tree.links.new(emission.outputs[0], output.inputs["Surface"])
        node = tree.nodes.new(kind)
        node.image = picture
        for mode, value in modes.items():
            setattr(node, mode, value)
        if coordinates:
            places = tree.nodes.new("ShaderNodeTexCoord")
            tree.links.new(places.outputs[coordinates], node.inputs["Vector"])
        if shows == "both":
            mix = tree.nodes.new("ShaderNodeMixRGB")
            tree.links.new(node.outputs["Color"], mix.inputs["Color2"])
            tree.links.new(node.outputs["Alpha"], mix.inputs["Fac"])
            mix.inputs["Color1"].default_value = (0.2, 0.5, 0.9, 1.0)
            tree.links.new(mix.outputs[0], emission.inputs["Color"])
        else:
            tree.links.new(node.outputs[shows], emission.inputs["Color"])
        mesh.materials.append(material)
        placed = bpy.data.objects.new(name, mesh)
        placed.location = (self.count % self.columns + 0.5, -(self.count // self.columns) - 0.5, 0.0)
        self.scene.collection.objects.link(placed)
        self.count += 1


def square(name, low, high):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(x - 0.5, y - 0.5, 0.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], [], [(0, 1, 2, 3)])
    layer = mesh.uv_layers.new(name="map")
    for corner, (x, y) in enumerate(((0, 0), (1, 0), (1, 1), (0, 1))):
        layer.data[corner].uv = (low + (high - low) * x, low + (high - low) * y)
    return mesh


def ball(name, steps=16):
    """A sphere, smooth."""
    angles = [(math.pi * row / steps, 2.0 * math.pi * column / (2 * steps))
              for row in range(steps + 1) for column in range(2 * steps)]
    points = [tuple(0.48 * x for x in (math.sin(a) * math.cos(b), math.sin(a) * math.sin(b), math.cos(a)))
              for a, b in angles]
    ring = 2 * steps
    faces = [(row * ring + c, (row + 1) * ring + c, (row + 1) * ring + (c + 1) % ring, row * ring + (c + 1) % ring)
             for row in range(steps) for c in range(ring)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, [], faces)
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    return mesh


def make(path):
    picture = Picture(8, 6)
    folder = Path(path).resolve().parent
    rgba = image("bytes", pixels_of(5, 3))
    data = image("data", pixels_of(4, 6, seed=1), "Non-Color")
    hdr = image("hdr", pixels_of(6, 4, 3, seed=2, high=4.0), LINEAR, is_float=True)
    for interpolation in ("Linear", "Closest", "Cubic", "Smart"):
        for extension in ("REPEAT", "EXTEND", "CLIP", "MIRROR"):
            if extension == "MIRROR" and bpy.app.version < (3, 5, 0):
                continue
            picture.add(f"{interpolation} {extension}", data if interpolation == "Cubic" else hdr,
                        interpolation=interpolation, extension=extension)
    picture.add("sRGB bytes", rgba)
    picture.add("sRGB alpha", rgba, "Alpha")
    picture.add("sRGB both", rgba, "both")
    for alpha in ("PREMUL", "CHANNEL_PACKED", "NONE"):
        picture.add(alpha, image(alpha, pixels_of(5, 3, seed=3), alpha=alpha), "both")
    picture.add("data both", data, "both")
    picture.add("hdr alpha", image("hdr alpha", pixels_of(4, 4, seed=4, high=0.9), is_float=True), "both")
    picture.add("png8", saved(folder, "image8.png", pixels_of(7, 4, 3, seed=5), "PNG", "8"))
    picture.add("png16", saved(folder, "image16.png", pixels_of(7, 4, 3, seed=6), "PNG", "16"))
    picture.add("png16 alpha", saved(folder, "image16a.png", pixels_of(7, 4, 4, seed=6), "PNG", "16"), "both")
    picture.add("png16 data", saved(folder, "data16.png", pixels_of(7, 4, 3, seed=6), "PNG", "16", "Non-Color"))
    for depth in ("16", "32"):
        texels = pixels_of(7, 4, 3, seed=7, high=3.0)
        picture.add(f"exr {depth}", saved(folder, f"image{depth}.exr", texels, "OPEN_EXR", depth, LINEAR))
    picture.add("other space", image("other space", 0.3 + 0.2 * pixels_of(5, 3, 3, seed=9), OTHER))
    picture.add("grey", image("grey", np.repeat(pixels_of(5, 5, 1, seed=10), 3, axis=2)))
    picture.add("no picture", None)
    picture.add("far away", data, low=1000.0, high=1002.0)
    picture.add("one texel", image("one", pixels_of(1, 1, seed=11)), interpolation="Cubic")
    for projection in ("SPHERE", "TUBE"):
        picture.add(projection, rgba, coordinates="Generated", rounded=True, projection=projection)
    for blend in (0.0, 0.3, 1.0):
        picture.add(f"box {blend}", rgba, coordinates="Generated", rounded=True, projection="BOX",
                    projection_blend=blend)
    for projection in ("EQUIRECTANGULAR", "MIRROR_BALL"):
        picture.add(projection, hdr, coordinates="Normal", kind="ShaderNodeTexEnvironment", rounded=True,
                    projection=projection)
    picture.add("environment of places", hdr, coordinates=None, kind="ShaderNodeTexEnvironment", rounded=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(path))


if __name__ == "__main__":
    make(sys.argv[sys.argv.index("--") + 1])
